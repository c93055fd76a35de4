"""From a plan to a shell over it, measured: the one way that job files and Blender go."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import Progress, Status
from ..surface.solve import CmcSolver
from .plan import Group, Plan, Settings, plan_conditions
from .shell import Shell, form_surface, solver_for
from .solve import modes_on, solve_plan

Array = NDArray[np.float64]

__all__ = ["Group", "Plan", "Settings", "Shell", "count_modes", "form"]


def form(
    plan: Plan,
    settings: Settings | None = None,
    *,
    solver: CmcSolver | None = None,
    initial: ArrayLike | None = None,
    progress: Progress | None = None,
    intersections: bool | Callable[[], bool] = True,
) -> Shell:
    """Solve for the shell over a plan, size and place it, and measure it.

    solver: one that an earlier call returned in `Shell.solver`; it is used if it belongs to this plan and to the
    sites, energy and triangulation that the settings ask for, which saves factoring. initial (S, 3), one normal
    a site: a map to start from, `surface.harmonic.normals` of an earlier one.
    progress(iteration, residual) is called every step; False cancels. intersections=False leaves out the
    slowest measure; see `report`. Raises `CmcError` (`MeshError`, `ConditionError`, `PlacementError`) on input that
    cannot be used; a solve that does not converge is told by `Shell.converged` and `message`.
    """
    settings = settings or Settings()
    plan = replace(plan, positions=np.asarray(plan.positions, dtype=np.float64))
    solver = solver_for(plan, settings, solver)
    surface = solve_plan(plan, settings, solver, initial=initial, progress=progress)
    shell = form_surface(plan, settings, surface, solver, intersections=intersections)
    if settings.counts_modes and surface.harmonic.status is Status.CONVERGED:
        return count_modes(plan, settings, shell)
    return shell


def count_modes(plan: Plan, settings: Settings, shell: Shell) -> Shell:
    """The same with the unstable and null modes of its map in the report.

    Raises `ConditionError` where the map has not converged.
    """
    assert shell.solver is not None
    conditions = plan_conditions(plan, settings, shell.solver.domain)
    index, nullity = modes_on(shell.solver, conditions, shell.surface)
    return replace(shell, report=replace(shell.report, index=index, nullity=nullity))
