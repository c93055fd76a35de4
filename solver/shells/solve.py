"""The surface over a plan: the solve itself, the second solution over the same rim, and unstable modes counted."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import ConditionError, Progress, Status
from ..gauss.boundary_data import Conditions
from ..gauss.initial_map import over_the_other_pole
from ..surface.cmc_surface import CmcSurface
from ..surface.solve import CmcSolver
from .plan import Plan, Settings, plan_conditions
from .plan_metric import at_sites, start_map

Array = NDArray[np.float64]

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
    if first.status in (Status.CANCELLED, Status.COLLAPSED):
        return first
    reached = first.harmonic.degree
    if settings.degree is not None and off_degree(first, settings.degree):
        return _other(first, solver, solve, settings.degree, ()) or first
    if settings.shell == "first":
        return first
    turn = -1.0 if reached >= 0.0 else 1.0
    found = _other(first, solver, solve, None, (reached + turn, reached - turn))
    if found is None:
        raise ConditionError(
            "No large bubble was found over this rim: on this mesh it shrinks to a point. Halve the edge length of the "
            "plan, or choose the first shell."
        )
    return found


def _other(
    first: CmcSurface,
    solver: CmcSolver,
    solve: Callable[[ArrayLike | None, float | None], CmcSurface],
    wanted: float | None,
    grafts: Sequence[float],
) -> CmcSurface | None:
    """A solution over the same boundary of another class (paper, Theorem D.1), or of the degree that is wanted.

    From the first map lifted over the other pole; else from that with a bubble grafted onto it, for a start of the
    degrees `grafts`. None where all of them come back.
    """
    for degree in (None, *grafts):
        try:
            surface = solve(first.harmonic.normals if degree is not None else _lifted(first, solver), degree)
        except ConditionError:  # a start that is not known for such domains
            continue
        other = off_degree(surface, first.harmonic.degree) if wanted is None else not off_degree(surface, wanted)
        if surface.status is Status.CANCELLED or (other and surface.harmonic.status is Status.CONVERGED):
            return surface
    return None


def _lifted(first: CmcSurface, solver: CmcSolver) -> Array:
    admissible = first.harmonic.admissible
    held = np.union1d(admissible.fixed, admissible.mirrors.sites)
    return admissible.pin(over_the_other_pole(solver.harmonic.dirichlet(held), first.harmonic.normals))


def off_degree(surface: CmcSurface, degree: float) -> bool:
    """Whether the map of a surface is in another class than one of that degree with the same boundary."""
    return abs(surface.harmonic.degree - degree) > _OTHER_CLASS


def modes_on(solver: CmcSolver, conditions: Conditions, surface: CmcSurface) -> tuple[int, int]:
    """Numbers of unstable and of null modes of a surface's map under its conditions (see `saddle_maps.index_of`).

    Raises `ConditionError` where the map is not critical, since it has no index then, and where a mode cannot be told
    from a null one.
    """
    if surface.harmonic.status is not Status.CONVERGED:
        raise ConditionError(
            "Unstable modes are counted at a map that has converged; let the solve reach its tolerance first."
        )
    try:
        return solver.index(conditions, surface.harmonic.normals)
    except ArithmeticError as error:
        raise ConditionError(
            "The modes of this map cannot be counted: one lies between the unstable and the null ones; refine the plan."
        ) from error
