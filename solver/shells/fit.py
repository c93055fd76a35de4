"""From a plan and a goal to the shell that comes nearest to it, measured: `form` for designs by target."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from ..errors import Progress
from ..fitting.fit import Fit
from ..fitting.gauss_map import GaussMapOptions, fit_gauss_map
from ..fitting.goals import OutlineOptions
from ..fitting.outline import fit_outline
from ..surface.placement import Plane, Similarity
from ..surface.solve import CmcSolver
from .measured import measure_shell
from .plan import Plan, Settings, plan_domain
from .rim_curves import curves_of_loops
from .shell import Shell

FitOptions = OutlineOptions | GaussMapOptions
"""The goal of a fitted shell: an outline and anchors, or the tangent planes of the plan's own mesh."""


def fit_plan(
    plan: Plan,
    options: FitOptions,
    *,
    solver: CmcSolver | None = None,
    progress: Progress | None = None,
    intersections: bool | Callable[[], bool] = True,
) -> Shell:
    """The CMC shell nearest to a goal, in its place and measured; `Shell.fit` says how near it came.

    options: `OutlineOptions`, whose `curve` is a list of closed polylines (m, 3), given to the loops of the plan by
    `curves_of_loops`; or `GaussMapOptions`, for a shell like the plan's mesh itself. solver: one for the plan's domain.
    progress(evaluation, value) is called every step; False cancels, and the best shell so far is the result. Raises
    `CmcError` on goals without meaning; where a goal cannot be met, see `Shell.ok` and `Shell.message`.
    """
    solver = solver or CmcSolver(plan_domain(plan))
    outline = plan.positions
    fit_to: Callable[..., Fit] = fit_gauss_map
    if isinstance(options, OutlineOptions):
        fit_to = fit_outline
        if options.curve is not None:
            given: Any = options.curve
            curves = [given] if isinstance(given, np.ndarray) and given.ndim == 2 else given
            lines = curves_of_loops(solver.domain, plan.positions, [np.asarray(curve) for curve in curves])
            options = replace(options, curve=lines)
            outline = lines if options.on_curve else outline
    options = replace(options, solver=solver, progress=progress)
    fit = fit_to(solver.domain, plan.positions, **vars(options))
    similarity = Similarity(1.0, fit.sign * np.eye(3), fit.shift)
    rim = np.isin(fit.surface.source, solver.domain.boundary_vertices)
    return measure_shell(
        plan,
        Settings(sheet=fit.sheet),
        fit.surface,
        Plane(fit.points()[rim].mean(axis=0), np.array([0.0, 0.0, 1.0])),
        similarity,
        solver,
        outline=outline,
        fit=fit,
        intersections=intersections,
    )
