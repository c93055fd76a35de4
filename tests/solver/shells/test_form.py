"""From a plan to a placed, measured shell: exact domes, groups, messages, cut surfaces."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from scipy.spatial import KDTree

from solver.catalogue import shapes
from solver.errors import CmcError, ConditionError, MeshError, Status
from solver.io.polygons import triangulate_polygons
from solver.shells.form import form
from solver.shells.plan import Group, Plan, Settings, plan_domain
from solver.shells.polygon_sheets import polygon_sheet
from solver.shells.shell import Shell, sheet_polygons
from solver.surface.placement import PlacementError, rim_weights


def disc(rings: int = 8, radius: float = 5.0, centre: tuple[float, float, float] = (0, 0, 0)) -> Plan:
    """A hexagonal disc; ring k has 6k vertices, the last 6 · rings are the boundary."""
    points, triangles = [np.zeros((1, 2))], []
    start, inner = 1, [0]
    for k in range(1, rings + 1):
        angles = 2 * np.pi * np.arange(6 * k) / (6 * k)
        points.append(k / rings * np.column_stack([np.cos(angles), np.sin(angles)]))
        ring = list(range(start, start + 6 * k))
        for side in range(6):
            for step in range(k):
                a, b = ring[side * k + step], ring[(side * k + step + 1) % (6 * k)]
                c = inner[(side * (k - 1) + step) % len(inner)]
                triangles.append((a, b, c))
                if step:
                    triangles.append((inner[side * (k - 1) + step - 1], a, c))
        start, inner = start + 6 * k, ring
    flat = radius * np.vstack(points)
    return Plan(np.column_stack([flat, np.zeros(len(flat))]) + centre, np.array(triangles))


def grid(columns: int, rows: int, size: float = 1.0, hole: bool = False) -> Plan:
    """Quads; `hole` leaves out the middle third each way."""
    x, y = np.meshgrid(np.arange(columns + 1), np.arange(rows + 1))
    points = size * np.column_stack([x.ravel(), y.ravel(), 0 * x.ravel()]).astype(float)
    index = np.arange(len(points)).reshape(rows + 1, columns + 1)
    quads = [
        np.array([index[j, i], index[j, i + 1], index[j + 1, i + 1], index[j + 1, i]])
        for j in range(rows)
        for i in range(columns)
        if not (hole and columns <= 3 * i < 2 * columns and rows <= 3 * j < 2 * rows)
    ]
    used, corners = np.unique(np.concatenate(quads), return_inverse=True)
    quads = list(corners.reshape(-1, 4))
    triangles, owner = triangulate_polygons(points[used], quads)
    return Plan(points[used], triangles, quads, triangle_polygons=owner)


def boundary_pairs(plan: Plan) -> np.ndarray:
    domain = plan_domain(plan)
    return domain.edges[domain.boundary_edges]


def test_a_disc_becomes_the_hemisphere_over_it():
    errors = []
    for rings in (6, 12):
        plan = disc(rings, radius=5.0, centre=(10, -3, 2))
        shell = form(plan)
        assert shell.ok
        dome = shell.placed["f+"] - [10, -3, 2]
        errors.append(np.abs(np.linalg.norm(dome, axis=1) - 5).max())
        assert_allclose(dome[:, 2].min(), 0, atol=1e-12)
        assert_allclose(shell.report.mean_curvature, 0.2, rtol=0.02)
        assert_allclose(shell.normals["f+"], dome / 5, atol=0.06)
    assert errors[1] < 0.3 * errors[0]
    assert "f-" not in shell.placed
    assert any("f- degenerates to a point" in note for note in shell.warnings)
    assert_allclose(shell.mean_curvature, 0.2, rtol=0.02)
    assert shell.message == shell.report.sentence and shell.message.startswith("Done. Curvature is even to ")


def test_match_plan_brings_the_boundary_to_the_outline():
    plan = disc(10, centre=(1, 2, 3))
    shell = form(plan, Settings(default_tilt=0.4))
    rim = np.unique(boundary_pairs(plan))
    assert_allclose(shell.placed["f+"][rim], plan.positions[rim], atol=0.01)
    assert shell.report.shown.outline.max < 0.01


@pytest.mark.parametrize(
    ("settings", "measure", "value"),
    [
        (Settings(size="span", value=12), lambda f: f.report.shown.span, 12),
        (Settings(size="rise", value=3), lambda f: f.report.shown.rise, 3),
        (Settings(size="radius", value=8), lambda f: 1 / f.report.mean_curvature, 8),
        (Settings(size="mean_curvature", value=0.3), lambda f: f.report.mean_curvature, 0.3),
    ],
)
def test_sizes_are_what_the_report_says(settings, measure, value):
    shell = form(disc(), settings)
    assert_allclose(measure(shell), value, rtol=1e-9)
    assert_allclose(shell.report.shown.mean_curvature.mean, shell.report.mean_curvature, rtol=0.02)


def test_flip_and_ground():
    up, down = (form(disc(), Settings(ground="rim", flip=flip)) for flip in (False, True))
    assert_allclose(down.placed["f+"], up.placed["f+"] * [1, 1, -1], atol=1e-12)
    assert_allclose(down.mean_curvature, up.mean_curvature, rtol=1e-9)
    assert down.placed["f+"][0, 2] < -4
    for shell in (up, down):  # normals on the side from which faces are counter-clockwise
        a, b, c = (shell.placed["f+"][shell.faces[:, k]] for k in range(3))
        of_faces = np.cross(b - a, c - a)
        assert (np.einsum("fi,fi->f", of_faces, shell.normals["f+"][shell.faces[:, 0]]) > 0).all()
    standing = form(disc(), Settings(flip=True))
    assert_allclose(standing.placed["f+"][:, 2].min(), 0, atol=1e-12)
    assert_allclose(standing.placed["f+"][0, 2], 0, atol=1e-12)


def test_a_sloped_plan_carries_everything_with_it():
    level = disc(centre=(1, 0, 2))
    angle = 0.3
    turn = np.array([[1, 0, 0], [0, np.cos(angle), -np.sin(angle)], [0, np.sin(angle), np.cos(angle)]])
    sloped = form(replace(level, positions=level.positions @ turn.T), Settings(size="rise", value=4, flip=True))
    straight = form(level, Settings(size="rise", value=4, flip=True))
    for name in ("f+", "g", "gauss"):
        assert_allclose(sloped.placed[name], straight.placed[name] @ turn.T, atol=1e-6)
    assert_allclose(sloped.report.shown.rise, 4, rtol=1e-9)


def test_a_plan_in_millimetres_is_the_same_plan():
    metres, millimetres = disc(), disc(radius=5000.0)
    one, other = form(metres), form(millimetres)
    assert_allclose(other.placed["f+"], 1000 * one.placed["f+"], atol=1e-6)
    assert_allclose(1000 * other.mean_curvature, one.mean_curvature, rtol=1e-6)


def test_groups_and_the_default_on_the_rest():
    """All edges in two groups of one condition are that condition by default; another one is not."""
    plan = disc()
    pairs = boundary_pairs(plan)
    tilt = 0.35
    halves = [
        Group("first", pairs[:20], parameters={"tilt": tilt}),
        Group("second", pairs[20:, ::-1], parameters={"tilt": tilt}),
    ]
    default = form(plan, Settings(default_tilt=tilt)).placed["f+"]
    grouped = form(replace(plan, groups=halves)).placed["f+"]
    assert_allclose(grouped, default, atol=1e-9)
    part = form(replace(plan, groups=halves[:1])).placed["f+"]
    assert np.abs(part - default).max() > 0.1


def test_a_free_group_leaves_the_others():
    plan = disc()
    pairs = boundary_pairs(plan)
    shell = form(replace(plan, groups=[Group("open", pairs[:12], "free"), Group("none", np.empty((0, 2)))]))
    assert shell.surface.harmonic.status is Status.CONVERGED
    assert 'Group "none" has no edges.' in shell.warnings


def test_both_sheets_where_there_are_two():
    shell = form(disc(10), Settings(default_kind="twisted"))
    assert set(shell.placed) == {"f+", "f-", "g", "gauss"}
    middle = 0.5 * (shell.placed["f+"] + shell.placed["f-"])
    assert_allclose(shell.placed["g"], middle, atol=1e-12)
    radius = 0.5 / shell.report.mean_curvature
    half = 0.5 * (shell.placed["f+"] - shell.placed["f-"])
    assert_allclose(np.linalg.norm(half, axis=1), radius, rtol=1e-9)
    gauss = shell.placed["gauss"] - shell.placed["gauss"].mean(axis=0)
    assert_allclose(gauss - gauss[0], half - half[0], atol=1e-9)
    assert_allclose(shell.normals["f-"], -shell.normals["f+"], atol=0)
    assert set(shell.report.sheets) == {"f+", "f-"}
    assert any("does not follow the drawn outline" in note for note in shell.warnings)


def test_the_sheet_that_is_shown_is_the_one_that_is_placed():
    plan = disc(10)
    shell = form(plan, Settings(default_kind="twisted", sheet="f-", size="span", value=7, ground="lowest"))
    assert shell.report.sheet == "f-"
    assert_allclose(shell.report.shown.span, 7, rtol=1e-9)
    assert_allclose(shell.placed["f-"][:, 2].min(), 0, atol=1e-12)
    inside = np.setdiff1d(np.arange(len(plan.positions)), boundary_pairs(plan))
    assert_allclose(np.median(shell.mean_curvature[inside]), shell.report.mean_curvature, rtol=0.05)


def test_a_degenerate_sheet_is_not_blown_up():
    with pytest.raises(PlacementError, match=r"f- degenerates to a point .* show f\+, or change a tilt"):
        form(disc(), Settings(sheet="f-"))


def test_a_solver_is_used_again_only_for_its_own_plan():
    plan = disc()
    first = form(plan)
    assert form(plan, Settings(default_tilt=0.1), solver=first.solver).solver is first.solver
    moved = replace(plan, positions=plan.positions + [3, 0, 0])
    assert form(moved, solver=first.solver).solver is first.solver
    stretched = replace(plan, positions=plan.positions * [1.01, 1, 1])
    again = form(stretched, solver=first.solver)
    assert again.solver is not first.solver
    assert_allclose(again.placed["f+"], form(stretched).placed["f+"], atol=0)


def test_progress_and_cancel():
    seen = []
    form(disc(), progress=lambda iteration, residual: seen.append((iteration, residual)))
    assert [s[0] for s in seen] == sorted(s[0] for s in seen)
    assert seen
    shell = form(disc(), Settings(default_tilt=0.3), progress=lambda iteration, residual: False)
    assert shell.surface.status is Status.CANCELLED
    assert not shell.ok
    assert any("cancelled" in note for note in shell.warnings)


def test_an_initial_map_is_where_it_starts():
    plan = disc()
    first = form(plan)
    again = form(plan, initial=first.surface.harmonic.normals)
    assert again.report.iterations <= 1
    assert_allclose(again.placed["f+"], first.placed["f+"], atol=1e-6)


def courtyard() -> Shell:
    plan = grid(9, 9, hole=True)
    pairs = boundary_pairs(plan)
    inner = pairs[np.all(np.abs(plan.positions[pairs][:, :, :2] - 4.5) < 2, axis=(1, 2))]
    return form(replace(plan, groups=[Group("court", inner, "plane", {"normal": (0.6, 0, 0.8)})]))


def test_a_courtyard_that_does_not_close_is_cut_and_says_so():
    plan, shell = grid(9, 9, hole=True), courtyard()
    assert shell.surface.status is Status.GAP
    assert not shell.ok
    assert any("gap" in note for note in shell.warnings)
    assert len(shell.source) > len(plan.positions)
    assert_array_equal(shell.source[shell.faces], plan.triangles)
    vertices, weights = rim_weights(plan.positions, boundary_pairs(plan))
    assert np.bincount(shell.source)[vertices].max() > 1
    centres = np.array([shell.placed["f+"][shell.source == vertex].mean(axis=0) for vertex in vertices])
    moved = np.average(centres - plan.positions[vertices], axis=0, weights=weights)
    assert_allclose(moved[:2], 0, atol=1e-12)
    polygons, index = sheet_polygons(plan.polygons, plan.triangle_polygons, plan.triangles, shell.faces)
    assert_array_equal(np.bincount(index) >= 1, True)
    assert sum(len(p) - 2 for p in polygons) == len(plan.triangles)
    for polygon, owner in zip(polygons, index, strict=True):
        drawn = plan.polygons[owner].tolist()
        assert set(shell.source[polygon].tolist()) <= set(drawn)
        if len(polygon) == 4:
            assert shell.source[polygon].tolist() == drawn


def test_polygons_of_a_closed_surface_are_the_plans():
    plan = grid(4, 4)
    polygons, index = sheet_polygons(plan.polygons, plan.triangle_polygons, plan.triangles, plan.triangles)
    assert_array_equal(polygons, plan.polygons)
    assert_array_equal(index, np.arange(16))


def tetrahedron() -> Plan:
    corners = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1.0]])
    return Plan(corners, np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]]))


def with_group(*groups: Group) -> Plan:
    return replace(disc(3), groups=groups)


RIM = np.array([[19, 20], [20, 21]])


@pytest.mark.parametrize(
    ("plan", "error", "message", "vertices"),
    [
        (tetrahedron(), MeshError, "The mesh is closed", []),
        (
            Plan(np.eye(3), np.array([[0, 1, 2]])),
            MeshError,
            r"\(1 triangle\) has no vertex inside",
            [],
        ),
        (grid(1, 3), MeshError, r"\(6 triangles\) has no vertex inside its boundary.*run Mesh Plan", []),
        (
            with_group(Group("inner", [[0, 1], [19, 20]])),
            ConditionError,
            r'Group "inner": No boundary edge joins vertices 0, 1',
            [0, 1],
        ),
        (with_group(Group("far", [[19, 99]])), ConditionError, r'Group "far": There is no vertex 99', [99]),
        (
            with_group(Group("one", RIM), Group("two", RIM[1:, ::-1])),
            ConditionError,
            'edge between vertices 20, 21 is in two groups, "one" and "two"',
            [20, 21],
        ),
        (
            with_group(Group("flat", RIM, "plane", {"normal": (0, 0, 0)})),
            ConditionError,
            r'Group "flat": .*zero or not finite',
            [],
        ),
        (
            with_group(Group("odd", RIM, "binormal", {"lean": 3})),
            ConditionError,
            r"Group \"odd\": .* has no parameter lean",
            [],
        ),
        (with_group(Group("odd", RIM, "spline")), ConditionError, r"Group \"odd\": There is no boundary", []),
    ],
)
def test_messages(plan, error, message, vertices):
    with pytest.raises(error, match=message) as caught:
        form(plan)
    assert list(caught.value.vertices) == vertices


def test_all_edges_free():
    plan = disc(3)
    with pytest.raises(ConditionError, match="All boundary edges are free"):
        form(replace(plan, groups=[Group("all", boundary_pairs(plan), "free")]))
    with pytest.raises(ConditionError, match="All boundary edges are free"):
        form(plan, Settings(default_kind="free"))


def test_opposite_planes_that_meet_are_named():
    groups = [
        Group("up", RIM[:1], "plane", {"normal": (0, 0, 1)}),
        Group("down", RIM[1:], "plane", {"normal": (0, 0, -1)}),
    ]
    with pytest.raises(ConditionError) as caught:
        form(with_group(*groups))
    assert list(caught.value.vertices) == [20]


@pytest.mark.parametrize(
    "settings", [{"sheet": "g"}, {"default_kind": "spline"}, {"size": "large"}, {"size": "rise", "value": -2}]
)
def test_settings_are_checked(settings):
    with pytest.raises(CmcError, match=r"There is no|must be a positive number"):
        Settings(**settings)


def test_a_plan_that_looks_down_is_noticed():
    plan = disc(4)
    down = form(replace(plan, triangles=plan.triangles[:, ::-1]))
    assert any("faces look down" in note for note in down.warnings)
    assert not any("faces look down" in note for note in form(plan).warnings)


def test_flat_all_around_is_a_collapse():
    with pytest.raises(PlacementError, match="normals are all the same, so the surface shrinks to a point"):
        form(disc(), Settings(default_tilt=np.pi / 2))


def moebius(columns: int = 12) -> Plan:
    """A closed strip of three rows of vertices with half a turn."""
    t = 2 * np.pi * np.arange(columns) / columns
    width = np.array([-0.4, 0.0, 0.4])
    radius = 2 + width * np.cos(t / 2)[:, None]
    points = np.stack([radius * np.cos(t)[:, None], radius * np.sin(t)[:, None], width * np.sin(t / 2)[:, None]], 2)
    index = np.vstack([np.arange(3 * columns).reshape(columns, 3), [[2, 1, 0]]])
    quads = [
        [index[i, j], index[i + 1, j], index[i + 1, j + 1], index[i, j + 1]] for i in range(columns) for j in range(2)
    ]
    return Plan(points.reshape(-1, 3), triangulate_polygons(points.reshape(-1, 3), quads)[0])


def two_discs() -> Plan:
    one, other = disc(3), disc(3, centre=(20, 0, 0))
    count = len(one.positions)
    return Plan(np.vstack([one.positions, other.positions]), np.vstack([one.triangles, other.triangles + count]))


def with_nan() -> Plan:
    plan = disc(3)
    plan.positions[5, 1] = np.nan
    return plan


@pytest.mark.parametrize(
    ("plan", "message"),
    [
        (two_discs(), "component"),
        (moebius(), "one-sided, like a Möbius strip"),
        (with_nan(), "vertex 5"),
        (Plan(np.zeros((0, 3)), np.zeros((0, 3), dtype=int)), "no|empty"),
        (Plan(disc(3).positions, np.vstack([disc(3).triangles, [[0, 1, 2]]])), "face"),
    ],
)
def test_meshes_that_are_no_surface(plan, message):
    with pytest.raises(MeshError, match=message):
        form(plan)


def test_a_vertical_rim_is_no_overhang_worth_a_warning():
    """Faces beside it lean by a degree or two, the surface does not; a rim that leans out by 20° is told."""
    shape = shapes.polygon([(0, 0), (10, 0), (10, 10), (0, 10)], max_edge=0.25, corner_radius=1.0)
    points = np.column_stack([shape.positions, np.zeros(len(shape.positions))])
    plan = Plan(points, shape.domain.faces)
    upright, leaning = (form(plan, Settings(default_tilt=np.radians(tilt))) for tilt in (0, -20))
    assert upright.report.shown.overhang.count > 0
    assert not any("overhangs" in note for note in upright.warnings)
    assert any("overhangs" in note for note in leaning.warnings)
    assert leaning.report.shown.overhang.largest_lean == pytest.approx(20, abs=5)


# --- sites, energies, triangulations -------------------------------------------------------


def test_a_solver_is_used_again_only_for_its_own_choice():
    """Another site, energy or triangulation makes another one, on the same domain, and another shell."""
    plan = disc(5)
    start = Settings(default_tilt=0.4)
    first = form(plan, start)
    for other in (
        replace(start, sites="faces"),
        replace(start, sites="faces", energy="mobius"),
        replace(start, delaunay=True),
    ):
        again = form(plan, other, solver=first.solver)
        assert again.solver is not first.solver
        assert again.solver.domain is first.solver.domain
        assert_allclose(again.placed["f+"], form(plan, other).placed["f+"], rtol=0, atol=0)
        assert form(plan, replace(other, default_tilt=0.3), solver=again.solver).solver is again.solver
        assert form(plan, start, solver=again.solver).solver is not again.solver
    faces = form(plan, replace(start, sites="faces"))
    assert form(plan, replace(start, sites="faces", energy="dual_cotan"), solver=faces.solver).solver is faces.solver
    mobius = form(plan, replace(start, sites="faces", energy="mobius"), solver=faces.solver)
    assert mobius.solver is not faces.solver


def test_a_start_is_on_the_sites_that_are_solved():
    plan, settings = disc(5), Settings(default_tilt=0.4, sites="faces")
    first = form(plan, settings)
    normals = first.surface.harmonic.normals
    assert len(normals) == len(plan.triangles)
    again = form(plan, settings, initial=normals)
    assert again.report.iterations <= 1
    assert_allclose(again.placed["f+"], first.placed["f+"], atol=1e-6)
    with pytest.raises(ConditionError, match=r"shape \(91, 3\), .*vertices, not \(150, 3\)"):
        form(plan, replace(settings, sites="vertices"), initial=normals)
    with pytest.raises(ConditionError, match=r"shape \(150, 3\), .*faces, not \(91, 3\)"):
        form(plan, settings, initial=form(plan).surface.harmonic.normals)


@pytest.mark.parametrize("sites", ["vertices", "faces"])
@pytest.mark.parametrize("flip", [False, True])
@pytest.mark.parametrize("faces", ["dual", "corner"])
def test_other_faces_lie_over_the_plan(faces, sites, flip):
    """Between plan and hemisphere, like the triangles: points, normals and sides; g lies half-way between f±."""
    plan = disc(10, centre=(1, 2, 3))
    shell = form(plan, Settings(default_tilt=0.2, ground="rim", flip=flip, sites=sites))
    assert shell.ok
    sheets = {name: polygon_sheet(shell, name, faces) for name in shell.placed}
    f, g, gauss = sheets["f+"], sheets["g"], sheets["gauss"]
    tree = KDTree(shell.placed["f+"])
    distance, nearest = tree.query(f.points)
    assert distance.max() < 0.75
    assert np.einsum("ni,ni->n", f.normals, shell.normals["f+"][nearest]).min() > 0.9
    radius = 0.5 / shell.report.mean_curvature
    assert_allclose(np.linalg.norm(f.points - g.points, axis=1).max(), radius, rtol=0.02)
    # g + N is f+, and the Gauss image is N, beside the plan as the triangles' is
    centre = (shell.placed["gauss"] - shell.placed["f+"] + shell.placed["g"])[0]
    assert_allclose(gauss.points, centre + f.points - g.points, rtol=0, atol=1e-9)
    flat = f.from_vertices(plan.positions)
    assert np.linalg.norm(flat[:, :2] - [1, 2], axis=1).max() < 5.01
    assert_allclose(f.from_corners(plan.positions[plan.triangles], plan.triangles), flat, rtol=0, atol=1e-12)
    for sheet in (f, g):
        vectors = np.array([area_vector(sheet.points[p]) for p in sheet.polygons])
        outside = np.array([sheet.normals[p].mean(axis=0) for p in sheet.polygons])
        areas = np.linalg.norm(vectors, axis=1)
        wrong = np.einsum("ni,ni->n", vectors, outside) < 0
        assert areas[wrong].sum() < 0.02 * areas.sum()


def area_vector(points: np.ndarray) -> np.ndarray:
    return 0.5 * np.cross(points, np.roll(points, -1, axis=0)).sum(axis=0)


def test_a_polygon_belongs_to_the_drawn_one_below():
    """Of the dual of a grid: that of a vertex lies on the quads around it, most of it on its owner."""
    plan = grid(5, 4)
    sheet = polygon_sheet(form(plan, Settings(default_tilt=0.3)), "f+", "dual")
    owners = sheet.owners(plan.triangles, plan.triangle_polygons)
    assert len(owners) == len(sheet.polygons) == 30
    for vertex, owner in enumerate(owners.tolist()):
        shares = np.bincount(plan.triangle_polygons[sheet.triangles[sheet.polygons[vertex]]])
        assert vertex in plan.polygons[owner]
        assert shares[owner] == shares.max()


def sheared_grid() -> Plan:
    """Parallelograms, each cut along its long diagonal."""
    plan = grid(6, 5)
    x, y, z = plan.positions.T
    triangles = np.concatenate([[quad[[0, 1, 2]], quad[[0, 2, 3]]] for quad in plan.polygons])
    owner = np.repeat(np.arange(len(plan.polygons)), 2)
    return Plan(np.column_stack([x + 0.3 * y, y, z]), triangles, plan.polygons, triangle_polygons=owner)


@pytest.mark.parametrize("faces", ["dual", "corner"])
def test_what_the_plan_carries_comes_through_other_triangles(faces):
    """Where the triangles are not the plan's, corner values without seams are those of the vertices."""
    plan = sheared_grid()
    shell = form(plan, Settings(default_tilt=0.3, delaunay=True))
    assert shell.surface.graph.domain is not shell.surface.domain
    sheet = polygon_sheet(shell, "f+", faces)
    drawn = plan.positions[:, :2]
    flat = sheet.from_vertices(drawn)
    assert_allclose(sheet.from_corners(drawn[plan.triangles], plan.triangles), flat, rtol=0, atol=1e-12)
    assert (flat.min(axis=0) > drawn.min(axis=0) - 0.5).all() and (flat.max(axis=0) < drawn.max(axis=0) + 0.5).all()
    owners = sheet.owners(plan.triangles, plan.triangle_polygons)
    centres = np.array([drawn[polygon].mean(axis=0) for polygon in plan.polygons])[owners]
    middles = np.array([flat[polygon].mean(axis=0) for polygon in sheet.polygons])
    distance = np.linalg.norm(centres - middles, axis=1)
    assert np.median(distance) < 0.9 and distance.max() < 2.0


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"sites": "edges"}, 'no kind of sites "edges"; choose one of vertices, faces'),
        ({"method": "guess"}, 'no method "guess"; choose one of newton'),
        ({"combinatorics": "triple"}, 'no combinatorics "triple"; choose one of primal, dual, corner'),
        ({"energy": "mobius"}, "'mobius' is not defined for normals on vertices; choose cotan"),
    ],
)
def test_choices_are_checked(settings, message):
    with pytest.raises(CmcError, match=message):
        Settings(**settings)
