"""The CMC surface whose rim lies on a given curve: the plan's outline, another closed curve, or some anchors.

Boundary normals are free, and so are the size and the place. Where the curve bounds a surface of constant mean
curvature at all, there is one for every rise from flat to about a half sphere; one number chooses among them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..domain.domain import Domain
from ..errors import ConditionError
from ..gauss.conditions import binormal
from ..gauss.frames import in_space
from ..linalg import as_numbers
from ..surface.solve import CmcSolver
from .curves import Curve
from .fit import Fit, FitStatus, Progress, Start, fit
from .target import Target
from .targets import Anchors, Closed, Crown, RimOnCurve, SmoothRim, TiltBounds, Volume

Array = NDArray[np.float64]
Int = NDArray[np.integer]

# Parts of the size by which the rim may stay off the curve, and anchors off their places, and still count as met.
_MET = 5e-3
# Part of the wanted height or volume by which it may be missed.
_KNOB_MET = 1e-4
# Part of the size by which a surface may fail to close around holes.
_CLOSED = 1e-3
_RISE = 0.5
# The relative error of the knob, squared, against the rim's distance as a part of the size, squared.
_KNOB_WEIGHT = 0.01
# Radians by which tilts may lie outside of their bounds, and how much they count.
_TILT_MET = 0.01
_TILT_WEIGHT = 0.1
# How much periods count: more than all the rest, since a shell that does not close cannot be built.
_PERIOD_WEIGHT = 10.0
# A fit goes in phases: the part of its evaluations, how much smoother the boundary normals are than in the end (rough
# ones early on lead to folded rims), how much more the knob counts, and the gain of a step that is worth another.
_PHASES = ((0.4, 3.0, 100.0, 1e-2), (0.6, 1.0, 1e4, 5e-4))
# One that goes on from another is smooth already; it first goes along with the knob, a quarter of the evaluations that
# it would take with a knob that counts most at once.
_ON = ((0.7, 1.0, 10.0, 5e-3), (0.3, 1.0, 1e4, 1e-3))
_STEEPEST = 0.95


@dataclass(frozen=True)
class Knob:
    """The one number that chooses among the surfaces with a given rim, as a user interface offers it."""

    label: str
    description: str


KNOBS = {
    "rise": Knob("Rise", "Height of the crown as a part of half the outline's smaller extent: 0 flat, 1 hemisphere"),
    "height": Knob("Height", "Height of the crown over the rim's mean height"),
    "volume": Knob("Volume", "Volume under the shell, over the rim's mean height"),
    "mean_curvature": Knob("Mean curvature", "H of the shell; 1/H is the radius of the sphere with that H"),
}


@dataclass(frozen=True, eq=False)
class Supports:
    """Vertices (k,) of the plan, the places (k, 3) where they shall be, and weights (k,)."""

    vertices: Int
    places: Array
    weights: Array


def fit_outline(
    domain: Domain,
    positions: ArrayLike,
    curve: ArrayLike | Sequence[ArrayLike] | None = None,
    *,
    rise: float | None = None,
    height: float | None = None,
    volume: float | None = None,
    mean_curvature: float | None = None,
    free_heights: bool = False,
    anchors: tuple[ArrayLike, ArrayLike, ArrayLike] | None = None,
    on_curve: bool = True,
    tilt: tuple[float, float] | None = None,
    smooth: float = 1e-7,
    sheet: str = "f+",
    max_evaluations: int = 150,
    initial: Fit | None = None,
    solver: CmcSolver | None = None,
    progress: Progress | None = None,
) -> Fit:
    """The surface over a plan whose rim lies on a closed curve (paper, Sec. 7: boundary control), heights upwards.

    positions: (V, 2|3) of the plan. curve: (m, 3) closed polyline, by default the plan's own boundary; on a plan with
    holes it is the outer one, or a list with one for each of `domain.boundary_loops`. Of rise,
    height, volume and mean_curvature at most one is given (see `KNOBS`); without any, the rise is 0.5. free_heights:
    only the outline seen from above counts. anchors: vertices (k,), places (k, 3) and weights (k,) of supports; with
    `on_curve` false they are all that counts. tilt: the least and the most tilt of the tangent planes along the rim,
    radians, 0 a vertical wall, ½ π flat. smooth: weight of ½ ∮ |dN₀|², which keeps the boundary normals from
    rattling. initial: an earlier fit of this plan to go on from.

    Around holes the surface shall close, too; as the plan has a conformal type of its own, its rims then come near to
    the curves but may not lie on them. A wish that no surface fulfils ends with the nearest one: `Fit.met` is false
    and the message says what to change. Raises `ConditionError` on wishes that contradict each other or make no sense.
    """
    points = in_space(domain, positions)
    _check(domain, tilt)
    wanted = _Wanted.of(domain, points, curve, rise, height, volume, mean_curvature)
    supports = _supports(domain, anchors)
    if supports is None and not on_curve:
        raise ConditionError("There is nothing to fit to: give anchors, or let the rim lie on the curve.")

    def run(start: Start, smoother: float, strictness: float, gain: float, evaluations: int) -> Fit:
        targets = wanted.targets(free_heights, on_curve, smoother * smooth, strictness)
        targets += _anchored(supports, wanted.base) if supports is not None else []
        targets += [TiltBounds(*tilt, weight=_TILT_WEIGHT)] if tilt is not None else []
        return fit(
            domain,
            targets,
            start,
            size=wanted.size,
            sheet=sheet,
            free_scale=mean_curvature is None,
            max_evaluations=evaluations,
            gain=gain,
            solver=solver,
            progress=progress,
        )

    solver = solver or CmcSolver(domain)
    phases = _PHASES if initial is None else _ON
    total = sum(share for share, *_ in phases)
    start = _start(solver, points, wanted) if initial is None else _continued(initial, wanted.base)
    history: list[float] = []
    for share, smoother, strictness, gain in phases:
        found = run(start, smoother, strictness, gain, max(1, round(share * max_evaluations / total)))
        history += found.history
        if found.status is FitStatus.CANCELLED:
            break
        start = _continued(found, 0.0)
    found = replace(found, history=history)
    found = replace(found, shift=found.shift + [0.0, 0.0, wanted.base])
    return replace(found, complaints=_complaints(found, wanted))


def _check(domain: Domain, tilt: tuple[float, float] | None) -> None:
    if len(domain.boundary_loops) == 0 or domain.genus:
        raise ConditionError("Fitting to an outline needs a plan: a mesh with a boundary and without handles.")
    if tilt is not None and not -0.5 * np.pi <= tilt[0] < tilt[1] <= 0.5 * np.pi:
        least, most = np.degrees(tilt)
        raise ConditionError(f"Tilts lie between -90° and 90°, the least below the most, not {least:g}° and {most:g}°.")


@dataclass(frozen=True, eq=False)
class _Wanted:
    """The curves, lowered so that the outer one's mean height `base` is zero, and the knob's height or volume or H.

    loops: vertices along each boundary loop, with its curve; outer: which of them is the outer one. size: of its
    bounding box; radius: of a circle with its area.
    """

    loops: Sequence[tuple[Int, Curve]]
    outer: Curve
    base: float
    size: float
    radius: float
    knob: str
    number: float

    @classmethod
    def of(
        cls,
        domain: Domain,
        points: Array,
        given: ArrayLike | Sequence[ArrayLike] | None,
        rise: float | None,
        height: float | None,
        volume: float | None,
        mean_curvature: float | None,
    ) -> _Wanted:
        lines, outer = _lines(domain, points, given)
        line = lines[outer]
        knobs = {"rise": rise, "height": height, "volume": volume, "mean_curvature": mean_curvature}
        chosen = {name: number for name, number in knobs.items() if number is not None}
        if len(chosen) > 1:
            raise ConditionError(f"Give one of {' and '.join(chosen)}, not both: one number chooses the surface.")
        knob, number = next(iter(chosen.items()), ("rise", _RISE))
        if not (np.isfinite(number) and number > 0.0):
            raise ConditionError(f"The {KNOBS[knob].label.lower()} must be a positive number, not {number}.")
        base = float(np.sum(Curve(line, closed=True).shares * line[:, 2]))
        curves = [Curve(each - [0.0, 0.0, base], closed=True) for each in lines]
        extent = np.ptp(line[:, :2], axis=0)
        if knob == "rise":
            number *= 0.5 * float(extent.min())
        loops = [(loop.astype(np.int64), curve) for loop, curve in zip(domain.boundary_loops, curves, strict=True)]
        radius = np.sqrt(abs(_area(line)) / np.pi)
        return cls(loops, curves[outer], base, float(np.linalg.norm(extent)), radius, knob, float(number))

    def targets(self, free_heights: bool, on_curve: bool, smooth: float, strictness: float) -> list[Target]:
        targets: list[Target] = [SmoothRim(weight=smooth)]
        if len(self.loops) > 1:
            targets.append(Closed(weight=_PERIOD_WEIGHT))
        if on_curve:
            targets += [RimOnCurve(curve, loop, free_heights) for loop, curve in self.loops]
        if self.knob in ("rise", "height"):
            targets.append(Crown(self.number, weight=strictness * _KNOB_WEIGHT))
        elif self.knob == "volume":
            targets.append(Volume(self.number, weight=strictness * _KNOB_WEIGHT))
        return targets

    def height_of(self, film: Array, areas: Array) -> float:
        """How high the film, of pressure one, has to be stretched for the knob."""
        if self.knob in ("rise", "height"):
            return self.number
        if self.knob == "mean_curvature":
            return 2.0 * self.number * float(film.max())
        return self.number * float(film.max() / np.sum(areas * film))


def _lines(domain: Domain, points: Array, given: ArrayLike | Sequence[ArrayLike] | None) -> tuple[list[Array], int]:
    """A closed line for each boundary loop, its own where none is given, and which of them is the outer one."""
    lines = [points[loop] for loop in domain.boundary_loops]
    outer = int(np.argmax([abs(_area(line)) for line in lines]))
    if given is None:
        return lines, outer
    if not isinstance(given, (list, tuple)) or np.ndim(given[0]) < 2:
        lines[outer] = _as_curve(given)  # pyright: ignore[reportArgumentType]
        return lines, outer
    if len(given) != len(lines):
        raise ConditionError(f"The plan has {len(lines)} boundary loops; {len(given)} curves cannot be theirs.")
    return [_as_curve(line) for line in given], outer


def _as_curve(given: ArrayLike) -> Array:
    line = as_numbers(given, "The points of the curve", ConditionError)
    if line.ndim != 2 or line.shape[1] not in (2, 3) or len(line) < 3 or not np.isfinite(line).all():
        raise ConditionError("The curve must be three or more points (m, 3) that are finite numbers, in order.")
    if line.shape[1] == 2:
        line = np.column_stack([line, np.zeros(len(line))])
    return line if _area(line) > 0 else line[::-1]


def _area(line: Array) -> float:
    """The area that a closed line encloses, seen from above."""
    x, y = line[:, 0], line[:, 1]
    return 0.5 * float(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)))


def _supports(domain: Domain, anchors: tuple[ArrayLike, ArrayLike, ArrayLike] | None) -> Supports | None:
    if anchors is None:
        return None
    vertices, places, weights = (np.asarray(part) for part in anchors)
    if vertices.ndim != 1 or places.shape != (len(vertices), 3) or weights.shape != vertices.shape:
        raise ConditionError("Anchors are vertices (k,), places (k, 3) and weights (k,).")
    bad = vertices[(vertices < 0) | (vertices >= domain.vertex_count)]
    if bad.size:
        raise ConditionError(f"There is no vertex {bad[0]} to anchor.", vertices=bad)
    return Supports(vertices.astype(np.int64), places.astype(np.float64), weights.astype(np.float64))


def _anchored(supports: Supports, base: float) -> list[Target]:
    places = supports.places - [0.0, 0.0, base]
    return [
        Anchors(supports.vertices[supports.weights == weight], places[supports.weights == weight], weight=float(weight))
        for weight in np.unique(supports.weights)
    ]


def _start(solver: CmcSolver, points: Array, wanted: _Wanted) -> Start:
    """The soap film under even pressure, linearised: Δu = -2H over the plan, zero on the rim, scaled to the knob.

    Where u has the slope 2 tan ½θ the shell's tangent plane leans by θ: exact over a circle.
    """
    domain = solver.domain
    dirichlet = solver.harmonic.dirichlet(domain.boundary_vertices.astype(np.int64))
    film = dirichlet.solve(domain.vertex_areas[:, None], np.zeros((len(domain.boundary_vertices), 1)))[:, 0]
    stretch = wanted.size / float(np.linalg.norm(np.ptp(points[:, :2], axis=0)))
    height = min(wanted.height_of(film * stretch**2, domain.vertex_areas * stretch**2), _STEEPEST * wanted.radius)
    slopes = _rim_slopes(domain, film) * height / (film.max() * stretch)
    conditions = binormal(domain, points, domain.boundary_edges, 0.5 * np.pi - 2.0 * np.arctan(0.5 * slopes))
    radius = 2.0 * film.max() * stretch**2 / height + 0.5 * height
    if wanted.knob == "mean_curvature":
        radius = 1.0 / wanted.number
    centre = np.average(wanted.outer.points, axis=0, weights=wanted.outer.shares)
    # the rim of f+ = g + N lies above the mean of g's boundary by the mean of N
    up = np.cos(2.0 * np.arctan(0.5 * slopes)).mean()
    return Start(conditions, 0.5 * radius, centre - [0.0, 0.0, 0.5 * radius * up])


def _rim_slopes(domain: Domain, film: Array) -> Array:
    """(B,) |∇u| in the faces behind the boundary edges: u is zero along them, so it is u at the tip over its height."""
    behind = domain.half_edges[domain.boundary_edges, 0]
    height = 2.0 * domain.face_areas[behind // 3] / domain.edge_lengths[domain.boundary_edges]
    return film[domain.faces.ravel()[behind]] / height


def _continued(earlier: Fit, base: float) -> Start:
    shift = earlier.shift - [0.0, 0.0, base]
    N = earlier.surface.harmonic.normals
    return Start(earlier.conditions, earlier.surface.scale, shift, N, earlier.response)


def _complaints(found: Fit, wanted: _Wanted) -> list[str]:
    """What is not met, and what to change, a sentence each."""
    sentences = []
    off = found.distances.get(RimOnCurve.label, 0.0)
    if off > _MET * wanted.size:
        sentences.append(
            f"The rim stays up to {off:.3g} off the curve ({100 * off / wanted.size:.1f} % of its size); round its "
            + {
                "mean_curvature": "corners, or ask for a smaller mean curvature.",
                "volume": "corners, or ask for less volume.",
            }.get(wanted.knob, "corners, or ask for a flatter shell.")
        )
    for label in (Crown.label, Volume.label):
        miss = found.distances.get(label, 0.0)
        if miss > _KNOB_MET * wanted.number:
            sentences.append(f"The {label} is missed by {miss:.3g}; it does not go together with the rim.")
    off = found.distances.get(Closed.label, 0.0)
    if off > _CLOSED * wanted.size:
        sentences.append(f"Around the holes a gap of {off:.3g} is left; make the shell flatter, or its rims freer.")
    off = found.distances.get(TiltBounds.label, 0.0)
    if off > _TILT_MET:
        sentences.append(
            f"Tangent planes along the rim lie up to {np.degrees(off):.2g}° outside of the bounds on their tilt; widen "
            "these, or free the heights of the rim."
        )
    off = found.distances.get(Anchors.label, 0.0)
    if off > _MET * wanted.size:
        sentences.append(f"An anchor is missed by {off:.3g}; move it, give it more weight, or take another away.")
    return sentences
