"""Balanced maps: the centre of mass of the normals, weighted with their Dirichlet energy, vanishes.

∫ N μ = 0 with μ = <dN ∧ *dN> (paper, Sec. 5.3.4 and Theorem E.1); discretely C = Σ N_i μ_i = 0 with μ_i = <(LN)_i, N_i>
(Theorem E.2). At a critical map (LN)_i = μ_i N_i wherever nothing holds N, so that the sum is that of LN, which is zero
on a closed domain; along a boundary it is the flux out of it.

`balanced` descends among balanced maps; at a harmonic map of a closed domain its three multipliers vanish. From near
the map of a Wente torus plain descent ends at a constant map, this one at a harmonic map onto a great circle, that of a
round cylinder (a test has both). The constraint keeps the unstable modes of the Wente map itself: for those use
`modes.saddle`. A constant map is balanced, too.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ..errors import ConditionError, Progress, Status
from .newton import Minimum, Step, descend, longest
from .problem import EnergyProblem, Point
from .saddles import climb
from .sphere import dot, exp, inner

Array = NDArray[np.float64]

# Energy up to which a map counts as constant.
_CONSTANT = 1e-12
_LARGEST_ROTATION = 0.5
_HALVINGS = 20
_SUFFICIENT_DECREASE = 1e-4
# Residual below which Newton's method is quicker than descent.
_NEAR = 1e-3


def imbalance(problem: EnergyProblem, N: Array) -> Array:
    """Σ N_i μ_i (3,) of a map N (S, 3), relative to its energy; zero at critical maps of closed domains."""
    point = problem.at(N)
    if point.energy <= _CONSTANT:
        return np.zeros(3)
    return _moment(point) / point.energy


def balanced(
    problem: EnergyProblem,
    N: Array,
    *,
    tolerance: float,
    max_iterations: int = 500,
    progress: Progress | None = None,
) -> Minimum:
    """Descent in the H¹ metric under the constraint C = 0 with its multipliers β (paper, Sec. 5.3.4).

    A step d = -K⁻¹ (G + Aᵀ β) solves A d = -C, A being the derivative of C; its length lowers E + ρ |C| with ρ > |β|.
    Near a critical map, where the multipliers vanish, Newton's method takes over (`saddles.climb`).
    Raises `ConditionError` for energies that are not quadratic.
    """
    if not problem.energy.quadratic:
        raise ConditionError('Balanced maps need the energy "cotan", with normals at vertices.')

    def take_step(point: Point) -> Step | int:
        direction, force = _direction(problem, point)
        moment = float(np.linalg.norm(_moment(point)))
        weight = 2.0 * force + 1.0
        slope = inner(point.tangent, direction) - weight * moment
        length = min(1.0, _LARGEST_ROTATION / max(longest(direction), 1e-300))
        for _ in range(_HALVINGS):
            trial = problem.at(exp(point.N, length * direction))
            change = problem.change(point, trial) + weight * (float(np.linalg.norm(_moment(trial))) - moment)
            if change <= _SUFFICIENT_DECREASE * length * min(slope, 0.0):
                return Step(trial, 4, length)
            length *= 0.5
        return 4

    options: dict = {"max_iterations": max_iterations, "progress": progress}
    near = descend(problem, N, take_step, tolerance=max(tolerance, _NEAR), **options)
    if near.status is not Status.CONVERGED or near.residual <= tolerance:
        return near
    critical = climb(problem, near.N, index=None, tolerance=tolerance, **options)
    return replace(critical, history=near.history[:-1] + critical.history)


def _moment(point: Point) -> Array:
    return np.asarray((dot(point.N, point.gradient) * point.N).sum(axis=0))


def moment_gradients(problem: EnergyProblem, point: Point) -> Array:
    """(3, S, 3) admissible gradients of the components of C: μ e_c + N^c LN + L (N^c N)."""
    density = dot(point.N, point.gradient)
    rows = []
    for c in range(3):
        own = point.N[:, c, None]
        rows.append(problem.project(point.N, density * np.eye(3)[c] + own * point.gradient + point.L @ (own * point.N)))
    return np.stack(rows)


def _direction(problem: EnergyProblem, point: Point) -> tuple[Array, float]:
    """The step (S, 3) and |β|."""
    gradients = moment_gradients(problem, point)
    downhill = problem.project(point.N, problem.dirichlet.precondition(point.tangent))
    lifted = np.stack([problem.project(point.N, problem.dirichlet.precondition(a)) for a in gradients])
    product = np.einsum("aij,bij->ab", gradients, lifted)
    right = _moment(point) - np.einsum("aij,ij->a", gradients, downhill)
    force = np.linalg.lstsq(product, right, rcond=1e-12)[0]
    return -downhill - np.einsum("a,aij->ij", force, lifted), float(np.linalg.norm(force))
