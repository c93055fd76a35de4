"""The second shell over a rim: another solution with the same boundary (paper, Theorem D.1)."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import ConditionError, Status
from ..gauss.initial_map import over_the_other_pole
from ..surface.cmc_surface import CmcSurface
from ..surface.solve import CmcSolver

Array = NDArray[np.float64]

# A bubble changes the degree by one; two maps are in different classes where their degrees differ by more than this.
_OTHER_CLASS = 0.5


def second_shell(
    first: CmcSurface,
    solver: CmcSolver,
    solve: Callable[[ArrayLike | None, float | None], CmcSurface],
    degree: float | None = None,
) -> CmcSurface | None:
    """A solution over the same boundary in another class than `first`, or of this degree; None where none is found.

    solve(start, degree): the solve with these conditions, as `solve_plan` has it. It starts from the first map lifted
    over the other pole; where that falls back and no degree is given, from the first map with a bubble grafted onto it.
    """
    turn = -1.0 if first.harmonic.degree >= 0.0 else 1.0
    grafts = () if degree is not None else (first.harmonic.degree + turn, first.harmonic.degree - turn)
    for graft in (None, *grafts):
        try:
            surface = solve(_lifted(first, solver) if graft is None else first.harmonic.normals, graft)
        except ConditionError:  # such domains have no start of that degree
            continue
        reached = off_degree(surface, first.harmonic.degree) if degree is None else not off_degree(surface, degree)
        if surface.status is Status.CANCELLED or (reached and surface.harmonic.status is Status.CONVERGED):
            return surface
    return None


def off_degree(surface: CmcSurface, degree: float) -> bool:
    """Whether the map of a surface is in another class than maps of that degree with the same boundary."""
    return abs(surface.harmonic.degree - degree) > _OTHER_CLASS


def _lifted(first: CmcSurface, solver: CmcSolver) -> Array:
    admissible = first.harmonic.admissible
    held = np.union1d(admissible.fixed, admissible.mirrors.sites)
    return admissible.pin(over_the_other_pole(solver.harmonic.dirichlet(held), first.harmonic.normals))
