"""How much work a span is: steps of Newton's method and back-solves, which do not depend on the machine."""

from __future__ import annotations

import numpy as np
import pytest

from solver import shapes, span_outline

SQUARE = np.array([[0, 0], [2, 0], [2, 2], [0, 2]])
ELL = [[0, 0], [2, 0], [2, 1], [1, 1], [1, 2], [0, 2]]


@pytest.mark.parametrize(
    ("first", "then"),
    [
        ({"mean_curvature": 0.5}, {"mean_curvature": 0.55}),
        ({"rise": 0.3}, {"rise": 0.32}),
        ({"volume": 0.5}, {"volume": 0.55}),
    ],
)
def test_a_small_change_takes_two_steps(first, then):
    plan = shapes.polygon(SQUARE, max_edge=0.06, corner_radius=0.2)
    before = span_outline(plan, plan.positions, **first)
    span = span_outline(plan, plan.positions, **then, initial=before)
    assert span.ok and len(span.history) <= 3 and span.history[-1].solves <= 28
    afresh = span_outline(plan, plan.positions, **then)
    assert np.abs(span.points - afresh.points).max() < 2e-5
    assert np.abs(span.normals - afresh.normals).max() < 2e-5


@pytest.mark.parametrize("volume", [0.5, 1.5])
def test_large_volumes_take_few_steps(volume):
    for outline in (SQUARE, SQUARE * [1.5, 0.5]):
        plan = shapes.polygon(outline, max_edge=0.07)
        area = float(np.prod(outline.max(axis=0)))
        span = span_outline(plan, plan.positions, volume=volume * 2 / 3 * np.pi * (area / np.pi) ** 1.5)
        assert span.ok and len(span.history) <= 9 and span.history[-1].solves <= 145


def test_over_a_surface_rolled_out_the_search_goes_on_from_it():
    plan = shapes.polygon(ELL, max_edge=0.07)
    span = span_outline(plan, plan.positions, volume=1.95)
    assert span.ok and span.domain is not plan.domain
    assert span.history[0].residual < 0.3 and span.history[-1].solves <= 100
