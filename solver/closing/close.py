"""Closing a surface: its periods around holes and handles vanish, and mirrors of one direction share a plane.

The closing conditions (`closing_conditions`) depend on the boundary normals and on the conformal type of the domain,
given by a few moduli (`closing_map`); Newton's method meets them (`newton_steps`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import KW_ONLY, dataclass
from enum import Enum

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..domain.domain import Domain
from ..domain.shape import DomainLike, as_domain
from ..errors import ConditionError, Progress, check_choice
from ..gauss.boundary_data import Conditions, check_conditions
from ..gauss.methods import METHODS
from ..gauss.options import with_options
from ..limits import COUNT, POSITIVE, TOLERANCE, Range, check_number
from ..signatures import check_fields
from ..surface.cmc_surface import CmcSurface
from ..surface.solve import CmcSolver
from ..symmetry.sides import Side
from .closing_conditions import NOTHING_OPEN, ClosingConditions
from .closing_map import ClosingMap, Place
from .holes import together
from .moduli import Moduli
from .newton_steps import ClosingSteps, Step, boundary_tangents

Array = NDArray[np.float64]

# Part of the first surface's area below which the surface has collapsed.
_COLLAPSED = 0.05
# Periods above this part of the size cut a surface open that does not close.
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
            ClosingStatus.STALLED: "No step brings the surface nearer to closing; change the boundary, or free more of "
            "it.",
            ClosingStatus.RANK_DEFICIENT: "The free normals and moduli do not reach all parts of the gap; free the "
            "normals, or more moduli.",
            ClosingStatus.OUT_OF_RANGE: "The moduli reached the end of their range before the surface closed; free the "
            "normals, or other moduli.",
            ClosingStatus.STEP_LIMIT: "The surface did not close within the limit of steps; allow more steps.",
            ClosingStatus.CANCELLED: "Closing was cancelled.",
            ClosingStatus.COLLAPSED: "The surface collapses on the way: no closed surface is near this boundary.",
            ClosingStatus.LOST: "No harmonic map was found to begin with; begin with other moduli, another initial map "
            "or another method.",
        }[self]


@dataclass(frozen=True, eq=False)
class PeriodOptions:
    """The options of `close_periods`, see there. Raises `ConditionError` on values without meaning."""

    _: KW_ONLY
    by: str = "normals"
    moduli: Moduli | Sequence[Moduli] | None = None
    weight: float = 1.0
    coplanar: Sequence[Sequence[Side]] = ()
    positions: ArrayLike | None = None
    initial: ArrayLike | None = None
    method: str = "newton"
    mean_curvature: float = 0.5
    tolerance: float = 1e-9
    max_steps: int = 12
    progress: Progress | None = None

    def __post_init__(self) -> None:
        check_choice(self.by, WAYS, "way to close")
        check_choice(self.method, METHODS, "method")
        check_number(self.weight, "weight of moduli", POSITIVE)
        check_number(self.tolerance, "tolerance", TOLERANCE)
        check_number(self.max_steps, "largest number of steps", Range(0, COUNT.most, whole=True))
        if (self.moduli is None) != (self.by == "normals"):
            verb = "needs" if self.moduli is None else "does not take"
            raise ConditionError(f'Closing by "{self.by}" {verb} moduli.')
        check_fields(self)


@dataclass(frozen=True, eq=False, repr=False)
class ClosingResult:
    """The last surface of a closing, and the changes that led to it.

    domain: with the final moduli (m,), called `names`. conditions: with the final normals, at vertices. gaps: the
    longest period or distance of planes as a part of the size, before and after each step. left: the rest of each of
    them, as such parts. rank: how many of their components the last step could move independently. turned: (n,) radians
    by which the prescribed normals turned. area_ratio: final area of f+ over its first area.
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
    def ok(self) -> bool:
        """Whether the surface closes."""
        return self.closed

    @property
    def message(self) -> str:
        """How closing ended, the gap, and the changes of the boundary."""
        words = [self.status.sentence, f"The gap was {self.gaps[0]:.2g} of the size and is {self.gaps[-1]:.2g}."]
        if not self.closed:
            words.append("The rest: " + ", ".join(f"{name} {length:.2g}" for name, length in self.left.items()) + ".")
        if self.status is ClosingStatus.RANK_DEFICIENT:
            words.append(f"Only {self.rank} of their components could be moved independently.")
        if self.turned.any():
            largest, mean = np.degrees([self.turned.max(), np.sqrt(np.mean(self.turned**2))])
            words.append(f"Normals along the boundary turned by {largest:.1f}° at most, {mean:.1f}° root mean square.")
        words += [f"{name} changed by {q:+.3g}." for name, q in zip(self.names, self.moduli, strict=True)]
        return " ".join(words)

    def __repr__(self) -> str:
        moduli = "".join(f", {name} {q:+.3g}" for name, q in zip(self.names, self.moduli, strict=True))
        gaps = f"gap {self.gaps[0]:.2g} to {self.gaps[-1]:.2g} in {len(self.gaps) - 1} steps"
        return f"ClosingResult({self.status.value}: {gaps}{moduli})"


