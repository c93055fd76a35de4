"""Wente's tori for tests: quarters that are minimisers, closed over their height, and whole cylinders."""

from __future__ import annotations

import numpy as np

from solver import Side, close_periods, conditions, shapes
from solver.design.closing import Closing
from solver.design.moduli import tube
from solver.gauss.sphere import exp
from tests.solver import exact
from tests.solver.pieces import edges_where

HEIGHTS = {120: 1.6248255393, 60: 2.0891548753}


def far_normal(angle: float) -> np.ndarray:
    return np.array([np.cos(np.radians(angle)), np.sin(np.radians(angle)), 0.0])


def closed_quarter(angle: float, columns: int, height: float) -> tuple[Closing, list[Side], float]:
    """From that height: N goes the long way along the left side, a mirror; the right side is free. It closes where the
    mirror's plane goes through the point in which the free side inverts."""
    shape, far = shapes.strip(0.5 * np.pi, height, columns), far_normal(angle)
    domain, sides = shape.domain, shape.sides
    ends = conditions.fixed(domain, sides["bottom"], [1, 0, 0]) + conditions.fixed(domain, sides["top"], far)
    held = ends + conditions.mirror(domain, sides["left"], [0, 0, 1], winding=1)
    named = [
        Side("left", sides["left"], "mirror", (0, 0, 1)),
        Side("right", sides["right"], "free"),
        Side("bottom", sides["bottom"], "tangent", (1, 0, 0)),
        Side("top", sides["top"], "tangent", far),
    ]
    every = np.arange(len(domain.faces))
    longer = tube(domain, shape.positions[domain.faces], every, (0, 1))
    closing = close_periods(domain, held, by="moduli", moduli=longer, coplanar=[named[:2]], tolerance=1e-10)
    return closing, named, height * float(np.exp(closing.moduli[0]))


def jittered_cylinder(angle: float, columns: int, seed: int, push: float = 1.5):
    """A whole cylinder, its conditions, and a start: the long arc pushed off its plane by sin · sin."""
    height = HEIGHTS[int(angle)]
    domain, points = exact.cylinder(height, columns, seed=seed)
    bottom, top = (edges_where(domain, points, lambda p, y=y: np.abs(p[:, 1] - y) < 1e-9) for y in (0.0, height))
    held = conditions.fixed(domain, bottom, [1, 0, 0]) + conditions.fixed(domain, top, far_normal(angle))
    x, y = points.T
    turn = (np.radians(angle) - 2.0 * np.pi) * y / height
    arc = np.column_stack([np.cos(turn), np.sin(turn), 0.0 * turn])
    off = push * np.sin(np.pi * y / height) * np.sin(x)
    return domain, held, exp(arc, np.outer(off, [0.0, 0.0, 1.0]))
