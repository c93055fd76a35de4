"""The plan mesher: boundary edges in their places, good triangles inside, and messages about bad plans."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from solver import Domain, MeshError
from solver.meshing.mesher import PlanMesh, mesh_plan
from solver.meshing.outline import check_loops, inside, signed_area
from solver.meshing.quality import smallest_angles
from solver.meshing.triangulate import triangulate

SQUARE = np.array([[0.0, 0.0], [10.0, 0.0], [10.0, 10.0], [0.0, 10.0]])
L_SHAPE = np.array([[0.0, 0.0], [12.0, 0.0], [12.0, 4.0], [5.0, 4.0], [5.0, 10.0], [0.0, 10.0]])


def ellipse(count: int, a: float, b: float, centre=(0.0, 0.0)) -> np.ndarray:
    t = 2 * np.pi * np.arange(count) / count
    return np.column_stack([centre[0] + a * np.cos(t), centre[1] + b * np.sin(t)])


def star(points: int) -> np.ndarray:
    k = np.arange(2 * points)
    r = np.where(k % 2, 2.0, 6.0)
    return np.column_stack([r * np.cos(k * np.pi / points), r * np.sin(k * np.pi / points)])


def spiral() -> np.ndarray:
    a = np.linspace(0, 4 * np.pi, 300)
    ray = np.column_stack([np.cos(a), np.sin(a)])
    return np.concatenate([(5 + 0.9 * a)[:, None] * ray, ((2 + 0.9 * a)[:, None] * ray)[::-1]])


def blob() -> np.ndarray:
    t = 2 * np.pi * np.arange(200) / 200
    r = 8 + 1.2 * np.cos(2 * t + 0.3) + np.cos(3 * t + 1) + 0.6 * np.cos(5 * t + 2)
    return np.column_stack([r * np.cos(t), r * np.sin(t)])


def comb() -> np.ndarray:
    teeth = [(3 * k + dx, y) for k in range(6) for dx, y in [(0, 0), (0, 8), (1.5, 8), (1.5, 0)]]
    return np.array([(0, -2), *teeth[1:-1], (16.5, -2)], dtype=float)[::-1]


def corridor() -> np.ndarray:
    t = np.linspace(0, 1, 60)
    centre = np.column_stack([4 * t, 0.5 * np.sin(9 * t)])
    along = np.gradient(centre, axis=0)
    left = 0.19 * np.column_stack([-along[:, 1], along[:, 0]]) / np.linalg.norm(along, axis=1)[:, None]
    return np.concatenate([centre - left, (centre + left)[::-1]])


def skyline() -> np.ndarray:
    """Towers with a step of 0.013 in one of them, far from which large triangles have their circumcentres."""
    roof = [
        (3.089, 1.475),
        (2.094, 1.475),
        (2.094, 0.497),
        (1.504, 0.497),
        (1.504, 1.323),
        (1.145, 1.323),
        (1.145, 1.307),
        (0.817, 1.307),
        (0.817, 1.796),
        (0.486, 1.796),
        (0.486, 0.219),
        (0.414, 0.219),
    ]
    return np.array([(0.414, 0.0), (3.089, 0.0), *roof])


COLUMNS = [ellipse(25, 0.35, 0.35, (x, y)) for x in range(2, 19, 4) for y in range(2, 11, 4)]
HALL = np.array([[0.0, 0.0], [20.0, 0.0], [20.0, 12.0], [0.0, 12.0]])
SLIT = np.array([[0, 0], [10, 0], [10, 6], [5.02, 6], [5.02, 1.5], [5, 1.5], [5, 6], [0, 6]], dtype=float)

ZOO = {
    "square": dict(outline=SQUARE, max_edge=0.7),
    "L": dict(outline=L_SHAPE, max_edge=0.6),
    "rounded L": dict(outline=L_SHAPE, max_edge=0.6, corner_radius=1.0),
    "thin": dict(outline=SQUARE * [2, 0.05], max_edge=1.0),
    "rounded star": dict(outline=star(7), max_edge=0.4, corner_radius=0.5),
    "courtyard": dict(outline=HALL, holes=[[(8, 4), (13, 4), (13, 8), (8, 8)]], max_edge=0.6, corner_radius=0.8),
    "columns": dict(outline=HALL, holes=COLUMNS, max_edge=0.6),
    "pavilion": dict(outline=SQUARE * [1, 0.6], max_edge=0.5, corner_radius=2.0),
    "spiral": dict(outline=spiral(), max_edge=0.8),
    "blob": dict(outline=blob(), max_edge=0.7),
    "comb": dict(outline=comb(), max_edge=0.6),
    "slit": dict(outline=SLIT, max_edge=0.5),
    "circle": dict(outline=ellipse(100, 1, 1), max_edge=0.12),
    "huge radius": dict(outline=L_SHAPE, max_edge=0.6, corner_radius=100.0),
    "flat": dict(outline=SQUARE * [1, 0.35], max_edge=0.9),
    "corridor": dict(outline=corridor(), max_edge=0.2),
    "skyline": dict(outline=skyline(), max_edge=0.0535, corner_radius=0.27),
    "coarse": dict(outline=L_SHAPE, max_edge=9.0),
}


def check(mesh: PlanMesh) -> Domain:
    """The mesh covers exactly what its boundary edges bound, and its boundary is those edges."""
    domain = Domain.from_positions(mesh.positions, mesh.triangles)
    assert domain.euler_characteristic == 1 - mesh.loop.max()
    rim = domain.edges[domain.boundary_edges]
    assert_array_equal(rim[np.argsort(rim[:, 0])], mesh.edges)
    bounded = sum(signed_area(mesh.positions[mesh.edges[mesh.loop == k, 0]]) for k in range(mesh.loop.max() + 1))
    assert_allclose(domain.area, bounded, rtol=1e-11)
    assert domain.vertex_count == len(mesh.positions)
    return domain


def smallest(mesh: PlanMesh) -> float:
    return np.degrees(smallest_angles(mesh.positions, mesh.triangles).min())


def bridges(mesh: PlanMesh) -> int:
    """Inner edges between two boundary vertices."""
    ends = np.sort(np.concatenate([np.roll(mesh.triangles, k, axis=1)[:, :2] for k in range(3)]), axis=1)
    edges, faces = np.unique(ends, axis=0, return_counts=True)
    return int(np.sum((edges < len(mesh.edges)).all(axis=1) & (faces == 2)))


@pytest.mark.parametrize("name", ZOO)
def test_every_plan_is_meshed_well(name):
    mesh = mesh_plan(**ZOO[name])
    domain = check(mesh)
    assert smallest(mesh) > 30
    assert bridges(mesh) == 0, "N would be given all around a triangle"
    assert domain.edge_lengths.max() < 1.45 * ZOO[name]["max_edge"]
    assert domain.edge_lengths[domain.boundary_edges].max() <= ZOO[name]["max_edge"] * (1 + 1e-9)


@pytest.mark.parametrize("name", ["square", "blob", "L", "pavilion"])
def test_wide_plans_have_the_wanted_edge_length(name):
    mesh = mesh_plan(**ZOO[name])
    lengths = check(mesh).edge_lengths / ZOO[name]["max_edge"]
    assert 0.95 < np.median(lengths) < 1.05
    assert lengths.min() > 0.5
    angles = np.degrees(smallest_angles(mesh.positions, mesh.triangles))
    assert angles.mean() > 53


def test_finer_meshes_are_equilateral_away_from_the_rim():
    mesh = mesh_plan(SQUARE, max_edge=0.12)
    check(mesh)
    angles = np.degrees(smallest_angles(mesh.positions, mesh.triangles))
    assert np.mean(angles > 59.9) > 0.6


@pytest.mark.parametrize("seed", range(24))
def test_random_plans(seed):
    mesh, sharpest = random_plan(np.random.default_rng(seed))
    check(mesh)
    # A sharp corner cannot be better than it is, and is divided only where that leaves more than about 22°.
    assert smallest(mesh) > min(28.0, 0.45 * sharpest)


def random_plan(random: np.random.Generator) -> tuple[PlanMesh, float]:
    """A jagged, a smooth or a stepped outline with a few random holes, and the sharpest inner angle of its mesh."""
    kind = random.integers(3)
    if kind == 0:
        angle = np.cumsum(random.uniform(0.3, 1.0, random.integers(5, 40)))
        angle *= 2 * np.pi / (angle[-1] + 0.5)
        outline = random.uniform(0.4, 1, (len(angle), 1)) * np.column_stack([np.cos(angle), np.sin(angle)])
    elif kind == 1:
        outline = ellipse(300, 1, random.uniform(0.1, 1))
        t = 2 * np.pi * np.arange(300) / 300
        wave = sum(random.normal() * 0.3 / k * np.cos(k * t + random.uniform(0, 6)) for k in range(1, 8))
        outline *= np.maximum(1 + wave, 0.15)[:, None]
    else:
        x, y = np.cumsum(random.uniform(0.05, 1, 9)), random.uniform(0.1, 2, 8)
        steps = [p for k in range(7, -1, -1) for p in [(x[k + 1], y[k]), (x[k], y[k])]]
        outline = np.array([(x[0], 0), (x[-1], 0), *steps])
    size = np.ptp(outline, axis=0).max()
    holes = []
    for _ in range(random.integers(0, 5)):
        hole = ellipse(random.integers(3, 9), 0.04 * size, 0.03 * size, random.uniform(-0.4, 0.4, 2) * size)
        try:
            check_loops(outline, [*holes, hole])
        except MeshError:
            continue  # outside, or across another one
        holes.append(hole)
    mesh = mesh_plan(
        outline, holes, max_edge=size * random.choice([0.04, 0.1, 0.3]), corner_radius=size * random.choice([0, 0.03])
    )
    before = np.empty(len(mesh.edges), dtype=int)
    before[mesh.edges[:, 1]] = mesh.edges[:, 0]
    ahead = mesh.positions[mesh.edges[:, 1]] - mesh.positions[mesh.edges[:, 0]]
    back = mesh.positions[before] - mesh.positions[mesh.edges[:, 0]]
    cross = ahead[:, 0] * back[:, 1] - ahead[:, 1] * back[:, 0]
    return mesh, float(np.min(np.degrees(np.arctan2(cross, np.sum(ahead * back, axis=1))) % 360))


def test_corners_stay_exactly_and_sides_are_divided_evenly():
    mesh = mesh_plan(L_SHAPE, max_edge=0.7)
    for corner in L_SHAPE:
        assert np.any(np.all(np.abs(mesh.positions - corner) < 1e-12, axis=1))
    length = np.linalg.norm(np.diff(mesh.positions[mesh.edges], axis=1)[:, 0], axis=1)
    for k in range(6):
        side = length[mesh.segment == k]
        assert_allclose(side, side[0], rtol=0.02)  # sides of 0.667 beside sides of 0.7
    assert_allclose(mesh.positions[0], L_SHAPE[0], atol=1e-12)


@pytest.mark.parametrize("clockwise", [False, True])
def test_edges_remember_the_segment_they_come_from(clockwise):
    outline = L_SHAPE[::-1] if clockwise else L_SHAPE
    hole = np.array([[1.0, 1.0], [3.0, 1.0], [3.0, 3.0], [1.0, 3.0]])
    mesh = mesh_plan(outline, [hole], max_edge=0.5)
    loops = [outline, hole]
    middle = mesh.positions[mesh.edges].mean(axis=1)
    for loop, segment, point in zip(mesh.loop, mesh.segment, middle, strict=True):
        a, b = loops[loop][segment], loops[loop][(segment + 1) % len(loops[loop])]
        along = (point - a) @ (b - a) / np.sum((b - a) ** 2)
        assert 0 < along < 1
        assert_allclose(a + along * (b - a), point, atol=1e-9)


def test_an_arc_is_divided_at_its_middle():
    mesh = mesh_plan(SQUARE, max_edge=0.5, corner_radius=2.0)
    check(mesh)
    middle = mesh.positions[mesh.edges].mean(axis=1)
    nearest = np.argmin([middle[:, 1], 10 - middle[:, 0], 10 - middle[:, 1], middle[:, 0]], axis=0)
    assert_array_equal(mesh.segment, nearest)
    centre = np.clip(mesh.positions[: len(mesh.edges)], 2, 8)
    assert_allclose(np.linalg.norm(mesh.positions[: len(mesh.edges)] - centre, axis=1), 2.0, atol=5e-4)
    assert_allclose(mesh.positions[0], 2 - np.sqrt(2) * np.ones(2), atol=1e-9)


def test_a_radius_too_large_makes_a_circle_of_a_square():
    mesh = mesh_plan(SQUARE, max_edge=0.5, corner_radius=1e6)
    assert_allclose(np.linalg.norm(mesh.positions[: len(mesh.edges)] - 5, axis=1), 5.0, atol=1e-3)


def test_a_smooth_curve_is_no_corner():
    plain = mesh_plan(ellipse(60, 5, 3), max_edge=0.8)
    rounded = mesh_plan(ellipse(60, 5, 3), max_edge=0.8, corner_radius=1.0)
    assert_array_equal(plain.positions, rounded.positions)


def test_where_a_curve_meets_a_chord_the_corner_is_rounded_smoothly():
    half = np.array([[np.cos(t), np.sin(t)] for t in np.linspace(0, np.pi, 80)]) * 5
    mesh = mesh_plan(half, max_edge=0.3, corner_radius=1.0)
    check(mesh)
    boundary = mesh.positions[: len(mesh.edges)]
    step = np.roll(boundary, -1, axis=0) - boundary
    before = np.roll(step, 1, axis=0)
    turn = np.arctan2(before[:, 0] * step[:, 1] - before[:, 1] * step[:, 0], np.sum(before * step, axis=1))
    assert np.degrees(np.abs(turn).max()) < 18
    assert_allclose(turn.sum(), 2 * np.pi, rtol=1e-12)


def test_a_column_in_the_way_of_an_arc_shrinks_it():
    column = ellipse(12, 0.2, 0.2, (0.6, 0.6))
    mesh = mesh_plan(SQUARE, [column], max_edge=1.0, corner_radius=4.0)
    check(mesh)
    assert mesh.positions[: len(mesh.edges)].sum(axis=1).min() < 0.8  # this arc passes outside the column
    assert np.linalg.norm(mesh.positions - [10, 10], axis=1).min() > 1.5  # the others are as asked


def test_points_to_keep_and_points_between_long_segments_stay_vertices():
    wall = np.array([[0, 0], [1.3, 0], [5, 0], [10, 0], [10, 6], [0, 6]], dtype=float)
    mesh = mesh_plan(wall, max_edge=1.8, keep=[[1]])
    for point in wall:
        assert np.any(np.all(np.abs(mesh.positions - point) < 1e-12, axis=1))
    assert set(mesh.segment) == set(range(6))


@pytest.mark.parametrize("scale", [2.0**-10, 2.0**20])
def test_scale_does_not_matter(scale):
    plan = mesh_plan(HALL, COLUMNS[:4], max_edge=0.75, corner_radius=0.5)
    other = mesh_plan(HALL * scale, [c * scale for c in COLUMNS[:4]], max_edge=0.75 * scale, corner_radius=0.5 * scale)
    assert_array_equal(plan.triangles, other.triangles)
    assert_allclose(other.positions, plan.positions * scale, rtol=1e-12)


def test_place_does_not_matter():
    offset = np.array([4.5e6, -3.2e5])  # metres in a national grid
    plan = mesh_plan(L_SHAPE, max_edge=0.5, corner_radius=1.0)
    far = mesh_plan(L_SHAPE + offset, max_edge=0.5, corner_radius=1.0)
    check(far)
    assert len(far.edges) == len(plan.edges)
    assert_allclose(far.positions[: len(far.edges)] - offset, plan.positions[: len(plan.edges)], atol=1e-8)
    assert smallest(far) > 30


def test_repeated_last_point_and_direction_do_not_matter():
    closed = np.concatenate([L_SHAPE, L_SHAPE[:1]])
    assert_array_equal(mesh_plan(closed, max_edge=0.9).positions, mesh_plan(L_SHAPE, max_edge=0.9).positions)
    turned = np.concatenate([L_SHAPE[:1], L_SHAPE[:0:-1]])
    assert_array_equal(mesh_plan(turned, max_edge=0.9).positions, mesh_plan(L_SHAPE, max_edge=0.9).positions)


def test_the_same_plan_gives_the_same_mesh():
    one, two = (mesh_plan(**ZOO["courtyard"]) for _ in range(2))
    assert_array_equal(one.positions, two.positions)
    assert_array_equal(one.triangles, two.triangles)


def test_a_boundary_edge_that_delaunay_misses_is_recovered():
    # Two long edges a hair apart with points in between on the far side of each.
    points = np.array([[1, 0], [9, 0], [9, 0.1], [5, 0.05], [1, 0.1], [0, -3], [10, -3], [10, 3], [0, 3]], dtype=float)
    edges = np.array([[5, 6], [6, 7], [7, 8], [8, 5], [0, 4], [4, 3], [3, 2], [2, 1], [1, 0]])
    triangles = triangulate(points, edges)
    used = np.sort(np.concatenate([np.roll(triangles, k, axis=1)[:, :2] for k in range(3)]), axis=1)
    assert set(map(tuple, np.sort(edges, axis=1).tolist())) <= set(map(tuple, used.tolist()))
    corners = points[triangles]
    area = np.linalg.det(corners[:, 1:] - corners[:, :1]) / 2
    assert (area > 0).all()
    assert_allclose(area.sum(), 60 - 0.6, rtol=1e-12)


def test_inside_follows_the_even_odd_rule():
    hole = np.array([[4.0, 4.0], [6.0, 4.0], [6.0, 6.0], [4.0, 6.0]])
    starts = np.concatenate([SQUARE, hole])
    ends = np.concatenate([np.roll(SQUARE, -1, axis=0), np.roll(hole, -1, axis=0)])
    points = np.random.default_rng(5).uniform(-2, 12, (500, 2))
    expected = np.all((points > 0) & (points < 10), axis=1) & ~np.all((points > 4) & (points < 6), axis=1)
    assert_array_equal(inside(points, starts, ends), expected)


BOW_TIE = [(0, 0), (4, 3), (4, 0), (0, 3)]
BAD = {
    "shape": (dict(outline=[1, 2, 3]), r"shape \(3,\)", ()),
    "words": (dict(outline=[("a", "b")] * 3), "not numbers", ()),
    "two points": (dict(outline=[(0, 0), (1, 0)]), "has 2 points", ()),
    "three that are two": (dict(outline=[(0, 0), (1, 0), (0, 0)]), "has 2 points", ()),
    "nan": (dict(outline=[(0, 0), (4, 0), (4, np.nan), (0, 3)]), "Point 2 of the outline is not finite", (2,)),
    "nan in a hole": (
        dict(outline=SQUARE, holes=[[(1, 1), (2, 1), (2, np.inf)]]),
        "Point 2 of hole 0 is not finite",
        (6,),
    ),
    "repeated": (dict(outline=[(0, 0), (4, 0), (4, 0), (0, 3)]), "Points 1 and 2 of the outline", (1, 2)),
    "pinched": (
        dict(outline=[(0, 0), (4, 0), (4, 3), (2, 1), (0, 3), (2, 1)]),
        "Points 3 and 5 of the outline",
        (3, 5),
    ),
    "spike": (
        dict(outline=[(0, 0), (4, 0), (4, 3), (4, 9), (4, 3.5), (0, 3)]),
        "Point 3 of the outline is a spike",
        (3,),
    ),
    "line": (dict(outline=[(0, 0), (4, 0), (9, 0)]), "encloses no area", (0, 1, 2)),
    "bow tie": (dict(outline=BOW_TIE), "its segments 0 and 2 meet", (0, 1, 2, 3)),
    "touching": (
        dict(outline=[(0, 0), (8, 0), (8, 4), (6, 4), (4, 0), (2, 4), (0, 4)]),
        "outline crosses or touches itself: its segments 0 and 3 meet",
        (0, 1, 3, 4, 5),
    ),
    "hole across": (
        dict(outline=SQUARE, holes=[[(8, 4), (12, 4), (12, 6), (8, 6)]]),
        "outline and hole 0 cross or touch: segment 1 meets segment 0",
        (1, 2, 4, 5, 6, 7),
    ),
    "hole outside": (dict(outline=SQUARE, holes=[[(12, 4), (13, 4), (13, 6)]]), "Hole 0 lies outside", (4, 5, 6)),
    "holes across": (
        dict(outline=SQUARE, holes=[[(1, 1), (4, 1), (4, 4), (1, 4)], [(3, 3), (6, 3), (6, 6), (3, 6)]]),
        "hole 0 and hole 1 cross",
        None,
    ),
    "hole in hole": (
        dict(outline=SQUARE, holes=[[(1, 1), (6, 1), (6, 6), (1, 6)], [(3, 3), (5, 3), (5, 5)]]),
        "Hole 1 lies inside hole 0",
        (8, 9, 10),
    ),
    "length": (dict(outline=SQUARE, max_edge=0.0), "give a positive length", ()),
    "no length": (dict(outline=SQUARE, max_edge=np.nan), "give a positive length", ()),
    "too long": (dict(outline=SQUARE, max_edge=12.0), "larger than the plan, which measures 10; .* 0.5 ", ()),
    "too short": (dict(outline=SQUARE, max_edge=1e-4), "would make about", ()),
    "radius": (dict(outline=SQUARE, corner_radius=-1.0), "corner radius is -1", ()),
    "keep": (dict(outline=SQUARE, keep=[[7]]), "Point 7 to keep", ()),
}


@pytest.mark.parametrize("name", BAD)
def test_bad_plans_are_refused_by_name(name):
    plan, message, vertices = BAD[name]
    with pytest.raises(MeshError, match=f"(?i){message}") as caught:
        mesh_plan(**{"max_edge": 0.5, **plan})
    assert vertices is None or caught.value.vertices == vertices
    assert str(caught.value).endswith(".")
