"""Whole Wente cylinders on meshes without symmetry, and perturbed maps, for tests of saddles."""

from __future__ import annotations

import numpy as np

from solver import HarmonicSolver, conditions
from solver.catalogue.wente import wente_start
from solver.catalogue.wente_heights import wente_height
from solver.gauss.modes import problem_of
from solver.gauss.sphere import normalize
from tests.solver import exact_surfaces
from tests.solver.fundamental_pieces import edges_where


def jittered_cylinder(angle: float, columns: int, seed: int):
    """A closing cylinder, its conditions, the start of docs/explanation/bubbles.md. angle: radians."""
    height = wente_height(angle)
    domain, points = exact_surfaces.cylinder(height, columns, seed=seed)
    bottom, top = (edges_where(domain, points, lambda p, y=y: np.abs(p[:, 1] - y) < 1e-9) for y in (0.0, height))
    held = conditions.fixed(domain, bottom, [1, 0, 0])
    held += conditions.fixed(domain, top, [np.cos(angle), np.sin(angle), 0.0])
    return domain, held, wente_start(points, angle, height)


def nearby(solver: HarmonicSolver, normals: np.ndarray, amount: float = 0.05) -> np.ndarray:
    """The normals of a closed domain moved by a smooth random field of up to `amount`."""
    problem = problem_of(solver, conditions.Conditions())
    noise = np.random.default_rng(1).standard_normal(normals.shape)
    smooth = problem.dirichlet.precondition(problem.graph.areas[:, None] * noise)
    return normalize(normals + amount * smooth / np.abs(smooth).max())
