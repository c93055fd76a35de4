"""Keeping a shell closed: the normals along its boundary, or the holes of its plan, change until no gap is left."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..closing.close import ClosingResult, close_periods
from ..closing.holes import MovingHoles
from ..domain.domain import Domain
from ..errors import JobError, Progress, Status
from ..measure.report import to_plain
from ..measure.summary import percent
from ..notes import Sentence
from ..surface.cmc_surface import CmcSurface
from ..surface.placement import plan_plane, rim_weights
from .closing_options import MOVING, ClosingOptions
from .gaps import hole_loops, relative_lengths
from .plan import COUNTED, Plan, Settings
from .plan_conditions import plan_conditions

Array = NDArray[np.float64]

_BY = {"normals": "normals", "tilts": "normals", "hole": "moduli", "both": "both"}

# Degrees below which a turn is rounding; digits of moduli to report.
_LEAST_TURN = 1e-6
_DIGITS = 7
# Cosine of the slope up to which a plan counts as level enough for its holes to move.
_LEVEL = 0.9


@dataclass(frozen=True, eq=False, repr=False)
class Closing:
    """How a shell was closed. plan: with other positions where its holes moved. moving: those holes, None where they
    stay. gap_before: the longest gap around a hole before, as a part of the size of f+, see `HoleGap`."""

    result: ClosingResult
    plan: Plan
    moving: MovingHoles | None
    gap_before: float

    @property
    def ok(self) -> bool:
        """Whether the shell closes."""
        return self.result.ok

    @cached_property
    def gap(self) -> float:
        """The longest gap that is left, as a part of the size of f+."""
        return float(relative_lengths(self.result.surface).max(initial=0.0))

    def __repr__(self) -> str:
        return f"Closing({self.result!r})"

    @property
    def moved(self) -> dict[str, float]:
        """The motions of the holes: lengths for x and y, degrees for a twist, a factor for the size."""
        if self.moving is None:
            return {}
        units = {"x": lambda q: q * self.moving.size, "y": lambda q: q * self.moving.size}  # type: ignore[union-attr]
        units |= {"twist": np.degrees, "size": np.exp}
        numbers = zip(self.result.names, np.round(self.result.moduli, _DIGITS).tolist(), strict=True)
        return {name: float(units[name.rpartition(" ")[2]](q)) for name, q in numbers}

    @property
    def message(self) -> str:
        """How closing ended, and the changes of the boundary."""
        closing, turned = self.result, np.degrees(self.result.turned)
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


def closed(
    plan: Plan, settings: Settings, surface: CmcSurface, options: ClosingOptions, progress: Progress | None = None
) -> Closing | None:
    """The surface nearest to `surface`, the one over this plan, that closes; None where that has no gap.

    A plan without prescribed normals, and whose holes stay, has nothing that could change: None too, the gap stays.
    progress(step, gap) is called at every step of Newton's method; False cancels. Raises `CmcError` as
    `check_closing`; not closing is a status.
    """
    conditions = plan_conditions(plan, settings, surface.domain)
    if surface.status is not Status.GAP or not (conditions.vertices.size or options.by in MOVING):
        return None
    moving = check_closing(plan, settings, surface.domain)
    result = close_periods(
        surface.domain,
        conditions,
        by=_BY[options.by],
        moduli=None if moving is None else moving.moduli(),
        weight=options.weight,
        positions=plan.positions if options.by == "tilts" else None,
        initial=surface.harmonic.normals,
        method="critical" if settings.method in COUNTED else "newton",
        max_steps=options.max_steps,
        progress=progress,
    )
    if moving is not None and result.moduli.any():
        plan = replace(plan, positions=moving.positions(result.moduli))
    return Closing(result, plan, moving, float(relative_lengths(surface).max(initial=0.0)))


def check_closing(plan: Plan, settings: Settings, domain: Domain) -> MovingHoles | None:
    """The holes that may move to close a plan; raises `CmcError` where its settings cannot close a shell."""
    options = settings.close
    if options is None or domain.euler_characteristic > 0:
        return None
    if settings.solver_choice != Settings().solver_choice:
        raise JobError(
            "Closing needs normals on vertices and the triangles of the plan; leave out other sites, energies and the "
            "Delaunay triangulation."
        )
    return _moving(plan, domain, options)


def closing_report(closing: Closing) -> dict[str, Any]:
    """How a shell was closed as plain data; angles in degrees."""
    result = closing.result
    turned = np.degrees(result.turned)
    return {
        "closed": result.closed,
        "status": result.status.value,
        "message": closing.message,
        "steps": len(result.gaps) - 1,
        "gap_before": closing.gap_before,
        "gap": closing.gap,
        "left": to_plain(result.left),
        "largest_turn": float(turned.max(initial=0.0)),
        "rms_turn": float(np.sqrt(np.mean(turned**2))) if turned.size else 0.0,
        "moved": to_plain(closing.moved),
        "area_ratio": float(result.area_ratio),
    }


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
