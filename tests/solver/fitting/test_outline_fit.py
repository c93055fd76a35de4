"""Fits to outlines whose answers are known, and goals that no surface meets."""

from functools import partial

import numpy as np
import pytest
from numpy.testing import assert_allclose

from solver import ConditionError, conditions, conformal_distortion, fit, mean_curvature_of, shapes, span_outline
from solver.fitting.curves import Curve
from solver.fitting.fit import FitStatus, Start
from solver.fitting.outline import fit_outline
from solver.fitting.targets import Anchors, Crown, SmoothRim


def test_closest_points_of_a_curve():
    square = Curve(np.array([[0, 0, 0], [2, 0, 0], [2, 2, 0], [0, 2, 0.0]]), closed=True)
    found = square.closest(np.array([[1, -1, 0], [3, 3, 1], [0.2, 1, 0.0]]))
    assert_allclose(found.points, [[1, 0, 0], [2, 2, 0], [0, 1, 0]], rtol=0, atol=1e-12)
    assert_allclose(square.length, 8)
    assert_allclose(square.at(np.array([0.0, 0.125, 0.5])), [[0, 0, 0], [1, 0, 0], [2, 2, 0]], rtol=0, atol=1e-12)
    assert_allclose(square.shares, 0.25)


@pytest.mark.parametrize("rise", [0.1, 0.45, 0.8])
def test_a_circle_gives_the_exact_cap(rise):
    shape = shapes.disc(800)
    found = fit_outline(shape.domain, shape.positions, rise=rise, max_evaluations=90)
    points = found.points()
    radius = (1 + rise**2) / (2 * rise)
    miss = np.linalg.norm(points - [0, 0, rise - radius], axis=1) - radius
    assert found.is_met, found.message
    assert_allclose(points[:, 2].max(), rise, rtol=1e-4, atol=0)
    assert_allclose(1 / found.surface.mean_curvature, radius, rtol=3e-3, atol=0)
    assert np.abs(miss).max() < 2e-3


def test_the_unit_of_the_domain_does_not_matter():
    shape = shapes.disc(300)
    found = fit_outline(shape.domain, 500.0 * shape.positions, height=40.0)
    assert found.is_met and len(found.history) < 25
    assert_allclose(1 / found.surface.mean_curvature, (500**2 + 40**2) / 80, rtol=3e-3, atol=0)


@pytest.mark.parametrize("rise", [0.05, 0.25, 0.45])
def test_a_square_keeps_its_outline(rise):
    shape = shapes.polygon([[-1, -1], [1, -1], [1, 1], [-1, 1]], max_edge=0.07, corner_radius=0.2)
    found = fit_outline(shape.domain, shape.positions, rise=rise)
    assert len(found.history) < 60
    size = np.linalg.norm(np.ptp(shape.positions[:, :2], axis=0))
    assert found.is_met, found.message
    assert found.distances["rim on curve"] < 2e-3 * size
    H = mean_curvature_of(found.points(), found.surface.faces, found.surface.normals)
    assert np.median(np.abs(H / found.surface.mean_curvature - 1)) < 0.03


def courtyard():
    angle = np.linspace(0, 2 * np.pi, 48, endpoint=False)
    circle = np.column_stack([np.cos(angle), np.sin(angle)])
    return shapes.polygon(circle, holes=[0.4 * circle + [0.15, 0.1]], max_edge=0.08)


