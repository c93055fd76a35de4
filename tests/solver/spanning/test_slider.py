"""One slider: mean curvature from -1/R through 0 to 1/R, each step from the last, R that of the line's sphere.

A line that is nearly a flat circle is at 1/R near its half sphere, where surfaces themselves change quickly with H: for
the circle the crown rises by 10 times the median in the last step. Steps there are allowed 5 times, elsewhere 3 times.
"""

from __future__ import annotations

import numpy as np
import pytest

from solver import shapes, span_outline

SQUARE = [[-1, -1], [1, -1], [1, 1], [-1, 1]]
ELL = [[0, 0], [2, 0], [2, 1], [1, 1], [1, 2], [0, 2]]
TURN = np.linspace(0, 2 * np.pi, 100, endpoint=False)
CIRCLE = np.column_stack([np.cos(TURN), np.sin(TURN)])


@pytest.mark.parametrize(
    ("outline", "rounding", "raised", "edge", "most"),
    [
        (SQUARE, 0.0, 0.0, 0.1, 3.0),
        (SQUARE, 0.3, 0.0, 0.1, 3.0),
        (ELL, 0.3, 0.0, 0.09, 3.0),
        (CIRCLE, 0.0, 0.2, 0.1, 5.0),
        (CIRCLE, 0.0, 0.6, 0.05, 3.0),
    ],
    ids=["square", "rounded square", "L", "circle raised by 20 %", "circle raised by 60 %"],
)
def test_no_step_fails_or_jumps(outline, rounding, raised, edge, most):
    plan = shapes.polygon(outline, max_edge=edge, corner_radius=rounding)
    x, y = plan.positions[:, :2].T
    points = np.column_stack([x, y, raised * (x**2 - y**2)])
    rim = points[plan.domain.boundary_vertices]
    radius = np.linalg.norm(rim - rim.mean(axis=0), axis=1).max()
    span, moves = None, []
    for H in np.linspace(-1.0, 1.0, 41) / radius:
        before, span = span, span_outline(plan, points, mean_curvature=H, initial=span)
        assert span.ok, f"H R = {H * radius:.2f}: {span.message}"
        if before is not None:
            moves.append(np.linalg.norm(span.points - before.points, axis=1).max())
    assert max(moves) <= most * np.median(moves)
