"""From a plan with holes to a shell that closes around them, placed and measured: `form` for closed shells."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..closing.close import ClosingResult, close_periods
from ..closing.holes import MOTIONS, MovingHoles
from ..domain.domain import Domain
from ..errors import ConditionError, JobError, Progress, check_choice
from ..limits import COUNT, POSITIVE, check_number
from ..measure.report import to_plain
from ..measure.summary import percent
from ..notes import Note, Sentence
from ..signatures import check_fields
from ..surface.cmc_surface import CmcSurface
from ..surface.placement import plan_plane, rim_weights
from ..surface.solve import CmcSolver
from .form import place_and_measure, solve_plan
from .gaps import hole_loops, relative_lengths
from .plan import Plan, Settings, plan_domain
from .plan_conditions import plan_conditions
from .shell import Shell

Array = NDArray[np.float64]

WAYS = {
    "normals": "the normals along the boundary change, as little as possible",
    "tilts": "the normals turn about the boundary only: the tilts change",
    "hole": "the holes move",
    "both": "normals and holes",
}
"""The parts of a plan that may change to close its shell."""
MOVING = ("hole", "both")

# Degrees below which a turn is rounding; digits of moduli to report.
_LEAST_TURN = 1e-6
_DIGITS = 7
# Cosine of the slope up to which a plan counts as level enough for its holes to move.
_LEVEL = 0.9


@dataclass(frozen=True, eq=False)
class ClosingOptions:
    """How to close the gaps around the holes of a plan.

    by: of `WAYS`. weight: with "both", of the motions of holes (see `close_periods`): the larger, the less they move.
    move: with "hole" and "both", of `holes.MOTIONS`, or a number of a hole → its own ones. holes: numbers of the moving
    ones, 1 has the longest rim; None: all, or those in `move`. max_steps: of Newton's method. Raises `JobError` on
    unknown ways and motions, and on numbers out of range.
    """

    by: str = "normals"
    weight: float = 1.0
    move: tuple[str, ...] | Mapping[int, tuple[str, ...]] = ("x", "y", "twist")
    holes: tuple[int, ...] | None = None
    max_steps: int = 12

    def __post_init__(self) -> None:
        check_choice(self.by, WAYS, "way to close", JobError)
        for name in self.motions:
            check_choice(name, MOTIONS, "motion of a hole", JobError)
        if isinstance(self.move, Mapping) and self.holes is not None:
            raise JobError("The motions of each hole name the holes already; leave the numbers of holes out.")
        if self.by in MOVING and not (self._each and all(self._each)):
            raise JobError(f"The holes need a motion: one or more of {', '.join(MOTIONS)}.")
        check_number(self.weight, "weight", POSITIVE, JobError)
        check_number(self.max_steps, "limit of steps", COUNT, JobError)
        check_fields(self)

    @property
    def motions(self) -> tuple[str, ...]:
        """The motions of any hole."""
        return tuple(name for names in self._each for name in names)

    @property
    def _each(self) -> list[tuple[str, ...]]:
        return list(self.move.values()) if isinstance(self.move, Mapping) else [self.move]


@dataclass(frozen=True, eq=False, repr=False)
class ClosedShell:
    """shell: the last one. plan: with other positions where its holes moved. moving: those holes, None where they
    stay. gap_before, gap: the longest gap around a hole as a part of the size of f+, see `HoleGap`."""

    shell: Shell
    plan: Plan
    closing: ClosingResult
    moving: MovingHoles | None
    gap_before: float

    @property
    def gap(self) -> float:
        return _longest_gap(self.shell.surface)

    @property
    def ok(self) -> bool:
        """Whether the shell closes."""
        return self.closing.ok and self.shell.ok

    def __repr__(self) -> str:
        return f"ClosedShell({self.shell!r}, {self.closing!r})"

    @property
    def moved(self) -> dict[str, float]:
        """The motions of the holes: lengths for x and y, degrees for a twist, a factor for the size."""
        if self.moving is None:
            return {}
        units = {"x": lambda q: q * self.moving.size, "y": lambda q: q * self.moving.size}  # type: ignore[union-attr]
        units |= {"twist": np.degrees, "size": np.exp}
        numbers = zip(self.closing.names, np.round(self.closing.moduli, _DIGITS).tolist(), strict=True)
        return {name: float(units[name.rpartition(" ")[2]](q)) for name, q in numbers}

    @property
    def message(self) -> str:
        """How closing ended, and the changes of the boundary."""
        closing, turned = self.closing, np.degrees(self.closing.turned)
        words = [closing.status.sentence, f"The gap was {percent(self.gap_before)} of the shell's size."]
        if not closing.closed:
            words[-1] = f"{words[-1][:-1]} and is {percent(self.gap)}."
        if turned.max(initial=0.0) > _LEAST_TURN:
            mean = np.sqrt(np.mean(turned**2))
            words.append(f"Normals along the boundary turned by {turned.max():.1f}° at most (RMS {mean:.1f}°).")
        kinds = {"twist": "{:+.2g}°", "size": "× {:.3g}"}
        motions, lengths = [], []
        for name, q in self.moved.items():
            form = kinds.get(name.rpartition(" ")[2])
            if q:
                motions.append(f"{name} {'{}' if form is None else form.format(q)}")
                lengths += [q] if form is None else []
        if motions:
            words.append(f"Holes moved: {', '.join(motions)}.")
        return Sentence(" ".join(words), *lengths)


def close_plan(
    plan: Plan,
    settings: Settings,
    options: ClosingOptions,
    *,
    solver: CmcSolver | None = None,
    start: CmcSurface | None = None,
    progress: Progress | None = None,
    intersections: bool = True,
) -> ClosedShell:
    """Change normals or holes until the shell over a plan closes, then place and measure it as `form` does.

    solver: one for the plan's domain. start: the surface of `solve_plan`, if it is known. progress(step, gap)
    is called at every step of Newton's method; False cancels. The groups of the plan stay as they are.
    Raises `CmcError` on plans without holes and on unusable input; not closing is a status: see `ok` and `message`.
    """
    _check_sites(settings)
    solver = solver or CmcSolver(plan_domain(plan))
    domain = solver.domain
    conditions = plan_conditions(plan, settings, domain)
    if conditions.is_spanned:
        raise ConditionError("A shell on lines closes around its holes by itself; form it without closing.")
    start = start or solve_plan(plan, settings, solver)
    moving = _moving(plan, domain, options)
    closing = close_periods(
        domain,
        conditions,
        by={"tilts": "normals", "hole": "moduli"}.get(options.by, options.by),
        moduli=None if moving is None else moving.moduli(),
        weight=options.weight,
        positions=plan.positions if options.by == "tilts" else None,
        initial=start.harmonic.normals,
        max_steps=options.max_steps,
        progress=progress,
    )
    if moving is not None and closing.moduli.any():
        plan, solver = replace(plan, positions=moving.positions(closing.moduli)), CmcSolver(closing.domain)
    shell = place_and_measure(plan, settings, closing.surface, solver, intersections=intersections)
    closed = ClosedShell(shell, plan, closing, moving, _longest_gap(start))
    return replace(closed, shell=_with_message(shell, closed))


def closing_report(closed: ClosedShell) -> dict[str, Any]:
    """The report on the closing as plain data; angles in degrees."""
    closing = closed.closing
    turned = np.degrees(closing.turned)
    return {
        "closed": closing.closed,
        "status": closing.status.value,
        "message": closed.message,
        "steps": len(closing.gaps) - 1,
        "gap_before": closed.gap_before,
        "gap": closed.gap,
        "left": to_plain(closing.left),
        "largest_turn": float(turned.max(initial=0.0)),
        "rms_turn": float(np.sqrt(np.mean(turned**2))) if turned.size else 0.0,
        "moved": to_plain(closed.moved),
        "area_ratio": float(closing.area_ratio),
    }


def _longest_gap(surface: CmcSurface) -> float:
    return float(relative_lengths(surface).max(initial=0.0))


def _check_sites(settings: Settings) -> None:
    if settings.solver_choice != Settings().solver_choice:
        raise JobError(
            "Closing needs normals on vertices and the triangles of the plan; leave out other sites, energies and the "
            "Delaunay triangulation."
        )


def _moving(plan: Plan, domain: Domain, options: ClosingOptions) -> MovingHoles | None:
    if options.by not in MOVING:
        return None
    if plan.lengths is not None:
        raise JobError("Holes move on the drawing, but this plan has its own edge lengths; close by the normals.")
    loops = hole_loops(domain)
    move = options.move
    numbers = tuple(move) if isinstance(move, Mapping) else options.holes or tuple(range(1, len(loops) + 1))
    wrong = [number for number in numbers if not 1 <= number <= len(loops)]
    if wrong or not loops:
        if not loops:
            raise JobError("The plan has no hole that could move.")
        raise JobError(f"The plan has {len(loops)} hole{'s' * (len(loops) != 1)}; there is no hole {wrong[0]}.")
    motions = [move[n] for n in numbers] if isinstance(move, Mapping) else [move] * len(numbers)
    vertices, weights = rim_weights(plan.positions, domain.edges[domain.boundary_edges])
    if abs(plan_plane(plan.positions, domain.faces, vertices, weights).normal[2]) < _LEVEL:
        raise JobError("Holes can only move horizontally, and this plan is too steep; close by the normals.")
    return MovingHoles(domain, plan.positions, [loops[n - 1] for n in numbers], motions, numbers)


def _with_message(shell: Shell, closed: ClosedShell) -> Shell:
    """The shell with the closing's message, which is also its first warning where it does not close."""
    if not closed.closing.closed:
        others = [note for note in shell.warnings if note != shell.report.sentence]
        return replace(shell, message=closed.message, warnings=[Note("gap", closed.message), *others])
    return replace(shell, message=closed.message) if shell.ok else shell
