"""Sides in planes that they meet at right angles: quarters equal their wholes."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

from solver import ConditionError, shapes, span_outline
from tests.solver.exact_surfaces import rates
from tests.solver.spanned_plans import (
    cap_error,
    catenoid_error,
    enneper,
    enneper_error,
    inside_curvature,
    quarter_disc,
    sphere_error,
)


def walls(plan, along_x: str, along_y: str):
    return [(plan.sides[along_x], [0, 1, 0]), (plan.sides[along_y], [1, 0, 0])]


def off_planes(span, plan, along_x: str, along_y: str) -> float:
    edges = plan.domain.edges
    y, x = span.points[edges[plan.sides[along_x]], 1], span.points[edges[plan.sides[along_y]], 0]
    return max(np.abs(x).max(), np.abs(y).max())


def test_a_quarter_of_a_cap():
    plan = quarter_disc(600)
    last = list(plan.sides)[-1]
    span = span_outline(plan, plan.positions, mean_curvature=0.8, mirrors=walls(plan, "side0", last))
    assert span.ok, span.message
    assert cap_error(span.points, 0.8) < 9e-4  # 3e-4 of it is that of the drawn arc
    assert off_planes(span, plan, "side0", last) < 1e-15
    assert_allclose(span.normals[span.domain.edges[plan.sides["side0"]], 1], 0, atol=1e-12)
    half = span_outline(plan, plan.positions, volume=np.pi / 6, mirrors=walls(plan, "side0", last))
    assert half.ok and sphere_error(half.points, 0.0, 1.0) < 2e-3


def test_a_quarter_of_enneper():
    errors = []
    for n in (160, 640):
        plan = quarter_disc(n)
        last = list(plan.sides)[-1]
        line = enneper(0.9 * (plan.positions[:, 0] + 1j * plan.positions[:, 1]))
        span = span_outline(plan.domain, line, mirrors=walls(plan, "side0", last))
        assert span.ok, span.message
        errors.append(enneper_error(span.points))
    assert errors[-1] < 8e-4 and rates(errors)[0] > 1.2, errors


def test_a_quarter_of_scherk_has_a_modulus():
    errors = []
    for n in (350, 1400):
        plan = shapes.polygon([[0, 0], [1.2, 0], [1.2, 1.2], [0, 1.2]], max_edge=1.2 * np.sqrt(1.15 / n))
        x, y = plan.positions.T
        line = np.column_stack([x, y, np.log(np.cos(x) / np.cos(y))])
        span = span_outline(plan.domain, line, mirrors=walls(plan, "side0", "side3"))
        assert span.ok, span.message
        x, y, z = span.points.T
        errors.append(np.abs(np.log(np.cos(x) / np.cos(y)) - z).max())
    assert errors[-1] < 4e-4 and rates(errors)[0] > 1.6, errors


def test_a_strip_becomes_a_quarter_of_a_catenoid():
    """Its length is not that of the plan, which is unrolled for its modulus."""
    plan = shapes.polygon([[0, 0], [0.5 * np.pi, 0], [0.5 * np.pi, 1.1], [0, 1.1]], max_edge=0.07)
    t, s = plan.positions.T * [[1.0], [0.7486 / 1.1]]
    line = np.column_stack([np.cosh(s) * np.cos(t), np.cosh(s) * np.sin(t), s])
    x, y, z = np.eye(3)
    sides = [(plan.sides["side0"], z), (plan.sides["side1"], x), (plan.sides["side3"], y)]
    span = span_outline(plan.domain, line, mirrors=sides)
    assert span.ok, span.message
    assert catenoid_error(span.points, 1.0, 0.0) < 2e-4
    lengths = np.ptp(span.positions, axis=0)
    assert_allclose(lengths[1] / lengths[0], 0.7486 / (0.5 * np.pi), rtol=3e-3)


def test_a_quarter_of_a_rectangle_is_a_quarter_of_the_whole():
    outline = np.array([[-1.5, -0.5], [1.5, -0.5], [1.5, 0.5], [-1.5, 0.5]])
    whole = shapes.polygon(outline, max_edge=0.09)
    quarter = shapes.polygon([[0, 0], [1.5, 0], [1.5, 0.5], [0, 0.5]], max_edge=0.09)
    mirrors = walls(quarter, "side0", "side3")
    one = span_outline(whole, whole.positions, mean_curvature=0.8)
    part = span_outline(quarter, quarter.positions, mean_curvature=0.8, mirrors=mirrors)
    assert one.ok and part.ok
    assert_allclose(4 * part.history[-1].volume, one.history[-1].volume, rtol=2e-3)
    assert_allclose(np.median(inside_curvature(part)), 0.8, rtol=0.01)


def test_mirrors_that_contradict_each_other():
    plan = quarter_disc(100)
    last = list(plan.sides)[-1]
    with pytest.raises(ConditionError, match="parallel"):
        span_outline(plan, plan.positions, mirrors=[(plan.sides["side0"], [1, 0, 0]), (plan.sides[last], [1, 0, 0])])
    with pytest.raises(ConditionError, match="spans its own points"):
        curve = plan.positions[plan.domain.boundary_loops[0]]
        span_outline(plan, plan.positions, curve, mirrors=walls(plan, "side0", last))


@pytest.mark.parametrize("height", [{}, {"rise": 0.4}, {"mean_curvature": 0.05}])
def test_a_mirror_that_lies_on_a_flat_plan_is_named(height):
    plan = shapes.rectangle(12.0, 6.0, columns=12)
    with pytest.raises(ConditionError, match=r"normal \(0, 0, 1\), holds all lines of the plan.*upright") as caught:
        span_outline(plan, plan.positions, mirrors=[("left", [0, 0, 2])], **height)
    assert set(caught.value.edges) == set(plan.sides["left"].tolist())
    raised = np.column_stack([plan.positions[:, :2], 0.1 * plan.positions[:, 0]])
    assert span_outline(plan, raised, mirrors=[("left", [-1, 0, 0])]).ok
