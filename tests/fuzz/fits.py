"""Fits of small plans: outlines in space, anchors, heights, meshes to approximate; a few evaluations each."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from solver import shapes
from solver.fitting.gauss_map import GaussMapOptions
from solver.fitting.goals import OutlineOptions
from solver.shells.fit import fit_plan
from solver.shells.plan import Plan

from .case import Case, Result, of_shell, pick
from .outlines import KINDS
from .settings import ODD

Rng = np.random.Generator


def case(rng: np.random.Generator, folder: Path) -> Case:
    name = pick(rng, ["convex", "letter", "star", "regular"])
    outline = KINDS[name](rng) * 10.0 ** rng.uniform(-3, 3)
    own = np.random.default_rng(rng.integers(2**32))
    approximates = rng.random() < 0.3

    def run() -> Result:
        size = float(np.ptp(outline, axis=0).max())
        shape = shapes.polygon(outline, max_edge=size / own.uniform(6, 14), corner_radius=pick(own, [0.0, 0.1]) * size)
        plan = Plan.from_shape(shape)
        if approximates or own.random() < 0.2:
            x, y = ((shape.positions - shape.positions.mean(axis=0)) / size).T
            heights = [0.5 - x**2 - y**2, x * y, 0.2 * np.sin(6 * x), 0 * x, 5 * x, np.abs(y)]
            plan.positions[:, 2] = size * pick(own, heights)
        return of_shell(fit_plan(plan, _approximation(own) if approximates else _outline(own, shape, size)))

    return Case(f"{'approximates' if approximates else 'fits'} {name}, {len(outline)} points", run)


def _approximation(rng: Rng) -> GaussMapOptions:
    number = pick(rng, [0.0, 1e-3, 1.0, *ODD])
    return GaussMapOptions(1e-3 if rng.random() < 0.7 else number, near=pick(rng, [0.0, 1.0, 300.0]), max_evaluations=8)


def _outline(rng: Rng, shape: shapes.Shape, size: float) -> OutlineOptions:
    options: dict = {"max_evaluations": pick(rng, [1, 5, 10])}
    if rng.random() < 0.7:
        height = pick(rng, ["rise", "height", "volume", "mean_curvature"])
        usual = {"rise": 0.5, "height": 0.3 * size, "volume": 0.1 * size**3, "mean_curvature": 1 / size}[height]
        options[height] = pick(rng, [usual, usual, usual * 10.0 ** rng.uniform(-3, 2), pick(rng, ODD)])
    rim = shape.positions[shape.domain.boundary_loops[0]]
    if rng.random() < 0.4:
        curve = np.column_stack([rim, 0.1 * size * np.sin(np.linspace(0, 4 * np.pi, len(rim)))])
        options["curve"] = pick(rng, [curve, curve[::-1], curve[:, [0, 2, 1]], 0 * curve, curve[:2], 5 * curve + size])
    if rng.random() < 0.3:
        vertices = rng.integers(-1 if rng.random() < 0.1 else 0, shape.domain.vertex_count, 3)
        weights = pick(rng, [np.ones(3), np.array([1.0, 1e6, 1e-6])])
        options["anchors"] = (vertices, size * rng.normal(size=(3, 3)), weights)
        options["on_curve"] = bool(rng.random() < 0.5)
    if rng.random() < 0.2:
        options["tilt"] = pick(rng, [(0.0, 1.5), (-0.1, 0.1), (1.0, 0.0), (np.nan, 1.0)])
    if rng.random() < 0.1:
        options["smooth"] = pick(rng, [0.0, 1.0, *ODD])
    options["free_heights"], options["sheet"] = bool(rng.random() < 0.2), pick(rng, ["f+", "f+", "f+", "f-"])
    return OutlineOptions(**options)
