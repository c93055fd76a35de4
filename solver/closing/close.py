"""Closing a surface: around holes and handles it shall come back to where it began, and its mirrors shall agree.

What is to vanish, periods and distances of planes (`relations`), depends on the boundary normals and on the conformal
type of the domain, given by a few moduli (`closing_map`); Newton's method makes it vanish (`closing_steps`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..domain.domain import Domain
from ..errors import ConditionError, Progress, check_choice
from ..gauss.boundary_data import Conditions
from ..gauss.methods import METHODS
from ..linalg import check_number
from ..surface.cmc_surface import CmcSurface
from ..surface.solve import CmcSolver
from ..symmetry.sides import Side
from .closing_conditions import ClosingConditions
from .closing_map import ClosingMap, Place
from .moduli import Moduli
from .newton_steps import ClosingSteps, Step, boundary_tangents

Array = NDArray[np.float64]

# Part of the first surface's area below which there is none to speak of.
_COLLAPSED = 0.05
# What is not closed is cut open above this part of the size.
_OPEN = 1e-3
WAYS = ("normals", "moduli", "both")


class ClosingStatus(Enum):
    """How closing ended; `sentence` says it to a person."""

    CLOSED = "closed"
    STALLED = "stalled"
    RANK_DEFICIENT = "rank deficient"
    OUT_OF_RANGE = "out of range"
    STEP_LIMIT = "step limit"
    CANCELLED = "cancelled"
    COLLAPSED = "collapsed"
    LOST = "lost"

    @property
    def sentence(self) -> str:
        return {
            ClosingStatus.CLOSED: "The surface closes.",
            ClosingStatus.STALLED: "No step brings the surface nearer to closing; change the boundary, or let more of "
            "it move.",
            ClosingStatus.RANK_DEFICIENT: "What may change does not reach all parts of the gap; let the normals "
            "change, or more moduli.",
            ClosingStatus.OUT_OF_RANGE: "The moduli came to the end of their range before the surface closed; let the "
            "normals change, or other moduli.",
            ClosingStatus.STEP_LIMIT: "The limit of steps was reached before the surface closed.",
            ClosingStatus.CANCELLED: "Closing was cancelled.",
            ClosingStatus.COLLAPSED: "The surface collapses on the way; no closed one was found near this boundary.",
            ClosingStatus.LOST: "No harmonic map was found to begin with; begin with other moduli, another initial map "
            "or another method.",
        }[self]


@dataclass(frozen=True, eq=False)
class ClosingResult:
    """The surface reached, and what it took.

    domain: with the moduli (m,) found, names in `names`. conditions: with the normals found, at vertices.
    gaps: the longest period or distance of planes as a part of the size, before and after each step. left: what is left
    of each of them, as such parts. rank: how many of their components could be moved independently in the last step.
    turned: (n,) radians by which the prescribed normals changed. area_ratio: the area of f+ now as a part of that
    before.
    """

    surface: CmcSurface
    domain: Domain
    conditions: Conditions
    moduli: Array
    names: tuple[str, ...]
    gaps: list[float]
    left: dict[str, float]
    rank: int | None
    turned: Array
    status: ClosingStatus
    area_ratio: float

    @property
    def closed(self) -> bool:
        return self.status is ClosingStatus.CLOSED

    @property
    def message(self) -> str:
        """How it ended, the gap, and what changed."""
        words = [self.status.sentence, f"The gap was {self.gaps[0]:.2g} of the size and is {self.gaps[-1]:.2g}."]
        if not self.closed:
            words.append("Left are " + ", ".join(f"{name}: {length:.2g}" for name, length in self.left.items()) + ".")
        if self.status is ClosingStatus.RANK_DEFICIENT:
            words.append(f"Only {self.rank} of their components could be moved independently.")
        if self.turned.any():
            largest, mean = np.degrees([self.turned.max(), np.sqrt(np.mean(self.turned**2))])
            words.append(f"Normals along the boundary turned by {largest:.1f}° at most, {mean:.1f}° root mean square.")
        words += [f"{name} changed by {q:+.3g}." for name, q in zip(self.names, self.moduli, strict=True)]
        return " ".join(words)


def close_periods(
    domain: Domain,
    conditions: Conditions,
    *,
    by: str = "normals",
    moduli: Moduli | None = None,
    weight: float = 1.0,
    coplanar: Sequence[Sequence[Side]] = (),
    positions: ArrayLike | None = None,
    initial: ArrayLike | None = None,
    method: str = "newton",
    mean_curvature: float = 0.5,
    tolerance: float = 1e-9,
    max_steps: int = 12,
    progress: Progress | None = None,
) -> ClosingResult:
    """Change the prescribed normals, the moduli of the domain, or both until the periods of the surface vanish.

    by: "normals", the least change of the normals in the H¹ norm along the boundary; "moduli", Newton's method in
    those; "both", the least of both together, the squares of moduli times `weight`. coplanar: groups of sides along
    mirrors of one direction, which shall lie in one plane: their distances are to vanish, too. positions: (V, 2|3) of
    the plan; with them only the tilts change, each normal turning about the boundary's tangent. tolerance: of the
    periods, as sums along loops, as a part of the size of f+. method: a name in `METHODS` by which the maps are found;
    "critical" and "saddle" follow those that are no minimisers. progress(step, gap) is called at every step, False
    cancels.

    Not closing is a status, with the nearest surface. Raises `ConditionError` where there is nothing to close, on names
    that do not exist, and where nothing may change.
    """
    check_choice(by, dict.fromkeys(WAYS), "way to close")
    check_choice(method, METHODS, "method")
    check_number(weight, "weight of moduli", positive=True)
    check_number(tolerance, "tolerance")
    check_number(max_steps, "largest number of steps")
    if (moduli is None) != (by == "normals"):
        raise ConditionError(f'Closing by "{by}" {"needs" if moduli is None else "does not take"} moduli.')
    if not conditions.vertices.size and by != "moduli":
        raise ConditionError("No normals are prescribed that could change; close by moduli.")
    relations = ClosingConditions.of(domain, conditions, coplanar)
    closing = ClosingMap(conditions, relations, moduli or Moduli.none(domain), method)
    axes = None if positions is None else boundary_tangents(domain, positions, closing.fixed)
    steps = ClosingSteps(closing, by, weight, axes)
    start = None if initial is None else np.asarray(initial, dtype=np.float64)
    return _result(closing, _search(steps, start, tolerance, max_steps, progress), mean_curvature)


@dataclass(frozen=True, eq=False)
class _Found:
    first: Place
    place: Place
    gaps: list[float]
    status: ClosingStatus
    rank: int | None


def _search(
    steps: ClosingSteps, initial: Array | None, tolerance: float, limit: int, progress: Progress | None
) -> _Found:
    first = place = steps.start(initial)
    gaps: list[float] = []
    step = None
    while True:
        if place.gap <= tolerance:
            place = steps.refined(place)
        gaps.append(place.gap)
        goes_on = progress is None or progress(len(gaps) - 1, place.gap) is not False
        status = _ended(place, first, len(gaps) - 1, tolerance, limit, step)
        if status is None and not goes_on:
            status = ClosingStatus.CANCELLED
        if status is None:
            step = steps.step(place)
            status = _stuck(step)
        if status is not None or step is None or step.place is None:
            return _Found(first, place, gaps, status or ClosingStatus.STALLED, step.rank if step else None)
        place = step.place


def _ended(
    place: Place, first: Place, count: int, tolerance: float, limit: int, step: Step | None
) -> ClosingStatus | None:
    if not place.found:
        return ClosingStatus.LOST
    if place.area < _COLLAPSED * first.area:
        return ClosingStatus.COLLAPSED
    if place.gap <= tolerance:
        return ClosingStatus.CLOSED
    if count < limit:
        return None
    return ClosingStatus.STEP_LIMIT if step is None or step.reaches else ClosingStatus.RANK_DEFICIENT


def _stuck(step: Step) -> ClosingStatus | None:
    if step.place is not None:
        return None
    if not step.reaches:
        return ClosingStatus.RANK_DEFICIENT
    return ClosingStatus.OUT_OF_RANGE if step.at_end else ClosingStatus.STALLED


def _result(closing: ClosingMap, found: _Found, mean_curvature: float) -> ClosingResult:
    place = found.place
    conditions = place.extension.given(place.rim)
    tolerance = np.inf if found.status is ClosingStatus.CLOSED else _OPEN
    surface = CmcSolver(place.domain).solve(
        conditions,
        initial=place.reached.N,
        method=closing.method,
        mean_curvature=mean_curvature,
        period_tolerance=tolerance,
    )
    return ClosingResult(
        surface=surface,
        domain=place.domain,
        conditions=conditions,
        moduli=place.q,
        names=closing.moduli.names,
        gaps=found.gaps,
        left=dict(zip(closing.relations.names, (place.lengths / place.size).tolist(), strict=True)),
        rank=found.rank,
        turned=2.0 * np.arcsin(np.minimum(0.5 * np.linalg.norm(place.rim - closing.first, axis=1), 1.0)),
        status=found.status,
        area_ratio=place.area / found.first.area,
    )
