"""Sharp corners: vertices that stay, and a plan whose sides shift."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

from solver import ConditionError, Domain, shapes, span_outline
from solver.fitting.curves import Curve
from solver.spanning.curves import SmoothCurve, corners
from solver.spanning.layout import flat_layout
from solver.spanning.setting import setting
from tests.solver.exact_surfaces import disc
from tests.solver.spanned_plans import distortion, inside_curvature

SQUARE = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
PENTAGON = np.column_stack([np.cos(2 * np.pi * np.arange(5) / 5), np.sin(2 * np.pi * np.arange(5) / 5)])


def closed(points: np.ndarray, per_side: int = 20) -> np.ndarray:
    """A polygon (n, 2|3) with points along its sides, in space."""
    points = np.column_stack([points, np.zeros((len(points), 3 - points.shape[1]))])
    u = np.arange(per_side) / per_side
    ahead = np.roll(points, -1, axis=0)
    return np.concatenate([a + u[:, None] * (b - a) for a, b in zip(points, ahead, strict=True)])


def off_line(points: np.ndarray, line: np.ndarray) -> float:
    return float(np.linalg.norm(Curve(line, closed=True).closest(points).points - points, axis=1).max())


def test_corners_are_told_from_arcs():
    t = np.linspace(0, 0.5 * np.pi, 4)
    assert corners(closed(SQUARE, 5)).tolist() == [0, 5, 10, 15]
    rounded = shapes.polygon(SQUARE, max_edge=0.2, corner_radius=0.3)
    loop = rounded.domain.boundary_loops[0]
    assert not len(corners(np.column_stack([rounded.positions[loop], np.zeros(len(loop))])))
    arc = np.column_stack([np.cos(t), np.sin(t), 0 * t])  # three segments a right angle, and two straight sides
    assert corners(np.vstack([[0, 0, 0], arc])).tolist() == [0, 1, 4]


def test_a_spline_goes_straight_between_corners_and_is_of_fourth_order_on_a_circle():
    piece = SmoothCurve(np.array([[0, 0, 0], [1, 0, 1], [1.5, 0, 1.5], [3.0, 0, 3.0]]), closed=False)
    points, tangents, bends = piece.at(np.linspace(0, piece.length, 7))
    assert_allclose(points[:, 0], points[:, 2], atol=1e-14)
    assert_allclose(np.linalg.norm(tangents, axis=1), 1, rtol=1e-12)
    assert np.abs(bends).max() < 1e-12
    off = []
    for count in (20, 40):
        t = 2 * np.pi * np.arange(count) / count
        circle = SmoothCurve(np.column_stack([np.cos(t), np.sin(t), 0 * t]), closed=True)
        off.append(np.abs(np.linalg.norm(circle.at(np.linspace(0, 7, 500))[0], axis=1) - 1).max())
    assert off[0] / off[1] > 14


@pytest.mark.parametrize(("H", "worst"), [(0.0, 1e-4), (0.5, 2e-4), (0.8, 3e-4)])
def test_a_pentagon_of_three_heights(H, worst):
    line = closed(np.column_stack([PENTAGON, [0, 0.3, 0, 0.5, 0.2]]))
    plan = shapes.polygon(PENTAGON, max_edge=0.1)
    span = span_outline(plan, plan.positions, line, mean_curvature=H)
    assert span.ok, span.message
    assert off_line(span.points[plan.domain.boundary_vertices], line) < 1e-9
    assert distortion(span) < worst and span.history[-1].solves < 60
    assert_allclose(np.median(inside_curvature(span)), H, rtol=0.02, atol=2e-3)


def test_a_sharp_rectangle_converges_from_a_plan_of_another_shape():
    """The sides of the plan shift; plans 2 : 1 and 3 : 1 end at the same conformal type."""
    line = closed(SQUARE * [3, 1])
    heights, ratios = [], []
    for stretch in (2.0, 3.0):
        plan = shapes.polygon(SQUARE * [stretch, 1], max_edge=0.16)
        span = span_outline(plan, plan.positions, line, volume=3.0)
        assert span.ok, span.message
        heights.append(span.points[:, 2].max())
        corner = span.positions[plan.domain.boundary_loops[0]]
        ratios.append(np.divide(*np.ptp(corner, axis=0)))
    assert_allclose(heights[0], heights[1], rtol=2e-3)
    assert_allclose(ratios[0], ratios[1], rtol=5e-3)


@pytest.mark.parametrize("line", [SQUARE, [[0, 0], [3, 0], [0, 2]]], ids=["square", "triangle"])
def test_a_round_plan_spans_corners(line):
    domain, points = disc(600)
    curve = closed(np.asarray(line, dtype=float))
    span = span_outline(domain, points, curve, mean_curvature=0.5)
    assert span.ok, span.message
    rim = span.points[domain.boundary_vertices]
    assert off_line(rim, curve) < 1e-9
    assert max(np.linalg.norm(rim - [*corner, 0], axis=1).min() for corner in np.asarray(line)) < 1e-12
    assert distortion(span) < 2e-3


def test_rounded_corners_slide():
    plan = shapes.polygon(SQUARE * [2, 1], max_edge=0.12, corner_radius=0.4)
    span = span_outline(plan, plan.positions, mean_curvature=0.5)
    assert span.ok and span.domain is plan.domain
    assert distortion(span) < 1e-3 and span.history[-1].solves < 60


def test_a_mark_between_corners_slides_along_the_outline():
    """A gable: the line has corners where the plan has none."""
    plan = shapes.polygon([[0, 0], [3, 0], [3, 2], [0, 2]], max_edge=0.1)
    x, y = plan.positions.T
    gable = 0.8 * (1 - np.abs(y - 1)) * (np.isclose(x, 0) | np.isclose(x, 3))
    problem, _ = setting(plan.domain, np.column_stack([x, y, gable]))
    assert len(problem.marks[0]) == 6 and problem.motions.count == 3
    span = span_outline(plan, np.column_stack([x, y, gable]))
    assert span.ok, span.message
    assert distortion(span) < 5e-3


def test_layouts_as_drawn_unrolled_and_from_above():
    plan = shapes.polygon(SQUARE, max_edge=0.4)
    flat, up = np.column_stack([plan.positions, 0 * plan.positions[:, 0]]), np.eye(3)[2]
    assert np.array_equal(flat_layout(plan.domain, flat)[1], plan.positions)
    angle = plan.positions[:, 0]
    rolled = np.column_stack([np.cos(angle), plan.positions[:, 1], np.sin(angle)])
    domain, positions = flat_layout(plan.domain, rolled)
    assert domain is plan.domain
    assert_allclose(Domain.from_positions(positions, domain.faces).edge_lengths, domain.edge_lengths, rtol=1e-9)
    hill = flat + 0.3 * np.cos(flat[:, :1]) * up
    domain, positions = flat_layout(Domain.from_positions(hill, plan.domain.faces), hill)
    assert_allclose(domain.edge_lengths, plan.domain.edge_lengths, rtol=1e-12)
    assert flat_layout(Domain.from_positions(hill, plan.domain.faces), hill * [1, 0.5, 1] * [-1, 1, 1]) is None


def test_anchors_stay_and_the_surface_is_the_same():
    domain, points = disc(800)
    free = span_outline(domain, points, mean_curvature=0.6)
    loop = domain.boundary_loops[0]
    held = loop[[0, 9, 30, 41, 60]]
    wave = np.column_stack([points, 0.2 * points[:, 0] * points[:, 1]])
    span = span_outline(domain, points, mean_curvature=0.6, anchors=held)
    assert span.ok, span.message
    assert_allclose(span.points[held, :2], points[held], rtol=0, atol=1e-12)
    assert_allclose(span.points[:, 2].max(), free.points[:, 2].max(), rtol=3e-3)
    assert span_outline(domain, wave, anchors=held).ok
    inside = np.setdiff1d(np.arange(domain.vertex_count), domain.boundary_vertices)[0]
    with pytest.raises(ConditionError, match="Anchors are vertices of the boundary"):
        span_outline(domain, points, anchors=[inside])


def test_a_rounded_outline_is_made_of_lines_and_arcs():
    """Between its points the curve stays on the rectangle with arcs that the points were taken from."""
    off = []
    for count in (7, 13):
        t = np.linspace(0, 0.5 * np.pi, count)
        arc = 0.4 * np.column_stack([np.cos(t), np.sin(t)])
        runs = []
        for k, centre in enumerate([[1.6, 0.6], [-1.6, 0.6], [-1.6, -0.6], [1.6, -0.6]]):
            turn = np.array([[0, 1], [-1, 0]]) if k % 2 else np.eye(2)
            runs.append(arc @ turn * (1 if k < 2 else -1) + centre)
        sides = [run[-1] + (runs[(k + 1) % 4][0] - run[-1]) * [[0.4], [0.7]] for k, run in enumerate(runs)]
        outline = np.concatenate([part for pair in zip(runs, sides, strict=True) for part in pair])
        curve = SmoothCurve(np.column_stack([np.roll(outline, 3, axis=0), np.zeros(len(outline))]), closed=True)
        points, tangents, _ = curve.at(np.linspace(0, curve.length, 3000))
        beyond = np.maximum(np.abs(points[:, :2]) - [1.6, 0.6], 0.0)
        distance = np.linalg.norm(beyond, axis=1) - 0.4
        inner = (np.abs(points[:, 0]) < 1.6) | (np.abs(points[:, 1]) < 0.6)
        assert np.abs(distance[inner]).max() < 1e-12
        assert np.abs(np.linalg.norm(tangents, axis=1) - 1).max() < 0.02
        off.append(np.abs(distance).max())
    assert off[0] < 2e-5 and off[0] / off[1] > 8, off


@pytest.mark.parametrize("max_edge", [0.16, 0.08])
def test_normals_at_re_entrant_corners_are_those_beside_them(max_edge):
    """The surface has no normal there. With the line's own, H inside would be 21 % off in the mean square."""
    plan = shapes.polygon(SQUARE, holes=[0.4 * SQUARE[::-1] + 0.1], max_edge=max_edge)
    span = span_outline(plan, plan.positions, mean_curvature=0.3)
    H = inside_curvature(span)
    assert np.sqrt(np.mean((H / 0.3 - 1.0) ** 2)) < 0.17