@pytest.mark.parametrize("rise", [0.05, 0.3])
def test_a_shell_over_a_courtyard_lies_on_both_its_lines(rise):
    """The surface is conformal to the plan with the moduli of the lines, not to the plan as drawn."""
    plan = courtyard()
    found = fit_outline(plan.domain, plan.positions, rise=rise)
    assert found.ok and not found.surface.is_open and found.distances["period"] == 0
    assert found.distances["rim on curve"] < 4e-3
    inner = plan.domain.boundary_loops[np.argmin([len(loop) for loop in plan.domain.boundary_loops])]
    assert_allclose(np.linalg.norm(found.points()[inner, :2] - [0.15, 0.1], axis=1), 0.4, rtol=0, atol=1e-3)
    Q = [conformal_distortion(domain, found.points()) for domain in (found.surface.domain, plan.domain)]
    assert np.mean(Q[0] - 1) < 0.02 and np.mean(Q[0]) < np.mean(Q[1])
    assert rise < 0.1 or np.mean(Q[1] - 1) > 0.02
    line = [plan.positions[loop] * [1, 1] + [5, 0] for loop in plan.domain.boundary_loops]
    moved = fit_outline(plan.domain, plan.positions, line, rise=rise)
    assert_allclose(moved.points().mean(axis=0), found.points().mean(axis=0) + [5, 0, 0], rtol=0, atol=1e-3)


def test_a_search_over_a_courtyard_starts_with_both_rims_on_their_lines():
    plan = courtyard()
    found = fit_outline(plan.domain, plan.positions, rise=0.3, smooth=1e-8)
    assert found.is_met and found.span is None and len(found.history) < 40, found.message
    assert found.distances["rim on curve"] < 0.02 and found.surface.gap < 1e-3


@pytest.mark.parametrize("sheet", ["f+", "f-"])
def test_lines_and_one_number_are_spanned(sheet):
    """The fit is the span: as either sheet, g centred, its rim on the sharp lines, normals to the outer side."""
    roof = shapes.polygon([[0, 0], [4, 0], [4, 3], [0, 3]], max_edge=0.4)
    points = np.column_stack([roof.positions + [7.0, 1.0], np.full(roof.domain.vertex_count, 2.0)])
    found, span = (call(roof, points, height=0.6) for call in (partial(fit_outline, sheet=sheet), span_outline))
    assert found.ok and found.message == span.message and len(found.history) < 12
    assert_allclose(found.points(), span.points, rtol=0, atol=1e-12)
    assert_allclose(found.normals(), span.normals, rtol=0, atol=1e-12)
    assert np.abs(found.points()[roof.domain.boundary_vertices, 2] - 2.0).max() < 1e-12
    assert_allclose(found.surface.g[roof.domain.boundary_vertices].mean(axis=0), 0, rtol=0, atol=1e-12)
    assert found.distances["crown height"] < 1e-5 and found.surface.mean_curvature == pytest.approx(span.mean_curvature)
    again = fit_outline(roof, points, height=0.65, sheet=sheet, initial=found)
    assert again.ok and len(again.history) <= len(found.history)


def test_mean_curvature_zero_and_below():
    """A soap film over a raised loop, and a cap that hangs: H >= 0 at a sign."""
    disc = shapes.disc(400)
    x, y = disc.positions.T
    raised = np.column_stack([x, y, 0.2 * (x**2 - y**2)])
    film = fit_outline(disc, raised, mean_curvature=0.0)
    assert film.ok and film.surface.mean_curvature == 0.0 and film.sign == 1.0
    H = mean_curvature_of(film.points(), film.surface.faces, film.normals())
    assert np.nanmax(np.abs(H)) < 0.03
    cap = fit_outline(disc, disc.positions, mean_curvature=-0.5)
    assert cap.ok and cap.sign == -1.0 and cap.surface.mean_curvature == pytest.approx(0.5)
    assert_allclose(cap.points()[:, 2].min(), np.sqrt(3) - 2, rtol=2e-3, atol=0)
    with pytest.raises(ConditionError, match="positive"):
        fit_outline(disc, raised, mean_curvature=0.0, tilt=(0.0, 1.5))