@with_options(PeriodOptions)
def close_periods(domain: DomainLike, conditions: Conditions, options: PeriodOptions) -> ClosingResult:
    """Change the prescribed normals, the moduli of the domain, or both until the periods of the surface vanish.

    by: "normals", the least change of the normals in the H¹ norm along the boundary; "moduli", Newton's method in
    the moduli; "both", the least of both together, the squares of moduli times `weight`. coplanar: groups of sides
    along mirrors of one direction that must lie in one plane: the distances between them vanish, too. positions:
    (V, 2|3) of the plan; with them only the tilts change, each normal turning about the boundary's tangent. initial:
    (V, 3) normals to start from. method: a name in `METHODS`; "critical" and "saddle" follow maps that are not
    minimisers. tolerance: of the periods, as sums along loops, as a part of the size of f+. progress(step, gap) is
    called at every step; False cancels. `hole`, `tube` and `tubes` make moduli; several holes are given as a list.

    Not closing is a status, with the nearest surface. Raises `ConditionError` where nothing is open, on unknown names,
    and where nothing may change.
    """
    domain = as_domain(domain)
    check_closing(domain, conditions, options.by, options.coplanar)
    moduli = Moduli.none(domain) if options.moduli is None else together(options.moduli)
    closing = ClosingConditions.of(domain, conditions, options.coplanar)
    closing_map = ClosingMap(conditions, closing, moduli, options.method)
    axes = None if options.positions is None else boundary_tangents(domain, options.positions, closing_map.fixed)
    steps = ClosingSteps(closing_map, options.by, options.weight, axes)
    return _result(closing_map, _search(steps, options), options.mean_curvature)


def check_closing(
    domain: Domain, conditions: Conditions, by: str, coplanar: Sequence[Sequence[Side]] = ()
) -> None:
    """Raise `ConditionError` where nothing is open, or nothing may change; nothing is solved for that."""
    check_conditions(conditions)
    if not conditions.vertices.size and by != "moduli":
        raise ConditionError("No normals are prescribed that could change; close by moduli.")
    if domain.euler_characteristic > 0 and not len(coplanar):
        raise ConditionError(NOTHING_OPEN)


@dataclass(frozen=True, eq=False)
class _Path:
    first: Place
    place: Place
    gaps: list[float]
    status: ClosingStatus
    rank: int | None


def _search(steps: ClosingSteps, options: PeriodOptions) -> _Path:
    initial, progress = options.initial, options.progress
    first = place = steps.start(None if initial is None else np.asarray(initial, dtype=np.float64))
    gaps: list[float] = []
    step = None
    while True:
        if place.gap <= options.tolerance:
            place = steps.refined(place)
        gaps.append(place.gap)
        goes_on = progress is None or progress(len(gaps) - 1, place.gap) is not False
        status = _ended(place, first, len(gaps) - 1, options, step)
        if status is None and not goes_on:
            status = ClosingStatus.CANCELLED
        if status is None:
            step = steps.step(place)
            status = _stuck(step)
        if status is not None or step is None or step.place is None:
            return _Path(first, place, gaps, status or ClosingStatus.STALLED, step.rank if step else None)
        place = step.place


def _ended(
    place: Place, first: Place, count: int, options: PeriodOptions, step: Step | None
) -> ClosingStatus | None:
    if not place.is_harmonic:
        return ClosingStatus.LOST
    if place.area < _COLLAPSED * first.area:
        return ClosingStatus.COLLAPSED
    if place.gap <= options.tolerance:
        return ClosingStatus.CLOSED
    if count < options.max_steps:
        return None
    return ClosingStatus.STEP_LIMIT if step is None or step.reaches else ClosingStatus.RANK_DEFICIENT


def _stuck(step: Step) -> ClosingStatus | None:
    if step.place is not None:
        return None
    if not step.reaches:
        return ClosingStatus.RANK_DEFICIENT
    return ClosingStatus.OUT_OF_RANGE if step.at_end else ClosingStatus.STALLED


def _result(closing_map: ClosingMap, path: _Path, mean_curvature: float) -> ClosingResult:
    place = path.place
    conditions = place.extension.given(place.rim)
    tolerance = np.inf if path.status is ClosingStatus.CLOSED else _OPEN
    surface = CmcSolver(place.domain).solve(
        conditions,
        initial=place.reached.N,
        method=closing_map.method,
        mean_curvature=mean_curvature,
        period_tolerance=tolerance,
    )
    return ClosingResult(
        surface=surface,
        domain=place.domain,
        conditions=conditions,
        moduli=place.q,
        names=closing_map.moduli.names,
        gaps=path.gaps,
        left=dict(zip(closing_map.closing.names, (place.lengths / place.size).tolist(), strict=True)),
        rank=path.rank,
        turned=2.0 * np.arcsin(np.minimum(0.5 * np.linalg.norm(place.rim - closing_map.first, axis=1), 1.0)),
        status=path.status,
        area_ratio=place.area / path.first.area,
    )
