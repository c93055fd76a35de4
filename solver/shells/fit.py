"""From a plan and a wish to a shell that comes nearest to it, measured: `pipeline.form` for designs by target."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray

from ..errors import JobError, Progress
from ..fitting.fit import Fit
from ..fitting.gauss_map import fit_gauss_map
from ..fitting.goals import HEIGHT_PARAMETERS
from ..fitting.outline import fit_outline
from ..surface.cmc_surface import SHEETS
from ..surface.placement import Plane, Similarity
from ..surface.solve import CmcSolver
from .form import measure_shell
from .plan import Plan, Settings, plan_domain
from .rim_curves import curves_of_loops
from .shell import Shell

Array = NDArray[np.float64]
Anchors = tuple[NDArray[np.integer], Array, Array]


@dataclass(frozen=True, eq=False)
class Goal:
    """What a shell shall come near to: an outline, anchors, or with `approximate` the mesh of the plan itself.

    on_curve: whether the rim shall lie on `curves`, closed polylines (m, 3) given to the loops of the plan as
    `curves_of_loops` says; None is the plan's own outline.
    height_parameter: of `HEIGHT_PARAMETERS`, with its `value`; None leaves it to `fit_outline`, where free_heights,
    anchors, tilt (radians), smooth and sheet are explained, too. regularisation, near: see `fit_gauss_map`, which
    chooses the sheet itself. max_evaluations: None is either's own. Raises `JobError` on a height_parameter or a sheet
    that is none.
    """

    approximate: bool = False
    regularisation: float = 1e-3
    near: float = 0.0
    on_curve: bool = True
    curves: Sequence[Array] | None = None
    height_parameter: str | None = None
    value: float = 0.0
    free_heights: bool = False
    anchors: Anchors | None = None
    tilt: tuple[float, float] | None = None
    smooth: float = 1e-7
    sheet: str = "f+"
    max_evaluations: int | None = None

    def __post_init__(self) -> None:
        if self.height_parameter is not None and self.height_parameter not in HEIGHT_PARAMETERS:
            known = ", ".join(HEIGHT_PARAMETERS)
            raise JobError(f'A fit has no "{self.height_parameter}"; choose one of {known}.')
        if self.sheet not in SHEETS:
            raise JobError(f'There is no sheet "{self.sheet}"; choose f+ or f-.')


def fit_plan(
    plan: Plan,
    wish: Goal,
    *,
    solver: CmcSolver | None = None,
    progress: Progress | None = None,
    intersections: bool = True,
) -> Shell:
    """The CMC shell nearest to a wish, where it was wished for, and measured; `Shell.fit` says how near it is.

    solver: one for the plan's domain. progress(evaluation, value) is called every step; False cancels, and the best
    shell until then is the result. Raises `CmcError` on a wish that makes no sense; one that cannot be fulfilled is
    told by `Shell.ok` and `Shell.message`.
    """
    positions = plan.positions
    solver = solver or CmcSolver(plan_domain(plan))
    lines = None if wish.curves is None else curves_of_loops(solver.domain, positions, wish.curves)
    found = _fit(solver, positions, lines, wish, progress)
    similarity = Similarity(1.0, found.sign * np.eye(3), found.shift)
    points = found.points()
    rim = np.isin(found.surface.source, solver.domain.boundary_vertices)
    outline = lines if lines is not None and wish.on_curve else positions
    return measure_shell(
        plan,
        Settings(sheet=found.sheet),
        found.surface,
        Plane(points[rim].mean(axis=0), np.array([0.0, 0.0, 1.0])),
        similarity,
        solver,
        outline=outline,
        fit=found,
        intersections=intersections,
    )


def _fit(solver: CmcSolver, positions: Array, lines: list[Array] | None, wish: Goal, progress: Progress | None) -> Fit:
    """What is not wished for is left to the fit."""
    call = partial(fit_gauss_map if wish.approximate else fit_outline, solver=solver, progress=progress)
    if wish.max_evaluations is not None:
        call = partial(call, max_evaluations=wish.max_evaluations)
    if wish.approximate:
        if wish.near:
            call = partial(call, near=wish.near)
        return call(solver.domain, positions, regularisation=wish.regularisation)
    if wish.height_parameter is not None:
        call = partial(call, **{wish.height_parameter: wish.value})
    if wish.tilt is not None:
        call = partial(call, tilt=wish.tilt)
    return call(
        solver.domain,
        positions,
        curve=lines,
        free_heights=wish.free_heights,
        anchors=wish.anchors,
        on_curve=wish.on_curve,
        smooth=wish.smooth,
        sheet=wish.sheet,
    )