def test_a_low_crown_is_met_although_it_hardly_shows():
    """Its height is met to a millionth of itself, below what the residual lets it be known to at first."""
    roof = shapes.polygon([[0, 0], [3, 0], [3, 1], [0, 1]], max_edge=(0.002 * 3**0.5) ** 0.5, corner_radius=0.3)
    found = fit_outline(roof, roof.positions, rise=0.05)
    assert found.ok and len(found.history) < 12, found.message
    assert found.points()[:, 2].max() == pytest.approx(0.025, rel=2e-6)


def test_bounds_that_the_span_keeps_need_no_search():
    disc = shapes.disc(200)
    found = fit_outline(disc, disc.positions, rise=0.3, tilt=(0.0, 1.5))
    assert found.ok and found.span is not None and found.distances["tilt bounds"] == 0
    assert fit_outline(disc, disc.positions, rise=0.3, tilt=(0.0, 0.9)).span is None


def test_a_crown_below_its_own_rim_is_refused():
    disc = shapes.disc(200)
    x, y = disc.positions.T
    raised = np.column_stack([x, y, 0.2 * (x**2 - y**2)])
    with pytest.raises(ConditionError, match=r"lines themselves reach 0\.2"):
        fit_outline(disc, raised, height=0.1)
    level = fit_outline(disc, raised, height=0.1, free_heights=True)
    assert level.is_met and level.distances["crown height"] < 1e-5


def test_tilts_are_kept_within_bounds():
    """A square shell is steepest in the middle of its sides; anchored at the corners only it can be anything."""
    shape = shapes.polygon([[-1, -1], [1, -1], [1, 1], [-1, 1]], max_edge=0.12, corner_radius=0.2)
    loop = shape.domain.boundary_loops[0]
    corners = np.unique([loop[np.argmax(shape.positions[loop] @ c)] for c in ([1, 1], [1, -1], [-1, 1], [-1, -1])])
    places = np.column_stack([shape.positions[corners], np.zeros(4)])
    supports = (corners, places, np.ones(4))
    bounds = np.radians([55, 70])
    free = fit_outline(shape.domain, shape.positions, rise=0.4, on_curve=False, anchors=supports)
    bound = fit_outline(shape.domain, shape.positions, rise=0.4, on_curve=False, anchors=supports, tilt=tuple(bounds))
    tilts = [np.arcsin(f.surface.normals[loop, 2]) for f in (free, bound)]
    outside = [np.abs(tilt - np.clip(tilt, *bounds)).max() for tilt in tilts]
    assert outside[0] > np.radians(5) and outside[1] < np.radians(0.2)
    assert free.is_met and bound.is_met and bound.distances["anchors"] < 1e-3
    level = fit_outline(shape.domain, shape.positions, rise=0.4, free_heights=True, tilt=tuple(np.radians([50, 75])))
    assert level.is_met and level.span is None and level.distances["rim on curve"] < 2e-3 * 2.83
    tight = fit_outline(shape.domain, shape.positions, rise=0.4, tilt=tuple(np.radians([20, 30])))
    assert not tight.is_met and "bounds on their tilt" in tight.message


def test_volume_and_mean_curvature_as_knobs():
    shape = shapes.disc(800)
    h = 0.4
    volume = np.pi * h * (3 + h**2) / 6
    found = fit_outline(shape.domain, shape.positions, volume=volume, max_evaluations=90)
    assert found.distances["volume"] < 1e-4 * volume
    assert_allclose(found.points()[:, 2].max(), h, rtol=0.01, atol=0)
    found = fit_outline(shape.domain, shape.positions, mean_curvature=0.5, max_evaluations=90)
    assert_allclose(found.surface.mean_curvature, 0.5, rtol=1e-12, atol=0)
    assert_allclose(found.points()[:, 2].max(), 2 - np.sqrt(3), rtol=0.01, atol=0)


