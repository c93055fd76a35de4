"""Newton's method on the product of spheres, with conjugate gradients inside.

At a map N, let G be the gradient in R³ and P the projection on the tangent planes (see `problem`). Each step solves
P H P d = -P G by conjugate gradients, preconditioned with a constant factored Laplacian; it stops early while N is far
from critical. A direction of negative curvature is followed as far as a step may go: near a saddle the gradient alone
would take hundreds of steps to leave.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..errors import Progress, Status
from .problem import EnergyProblem, Point
from .sphere import dot, exp, inner

Array = NDArray[np.float64]

# A longer step of a normal, in radians, can jump to another homotopy class.
_LARGEST_ROTATION = 0.5
_LARGEST_FORCING = 0.1
_SUFFICIENT_DECREASE = 1e-4
_HALVINGS = 30
# Differences of the energy below this part of it are rounding.
_ROUNDING = 1e-13
_FALLING = 0.99
_CG_LIMIT = 200


@dataclass(frozen=True)
class Iterate:
    """One line of the history: energy and residual before a step, back-solves and length of the step."""

    energy: float
    residual: float
    solves: int
    step: float


@dataclass(frozen=True)
class Minimum:
    """The map N (S, 3) that a minimiser reached, and how it ended."""

    N: Array
    residual: float
    status: Status
    history: list[Iterate]

    @property
    def ok(self) -> bool:
        return self.status is Status.CONVERGED

    @property
    def message(self) -> str:
        return self.status.sentence


@dataclass(frozen=True)
class Step:
    """The next map, the back-solves it cost, and the length of the step as a part of the full one."""

    point: Point
    solves: int
    length: float


def descend(
    problem: EnergyProblem,
    N: Array,
    take_step: Callable[[Point], Step | int | Status],
    *,
    tolerance: float,
    max_iterations: int,
    progress: Progress | None = None,
) -> Minimum:
    """Take steps from N (S, 3) until the residual is within the tolerance.

    Where `take_step` reaches no better map it returns the number of back-solves it cost, or a status that ends the
    descent; from infinite energy no step is possible. Does not raise where it fails to converge: the status says how
    it ended. `progress(iteration, residual)` is called at each map reached; returning False cancels.
    """
    history: list[Iterate] = []
    point = problem.at(N)
    while True:
        goes_on = progress is None or progress(len(history), point.residual) is not False
        status = _ended(point.residual, tolerance, len(history), max_iterations, goes_on)
        if point.energy < 0.0:  # a sum of squares is not, unless some weights are negative
            status = Status.UNBOUNDED
        if status is not None:
            history.append(Iterate(point.energy, point.residual, 0, 0.0))
            return Minimum(point.N, point.residual, status, history)
        step = take_step(point) if np.isfinite(point.residual) else 0
        if not isinstance(step, Step):
            solves, status = (0, step) if isinstance(step, Status) else (step, Status.STALLED)
            history.append(Iterate(point.energy, point.residual, solves, 0.0))
            return Minimum(point.N, point.residual, status, history)
        history.append(Iterate(point.energy, point.residual, step.solves, step.length))
        point = step.point


def _ended(residual: float, tolerance: float, step: int, limit: int, goes_on: bool) -> Status | None:
    if residual <= tolerance:
        return Status.CONVERGED
    if not goes_on:
        return Status.CANCELLED
    return Status.ITERATION_LIMIT if step >= limit else None


def newton(
    problem: EnergyProblem,
    N: Array,
    *,
    tolerance: float,
    max_iterations: int = 200,
    progress: Progress | None = None,
) -> Minimum:
    """Newton's method with truncated conjugate gradients and Armijo's rule along great circles."""

    def take_step(point: Point) -> Step | int:
        forcing = min(_LARGEST_FORCING, point.residual)
        direction, solves = conjugate_gradients(problem, point, problem.hessian(point), forcing)
        return line_search(problem, point, direction, solves)

    return descend(problem, N, take_step, tolerance=tolerance, max_iterations=max_iterations, progress=progress)


def conjugate_gradients(
    problem: EnergyProblem, point: Point, operator: Callable[[Array], Array], forcing: float
) -> tuple[Array, int]:
    """A descent direction d with `operator(d) ≈ -PG`, and the back-solves it cost.

    operator: symmetric on admissible vectors. Ends when the preconditioned rest has fallen by `forcing`, or at the
    first direction of negative curvature.
    """

    def precondition(X: Array) -> Array:
        return problem.project(point.N, problem.dirichlet.precondition(X))

    rest = -point.tangent
    z = precondition(rest)
    p = z
    rest_z = first = inner(rest, z)
    d = np.zeros_like(rest)
    for solves in range(1, _CG_LIMIT):
        curved = operator(p)
        curvature = inner(p, curved)
        if curvature <= 0.0:
            return d + p * (_LARGEST_ROTATION / longest(p)), solves
        alpha = rest_z / curvature
        d = d + alpha * p
        rest = rest - alpha * curved
        z = precondition(rest)
        rest_z, last = inner(rest, z), rest_z
        if rest_z <= forcing**2 * first:
            return d, solves + 1
        p = z + (rest_z / last) * p
    return d, _CG_LIMIT


def line_search(problem: EnergyProblem, point: Point, direction: Array, solves: int) -> Step | int:
    """Armijo's rule along exp_N, from the full step; a step into infinite energy is never taken.

    Where the energy can fall by no more than its rounding, the residual decides.
    """
    slope = inner(point.tangent, direction)
    length = min(1.0, _LARGEST_ROTATION / longest(direction))
    for _ in range(_HALVINGS):
        trial = problem.at(exp(point.N, length * direction))
        if -length * slope <= _ROUNDING * abs(point.energy):
            if trial.residual < _FALLING * point.residual:
                return Step(trial, solves, length)
        elif problem.change(point, trial) <= _SUFFICIENT_DECREASE * length * slope:
            return Step(trial, solves, length)
        length *= 0.5
    return solves


def longest(d: Array) -> float:
    """The largest |d_i|."""
    return float(np.sqrt(dot(d, d).max()))
