"""What is wished for of a shell over an outline: curves, supports, bounds, and one number that chooses the shell."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..domain.domain import Domain
from ..errors import ConditionError
from ..linalg import as_numbers, check_number
from .curves import Curve
from .fit import Fit
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
# Radians by which tilts may lie outside of their bounds, and how much they count.
_TILT_MET = 0.01
_TILT_WEIGHT = 0.1
_RISE = 0.5
# What to ask for instead where the rim stays off its curve.
_LESS = {"mean_curvature": "smaller mean curvature", "volume": "smaller volume"}
# The relative error of the height_parameter, squared, against the rim's distance as a part of the size, squared.
_KNOB_WEIGHT = 0.01
# How much periods count: more than all the rest, since a shell that does not close cannot be built.
_PERIOD_WEIGHT = 10.0


@dataclass(frozen=True)
class HeightParameter:
    """The one number that chooses among the surfaces with a given rim, as a user interface offers it."""

    label: str
    description: str


HEIGHT_PARAMETERS = {
    "rise": HeightParameter(
        "Rise", "Height of the crown as a part of half the outline's smaller extent: 0 flat, 1 hemisphere"
    ),
    "height": HeightParameter("Height", "Height of the crown over the rim's mean height"),
    "volume": HeightParameter("Volume", "Volume under the shell, over the rim's mean height"),
    "mean_curvature": HeightParameter("Mean curvature", "H of the shell; 1/H is the radius of the sphere with that H"),
}


@dataclass(frozen=True, eq=False)
class Supports:
    """Vertices (k,) of the plan, the places (k, 3) where they shall be, and weights (k,)."""

    vertices: Int
    places: Array
    weights: Array


@dataclass(frozen=True, eq=False)
class Goals:
    """All heights are over the mean height `base` of the outer curve.

    loops: vertices along each boundary loop, with its curve; outer: which of the curves is the outer one. on_curve:
    whether the rim shall lie on them, free_heights: seen from above only. size: of the outer curve's bounding box;
    radius: of a circle with its area. height_parameter: in `HEIGHT_PARAMETERS`, number: the height, volume or H that is
    wanted. tilt: bounds.
    """

    loops: Sequence[tuple[Int, Curve]]
    outer: Curve
    on_curve: bool
    free_heights: bool
    base: float
    size: float
    radius: float
    height_parameter: str
    number: float
    supports: Supports | None
    tilt: tuple[float, float] | None

    @classmethod
    def of(
        cls,
        domain: Domain,
        points: Array,
        given: ArrayLike | Sequence[ArrayLike] | None,
        height_parameters: dict[str, float | None],
        *,
        on_curve: bool,
        free_heights: bool,
        anchors: tuple[ArrayLike, ArrayLike, ArrayLike] | None,
        tilt: tuple[float, float] | None,
    ) -> Goals:
        """See `fit_outline`, which has their names; height_parameters: by name, at most one of them a number."""
        _check(domain, tilt)
        lines, outer = _lines(domain, points, given)
        line = lines[outer]
        base = float(np.sum(Curve(line, closed=True).shares * line[:, 2]))
        supports = _supports(domain, anchors, base)
        if supports is None and not on_curve:
            raise ConditionError("There is nothing to fit to: give anchors, or let the rim lie on the curve.")
        extent = np.ptp(line[:, :2], axis=0)
        height_parameter, number = _chosen(height_parameters)
        if height_parameter == "rise":
            number *= 0.5 * float(extent.min())
        curves = [Curve(each - [0.0, 0.0, base], closed=True) for each in lines]
        loops = [(loop.astype(np.int64), curve) for loop, curve in zip(domain.boundary_loops, curves, strict=True)]
        size, radius = float(np.linalg.norm(extent)), float(np.sqrt(abs(_area(line)) / np.pi))
        outer_curve = curves[outer]
        return cls(
            loops, outer_curve, on_curve, free_heights, base, size, radius, height_parameter, number, supports, tilt
        )

    def targets(self, smooth: float, strictness: float) -> list[Target]:
        """smooth: weight of calm boundary normals; strictness: how much more than usual the height_parameter counts."""
        targets: list[Target] = [SmoothRim(weight=smooth)]
        if len(self.loops) > 1:
            targets.append(Closed(weight=_PERIOD_WEIGHT))
        if self.on_curve:
            targets += [RimOnCurve(curve, loop, self.free_heights) for loop, curve in self.loops]
        if self.height_parameter in ("rise", "height"):
            targets.append(Crown(self.number, weight=strictness * _KNOB_WEIGHT))
        elif self.height_parameter == "volume":
            targets.append(Volume(self.number, weight=strictness * _KNOB_WEIGHT))
        if self.supports is not None:
            targets += _anchored(self.supports)
        if self.tilt is not None:
            targets.append(TiltBounds(*self.tilt, weight=_TILT_WEIGHT))
        return targets

    def height_of(self, film: Array, areas: Array) -> float:
        """How high the film, of pressure one, has to be stretched for the height_parameter."""
        if self.height_parameter in ("rise", "height"):
            return self.number
        if self.height_parameter == "mean_curvature":
            return 2.0 * self.number * float(film.max())
        return self.number * float(film.max() / np.sum(areas * film))

    def scaled(self, factor: float) -> Goals:
        """For another number."""
        return replace(self, number=factor * self.number)

    def is_off(self, found: Fit) -> bool:
        """Whether the rim is off its curve."""
        return found.distances.get(RimOnCurve.label, 0.0) > _MET * self.size

    def unmet(self, found: Fit) -> list[str]:
        """What is not met, and what to change, a sentence each."""
        sentences = []
        far = found.distances
        if self.is_off(found):
            off = far[RimOnCurve.label]
            sentences.append(
                f"The rim stays up to {off:.3g} off the curve ({100 * off / self.size:.1f} % of its size); round its "
                f"corners, or ask for a {_LESS.get(self.height_parameter, 'flatter shell')}."
            )
        for label in (Crown.label, Volume.label):
            if (miss := far.get(label, 0.0)) > _KNOB_MET * self.number:
                sentences.append(f"The {label} is missed by {miss:.3g}; it does not go together with the rim.")
        if (off := far.get(Closed.label, 0.0)) > _CLOSED * self.size:
            sentences.append(f"Around the holes a gap of {off:.3g} is left; make the shell flatter, or its rims freer.")
        if (off := far.get(TiltBounds.label, 0.0)) > _TILT_MET:
            sentences.append(
                f"Tangent planes along the rim lie up to {np.degrees(off):.2g}° outside of the bounds on their tilt; "
                "widen these, or free the heights of the rim."
            )
        if (off := far.get(Anchors.label, 0.0)) > _MET * self.size:
            sentences.append(f"An anchor is missed by {off:.3g}; move it, give it more weight, or take another away.")
        return sentences


def _check(domain: Domain, tilt: tuple[float, float] | None) -> None:
    if len(domain.boundary_loops) == 0 or domain.genus:
        raise ConditionError("Fitting to an outline needs a plan: a mesh with a boundary and without handles.")
    if tilt is None:
        return
    bounds = as_numbers(tilt, "The bounds on the tilt", ConditionError)
    if bounds.shape != (2,):
        raise ConditionError("The bounds on the tilt are two angles, the least and the most.")
    if not -0.5 * np.pi <= bounds[0] < bounds[1] <= 0.5 * np.pi:
        least, most = np.degrees(bounds)
        raise ConditionError(f"Tilts lie between -90° and 90°, the least below the most, not {least:g}° and {most:g}°.")


def _chosen(height_parameters: dict[str, float | None]) -> tuple[str, float]:
    chosen = {name: number for name, number in height_parameters.items() if number is not None}
    if len(chosen) > 1:
        raise ConditionError(f"Give one of {' and '.join(chosen)}, not both: one number chooses the surface.")
    height_parameter, number = next(iter(chosen.items()), ("rise", _RISE))
    check_number(number, HEIGHT_PARAMETERS[height_parameter].label.lower(), positive=True)
    return height_parameter, float(number)


def _lines(domain: Domain, points: Array, given: ArrayLike | Sequence[ArrayLike] | None) -> tuple[list[Array], int]:
    """A closed line for each boundary loop, its own where none is given, and which of them is the outer one."""
    lines = [points[loop] for loop in domain.boundary_loops]
    outer = int(np.argmax([abs(_area(line)) for line in lines]))
    if given is None:
        return lines, outer
    if not isinstance(given, (list, tuple)) or not _are_lines(given):
        lines[outer] = _as_curve(given)  # pyright: ignore[reportArgumentType]
        return lines, outer
    if len(given) != len(lines):
        raise ConditionError(f"The plan has {len(lines)} boundary loops; {len(given)} curves cannot be theirs.")
    return [_as_curve(line) for line in given], outer


def _are_lines(given: Sequence[ArrayLike]) -> bool:
    """Whether these are lines, and not the points of one."""
    try:
        return len(given) > 0 and np.ndim(given[0]) >= 2
    except ValueError:  # the first one is ragged, so it is no point
        return True


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


def _supports(domain: Domain, anchors: tuple[ArrayLike, ArrayLike, ArrayLike] | None, base: float) -> Supports | None:
    if anchors is None:
        return None
    numbers = [as_numbers(part, "Vertices, places and weights of anchors", ConditionError) for part in anchors]
    if len(numbers) != 3:
        raise ConditionError("Anchors are vertices (k,), places (k, 3) and weights (k,).")
    vertices, places, weights = numbers
    if vertices.ndim != 1 or places.shape != (len(vertices), 3) or weights.shape != vertices.shape:
        raise ConditionError("Anchors are vertices (k,), places (k, 3) and weights (k,).")
    bad = vertices[~np.isin(vertices, np.arange(domain.vertex_count))]
    if bad.size:
        raise ConditionError(f"There is no vertex {bad[0]:g} to anchor.", vertices=bad)
    if not (np.isfinite(places).all() and np.isfinite(weights).all() and (weights > 0.0).all()):
        raise ConditionError("Places of anchors must be finite, and their weights positive.")
    return Supports(vertices.astype(np.int64), places.astype(np.float64) - [0.0, 0.0, base], weights.astype(np.float64))


def _anchored(supports: Supports) -> list[Target]:
    """One target for each weight."""
    groups = [(weight, supports.weights == weight) for weight in np.unique(supports.weights)]
    return [Anchors(supports.vertices[of], supports.places[of], weight=float(weight)) for weight, of in groups]
