"""Newton's method on the 4 S equations with Lagrange multipliers (paper, Appendix B): the reference.

The unknowns are the normals, free to leave the sphere, and one multiplier each:

    grad E(N)_i + Λ_i N_i = 0,    ½ (1 - |N_i|²) = 0,

and at a site on a mirror one more, μ_i, with + μ_i ν_i in the first equation and <ν_i, N_i> = 0.

The energy is continued off the sphere as a function of c = 1 - ½ |N_i - N_j|², so that its gradient is
Σ star (N_i - N_j) and, for the cotangent energy, its Hessian the Laplacian. Every step factors a new saddle matrix:
slow, and sure to converge only near a critical point of any kind; but it shares no code with Newton's method on the
spheres.
"""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray
from scipy.sparse.linalg import splu

from ..errors import Progress
from .newton import Minimum, Step, descend
from .problem import EnergyProblem, Point
from .sphere import dot, normalize

Array = NDArray[np.float64]

_HALVINGS = 12


def lagrange(
    problem: EnergyProblem,
    N: Array,
    *,
    tolerance: float,
    max_iterations: int = 50,
    progress: Progress | None = None,
) -> Minimum:
    """Full Newton steps; each is halved while it would not lower the residual, and ends on the spheres."""

    def take_step(point: Point) -> Step | int:
        direction = _direction(problem, point)
        if direction is None:
            return 1
        length = 1.0
        for _ in range(_HALVINGS):
            trial = problem.at(normalize(point.N + length * direction))
            if trial.residual < point.residual:
                return Step(trial, 1, length)
            length *= 0.5
        return 1

    return descend(problem, N, take_step, tolerance=tolerance, max_iterations=max_iterations, progress=progress)


def _direction(problem: EnergyProblem, point: Point) -> Array | None:
    """δN (S, 3) of one Newton step of the whole system, zero at fixed sites; None where the system is singular.

    On the sphere the best multipliers are Λ_i = -<N_i, G_i> and μ_i = -<ν_i, G_i>, and with them the other equations
    hold already.
    """
    unknown, mirrors = problem.dirichlet.unknown, problem.mirrors
    count = len(unknown)
    multiplier = -dot(point.N, point.gradient)
    rows = (3 * unknown[:, None] + np.arange(3)).ravel()
    hessian = sp.csr_array(sp.kron(point.L, sp.eye_array(3)) + sp.diags_array(np.repeat(multiplier[:, 0], 3)))
    bending = problem.bending(point)
    if bending is not None:
        rows_u, dstar = bending
        hessian = sp.csr_array(hessian - rows_u.T @ sp.diags_array(dstar) @ rows_u)
    hessian = hessian[rows][:, rows]
    X = _rows(point.N[unknown], np.arange(count), count)
    Y = _rows(mirrors.normals, np.searchsorted(unknown, mirrors.sites), count)
    constraints = sp.csr_array(sp.vstack([-X, Y]))
    saddle = sp.block_array([[hessian, constraints.T], [constraints, None]], format="csc")
    first = mirrors.flatten(point.gradient + multiplier * point.N)[unknown].ravel()
    try:
        solution = splu(saddle).solve(np.concatenate([-first, np.zeros(count + len(mirrors.sites))]))
    except RuntimeError:  # SuperLU: "Factor is exactly singular"
        return None
    direction = np.zeros_like(point.N)
    direction[unknown] = solution[: 3 * count].reshape(-1, 3)
    return direction


def _rows(vectors: Array, places: NDArray[np.integer], count: int) -> sp.csr_array:
    """(m, 3 count) a vector (m, 3) a row, at the place (m,) of its site."""
    columns = 3 * places[:, None] + np.arange(3)
    starts = np.arange(0, 3 * len(places) + 1, 3)
    return sp.csr_array((vectors.ravel(), columns.ravel(), starts), shape=(len(places), 3 * count))
