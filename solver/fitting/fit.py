"""Boundary normals, size and place of the CMC surface that comes nearest to a sum of targets (paper, Sec. 5.2)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from enum import Enum
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize

from ..domain.domain import Domain
from ..errors import CmcError, ConditionError, Progress
from ..gauss.boundary_data import Conditions
from ..surface.adjoint import AdjointSolver
from ..surface.cmc_surface import CmcSurface
from ..surface.solve import CmcSolver
from .gauss_newton import GaussNewtonModel
from .objective import Objective
from .response import Response
from .target import Target

Array = NDArray[np.float64]

_SIDES = {"f+": 1.0, "f-": -1.0}
# Evaluations for which one model serves, and how many steps' gain such a run has to bring to be followed by another.
_RUN = 25
_RUN_GAIN = 10.0
# A value that is small: gains are parts of the value and this, so that a fit that is nearly perfect ends.
_ENOUGH = 1e-5


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
    history: the value at each evaluation. complaints: a sentence for each wish that is not met. response: serves fits
    that go on from this one.
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
    unmet: tuple[str, ...] | list[str] = ()
    response: Response | None = None

    @property
    def is_met(self) -> bool:
        """Whether every wish is fulfilled, to the tolerance of what it is."""
        return not self.unmet

    @property
    def message(self) -> str:
        """How it ended, and what is not met."""
        return " ".join([self.status.sentence, *self.unmet])

    def points(self, sheet: str | None = None) -> Array:
        """A sheet (n, 3) in its place; by default the one that was fitted."""
        return self.sign * self.surface.sheet(sheet or self.sheet) + self.shift


@dataclass(frozen=True, eq=False)
class Start:
    """Where a fit begins: boundary conditions, scale 1 / (2 H), shift, and normals (V, 3) of a first map or None.

    response: of an earlier fit on the same domain, whose matrices then serve again.
    """

    conditions: Conditions
    scale: float
    shift: Array
    normals: Array | None = None
    response: Response | None = None


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
    gain: float = 1e-4,
    solver: CmcSolver | None = None,
    progress: Progress | None = None,
) -> Fit:
    """Minimise Σ weight · target over the boundary normals, and the scale and the shift where they are free.

    The vertices that `start.conditions` fix are those whose normals may change. size: a length by which errors are
    divided. gain: the part of the value that a step has to bring to be followed by another. By L-BFGS in the
    coordinates of `GaussNewtonModel`; each evaluation is a warm solve and an adjoint one. progress(evaluation, value)
    is called at every step, False cancels. Raises `ConditionError` on names that do not exist, or nothing to fit to.
    """
    if sheet not in _SIDES:
        raise ConditionError(f"There is no sheet {sheet!r} to fit; known are {', '.join(_SIDES)}.")
    if not targets:
        raise ConditionError("There is no target to fit to.")
    solver = solver or CmcSolver(domain)
    fixed, rim = start.conditions.resolve()
    response = start.response
    if response is None or not response.belongs(solver.harmonic, fixed):
        response = Response(AdjointSolver(solver.harmonic, start.conditions))
    objective = Objective(response, targets, _SIDES[sheet], size, free_scale, free_shift, start.normals)
    status = _minimise(objective, objective.vector(rim, start.scale, start.shift), gain, max_evaluations, progress)
    return _finished(solver, objective, status, sheet)


def _minimise(objective: Objective, x: Array, gain: float, limit: int, progress: Progress | None) -> FitStatus:
    """Runs of L-BFGS, each with a model of its own, until one gains little."""
    value = np.inf
    while len(objective.history) < limit:
        before, steps = value, min(_RUN, limit - len(objective.history))
        x, value, goes_on = _run(objective, x, gain, steps, progress)
        if not goes_on:
            return FitStatus.CANCELLED
        if before - value < _RUN_GAIN * gain * (value + _ENOUGH):
            return FitStatus.CONVERGED
    return FitStatus.EVALUATION_LIMIT


def _run(
    objective: Objective, x: Array, gain: float, limit: int, progress: Progress | None
) -> tuple[Array, float, bool]:
    """L-BFGS from x, for as many evaluations; where it got to, the value there, and whether to go on."""
    here, slope = objective(x)
    model = GaussNewtonModel(objective, x)
    # in these units the first step, as L-BFGS takes it, is the one that the model proposes
    unit = max(float(np.linalg.norm(model.back(slope))), 1e-150)
    goes_on = True

    def moved(y: Array) -> tuple[float, Array]:
        value, gradient = objective(x + unit * model.forth(y)) if y.any() else (here, slope)
        return (value + _ENOUGH) / unit**2, model.back(gradient) / unit

    def each_step(intermediate_result: Any) -> None:
        nonlocal goes_on
        if progress is not None and progress(len(objective.history), objective.history[-1]) is False:
            goes_on = False
            raise StopIteration

    options = {"maxfun": limit, "maxiter": limit, "maxcor": _RUN, "ftol": gain, "gtol": 0.0}
    found = minimize(moved, np.zeros_like(x), jac=True, method="L-BFGS-B", callback=each_step, options=options)
    return x + unit * model.forth(found.x), float(found.fun) * unit**2 - _ENOUGH, goes_on


def _finished(solver: CmcSolver, objective: Objective, status: FitStatus, sheet: str) -> Fit:
    best = objective.best
    if best is None:
        raise CmcError("The fit was cancelled before it began.")
    found = objective.extension.given(best.rim)
    surface = solver.solve(found, initial=best.state.N, mean_curvature=0.5 / best.scale)
    if not (surface.is_open or found.mirrors.size):
        # the conjugate that was fitted; at the rim it differs from the solver's own at second order, and along mirrors
        # only that lies in their planes
        g, N = best.scale * best.state.g, best.scale * surface.normals
        surface = replace(surface, g=g, f_plus=g + N, f_minus=g - N)
    distances: dict[str, float] = {}
    for target in objective.targets:  # of several with one label, as anchors of different weights, the farthest
        distances[target.label] = max(target.distance(best.shape), distances.get(target.label, 0.0))
    return Fit(
        surface, best.shift, found, distances, best.value, status, objective.history, sheet, response=objective.response
    )
