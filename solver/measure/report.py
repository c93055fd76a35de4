"""The report of a solve: its numbers, for people and as JSON."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, fields, is_dataclass
from enum import Enum
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..errors import CmcError, MeshError, Status, check_choice, listed
from ..linalg import as_numbers
from ..notes import Sentence
from ..signatures import checked
from ..surface.cmc_surface import SHEETS, CmcSurface, SurfaceLike, as_surface
from .arrays import Array
from .planes import PlaneReport
from .sheet import SheetReport, measure_sheet
from .summary import count, measure_lines, number, off_by, percent, size_line

# Largest deviation of placed points from a similarity image of the sheet, as a fraction of its size; single
# precision far from the origin leaves about 1e-5.
_SIMILAR = 1e-3
# Curvature that varies by less is even "to 0.01 %".
_EVEN = 1e-4


@dataclass(frozen=True)
class Report:
    """A solve and its sheets in numbers. Lengths are those of the measured points, `scale` the factor to them.

    `energy` is the Dirichlet energy of the normals, `residual` as in docs/reference/conventions.md. `closure_error` and
    `gap` (the longest period) are lengths; `periods` has one vector for each hole or handle. `sheet` names the shown
    sheet; `planes` measures how well its sides lie in their planes, if any are prescribed. `index` and `nullity` count
    the unstable and the null modes of the map; None if they were not counted.
    """

    status: str
    converged: bool
    sentence: str
    energy: float
    degree: float
    residual: float
    iterations: int
    vertices: int
    faces: int
    mean_curvature: float
    scale: float
    closure_error: float
    is_open: bool
    periods: tuple[tuple[float, float, float], ...]
    gap: float
    sheet: str
    sheets: dict[str, SheetReport]
    planes: tuple[PlaneReport, ...] = ()
    index: int | None = None
    nullity: int | None = None

    def __repr__(self) -> str:
        measured = ", ".join(self.sheets)
        return f"Report({self.sheet}: {self.sentence!r}; H = {self.mean_curvature:.4g}, sheets {measured})"

    @property
    def ok(self) -> bool:
        """Whether the map converged and the surface closes around holes and handles."""
        return self.status == Status.CONVERGED.value

    @property
    def message(self) -> str:
        """The sentence."""
        return self.sentence

    @property
    def shown(self) -> SheetReport:
        """The measures of the sheet that is shown."""
        return self.sheets[self.sheet]

    def to_dict(self) -> dict[str, Any]:
        """Plain dictionaries, lists, numbers and strings; a number that is not finite is None."""
        return to_plain(self)

    def to_json(self, indent: int | None = 2) -> str:
        """Strict JSON: null for a number that is not finite."""
        return json.dumps(self.to_dict(), indent=indent, allow_nan=False, ensure_ascii=False)

    def summary(self, unit: str = "") -> str:
        """Six to nine lines for a person, and one for each plane; `unit` is the name of the length unit, as "m"."""
        steps, mesh = count(self.iterations, "iteration"), count(self.faces, "face")
        lines = [
            self.sentence,
            f"Energy {self.energy:.6g}, residual {self.residual:.1e} after {steps} on {mesh}.",
            self._map_line(),
            size_line(self.shown, unit),
        ]
        if self.periods:
            what = "the gap" if self.is_open else "which was projected out"
            lines.append(f"Longest period around a hole or handle {number(self.gap, unit)}, {what}.")
        lines += measure_lines(self.shown, unit)
        return "\n".join(lines + [plane.line(unit) for plane in self.planes])

    def _map_line(self) -> str:
        """Degree, and unstable modes where they were counted."""
        degree = f"Degree {round(self.degree, 6) + 0.0:.3g}"
        if self.index is None:
            return f"{degree}."
        null = f", and {count(self.nullity, 'null mode')}" if self.nullity else ""
        return f"{degree}, {count(self.index, 'unstable mode')}{null}."


@checked
def report(
    surface: SurfaceLike,
    outline: ArrayLike | Sequence[ArrayLike] | None = None,
    *,
    corners: ArrayLike = (),
    sheet: str = "f+",
    positions: ArrayLike | Mapping[str, ArrayLike] | None = None,
    intersections: bool | Callable[[], bool] = True,
    up: ArrayLike = (0.0, 0.0, 1.0),
) -> Report:
    """Measure a surface: its solve, and curvature, distortion, size, overhang and intersections of its sheets.

    sheet: "f+" or "f-", the one that is shown.
    corners: vertices of the domain where the rim has a corner, at which normals of the surface have no derivative; mean
        curvature is measured on the faces that are more than an edge away from them.
    outline: drawn positions (V, 2|3) of the domain's vertices, or a list of closed polylines, in the frame of the
        measured points; the distance of the shown sheet's boundary from it is reported. Two coordinates: the distance
        in plan.
    positions: (n, 3) placed points of the shown sheet, or a mapping from "f+", "f-" to such points; only these sheets
        are measured. They must be images of the surface's own points under one similarity (moved, turned, mirrored,
        scaled); normals and target curvature follow. Default: both sheets as they are.
    intersections: False leaves out self-intersections, the slowest part. A function is called now and then;
        `Interrupted` is raised when it returns False.
    up: the vertical (3,), for overhang, span and rise.

    Raises `MeshError` where arrays do not match the surface, `CmcError` on another sheet name.
    """
    check_choice(sheet, SHEETS, "report on a sheet", CmcError)
    surface = as_surface(surface)
    placed = _placed(surface, sheet, positions)
    scale, turn = _similarity(surface, placed, sheet)
    target = surface.mean_curvature / scale
    sheets = {
        name: measure_sheet(
            name,
            surface.domain,
            points,
            surface.faces,
            (1.0 if name == "f+" else -1.0) * np.asarray(surface.normals) @ turn,
            target,
            degenerate=surface.is_degenerate(name),
            corners=np.flatnonzero(np.isin(surface.source, np.asarray(corners, dtype=np.int64))),
            outline=outline if name == sheet else None,
            intersections=intersections,
            up=up,
        )
        for name, points in placed.items()
    }
    return _with_solve(surface, sheet, sheets, scale, turn)


def _placed(surface: CmcSurface, sheet: str, positions: ArrayLike | Mapping[str, ArrayLike] | None) -> dict[str, Array]:
    if positions is None:
        measured = SHEETS if surface.mean_curvature else (sheet,)  # a surface of H = 0 has no twin
        given: Mapping[str, ArrayLike] = {name: surface.sheet(name) for name in measured}
    elif isinstance(positions, Mapping):
        given = {name: positions[name] for name in SHEETS if name in positions}
    else:
        given = {sheet: positions}
    if sheet not in given:
        raise MeshError(f"The placed positions of {sheet} are missing; they are the sheet that is shown.")
    placed = {name: as_numbers(points, "Positions", MeshError) for name, points in given.items()}
    for name, points in placed.items():
        expected = np.shape(surface.sheet(name))
        if points.shape != expected:
            raise MeshError(f"The positions of {name} have shape {points.shape}, its points {expected}.")
        wrong = np.flatnonzero(~np.isfinite(points).all(axis=1))
        if len(wrong):
            raise MeshError(f"The positions of {name} at vertices {listed(wrong)} are not finite.", vertices=wrong)
    return placed


def _similarity(surface: CmcSurface, placed: dict[str, Array], sheet: str) -> tuple[float, Array]:
    """Scale s and orthogonal R (3, 3), mirrors included: placed = s · points @ R + shift (Procrustes)."""
    names = [sheet, *placed]
    name = next((name for name in names if not surface.is_degenerate(name)), None)
    if name is None or placed[name] is surface.sheet(name):
        return 1.0, np.eye(3)
    own, other = np.asarray(surface.sheet(name)), placed[name]
    own, other = own - own.mean(axis=0), other - other.mean(axis=0)
    left, s, right = np.linalg.svd(own.T @ other)
    turn, spread = left @ right, float(np.einsum("ij,ij->", own, own))
    scale = float(s.sum()) / spread if spread > 0 else 0.0
    if not scale > 0 or np.abs(other - scale * own @ turn).max() > _SIMILAR * np.abs(other).max():
        raise MeshError(f"The positions of {name} are not its points moved, turned, mirrored or scaled.")
    return scale, turn


def _with_solve(surface: CmcSurface, sheet: str, sheets: dict[str, SheetReport], scale: float, turn: Array) -> Report:
    harmonic = surface.harmonic
    periods = scale * np.asarray(surface.periods, dtype=np.float64).reshape(-1, 3) @ turn
    return Report(
        status=surface.status.value,
        converged=harmonic.status is Status.CONVERGED,
        sentence=_sentence(surface, sheets[sheet], scale),
        energy=float(harmonic.energy),
        degree=float(harmonic.degree),
        residual=float(harmonic.residual),
        iterations=int(harmonic.iterations),
        vertices=int(surface.domain.vertex_count),
        faces=len(surface.faces),
        mean_curvature=float(surface.mean_curvature / scale),
        scale=scale,
        closure_error=scale * surface.scale * float(surface.conjugate.closure_error),
        is_open=surface.is_open,
        periods=tuple((float(x), float(y), float(z)) for x, y, z in periods),
        gap=scale * surface.gap,
        sheet=sheet,
        sheets=sheets,
    )


def _sentence(surface: CmcSurface, shown: SheetReport, scale: float) -> str:
    """How even the curvature of the shown sheet is, where the map converged; and how long the gap is, at that scale."""
    H = shown.mean_curvature
    gap = f"{Status.GAP.sentence} The gap is {{}} long."
    if surface.harmonic.status is not Status.CONVERGED or H is None:
        words, even = surface.outcome, ""
    elif H.is_off:
        words, even = "", f"Curvature is off by {off_by(H)}."
    else:
        even = percent(max(H.relative_l2, _EVEN)) if H.reference == abs(H.target) else f"{H.l2:.2g}"
        away = " away from corners" if H.left_out else ""
        words, even = "Done.", f"Curvature is even to {even}{away}."
    if not surface.is_open:
        return f"{words} {even}".strip()
    return Sentence(f"{gap} {even}" if even else f"{words} {gap}", scale * surface.gap)


def to_plain(value: Any) -> Any:
    """Dataclasses, arrays, enums and numpy numbers as JSON values; nan and infinity become None."""
    if is_dataclass(value) and not isinstance(value, type):
        return {field.name: to_plain(getattr(value, field.name)) for field in fields(value)}
    if isinstance(value, Mapping):
        return {str(key): to_plain(item) for key, item in value.items()}
    if isinstance(value, np.ndarray):
        return to_plain(value.tolist())
    if isinstance(value, (list, tuple)):
        return [to_plain(item) for item in value]
    if isinstance(value, Enum):
        return to_plain(value.value)
    if isinstance(value, np.generic):
        return to_plain(value.item())
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value
