"""Boundary normals, size and place of the CMC surface that comes nearest to a sum of targets (paper, Sec. 5.2)."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from enum import Enum
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize

from ..domain.domain import Domain
from ..errors import CmcError, ConditionError
from ..gauss import conditions as boundary
from ..gauss.conditions import Conditions
from ..gauss.sphere import inner, normalize, project
from ..surface.cmc import CmcSurface
from ..surface.solve import CmcSolver
from .adjoint import Extension, State
from .targets import Partials, Shape, Target, boundary_shares

Array = NDArray[np.float64]
Progress = Callable[[int, float], bool | None]

_SIDES = {"f+": 1.0, "f-": -1.0}
# Harmonic maps are found to this residual while searching, so that gradients are good to as many digits.
_RESIDUAL = 1e-7
# Steps that L-BFGS remembers.
_MEMORY = 30


class FitStatus(Enum):
    """How a fit ended; `sentence` says it to a person."""

    CONVERGED = "converged"
    EVALUATION_LIMIT = "evaluation limit"
    CANCELLED = "cancelled"

    @property
    def sentence(self) -> str:
        return {
            FitStatus.CONVERGED: "No change of the boundary normals comes nearer to the targets.",
            FitStatus.EVALUATION_LIMIT: "The limit of evaluations was reached; more may come nearer to the targets.",
            FitStatus.CANCELLED: "The fit was cancelled; the surface is the best one found until then.",
        }[self]


@dataclass(frozen=True, eq=False)
class Fit:
    """The best surface found, and how near it came.

    surface: in the size of the world, its g centred; its sheets times `sign` plus `shift` (3,) are in their place. A
    sign of -1 reflects it in a point: the tangent planes stay and it bulges to the other side of N. conditions: the
    boundary normals found, at vertices. distances: label → distance of each target, see there. value: of their sum.
    history: the value at each evaluation. complaints: a sentence for each wish that is not met.
    """

    surface: CmcSurface
    shift: Array
    conditions: Conditions
    distances: dict[str, float]
    value: float
    status: FitStatus
    history: list[float]
    sheet: str = "f+"
    sign: float = 1.0
    complaints: tuple[str, ...] | list[str] = ()

    @property
    def met(self) -> bool:
        """Whether every wish is fulfilled, to the tolerance of what it is."""
        return not self.complaints

    @property
    def message(self) -> str:
        """How it ended, and what is not met."""
        return " ".join([self.status.sentence, *self.complaints])

    def points(self, sheet: str | None = None) -> Array:
        """A sheet (n, 3) in its place; by default the one that was fitted."""
        return self.sign * self.surface.sheet(sheet or self.sheet) + self.shift


@dataclass(frozen=True, eq=False)
class Start:
    """Where a fit begins: boundary conditions, scale 1 / (2 H), shift, and normals (V, 3) of a first map or None."""

    conditions: Conditions
    scale: float
    shift: Array
    normals: Array | None = None


def fit(
    domain: Domain,
    targets: Sequence[Target],
    start: Start,
    *,
    size: float,
    sheet: str = "f+",
    free_scale: bool = True,
    free_shift: bool = True,
    max_evaluations: int = 200,
    solver: CmcSolver | None = None,
    progress: Progress | None = None,
) -> Fit:
    """Minimise Σ weight · target over the boundary normals, and the scale and the shift where they are free.

    The vertices that `start.conditions` fix are those whose normals may change. size: a length by which errors are
    divided. By L-BFGS; each evaluation is a warm solve and an adjoint one. progress(evaluation, value) is called at
    every step, False cancels. Raises `ConditionError` on names that do not exist, or nothing to fit to.
    """
    if sheet not in _SIDES:
        raise ConditionError(f"There is no sheet {sheet!r} to fit; known are {', '.join(_SIDES)}.")
    if not targets:
        raise ConditionError("There is no target to fit to.")
    solver = solver or CmcSolver(domain)
    fixed, rim = start.conditions.resolve()
    extension = Extension(solver.harmonic, fixed, start.conditions.up)
    search = _Search(extension, targets, _SIDES[sheet], size, free_scale, free_shift, start.normals)
    status = _minimise(search, search.vector(rim, start.scale, start.shift), max_evaluations, progress)
    return _finished(solver, search, status, sheet)


@dataclass(frozen=True, eq=False)
class _Placed:
    """A state in the world: points = scale · (g + side · N) + shift."""

    state: State
    rim: Array
    scale: float
    shift: Array
    shape: Shape
    value: float = np.inf


class _Search:
    """The sum of the targets as a function of one vector: boundary normals, logarithm of the scale, shift.

    Boundary normals count with the root of the boundary length they stand for, so that the mesh does not matter.
    """

    def __init__(
        self,
        extension: Extension,
        targets: Sequence[Target],
        side: float,
        size: float,
        free_scale: bool,
        free_shift: bool,
        first: Array | None,
    ) -> None:
        self.extension, self.targets, self.side, self.size = extension, targets, side, size
        self.free_scale, self.free_shift, self.first = free_scale, free_shift, first
        self.roots = np.sqrt(boundary_shares(extension.domain)[extension.fixed])[:, None]
        self.best: _Placed | None = None
        self.history: list[float] = []

    def vector(self, rim: Array, scale: float, shift: Array) -> Array:
        return np.concatenate([(self.roots * rim).ravel(), [np.log(scale)], shift / self.size])

    def __call__(self, x: Array) -> tuple[float, Array]:
        placed = self._place(x)
        total = Partials.none(placed.shape)
        for target in self.targets:
            total = total + target.partials(placed.shape).times(target.weight)
        self.history.append(total.value)
        if self.best is None or total.value < self.best.value:
            self.best = replace(placed, value=total.value)
        return total.value, self._gradient(x, placed, total)

    def _place(self, x: Array) -> _Placed:
        rim = normalize(x[:-4].reshape(-1, 3) / self.roots)
        state = self.extension(rim, self.best.state.N if self.best else self.first, _RESIDUAL)
        scale, shift = float(np.exp(x[-4])), x[-3:] * self.size
        points = scale * (state.g + self.side * state.N) + shift
        shape = Shape(self.extension.domain, self.extension.fixed, points, state.N, self.size)
        return _Placed(state, rim, scale, shift, shape)

    def _gradient(self, x: Array, placed: _Placed, total: Partials) -> Array:
        by_conjugate = placed.scale * total.by_points
        by_rim = self.extension.pull_back(placed.state, total.by_normals + self.side * by_conjugate, by_conjugate)
        length = np.linalg.norm(x[:-4].reshape(-1, 3), axis=1, keepdims=True)
        by_scale = inner(total.by_points, placed.shape.points - placed.shift) if self.free_scale else 0.0
        by_shift = self.size * total.by_points.sum(axis=0) if self.free_shift else np.zeros(3)
        return np.concatenate([(project(placed.rim, by_rim) / length).ravel(), [by_scale], by_shift])


def _minimise(search: _Search, x: Array, limit: int, progress: Progress | None) -> FitStatus:
    cancelled = False

    def each_step(intermediate_result: Any) -> None:
        nonlocal cancelled
        if progress is not None and progress(len(search.history), float(intermediate_result.fun)) is False:
            cancelled = True
            raise StopIteration

    options = {"maxfun": limit, "maxiter": limit, "maxcor": _MEMORY, "ftol": 1e-15, "gtol": 1e-10}
    found = minimize(search, x, jac=True, method="L-BFGS-B", callback=each_step, options=options)
    if cancelled:
        return FitStatus.CANCELLED
    return FitStatus.EVALUATION_LIMIT if found.status == 1 else FitStatus.CONVERGED


def _finished(solver: CmcSolver, search: _Search, status: FitStatus, sheet: str) -> Fit:
    best = search.best
    if best is None:
        raise CmcError("The fit was cancelled before it began.")
    found = boundary.fixed_at(solver.domain, search.extension.fixed, best.rim)
    found = replace(found, up=search.extension.up)
    surface = solver.solve(found, initial=best.state.N, mean_curvature=0.5 / best.scale)
    if not surface.is_open:
        # the conjugate that was fitted; at the rim it differs from the solver's own at second order
        g, N = best.scale * best.state.g, best.scale * surface.normals
        surface = replace(surface, g=g, f_plus=g + N, f_minus=g - N)
    distances: dict[str, float] = {}
    for target in search.targets:  # of several with one label, as anchors of different weights, the farthest
        distances[target.label] = max(target.distance(best.shape), distances.get(target.label, 0.0))
    return Fit(surface, best.shift, found, distances, best.value, status, search.history, sheet)