def test_a_quarter_between_mirrors_is_a_quarter_of_the_cap():
    angle = np.linspace(0, np.pi / 2, 24)
    arc = np.column_stack([np.cos(angle), np.sin(angle)])
    plan = shapes.polygon(np.vstack([[0, 0], arc]), max_edge=0.08)
    domain, points = plan.domain, plan.positions
    middles = points[domain.edges[domain.boundary_edges]].mean(axis=1)
    walls = [domain.boundary_edges[np.abs(middles[:, k]) < 1e-9] for k in (0, 1)]
    rim = np.setdiff1d(domain.boundary_edges, np.concatenate(walls))
    held = conditions.binormal(domain, points, rim, 0.3)
    held = held + conditions.mirror(domain, walls[0], [1, 0, 0]) + conditions.mirror(domain, walls[1], [0, 1, 0])
    ends = np.unique(domain.edges[rim])
    places = np.column_stack([points[ends], np.zeros(len(ends))])
    targets = [SmoothRim(weight=1e-7), Anchors(ends, places), Crown(0.4)]
    found = fit(domain, targets, Start(held, 1.0, np.zeros(3)), size=2.0)
    radius = (1 + 0.4**2) / 0.8
    miss = np.linalg.norm(found.points() - [0, 0, 0.4 - radius], axis=1) - radius
    assert np.abs(miss).max() < 1e-3 and found.conditions.mirrors.size
    assert_allclose(1 / found.surface.mean_curvature, radius, rtol=1e-3)


def test_goals_that_cannot_be_met_end_with_the_nearest_surface_and_a_sentence():
    shape = shapes.disc(400)
    found = fit_outline(shape.domain, shape.positions, mean_curvature=2.0)
    assert not found.is_met and found.status is FitStatus.NO_SURFACE
    assert "the largest is about 1.0" in found.message and "Choose a smaller one" in found.message
    assert found.distances["rim on curve"] < 1e-3
    assert np.isfinite(found.points()).all()


def test_fits_can_be_cancelled_and_continued():
    shape = shapes.disc(400)
    seen = []

    def progress(evaluation, value):
        seen.append((evaluation, value))
        return len(seen) < 2

    first = fit_outline(shape.domain, shape.positions, rise=0.4, progress=progress)
    assert first.status is FitStatus.CANCELLED and len(seen) == 2
    second = fit_outline(shape.domain, shape.positions, rise=0.4, initial=first)
    assert second.is_met and len(second.history) < 12
    bounds = {"rise": 0.4, "tilt": (0.0, 0.7), "free_heights": True}
    whole = fit_outline(shape.domain, shape.positions, **bounds)
    first = fit_outline(shape.domain, shape.positions, max_evaluations=2, **bounds)
    assert first.status is FitStatus.EVALUATION_LIMIT
    second = fit_outline(shape.domain, shape.positions, initial=first, **bounds)
    assert second.value < first.value and second.value < 2 * whole.value + 1e-6
    with pytest.raises(ConditionError, match="another plan"):
        fit_outline(shapes.disc(100), shapes.disc(100).positions, initial=first, **bounds)


def test_wrong_goals_are_refused():
    shape = shapes.disc(100)
    domain, points = shape.domain, shape.positions
    for arguments, message in (
        ({"rise": 0.3, "volume": 1.0}, "one of"),
        ({"rise": -1.0}, "positive"),
        ({"curve": [[0, 0], [1, 1]]}, "three or more"),
        ({"on_curve": False}, "nothing to fit"),
        ({"sheet": "g"}, "sheet"),
        ({"tilt": (1.0, 0.5)}, "below the most"),
        ({"curve": [np.eye(3), np.eye(3)]}, "so 2 curves do not fit it"),
        ({"anchors": ([999], [[0, 0, 0]], [1.0])}, "999"),
    ):
        with pytest.raises(ConditionError, match=message):
            fit_outline(domain, points, **arguments)
    with pytest.raises(ConditionError, match="without handles"):
        torus = shapes.torus(1.0, 1.0, 8)
        fit_outline(torus.domain, np.zeros((torus.domain.vertex_count, 3)))
