"""Fits with given normals along some sides and lines along others: exact caps, halls, and what cannot be."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from numpy.testing import assert_allclose

from solver import ConditionError, HarmonicSolver, Shape, conditions, fit_outline, shapes
from solver.fitting.curves import Curve
from solver.fitting.fit import FitStatus
from solver.fitting.goals import Goals, OutlineOptions
from solver.fitting.objective import Objective
from solver.fitting.response import Response, hats, runs
from solver.fitting.sides import opposite
from solver.gauss.frames import in_space
from solver.spanning.outline import span_outline
from solver.surface.adjoint import AdjointSolver
from tests.solver.exact_surfaces import rates

HALL = np.array([[0.0, 0.0], [18.0, 0.0], [18.0, 12.0], [0.0, 12.0]])
SIZE = np.hypot(18.0, 12.0)
LINE_MET = 3e-3


def hall(max_edge: float = 0.7, corner_radius: float = 1.5, **how) -> Shape:
    """A rectangle; sides "street", "back" along x and "left" without the rounded corners."""
    plan = shapes.polygon(HALL, max_edge=max_edge, corner_radius=corner_radius, **how)
    ends = plan.positions[plan.domain.edges[plan.domain.boundary_edges]]
    for name, axis, place in (("street", 1, 0.0), ("back", 1, 12.0), ("left", 0, 0.0)):
        plan.sides[name] = plan.domain.boundary_edges[(np.abs(ends[:, :, axis] - place) < 1e-6).all(axis=1)]
    return plan


def leaning(plan: Shape, side: str, degrees: float) -> conditions.Conditions:
    return conditions.binormal(plan, side, tilt=np.radians(degrees))


def street(plan: Shape, degrees: float = 60.0):
    return {"rise": 0.35, "held": leaning(plan, "street", degrees)}


def touched(plan: Shape):
    return {"rise": 0.35, "held": conditions.fixed(plan, "street", [0.0, -0.64, 0.77])}


def mirrored(plan: Shape):
    return {"rise": 0.35, "held": leaning(plan, "side0", 60) + conditions.mirror(plan, "side3", [1, 0, 0])}


def with_lean(plan: Shape):
    both = leaning(plan, "street", 60) + conditions.lean(plan, "back", np.radians(70))
    return {"rise": 0.35, "held": both}


def courtyard() -> Shape:
    angle = np.linspace(0, 2 * np.pi, 32, endpoint=False)
    hole = [9, 6] + 2.2 * np.column_stack([np.cos(angle), np.sin(angle)])
    return hall(0.8, holes=[hole])


def inner(found):
    """Vertices inside the sides with given normals."""
    sides = [np.setdiff1d(side.vertices[1:-1], side.zone) for side in found.sides if side.kind == "held"]
    return np.concatenate(sides)


# --- exact -------------------------------------------------------------------------------------


@pytest.mark.parametrize("sheet", ["f+", "f-"])
def test_half_a_circle_on_its_line_and_half_with_the_caps_own_normals(sheet):
    """Both halves are those of one cap, so it is found, at second order, as either sheet."""
    rise = 0.4
    radius = (1 + rise**2) / (2 * rise)
    misses = []
    for n in (300, 1200):
        disc = shapes.disc(n)
        rim = disc.domain.boundary_edges
        half = rim[disc.positions[disc.domain.edges[rim]].mean(axis=1)[:, 1] < 0]
        held = conditions.binormal(disc, half, tilt=np.arcsin((radius - rise) / radius))
        found = fit_outline(disc, disc.positions, rise=rise, held=held, sheet=sheet)
        assert found.ok and found.span is None and len(found.history) < 15, found.message
        misses.append(np.abs(np.linalg.norm(found.points() - [0, 0, rise - radius], axis=1) - radius).max())
        assert_allclose(found.surface.mean_curvature, 1 / radius, rtol=1e-3)
        kept = np.isin(held.resolve()[0], inner(found))
        assert_allclose(found.normals()[held.resolve()[0][kept]], held.resolve()[1][kept], rtol=0, atol=1e-15)
    assert misses[0] < 4e-3 and rates(misses).min() > 1.5


def test_opposite_conditions_are_those_of_the_opposite_map():
    plan = hall(1.5)
    held = leaning(plan, "street", 30)
    turned = opposite(held)
    assert_allclose(turned.resolve()[1], -held.resolve()[1], rtol=0, atol=1e-15)
    assert held.up[2] > 0
    assert_allclose(turned.up, -held.up, rtol=0, atol=0)


# --- halls -------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("make", "goals"),
    [
        (hall, street),
        (hall, partial(street, degrees=40.0)),
        (hall, touched),
        (hall, with_lean),
        (partial(hall, corner_radius=0.0), mirrored),
    ],
    ids=["leans 60", "leans 40", "touches a plane", "another side over its line", "beside a mirror"],
)
def test_lines_here_given_normals_there(make, goals):
    plan = make()
    found = fit_outline(plan, plan.positions, **goals(plan))
    assert found.is_met and found.status is FitStatus.CONVERGED, found.message
    kinds = [side.kind for side in found.sides]
    assert "held" in kinds and "line" in kinds
    for side in found.sides:
        if side.kind in ("line", "lean"):
            assert side.distance < LINE_MET * SIZE
        assert side.angle < np.radians(0.5 if side.kind == "lean" else 1e-13)
        assert bool(len(side.zone)) == (side.kind == "held")
    assert_allclose(found.points()[:, 2].max(), 0.35 * 6.0, rtol=1e-4)
    N = found.surface.harmonic.normals
    vertices, normals = replace(goals(plan)["held"], leans=np.zeros(0, int)).resolve()
    kept = np.isin(vertices, inner(found))
    assert kept.sum() > 4
    assert_allclose(N[vertices[kept]], normals[kept], rtol=0, atol=1e-15)
    zones = np.concatenate([side.zone for side in found.sides])
    apart = ~np.isin(vertices, inner(found)) & np.isin(vertices, zones)
    assert np.abs(N[vertices[apart]] - normals[apart]).max() > 0.01  # in blend zones they are free


def test_lines_stay_in_the_distances_that_a_user_can_measure():
    """The distance in `sides` is that of the points of the result, which have not moved since."""
    plan = hall()
    found = fit_outline(plan, plan.positions, **street(plan))
    side = next(side for side in found.sides if side.kind == "line")
    line = in_space(plan.domain, plan.positions)[side.vertices]
    points = found.points()[side.vertices]
    off = np.linalg.norm(points - Curve(line, closed=False).closest(points).points, axis=1)
    off[[0, -1]] = np.linalg.norm(points - line, axis=1)[[0, -1]]  # the ends are to stay
    assert_allclose(off.max(), side.distance, rtol=0, atol=1e-9 * SIZE)
    held = next(side for side in found.sides if side.kind == "held")
    assert 0.01 * SIZE < held.distance < 0.1 * SIZE  # the rim is free there


def test_neither_unit_nor_place_matter():
    """Nor does the sheet: f- of the opposite map is the same surface."""
    plan = hall()
    found = fit_outline(plan, plan.positions, **street(plan))
    for scale, place in ((1000.0, [0.0, 0.0, 0.0]), (1.0, [1e4, -2e4, 50.0])):
        points = scale * in_space(plan.domain, plan.positions) + place
        other = fit_outline(plan, points, **street(plan))
        assert_allclose((other.points() - place) / scale, found.points(), rtol=0, atol=2e-4 * SIZE)
    twin = fit_outline(plan, plan.positions, **street(plan), sheet="f-")
    assert_allclose(twin.points(), found.points(), rtol=0, atol=1e-6 * SIZE)


def test_a_mirror_stays_in_its_plane():
    plan = hall(corner_radius=0.0)
    found = fit_outline(plan, plan.positions, **mirrored(plan))
    mirror = np.unique(plan.domain.edges[plan.sides["side3"]])
    assert np.ptp(found.points()[mirror, 0]) < 1e-9 * SIZE
    assert np.abs(found.points()[mirror, 0]).max() < 2e-3 * SIZE
    assert np.abs(found.surface.harmonic.normals[mirror, 0]).max() < 1e-12


def test_a_courtyard_that_leans_closes():
    plan = courtyard()
    held = leaning(plan, "hole0", 70)
    found = fit_outline(plan, plan.positions, rise=0.35, held=held)
    assert found.is_met and not found.surface.is_open, found.message
    assert found.distances["period"] < 1e-3 * SIZE
    vertices, normals = held.resolve()
    assert_allclose(found.surface.harmonic.normals[vertices], normals, rtol=0, atol=1e-15)
    line, hole = sorted(found.sides, key=lambda side: side.kind, reverse=True)
    assert line.distance < LINE_MET * SIZE and hole.angle < 1e-14 and not len(hole.zone)


def test_the_curvature_asked_for_and_a_curve_elsewhere():
    plan = hall()
    held = leaning(plan, "street", 60)
    found = fit_outline(plan, plan.positions, mean_curvature=0.062, held=held)
    assert found.is_met and found.surface.mean_curvature == pytest.approx(0.062, rel=1e-12)
    line = in_space(plan.domain, plan.positions)[plan.domain.boundary_loops[0]] + [3.0, -2.0, 5.0]
    moved = fit_outline(plan, plan.positions, line, mean_curvature=0.062, held=held)
    with pytest.raises(ConditionError, match="given twice"):
        fit_outline(plan, plan.positions, line, held=held + conditions.line(plan, "outer", line))
    assert moved.is_met, moved.message
    assert moved.points()[:, 2].max() == pytest.approx(found.points()[:, 2].max() + 5.0, abs=0.02 * SIZE)


def test_leans_and_mirrors_alone_are_spanned():
    plan = hall(corner_radius=0.0)
    mirror = conditions.mirror(plan, "side3", [1, 0, 0])
    leans = [("side0", np.radians(70))]
    lean = conditions.lean(plan, "side0", np.radians(70))
    found = fit_outline(plan, plan.positions, rise=0.35, held=mirror + lean + conditions.line(plan, "side1"))
    span = span_outline(plan, plan.positions, rise=0.35, leans=leans, mirrors=[("side3", [1, 0, 0])])
    assert found.ok and found.span is not None
    assert_allclose(found.points(), span.points, rtol=0, atol=1e-9)
    assert {side.kind for side in found.sides} == {"line", "lean", "mirror"}


def test_a_free_side_lies_on_a_sphere_between_its_lines():
    """Its normals have no derivative across the rim, so that g stays in a point along it, and f = g + N / 2H."""
    disc = shapes.disc(300)
    rim = disc.domain.boundary_edges
    x, y = disc.positions[disc.domain.edges[rim]].mean(axis=1).T
    free = rim[np.abs(np.arctan2(y, x)) < np.pi / 6]
    found = fit_outline(disc, disc.positions, rise=0.4, free=free)
    assert found.is_met and found.span is None, found.message
    inside = next(side for side in found.sides if side.kind == "free").vertices[1:-1]
    assert not np.isin(inside, found.conditions.vertices).any()
    assert np.ptp(found.surface.g[inside], axis=0).max() < 0.03 < np.ptp(found.surface.g, axis=0).max()
    line = next(side for side in found.sides if side.kind == "line")
    assert line.distance < 2 * LINE_MET * 2 ** 1.5


# --- continued ---------------------------------------------------------------------------------


def test_a_lean_changed_by_a_degree_is_continued_nearby():
    plan = hall()
    first = fit_outline(plan, plan.positions, **street(plan))
    again = fit_outline(plan, plan.positions, **street(plan), initial=first)
    assert len(again.history) < 8
    assert np.abs(again.points() - first.points()).max() < 1e-3 * SIZE
    changed = fit_outline(plan, plan.positions, **street(plan, 61.0), initial=first)
    assert changed.is_met and changed.response is first.response and len(changed.history) < 30
    assert np.abs(changed.points() - first.points()).max() < 0.03 * SIZE
    vertices, normals = leaning(plan, "street", 61).resolve()
    kept = np.isin(vertices, inner(changed))
    assert_allclose(changed.surface.harmonic.normals[vertices[kept]], normals[kept], rtol=0, atol=1e-15)
    quick = fit_outline(plan, plan.positions, **street(plan, 61.0), initial=first, max_evaluations=1)
    assert len(quick.history) <= 3 and quick.status is FitStatus.EVALUATION_LIMIT
    line = next(side for side in quick.sides if side.kind == "line")
    assert line.distance < 0.015 * SIZE


# --- the parts ---------------------------------------------------------------------------------


def test_the_gradient_beside_given_normals_leans_and_mirrors():
    """Central differences along random changes of the free normals, the scale and the shift."""
    plan = hall(1.5, corner_radius=0.0)
    held = mirrored(plan)["held"] + conditions.lean(plan, "side2", np.radians(70))
    points = in_space(plan.domain, plan.positions)
    goals = Goals.of(plan, points, OutlineOptions(rise=0.35, held=held))
    span = span_outline(plan, plan.positions, rise=0.35, leans=[("side2", np.radians(70))])
    start = goals.sides.conditions(span.normals)
    response = Response(AdjointSolver(HarmonicSolver(plan.domain), start), goals.sides.held)
    rim = start.resolve()[1]
    random = np.random.default_rng(5)
    for target in goals.targets(1e4, span.points):
        objective = Objective(response, [target], 1.0, goals.size, True, True, span.normals, rim)
        objective.best = None
        x = objective.vector(rim, 6.0, np.array([9.0, 6.0, -5.0]))
        x[:-4] *= 1.0 + 0.1 * random.random(len(x) - 4)  # lengths do not matter, but differ
        value, gradient = objective(x)
        way = 1e-2 * random.normal(size=x.shape)
        h = 1e-4
        ahead, behind = (objective(x + sign * h * way)[0] for sign in (1, -1))
        assert_allclose(gradient @ way, (ahead - behind) / (2 * h), rtol=2e-4, atol=1e-7 * (value + 1e-9) / h)


def test_what_is_given_is_no_unknown():
    plan = hall(1.5)
    held = leaning(plan, "street", 60)
    goals = Goals.of(plan, in_space(plan.domain, plan.positions), OutlineOptions(held=held))
    N = np.tile([0.0, 0.0, 1.0], (plan.domain.vertex_count, 1))
    start = goals.sides.conditions(N)
    response = Response(AdjointSolver(HarmonicSolver(plan.domain), start), goals.sides.held)
    assert len(goals.sides.held) > 2 and not np.isin(response.vertices, goals.sides.held).any()
    assert len(response.vertices) + len(goals.sides.held) == len(plan.domain.boundary_vertices)
    assert not response.spread[goals.sides.held].any()


def test_given_normals_turn_into_the_plane_of_a_mirror_where_they_meet_one():
    plan = hall(1.5, corner_radius=0.0)
    skew = np.array([0.3, -0.6, 0.7]) / np.linalg.norm([0.3, -0.6, 0.7])
    held = conditions.fixed(plan, "side0", skew) + conditions.mirror(plan, "side3", [1, 0, 0])
    goals = Goals.of(plan, in_space(plan.domain, plan.positions), OutlineOptions(held=held))
    start = goals.sides.conditions(np.tile([0.0, 0.0, 1.0], (plan.domain.vertex_count, 1)))
    vertices, there = start.resolve()
    normals = np.zeros((plan.domain.vertex_count, 3))
    normals[vertices] = there
    corner = int(np.argmin(np.abs(plan.positions).sum(axis=1)))
    assert abs(normals[corner, 0]) < 1e-15 and normals[corner, 1] < -0.5
    others = np.setdiff1d(goals.sides.held, corner)
    assert len(others) and np.abs(normals[others] - skew).max() < 1e-15


def test_hat_functions_of_pieces_of_a_boundary():
    """They sum up to one, have a knot at either end, and none goes over a gap."""
    plan = hall(1.0)
    loop = plan.domain.boundary_loops[0]
    vertices = np.sort(np.concatenate([loop[2:14], loop[20:45]]))
    functions = hats(plan.domain, vertices, 12)
    assert_allclose(functions.sum(axis=1), 1.0, rtol=0, atol=1e-12)
    first = np.searchsorted(vertices, np.sort(loop[2:14]))
    rest = np.setdiff1d(np.arange(len(vertices)), first)
    assert not (functions[first].sum(axis=0) * functions[rest].sum(axis=0)).any()
    for end in loop[[2, 13, 20, 44]]:
        assert functions[[int(np.searchsorted(vertices, end))]].max() == 1.0


def test_runs_of_a_ring():
    marked = np.array([True, True, False, True, False, False, True])
    assert sorted(run.tolist() for run in runs(marked)) == [[3], [6, 0, 1]]
    assert [run.tolist() for run in runs(np.ones(3, bool))] == [[0, 1, 2]] and runs(np.zeros(3, bool)) == []


def test_a_piece_of_a_closed_curve():
    square = Curve(np.array([[0, 0, 0], [2, 0, 0], [2, 2, 0], [0, 2, 0.0]]), closed=True)
    piece = square.between(np.array([1.0, -1, 0]), np.array([3.0, 1, 0]))
    assert_allclose(piece.points, [[1, 0, 0], [2, 0, 0], [2, 1, 0]], rtol=0, atol=1e-12)
    back = square.between(np.array([1.5, 0, 0]), np.array([0.5, 0, 0]))
    assert_allclose(back.length, 7.0) and not back.closed


# --- what cannot be ----------------------------------------------------------------------------


def test_what_is_missed_is_said_side_by_side():
    plan = hall()
    found = fit_outline(plan, plan.positions, **street(plan, 30.0), max_evaluations=2)
    assert not found.is_met and not found.ok and found.status is FitStatus.EVALUATION_LIMIT
    line = next(side for side in found.sides if side.kind == "line")
    assert line.distance > LINE_MET * SIZE and f"{line.distance:.4g} off its line" in found.message


def test_wrong_sides_are_refused():
    plan = hall(1.5)
    held = leaning(plan, "street", 60)
    inside = np.setdiff1d(np.arange(plan.domain.vertex_count), plan.domain.boundary_vertices)[:1]
    for goals, message in (
        ({"held": held, "free": "street"}, "cannot be free and held by given normals"),
        ({"held": held + conditions.mirror(plan, "street", [0, 1, 0])}, "in a mirror and held"),
        ({"held": leaning(plan, "outer", 60)}, "No side is left on its line"),
        ({"held": conditions.fixed_at(plan, inside, [0, 0, 1])}, "given inside"),
        ({"held": held + conditions.line(plan, "street")}, "cannot be on a line and held"),
        ({"held": held + conditions.lean(plan, "street", 1.0)}, "cannot be leaning over a line and held"),
        ({"held": held, "mean_curvature": -0.1}, "positive"),
        ({"held": held, "blend": 2.0}, "blend"),
        ({"held": "street"}, "Conditions are needed"),
    ):
        with pytest.raises(ConditionError, match=message):
            fit_outline(plan, plan.positions, **goals)
