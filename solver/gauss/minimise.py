"""Newton's method on the product of spheres, with conjugate gradients inside.

The energy is E = ½ <LN, N> with |N_i| = 1. At a map N, let G = LN, λ_i = <N_i, G_i> and P the projection on the
tangent planes. Then PG is the gradient and P (L - λ) P the Hessian. Each step solves P (L - λ) P d = -P G by
conjugate gradients, preconditioned by the factor of L, which does not change; it stops early while N is far from
critical. Where the curvature is negative the step goes as far along that direction as a step may: near a saddle the
gradient alone would take hundreds of steps to leave.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from ..errors import Status
from ..linalg import Factor
from .sphere import dot, exp, inner, project

Array = NDArray[np.float64]
Progress = Callable[[int, float], bool | None]

# A longer step of a normal, in radians, can jump to another homotopy class.
_LARGEST_ROTATION = 0.5
_LARGEST_FORCING = 0.1
_SUFFICIENT_DECREASE = 1e-4
_HALVINGS = 30
_CG_LIMIT = 200


@dataclass(frozen=True)
class DirichletProblem:
    """E(N) = ½ <LN, N> as a function of the unknown normals X (U, 3), the others being fixed.

    L: (U, U) of the unknown sites; load: (U, 3), L_UF N_F; areas: (U,); total_area: of the whole domain;
    constant: ½ <N_F, L_FF N_F>; factor: of L.
    """

    L: sp.csr_array
    load: Array
    areas: Array
    total_area: float
    constant: float
    factor: Factor

    def gradient(self, X: Array) -> Array:
        """dE/dX in R³, before projection."""
        return self.L @ X + self.load

    def energy(self, X: Array, gradient: Array) -> float:
        return 0.5 * inner(X, gradient + self.load) + self.constant

    def residual(self, tangent: Array) -> float:
        """sqrt(A Σ |P_i (LN)_i|² / A_i): the L² norm of N × (d*dN) on the domain scaled to unit area."""
        return float(np.sqrt(self.total_area * np.sum(dot(tangent, tangent)[:, 0] / self.areas)))


@dataclass(frozen=True)
class Iterate:
    """One line of the history: the map before the step, and what the step took."""

    energy: float
    residual: float
    solves: int
    step: float


@dataclass(frozen=True)
class Minimum:
    X: Array
    residual: float
    status: Status
    history: list[Iterate]


def newton(
    problem: DirichletProblem,
    X: Array,
    *,
    tolerance: float,
    max_iterations: int,
    progress: Progress | None = None,
) -> Minimum:
    """Minimise from X (U, 3). Never raises for want of convergence: the status says how it ended.

    `progress(iteration, residual)` is called at each map reached; returning False cancels.
    """
    history: list[Iterate] = []
    gradient = problem.gradient(X)
    while True:
        energy = problem.energy(X, gradient)
        tangent = project(X, gradient)
        residual = problem.residual(tangent)
        goes_on = progress is None or progress(len(history), residual) is not False
        status = _ended(residual, tolerance, len(history), max_iterations, goes_on)
        if status is not None:
            history.append(Iterate(energy, residual, 0, 0.0))
            return Minimum(X, residual, status, history)
        direction, solves = _direction(problem, X, gradient, tangent, residual)
        found = _line_search(problem, X, gradient, tangent, direction)
        history.append(Iterate(energy, residual, solves, found[2] if found else 0.0))
        if found is None:
            return Minimum(X, residual, Status.STALLED, history)
        X, gradient, _ = found


def _ended(residual: float, tolerance: float, step: int, limit: int, goes_on: bool) -> Status | None:
    if residual <= tolerance:
        return Status.CONVERGED
    if not goes_on:
        return Status.CANCELLED
    return Status.ITERATION_LIMIT if step >= limit else None


def _direction(
    problem: DirichletProblem, X: Array, gradient: Array, tangent: Array, residual: float
) -> tuple[Array, int]:
    """A descent direction by truncated conjugate gradients, and the back-solves it took."""
    multiplier = dot(X, gradient)
    rest = -tangent
    z = project(X, problem.factor.solve(rest))
    p = z
    rest_z = first = inner(rest, z)
    forcing = min(_LARGEST_FORCING, residual)
    d = np.zeros_like(X)
    for solves in range(1, _CG_LIMIT):
        curved = project(X, problem.L @ p - multiplier * p)
        curvature = inner(p, curved)
        if curvature <= 0.0:
            return d + p * (_LARGEST_ROTATION / _longest(p)), solves
        alpha = rest_z / curvature
        d = d + alpha * p
        rest = rest - alpha * curved
        z = project(X, problem.factor.solve(rest))
        rest_z, last = inner(rest, z), rest_z
        if rest_z <= forcing**2 * first:
            return d, solves + 1
        p = z + (rest_z / last) * p
    return d, _CG_LIMIT


def _line_search(
    problem: DirichletProblem, X: Array, gradient: Array, tangent: Array, direction: Array
) -> tuple[Array, Array, float] | None:
    """Armijo's rule along exp_N; the next map, its gradient and the step, or None.

    The decrease is computed as ½ <X' - X, G' + G>, not as a difference of energies, which would drown in
    rounding long before the tolerance is reached.
    """
    slope = inner(tangent, direction)
    step = min(1.0, _LARGEST_ROTATION / _longest(direction))
    for _ in range(_HALVINGS):
        trial = exp(X, step * direction)
        after = problem.gradient(trial)
        if 0.5 * inner(trial - X, after + gradient) <= _SUFFICIENT_DECREASE * step * slope:
            return trial, after, step
        step *= 0.5
    return None


def _longest(d: Array) -> float:
    return float(np.sqrt(dot(d, d).max()))


METHODS: dict[str, Callable[..., Minimum]] = {"newton": newton}
