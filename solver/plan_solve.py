"""The surface over a plan: the solve itself, the second solution over the same rim, and unstable modes counted."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .errors import ConditionError, Status
from .gauss.conditions import Conditions
from .gauss.saddle_maps import Modes
from .plan import Plan, Settings, plan_conditions
from .plan_metric import at_sites, start_map
from .surface.cmc import CmcSurface
from .surface.solve import CmcSolver

Array = NDArray[np.float64]
Progress = Callable[[int, float], bool | None]

# A bubble changes the degree by one; a map is of another class where it changed by more than this.
_OTHER_CLASS = 0.5


def solve_plan(
    plan: Plan,
    settings: Settings,
    solver: CmcSolver,
    *,
    initial: ArrayLike | None = None,
    progress: Progress | None = None,
) -> CmcSurface:
    """The surface that the settings ask for, from `initial` (S, 3) or else from the plan's own start.

    Raises `CmcError` on what cannot be solved for; not converging is a status.
    """
    conditions = plan_conditions(plan, settings, solver.domain)
    if initial is None and plan.initial is not None:
        normals = start_map(plan.initial, len(plan.positions))
        initial = at_sites(solver.harmonic.graph, normals)

    def solve(start: ArrayLike | None, degree: float | None) -> CmcSurface:
        return solver.solve(
            conditions,
            initial=start,
            method=settings.method,
            averaging=settings.averaging,
            tolerance=settings.tolerance,
            period_tolerance=settings.period_tolerance,
            side=settings.side,
            degree=degree,
            progress=progress,
        )

    first = solve(initial, settings.degree)
    if settings.shell == "first" or first.status in (Status.CANCELLED, Status.COLLAPSED):
        return first
    return _large(first, solve)


def _large(first: CmcSurface, solve: Callable[[ArrayLike | None, float | None], CmcSurface]) -> CmcSurface:
    """The other solution over the same boundary (paper, Theorem D.1): that of one degree less, or of one more.

    A bubble is grafted onto the first map and let relax; the one that turns against the map takes less energy and is
    tried first. Where both shrink until the mesh does not see them the first map comes back, with a status that says
    so.
    """
    degree = first.harmonic.degree
    found = []
    for turn in (-1.0, 1.0) if degree >= 0.0 else (1.0, -1.0):
        surface = solve(first.harmonic.normals, degree + turn)
        if surface.status is Status.CANCELLED:
            return surface
        if surface.status in (Status.CONVERGED, Status.GAP) and is_other(surface, degree):
            return surface
        found.append(surface)
    others = [surface for surface in found if is_other(surface, degree)]
    if others:
        return others[0]
    return replace(first, harmonic=replace(first.harmonic, status=Status.UNDER_RESOLVED))


def is_other(surface: CmcSurface, degree: float) -> bool:
    """Whether the map of a surface is in another class than one of that degree with the same boundary."""
    return abs(surface.harmonic.degree - degree) > _OTHER_CLASS


def modes_on(solver: CmcSolver, conditions: Conditions, surface: CmcSurface) -> Modes:
    """Unstable and null modes of a surface's map under its conditions; see `modes_of`.

    Raises `ConditionError` where the map is not critical, since it has no index then.
    """
    if surface.harmonic.status is not Status.CONVERGED:
        raise ConditionError(
            "Unstable modes are counted at a map that has converged; let the solve reach its tolerance first."
        )
    return solver.modes(conditions, surface.harmonic.normals)
