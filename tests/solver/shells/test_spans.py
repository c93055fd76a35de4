"""Shells on lines: forms that are spanned, against spheres, soap films and other ways to the same surface."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

from solver import CmcError, ConditionError, Plan, Settings, conditions, form, shapes, span_outline
from solver.shells.plan import plan_domain
from solver.shells.update import update
from solver.surface.solve import CmcSolver

HALL = np.array([(0, 0), (8, 0), (8, 5), (0, 5.0)])


@pytest.fixture(scope="module")
def disc():
    return shapes.disc(900)


@pytest.fixture(scope="module")
def hall():
    return shapes.polygon(HALL, max_edge=0.4)


@pytest.mark.parametrize(
    "settings, height, H",
    [
        (Settings(), 0.35, 0.6236),
        (Settings(flip=True), -0.35, -0.6236),
        (Settings(size="rise", value=0.5), 0.5, 0.8),
        (Settings(size="height", value=-0.5), -0.5, -0.8),
        (Settings(size="mean_curvature", value=0.0), 0.0, 0.0),
        (Settings(size="mean_curvature", value=-0.6), -1.0 / 3.0, -0.6),
        (Settings(size="volume", value=np.pi / 6 * 0.5 * (3 + 0.25)), 0.5, 0.8),
        (Settings(size="volume", value=0.85, flip=True), -0.5, -0.8),
    ],
)
def test_shells_over_a_circle_are_caps(disc, settings, height, H):
    """Of height h and radius 1/H = (1 + h²) / 2h over the unit circle, with the volume π h (3 + h²) / 6."""
    shell = form(Plan.from_shape(disc, {"outer": "line"}), settings)
    assert shell.ok and shell.span is not None and shell.span.ok
    z = shell.points()[:, 2]
    assert_allclose(z[np.abs(z).argmax()], height, rtol=4e-3, atol=1e-9)
    assert_allclose(shell.report.mean_curvature, H, rtol=4e-3, atol=1e-9)
    assert_allclose(shell.report.shown.mean_curvature.mean, H, rtol=0.01, atol=1e-3)
    rim = shell.points()[disc.domain.boundary_vertices]
    assert_allclose(np.linalg.norm(rim[:, :2], axis=1), 1.0, rtol=1e-12)
    assert_allclose(rim[:, 2], 0.0, atol=1e-12)
    assert [note.code for note in shell.warnings] == (["point"] if H else [])
    if H:
        assert np.ptp(shell.placed["gauss"], axis=0).max() < 2.0 / abs(H)


def test_a_soap_film_has_no_twin(disc):
    shell = form(Plan.from_shape(disc), Settings(default_kind="line", size="mean_curvature", value=0.0))
    assert sorted(shell.placed) == ["f+", "gauss"]
    assert shell.report.shown.mean_curvature.reference == pytest.approx(1 / np.sqrt(np.pi), rel=1e-2)
    with pytest.raises(CmcError, match=r'no sheet "f-"'):
        shell.points("f-")


def test_lines_with_heights_without_a_size_are_soap_films():
    raised = shapes.disc(600)
    x, y = raised.positions[:, :2].T
    plan = Plan(np.column_stack([x, y, 0.3 * (x**2 - y**2)]), raised.domain.faces)
    shell = form(plan, Settings(default_kind="line"))
    assert shell.ok and shell.report.mean_curvature == 0.0
    assert shell.report.shown.outline is not None and shell.report.shown.outline.max < 1e-4  # the spline
    assert "even to" in shell.message and "%" not in shell.message


def test_a_span_is_that_of_span_outline(hall):
    """Lines, a lean and a mirror, by both doors."""
    sides = {
        "side0": "line",
        "side1": "line",
        "side2": ("lean", {"angle": np.radians(60)}),
        "side3": ("mirror", {"normal": (-1, 0, 0)}),
    }
    shell = form(Plan.from_shape(hall, sides), Settings(size="rise", value=0.4))
    span = span_outline(
        hall, hall.positions, rise=0.4, leans=[("side2", np.radians(60))], mirrors=[("side3", (-1, 0, 0))]
    )
    assert shell.ok, shell.message
    assert_allclose(shell.points(), span.points, atol=1e-9)
    assert shell.report.planes[0].relative < 1e-9
    over = shell.points()[np.unique(hall.domain.edges[hall.sides["side2"]])]
    assert_allclose(over[:, 1], 5.0, atol=1e-12)
    assert np.ptp(over[:, 2]) > 0.3
    assert shell.report.shown.mean_curvature.left_out > 0 and "away from corners" in shell.message


def test_a_flipped_shell_with_a_lean_is_the_mirror_image(hall):
    plan = Plan.from_shape(hall, {"side2": ("lean", {"angle": np.radians(60)})})
    up, down = (form(plan, Settings(default_kind="line", flip=flip)).points() for flip in (False, True))
    assert_allclose(down, up * [1, 1, -1], atol=1e-5)


def test_edges_in_no_group_may_lie_on_their_line(hall):
    by_group = form(Plan.from_shape(hall, {"outer": "line"}))
    by_default = form(Plan.from_shape(hall), Settings(default_kind="line"))
    assert_allclose(by_default.points(), by_group.points(), atol=0)


def test_a_chosen_curve_takes_the_place_of_a_loop(disc):
    """From another start, the other way round, and raised by 0.2."""
    angles = -np.linspace(0, 2 * np.pi, 90, endpoint=False) + 1.0
    curve = np.column_stack([np.cos(angles), np.sin(angles), np.full(90, 0.2)])
    shell = form(Plan.from_shape(disc, {"outer": ("line", {"curve": curve})}), Settings(size="rise", value=0.5))
    rim = shell.points()[disc.domain.boundary_vertices]
    assert shell.ok
    assert_allclose(rim[:, 2], 0.2, atol=1e-9)
    assert_allclose(shell.points()[:, 2].max(), 0.7, rtol=1e-3)
    assert shell.report.shown.outline.max < 2e-3  # of the spline from the polygon with 90 corners


def test_a_ring_of_one_drawn_loop_and_one_curve():
    ring = shapes.annulus(0.5, 1.0, 900)
    angles = np.linspace(0, 2 * np.pi, 90, endpoint=False)
    upper = np.column_stack([0.6 * np.cos(angles), 0.6 * np.sin(angles), np.full(90, 0.5)])
    plan = Plan.from_shape(ring, {"outer": "line", "inner": ("line", {"curve": upper})})
    shell = form(plan, Settings(size="mean_curvature", value=0.0))
    assert shell.ok, shell.message
    z = np.sort(np.unique(np.round(shell.points()[ring.domain.boundary_vertices][:, 2], 9)))
    assert_allclose(z, [0.0, 0.5], atol=1e-9)


def test_a_neck_that_closes_is_said(disc):
    ring = shapes.annulus(0.5, 1.0, 900)
    angles = np.linspace(0, 2 * np.pi, 90, endpoint=False)
    upper = np.column_stack([0.6 * np.cos(angles), 0.6 * np.sin(angles), np.full(90, 1.3)])
    plan = Plan.from_shape(ring, {"outer": "line", "inner": ("line", {"curve": upper})})
    shell = form(plan, Settings(size="mean_curvature", value=0.0))
    assert not shell.ok and "neck" in shell.message
    assert "not-converged" in [note.code for note in shell.warnings]
    assert shell.report.status == "no surface"


def test_spans_continue_from_the_last_one(hall):
    plan = Plan.from_shape(hall, {"outer": "line"})
    first = form(plan, Settings(size="mean_curvature", value=0.15))
    settings = Settings(size="mean_curvature", value=0.16)
    warm, cold = form(plan, settings, initial=first.span, solver=first.solver), form(plan, settings)
    assert len(warm.span.history) < len(cold.span.history)
    assert_allclose(warm.points(), cold.points(), atol=1e-5)
    with pytest.raises(ConditionError, match="continues from the span of an earlier one"):
        form(plan, settings, initial=first.surface.harmonic.normals)


def test_updates_follow_a_line_and_a_kind(hall):
    """As live updates do: the number changes, then a vertex of the line, then the sides become rim-free."""
    plan = Plan.from_shape(hall, {"outer": "line"})
    solver = CmcSolver(plan_domain(plan))
    first = form(plan, Settings(size="rise", value=0.3), solver=solver)
    higher = update(plan, Settings(size="rise", value=0.32), solver, first.span)
    assert higher.ok and higher.span is not None
    assert_allclose(higher.placed["f+"][:, 2].max(), 0.8, atol=1e-3)
    moved = plan.positions.copy()
    moved[hall.domain.boundary_vertices, 2] = 0.05 * moved[hall.domain.boundary_vertices, 0]
    raised = Plan(moved, plan.triangles, groups=plan.groups)
    solver = CmcSolver(plan_domain(raised))
    followed = update(raised, Settings(size="rise", value=0.32), solver, higher.last)
    assert followed.ok
    assert_allclose(
        followed.placed["f+"], form(raised, Settings(size="rise", value=0.32)).points(), atol=2e-3
    )
    free = Plan.from_shape(hall, {"outer": ("binormal", {"tilt": 0.6})})
    assert update(free, Settings(), CmcSolver(plan_domain(free)), higher.last).span is None


def test_plans_on_lines_that_cannot_be_spanned_are_refused(hall):
    cases = [
        ({}, {"method": "saddle"}, r'leave out "method"'),
        ({}, {"degree": 1.0}, r'leave out "degree"'),
        ({}, {"size": "span", "value": 3.0}, r'is not sized by "span"; choose rise, height'),
        ({}, {"sheet": "f-"}, r"f- is its twin; show f\+"),
        ({"side0": ("lean", {"angle": 0.01})}, {}, r'Group "side0": A lean of 0\.573° is out of range'),
        ({"side0": ("mirror", {"normal": (0, -1, 0), "winding": 1})}, {}, r"take the winding out"),
        ({"side0": ("line", {"curve": 2 * HALL})}, {}, r"takes the place of a whole boundary loop"),
    ]
    for sides, settings, message in cases:
        with pytest.raises(CmcError, match=message):
            form(Plan.from_shape(hall, sides), Settings(**{"default_kind": "line", **settings}))
    with pytest.raises(CmcError, match=r'rim free is not sized by "volume"'):
        form(Plan.from_shape(hall), Settings(size="volume", value=3.0))
    with pytest.raises(CmcError, match="height must be a positive number"):
        form(Plan.from_shape(hall), Settings(size="height", value=-3.0))


def test_conditions_add_up(hall):
    walls = conditions.lean(hall, ["side1", "side2"], 1.0)
    rim = conditions.line(hall, "side0") + walls + conditions.line(hall, "side3")
    assert rim.is_spanned and not rim.is_empty
    assert len(rim.lines) + len(rim.leans) == len(hall.domain.boundary_edges)
    assert repr(rim) == f"Conditions({len(rim.lines)} edges on lines, {len(rim.leans)} leaning edges)"
