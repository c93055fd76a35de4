"""The harmonic map heat flow in the H¹ metric, with explicit steps (paper, Sec. 4.2, Eq. 17)."""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from ..errors import Progress
from .newton import Minimum, Step, conjugate_gradients, descend, line_search
from .problem import EnergyProblem, Point

Array = NDArray[np.float64]

# Relative accuracy of the linear solve for a direction.
_FORCING = 1e-3


def flow(
    problem: EnergyProblem,
    N: Array,
    *,
    tolerance: float,
    max_iterations: int = 2000,
    progress: Progress | None = None,
) -> Minimum:
    """Gradient flow: N ← exp_N(h δ) with `<δ, φ>_H¹ = -<grad E, φ>` for all tangent φ, h halved until E falls.

    The H¹ product is the mass (areas as parts of the whole, so that units do not matter) plus the Laplacian with the
    weights of the energy at equal normals, made positive. Linear convergence.
    """
    graph, energy = problem.graph, problem.energy
    weights = np.abs(energy.star(np.ones(len(graph.links)), graph))
    product = sp.csr_array(graph.laplacian(weights) + sp.diags_array(graph.areas / graph.areas.sum()))

    def take_step(point: Point) -> Step | int:
        direction, solves = conjugate_gradients(
            problem, point, lambda d: problem.project(point.N, product @ d), _FORCING
        )
        return line_search(problem, point, direction, solves)

    return descend(problem, N, take_step, tolerance=tolerance, max_iterations=max_iterations, progress=progress)
