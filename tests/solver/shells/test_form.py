"""A shell formed over a plan: its size, place and conditions, cuts, and solvers used again."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from solver.catalogue import shapes
from solver.errors import Status
from solver.shells.form import form
from solver.shells.plan import Group, Plan, Settings
from solver.shells.shell import Shell, sheet_polygons
from solver.surface.placement import PlacementError, rim_weights
from tests.solver.drawn_plans import boundary_pairs, disc, grid


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
        (Settings(size="height", value=3), lambda f: f.report.shown.rise, 3),
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
    settings = Settings(size="height", value=4, flip=True, against="surface")
    sloped, straight = form(replace(level, positions=level.positions @ turn.T), settings), form(level, settings)
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


def test_a_plan_that_looks_down_is_noticed():
    plan = disc(4)
    down = form(replace(plan, triangles=plan.triangles[:, ::-1]))
    assert any("faces look down" in note for note in down.warnings)
    assert not any("faces look down" in note for note in form(plan).warnings)


def test_a_vertical_rim_is_no_overhang_worth_a_warning():
    """Faces beside it lean by a degree or two, the surface does not; a rim that leans out by 20° is reported."""
    shape = shapes.polygon([(0, 0), (10, 0), (10, 10), (0, 10)], max_edge=0.25, corner_radius=1.0)
    points = np.column_stack([shape.positions, np.zeros(len(shape.positions))])
    plan = Plan(points, shape.domain.faces)
    upright, leaning = (form(plan, Settings(default_tilt=np.radians(tilt))) for tilt in (0, -20))
    assert upright.report.shown.overhang.count > 0
    assert not any("overhangs" in note for note in upright.warnings)
    assert any("overhangs" in note for note in leaning.warnings)
    assert leaning.report.shown.overhang.largest_lean == pytest.approx(20, abs=5)
