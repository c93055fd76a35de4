"""The CMC surface that comes nearest to a sum of targets: its boundary normals, size and place (paper, Sec. 5.2)."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from enum import Enum
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize

from ..domain.shape import DomainLike, as_domain
from ..errors import CmcError, ConditionError, Progress, Status, check_choice
from ..gauss.boundary_data import Conditions
from ..gauss.sphere import dot
from ..signatures import checked
from ..spanning.span import Span
from ..surface import convert, notebook
from ..surface.adjoint import AdjointSolver
from ..surface.cmc_surface import CmcSurface
from ..surface.plane_projection import VertexPlanes
from ..surface.solve import CmcSolver
from .gauss_newton import CONTINUED, FAR, NEAR, GaussNewtonModel
from .objective import Objective
from .response import Response
from .side_residuals import SideResidual
from .target import Target

if TYPE_CHECKING:
    import trimesh

Array = NDArray[np.float64]

_SIDES = {"f+": 1.0, "f-": -1.0}
# Evaluations per model, and the gain of such a run, in gains of a step, that makes another one worthwhile.
_RUN = 25
_RUN_GAIN = 10.0
# A small value: gains are parts of the value plus this, so that a nearly perfect fit ends.
_ENOUGH = 1e-5
# The farthest that one run may take the logarithm of the scale, and the shift in sizes.
_FAR = 20.0


class FitStatus(Enum):
    """How a fit ended; `sentence` says it to a person."""

    CONVERGED = "converged"
    EVALUATION_LIMIT = "evaluation limit"
    NO_SURFACE = "no surface"
    CANCELLED = "cancelled"

    @property
    def sentence(self) -> str:
        return {
            FitStatus.CONVERGED: "The fit converged: no change of the boundary normals comes nearer to the targets.",
            FitStatus.EVALUATION_LIMIT: "The fit reached its limit of evaluations; more may bring it nearer.",
            FitStatus.NO_SURFACE: "No surface on these lines was found.",
            FitStatus.CANCELLED: "The fit was cancelled; this is the best surface up to then.",
        }[self]


@dataclass(frozen=True, eq=False, repr=False)
class Fit:
    """The best surface of a fit, and how near it came.

    surface: in world size, its g centred; a sheet times `sign` plus `shift` (3,) is in its place. A sign of -1 reflects
    it in a point: the tangent planes stay and it bulges to the other side of N. conditions: the fitted boundary
    normals, at vertices. distances: label → distance of each target, see there. value: of their sum. history: the value
    at each evaluation. unmet: a sentence for each goal that is not met. response: serves fits that continue this one.

    span: where lines and one number are all that was asked for, the surface on them, found without a search. Then
    `surface` is the span itself, with its exact rim; its domain is the plan with the moduli that the lines need (see
    `Span`), to which the surface is conformal; history has the residual after each step.
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
    sides: tuple[SideResidual, ...] = ()
    solver: CmcSolver | None = None
    response: Response | None = None
    model: GaussNewtonModel | None = None
    span: Span | None = None

    @property
    def is_met(self) -> bool:
        """Whether every goal is met, each to its own tolerance."""
        return not self.unmet

    @property
    def ok(self) -> bool:
        """Whether every goal is met by a surface that converged and closes."""
        return self.is_met and self.surface.status is Status.CONVERGED

    @property
    def message(self) -> str:
        """How the fit ended, and the goals that it did not meet."""
        return " ".join(self.sentences)

    @property
    def sentences(self) -> list[str]:
        """The sentences of `message`."""
        if self.span is not None:
            return [self.span.message]
        return [self.status.sentence, *self.unmet]

    @checked
    def points(self, sheet: str | None = None) -> Array:
        """A sheet (n, 3) in its place; by default the fitted one."""
        return self.sign * self.surface.sheet(sheet or self.sheet) + self.shift

    @checked
    def normals(self, sheet: str | None = None) -> Array:
        """Unit normals (n, 3) of a sheet in its place, on the side from which its faces are counter-clockwise."""
        N = self.surface.normals
        return -N if (sheet or self.sheet) == "f-" else N

    @checked
    def save(self, path: str | os.PathLike[str], sheet: str | None = None) -> None:
        """Write a sheet's triangles as OBJ, PLY, STL or GLB, by the suffix; raises `JobError` where that fails."""
        convert.save_mesh(path, self.points(sheet), self.surface.faces, self.normals(sheet))

    @checked
    def to_trimesh(self, sheet: str | None = None) -> trimesh.Trimesh:
        """A sheet in its place as a `trimesh.Trimesh` with its normals."""
        return convert.to_trimesh(self.points(sheet), self.surface.faces, self.normals(sheet))

    def _repr_html_(self) -> str:
        """Distances and status, and a picture of the fitted sheet where matplotlib is installed."""
        numbers = {
            "sheet": self.sheet,
            "mean curvature H": f"{self.surface.mean_curvature:.4g}",
            **{label: f"{distance:.3g}" for label, distance in self.distances.items()},
            "status": f"{self.status.value} after {len(self.history)} evaluations",
            "goals": "met" if self.is_met else " ".join(self.unmet),
        }
        return notebook.table("Fit", numbers, notebook.picture(self.points(), self.surface.faces))

    def __repr__(self) -> str:
        far = ", ".join(f"{label} {distance:.3g}" for label, distance in self.distances.items())
        goals = "met" if self.is_met else "not met"
        return f"Fit({self.sheet}: {far}; {self.status.value} after {len(self.history)} evaluations, goals {goals})"


