"""Saddle maps: up along a few unstable modes and down along all others, then Newton's method.

A Newton step leads to a zero of the gradient, up or down in energy. In the eigenvectors v_i of the Hessian in the H¹
product, H v_i = λ_i K v_i, it is -Σ v_i <v_i, G> / λ_i: down where λ_i > 0, up where λ_i < 0. The `index` lowest of the
negative terms keep their sign and the others change it, so that the map climbs along these modes only. Near the saddle
no sign changes and the steps are Newton's.

Null directions are kept out of a step by bordering its matrix (a phase condition each): rotations of the sphere that
keep the conditions, and translations of a flat domain. The mesh keeps translations only roughly: where most of the
gradient is along them, the map moves along them, too, downwards.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..errors import Progress
from .newton import Minimum, Step, descend, longest
from .null_directions import Fields, drifts, free_rotations
from .problem import EnergyProblem, Point
from .sphere import exp
from .tangent import TangentSystem

Array = NDArray[np.float64]

# The largest rotation of a normal in one step, in radians.
_LARGEST_ROTATION = 0.5
# The same where the map moves along given null fields.
_LARGEST_DRIFT = 0.1
# Below this residual a step must lower it; above it |λ| counts as at least the floor.
_NEAR = 0.2
_FLOOR = 0.1
# More modes than these below the floor are not looked for.
_MANY = 100
# Residual below which it may move along given null fields.
_NEARLY = 1.0
_HALVINGS = 8
_FALLING = 0.99
# Where a step would leave more than this part of the gradient along the given null fields, the map moves there.
_LEFT = 0.3


def climb(
    problem: EnergyProblem,
    N: Array,
    *,
    tolerance: float,
    max_iterations: int = 100,
    progress: Progress | None = None,
    index: int | None = 1,
    null: Fields | None = None,
) -> Minimum:
    """A critical map of that index, or of a smaller one, from N (S, 3); the nearest of any index if None.

    null: N ↦ fields (k, S, 3) along which the energy hardly changes; `null_directions.drifts` unless given. They do
    not count in the index.
    """
    axes = free_rotations(problem, N)
    null = null or drifts(problem, N)

    def take_step(point: Point) -> Step | int:
        system = TangentSystem.of(problem, point)
        turns = np.cross(axes[:, None, :], point.N)
        exact = gauge = system.orthonormal(system.coordinates(turns))
        if null is not None:
            gauge = system.orthonormal(system.coordinates(np.concatenate([turns, null(point.N)])))
        direction, left = system.solve(-system.gradient, gauge)
        drift = None
        if point.residual < _NEARLY and np.linalg.norm(left) > _LEFT * system.dual_norm(system.gradient):
            drift = system.solve(-system.gradient, exact)[0] - direction
        if index is not None:
            direction = _turned(system, gauge, index, direction, is_near=point.residual <= _NEAR)
        if drift is None:
            return _advance(problem, point, system.in_space(direction))
        uphill = index is not None and drift @ system.gradient > 0.0
        return _drift(problem, point, system.in_space(direction - drift if uphill else direction + drift))

    return descend(problem, N, take_step, tolerance=tolerance, max_iterations=max_iterations, progress=progress)


def _turned(system: TangentSystem, gauge: Array, index: int, newton: Array, *, is_near: bool) -> Array:
    """Newton's step (n,) turned downhill along all negative modes but the lowest `index`, and shorter along modes with
    |λ| below the floor.

    The modes are counted before they are looked for: near the saddle there is nothing to turn, and where there are very
    many the map is far from any saddle of that index, so that the H¹ gradient will do for the way down.
    """
    floor = 0.0 if is_near else _FLOOR
    count = system.count(floor, gauge)
    if count <= (index if is_near else 0):
        return newton
    if count > max(_MANY, index):
        gradient = system.product_factor.solve(system.gradient)
        values, modes = system.lowest(index, gauge) if index else (np.zeros(0), gauge[:, :0])
        upward, none = modes[:, values < 0.0], gauge @ (gauge.T @ system.gradient)
        return none - gradient + 2.0 * upward @ (upward.T @ system.gradient)
    values, modes = system.lowest(count, gauge)
    signs = np.where((np.arange(len(values)) < index) & (values < 0.0), -1.0, 1.0)
    wanted = signs * np.maximum(np.abs(values), floor)
    return newton + modes @ ((modes.T @ system.gradient) * (1.0 / values - 1.0 / wanted))


def _advance(problem: EnergyProblem, point: Point, direction: Array) -> Step | int:
    """The step, cut to the largest rotation; near a critical map halved until it lowers the residual."""
    size = longest(direction)
    if not np.isfinite(size):
        return 1
    length = min(1.0, _LARGEST_ROTATION / max(size, 1e-300))
    for _ in range(_HALVINGS):
        trial = problem.at(exp(point.N, length * direction))
        if point.residual > _NEAR or trial.residual < _FALLING * point.residual:
            return Step(trial, 1, length)
        length *= 0.5
    return 1


def _drift(problem: EnergyProblem, point: Point, direction: Array) -> Step | int:
    """A step along null fields, during which the residual may rise."""
    size = longest(direction)
    if not np.isfinite(size):
        return 1
    length = min(1.0, _LARGEST_DRIFT / max(size, 1e-300))
    return Step(problem.at(exp(point.N, length * direction)), 2, length)
