"""Drawn plans, meshed, formed and, between mirrors, completed: the way of most people."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import numpy as np

from solver import shapes
from solver.shells.complete import CopySelection, complete_plan
from solver.shells.form import form
from solver.shells.plan import Plan

from .case import Case, Result, of_shell, pick
from .outlines import drawn, edge_for
from .settings import groups, settings


def case(rng: np.random.Generator, folder: Path) -> Case:
    name, outline, holes = drawn(rng)
    max_edge = edge_for(rng, outline, (25, 250))
    radius = pick(rng, [0.0, 1.0, 2.0, 4.0]) * abs(max_edge)
    own = np.random.default_rng(rng.integers(2**32))

    def run() -> Result:
        shape = shapes.polygon(outline, holes, max_edge, radius)
        sides = [name for name in shape.sides if name.startswith("side") or re.fullmatch(r"hole\d", name)][:15]
        edges = [shape.domain.edges[shape.sides[side]] for side in sides]
        plan = Plan.from_shape(shape)
        plan.groups = groups(own, edges, [_outward(shape.positions, pairs) for pairs in edges])
        if own.random() < 0.1:
            plan.positions[:, 2] = own.normal(size=2) @ (shape.positions - shape.positions[0]).T
        choice = settings(own, float(np.ptp(shape.positions, axis=0).max()))
        shell = form(plan, choice)
        result = of_shell(shell)
        if own.random() < 0.4 and {group.kind for group in plan.groups} & {"mirror", "plane"}:
            copies = complete_plan(plan, shell, CopySelection(copies=pick(own, [None, 2, 8])), choice.sheet)
            return replace(result, numbers={**result.numbers, "points of the copies": copies.points})
        return result

    text = f"{name}, {len(outline)} points, {len(holes)} holes, max_edge {max_edge:.3g}, corner_radius {radius:.3g}"
    return Case(text, run)


def _outward(positions: np.ndarray, pairs: np.ndarray) -> np.ndarray:
    """The horizontal normal of a side's first edge; the plan is on the left of its edges."""
    x, y = positions[pairs[0, 1]] - positions[pairs[0, 0]]
    return np.array([y, -x, 0.0]) / np.hypot(x, y)