@dataclass(frozen=True, eq=False)
class Start:
    """The start of a fit: boundary conditions, scale 1 / (2 H), shift, and normals (V, 3) of a first map or None.

    response, model: of an earlier fit on the same domain, to use their matrices again. held: vertices (k,) whose
    normals stay as the conditions have them.
    """

    conditions: Conditions
    scale: float
    shift: Array
    normals: Array | None = None
    response: Response | None = None
    model: GaussNewtonModel | None = None
    held: NDArray[np.integer] = field(default_factory=lambda: np.zeros(0, dtype=np.int64))


@checked
def fit(
    domain: DomainLike,
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

    The normals at the vertices that `start.conditions` fix may change, but for those at `start.held`. size: the length
    by which errors are divided. gain: the part of the value that a step must gain to be followed by another. By L-BFGS
    in the coordinates of `GaussNewtonModel`; each evaluation takes a warm solve and an adjoint one. With the response
    and the model of an earlier fit it stays near the surface of that one. progress(evaluation, value) is called at
    every step; False cancels. Raises `ConditionError` on an unknown sheet and without targets.
    """
    check_choice(sheet, _SIDES, "sheet")
    if not targets:
        raise ConditionError("A fit needs a target; give one or more.")
    domain = as_domain(domain)
    solver = solver or CmcSolver(domain)
    fixed, rim = start.conditions.resolve()
    response = start.response
    if response is None or not response.belongs(solver.harmonic, fixed, start.held):
        response = Response(AdjointSolver(solver.harmonic, start.conditions), start.held)
    objective = Objective(response, targets, _SIDES[sheet], size, free_scale, free_shift, start.normals, rim)
    model = start.model.damped(CONTINUED) if start.model is not None and start.model.suits(objective) else None
    first = objective.vector(rim, start.scale, start.shift)
    status, model = _minimise(objective, first, gain, max_evaluations, progress, model)
    return _finished(solver, objective, status, sheet, model)


def _minimise(
    objective: Objective,
    x: Array,
    gain: float,
    limit: int,
    progress: Progress | None,
    model: GaussNewtonModel | None,
) -> tuple[FitStatus, GaussNewtonModel]:
    """Runs of L-BFGS, each with a model of its own, until one gains little; and the last model.

    model: of the first run, from an earlier search, or None.
    """
    value, damping = np.inf, FAR
    while True:
        before, steps = value, min(_RUN, limit - len(objective.history))
        here = objective(x)
        model = model or GaussNewtonModel(objective, x, damping)
        x, value, goes_on = _run(objective, model, x, here, gain, steps, progress)
        if not goes_on:
            return FitStatus.CANCELLED, model
        if before - value < _RUN_GAIN * gain * (value + _ENOUGH):
            return FitStatus.CONVERGED, model
        if len(objective.history) >= limit:
            return FitStatus.EVALUATION_LIMIT, model
        model, damping = None, NEAR


def _run(
    objective: Objective,
    model: GaussNewtonModel,
    x: Array,
    first: tuple[float, Array],
    gain: float,
    limit: int,
    progress: Progress | None,
) -> tuple[Array, float, bool]:
    """L-BFGS from x, with the value and gradient `first`, for up to `limit` evaluations.

    The vector reached, its value, and False where cancelled.
    """
    here, slope = first
    # in these units the first step of L-BFGS is the one that the model proposes
    unit = max(float(np.linalg.norm(model.back(slope))), 1e-150)
    goes_on = True

    def moved(y: Array) -> tuple[float, Array]:
        step = unit * model.forth(y)
        if not np.abs(step[-4:]).max() < _FAR:  # uphill from here on, or the scale overflows
            wall = (here + _ENOUGH) / unit**2
            return wall * (1.0 + float(y @ y)), 2.0 * wall * y
        value, gradient = objective(x + step) if y.any() else (here, slope)
        return (value + _ENOUGH) / unit**2, model.back(gradient) / unit

    def each_step(intermediate_result: Any) -> None:
        nonlocal goes_on
        if progress is not None and progress(len(objective.history), objective.history[-1]) is False:
            goes_on = False
            raise StopIteration

    options = {"maxfun": limit, "maxiter": limit, "maxcor": _RUN, "ftol": gain, "gtol": 0.0}
    reached = minimize(moved, np.zeros_like(x), jac=True, method="L-BFGS-B", callback=each_step, options=options)
    return x + unit * model.forth(reached.x), float(reached.fun) * unit**2 - _ENOUGH, goes_on


def _finished(
    solver: CmcSolver, objective: Objective, status: FitStatus, sheet: str, model: GaussNewtonModel
) -> Fit:
    best = objective.best
    if best is None:
        raise CmcError("The fit was cancelled before it began.")
    conditions = objective.extension.given(best.rim)
    surface = solver.solve(conditions, initial=best.state.N, mean_curvature=0.5 / best.scale)
    if not surface.is_open:
        # the fitted conjugate; at the rim it differs from the solver's own at second order, which alone lies in the
        # planes of mirrors
        g, N = best.scale * best.state.g, best.scale * surface.normals
        planes = VertexPlanes.of(surface.domain, surface.harmonic.admissible.sides.planes)
        offsets = dot(surface.g[planes.vertices[planes.places]], planes.normals)[:, 0]
        g[planes.vertices] = planes.nearest(g[planes.vertices], offsets)
        surface = replace(surface, g=g, f_plus=g + N, f_minus=g - N)
    distances: dict[str, float] = {}
    for target in objective.targets:  # the farthest of those with one label, such as anchors of different weights
        distances[target.label] = max(target.distance(best.shape), distances.get(target.label, 0.0))
    return Fit(
        surface=surface,
        shift=best.shift,
        conditions=conditions,
        distances=distances,
        value=best.value,
        status=status,
        history=objective.history,
        sheet=sheet,
        solver=solver,
        response=objective.response,
        model=model,
    )
