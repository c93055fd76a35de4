"""Goals of a shell over an outline: curves, supports, bounds on the tilt, and the one number that chooses the shell."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import KW_ONLY, dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..domain.domain import Domain
from ..domain.shape import DomainLike, as_domain
from ..errors import ConditionError, Progress, check_choice
from ..gauss.boundary_data import Conditions, check_conditions
from ..gauss.frames import boundary_edges
from ..limits import COUNT, EXTREME, NUMBERS, POSITIVE, Range, check_number
from ..linalg import as_numbers
from ..notes import Sentence
from ..signatures import check_fields
from ..spanning.lines import boundary_lines
from ..surface.cmc_surface import SHEETS
from ..surface.solve import CmcSolver
from .curves import Curve
from .feasible import check_held
from .fit import Fit
from .side_residuals import SideResidual, side_residuals
from .sides import HELD, LEAN, LINE, MIRROR, Sides, opposite
from .supports import Supports
from .target import Shape, Target
from .targets import Anchors, Closed, Crown, RimOnCurve, SmoothRim, TiltBounds, Volume
from .wall_targets import ContactAngle, InPlane

Array = NDArray[np.float64]
Int = NDArray[np.integer]

# Part of the size by which the rim may stay off its curve, and anchors off their places, and still meet the goal.
_MET = 5e-3
# Part of the wanted height or volume by which it may be missed.
_HEIGHT_MET = 1e-4
# Part of the size by which a surface may fail to close around holes.
_CLOSED = 1e-3
# Radians by which tilts may lie outside their bounds, and the weight of the bounds.
_TILT_MET = 0.01
_TILT_WEIGHT = 0.1
_RISE = 0.5
# Weight of smooth boundary normals where none is given; beside given normals it decides how these blend into lines.
_SMOOTH, _SMOOTH_BLEND = 1e-7, 1e-8
# Length of the blend zones by the size, and the weight of the angles at which sides lean over their lines.
_BLEND, _BLENDS = 0.15, Range(0.0, 1.0)
_LEAN_WEIGHT = 0.1
# The way out where the rim stays off its curve.
_LESS = {"mean_curvature": "smaller mean curvature", "volume": "smaller volume"}
# Weight of the squared relative error of the height parameter against the squared distance of the rim by the size.
_HEIGHT_WEIGHT = 0.01
# Weight of the periods: more than all the rest, since nobody can build a shell that does not close.
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
class OutlineOptions:
    """The options of `fit_outline`, see there. Raises `ConditionError` on values without meaning."""

    curve: ArrayLike | Sequence[ArrayLike | None] | None = None
    _: KW_ONLY
    rise: float | None = None
    height: float | None = None
    volume: float | None = None
    mean_curvature: float | None = None
    free_heights: bool = False
    anchors: tuple[ArrayLike, ArrayLike, ArrayLike] | None = None
    on_curve: bool = True
    tilt: tuple[float, float] | None = None
    smooth: float | None = None
    held: Conditions | None = None
    free: ArrayLike = ()
    blend: float = _BLEND
    sheet: str = "f+"
    max_evaluations: int = 300
    initial: Fit | None = None
    solver: CmcSolver | None = None
    progress: Progress | None = None

    def __post_init__(self) -> None:
        if self.smooth is not None:
            check_number(self.smooth, "weight of smooth boundary normals")
        if self.held is not None:
            check_conditions(self.held)
        check_number(self.blend, "length of blend zones, as a part of the size,", _BLENDS)
        check_number(self.max_evaluations, "largest number of evaluations", COUNT)
        check_choice(self.sheet, SHEETS, "sheet")
        if self.tilt is not None:
            _check_bounds(self.tilt)
        if self.anchors is None and not self.on_curve:
            raise ConditionError("There is nothing to fit to: give anchors, or let the rim lie on the curve.")
        name, number = self.height_parameter
        is_free = name == "mean_curvature" and self.has_lines_only
        check_number(number, HEIGHT_PARAMETERS[name].label.lower(), NUMBERS if is_free else POSITIVE)
        check_fields(self)

    @property
    def has_lines_only(self) -> bool:
        """Whether lines and one number are all that is asked for, so that the span is the surface."""
        return self.may_be_spanned and self.tilt is None

    @property
    def may_be_spanned(self) -> bool:
        """Whether the span is the surface if it keeps the bounds on its tilt: with no normals given, no edge free."""
        given = self.held is not None and self.held.vertices.size
        plain = self.anchors is None and self.smooth in (None, _SMOOTH) and not np.size(self.free)
        return self.on_curve and plain and not given

    def curves(self, domain: Domain) -> ArrayLike | Sequence[ArrayLike | None] | None:
        """`curve`, or those that `held` has in the place of whole boundary loops."""
        if self.held is None or not self.held.curves:
            return self.curve
        if self.curve is not None:
            raise ConditionError("Curves are given twice; leave out `curve`, or those of the conditions.")
        given, loops = self.held.curves, domain.boundary_loop_edges
        return [next((points for edges, points in given if loop[0] in edges), None) for loop in loops]

    @property
    def height_parameter(self) -> tuple[str, float]:
        """The one of `HEIGHT_PARAMETERS` that is given, and its value; without any, a rise of ½."""
        given = {name: getattr(self, name) for name in HEIGHT_PARAMETERS if getattr(self, name) is not None}
        if len(given) > 1:
            raise ConditionError(f"Give one of {' and '.join(given)}, not both: one number chooses the surface.")
        return next(iter(given.items()), ("rise", _RISE))


@dataclass(frozen=True, eq=False)
class Goals:
    """The options of an outline fit over a plan, ready to become targets; heights are over `base`.

    sides: of the boundary. base: the mean height of the outer curve. curves: of each boundary loop; own: whether it is
    the loop itself, as drawn (V, 3). size: of the outer curve's bounding box. height_parameter: in `HEIGHT_PARAMETERS`,
    a rise as a height; number: the wanted height, volume or H.
    """

    options: OutlineOptions
    sides: Sides
    curves: Sequence[Curve]
    own: Sequence[bool]
    drawn: Array
    base: float
    size: float
    height_parameter: str
    number: float
    supports: Supports | None

    @classmethod
    def of(cls, domain: DomainLike, points: Array, options: OutlineOptions) -> Goals:
        """Over a plan with these points (V, 3). Raises `ConditionError` on goals that do not fit the plan."""
        free, domain = boundary_edges(domain, options.free), as_domain(domain)
        given = options.held or Conditions()
        given = opposite(given) if options.sheet == "f-" else given
        if len(domain.boundary_loops) == 0 or domain.genus:
            raise ConditionError("Fitting to an outline needs a plan: a mesh with a boundary and without handles.")
        lines, outer, own = boundary_lines(domain, points, options.curves(domain))
        line = lines[outer]
        base = float(np.sum(Curve(line, closed=True).shares * line[:, 2]))
        extent = np.ptp(line[:, :2], axis=0)
        size = float(np.linalg.norm(extent))
        sides = Sides.of(domain, points, given, free, size, options.blend)
        check_held(sides, -1.0 if options.sheet == "f-" else 1.0)
        if options.on_curve and not sides.has(LINE, LEAN):
            raise ConditionError("No side is left on its line; solve with these conditions, or take one out of them.")
        height_parameter, number = options.height_parameter
        if height_parameter == "rise":
            height_parameter, number = "height", number * 0.5 * float(extent.min())
        _check_size(height_parameter, float(number), size)
        curves = [Curve(each - [0.0, 0.0, base], closed=True) for each in lines]
        return cls(
            options=options,
            sides=sides,
            curves=curves,
            own=own,
            drawn=points - [0.0, 0.0, base],
            base=base,
            size=size,
            height_parameter=height_parameter,
            number=float(number),
            supports=Supports.of(domain, options.anchors, base, line, size),
        )

    @property
    def has_given_normals(self) -> bool:
        """Whether normals are given along some sides."""
        return self.sides.has(HELD)

    @property
    def has_given_sides(self) -> bool:
        """Whether some sides have given normals or lean over their lines, so that each side has a goal of its own."""
        return self.options.on_curve and self.sides.has(HELD, LEAN)

    def lines(self, points: Array) -> list[RimOnCurve]:
        """A target for each side on a line, or over one.

        points: (V, 3) of a surface near the wanted one; its ends of a side tell which piece of a curve the side is on.
        """
        found = []
        for side in self.sides.of_kind(LINE, LEAN):
            curve, ends = self.curves[side.loop], (self.drawn if self.own[side.loop] else points)[side.vertices]
            piece = curve if side.closed else curve.between(ends[0], ends[-1])
            found.append(RimOnCurve(piece, side.vertices, self.options.free_heights or side.kind == LEAN))
        return found

    def targets(self, strictness: float, points: Array) -> list[Target]:
        """strictness: a factor of the height parameter's weight; points: see `lines`."""
        smooth = self.options.smooth
        if smooth is None:
            smooth = _SMOOTH_BLEND if self.has_given_normals else _SMOOTH
        targets: list[Target] = [SmoothRim(weight=smooth)]
        if len(self.curves) > 1:
            targets.append(Closed(weight=_PERIOD_WEIGHT))
        if self.options.on_curve:
            targets += [*self.lines(points), *self.leans(), *self._mirrors()]
        if self.height_parameter == "height":
            targets.append(Crown(self.number, weight=strictness * _HEIGHT_WEIGHT))
        elif self.height_parameter == "volume":
            targets.append(Volume(self.number, weight=strictness * _HEIGHT_WEIGHT))
        if self.supports is not None:
            targets += self.supports.targets()
        if self.options.tilt is not None:
            targets.append(TiltBounds(*self.options.tilt, weight=_TILT_WEIGHT))
        return targets

    def _mirrors(self) -> list[InPlane]:
        """A target for each mirror at an end of a line: its plane goes through the middle of its drawn points."""
        ends = self.sides.junctions
        return [
            InPlane(side.vertices, self.drawn[side.vertices].mean(axis=0), side.normals[0])
            for side in self.sides.of_kind(MIRROR)
            if np.isin(side.vertices, ends).any()
        ]

    def leans(self) -> list[ContactAngle]:
        """A target for each side that leans over its line, far from its ends."""
        sign = -1.0 if self.options.sheet == "f-" else 1.0
        found = []
        for side in self.sides.of_kind(LEAN):
            far = self.sides.far(side)
            target = ContactAngle(side.vertices[far], side.normals[far], side.angle, sign, weight=_LEAN_WEIGHT)
            found.append(target)
        return found

    def residuals(self, fit: Fit) -> tuple[SideResidual, ...]:
        """How far each side of the fitted surface, in its place, is from what was asked of it."""
        surface = fit.surface
        if surface.is_open:  # vertices along the cut are there twice
            return ()
        N, points = surface.harmonic.normals, fit.points() - [0.0, 0.0, self.base]
        shape = Shape(surface.domain, surface.domain.boundary_vertices.astype(np.int64), points, N, self.size)
        return side_residuals(self.sides.all, self.lines(points), self.leans(), shape, self.drawn)

    def unmet(self, fit: Fit) -> list[str]:
        """A sentence for each goal that is not met: by how much, and the way out."""
        sentences = [text for side in fit.sides for text in side.unmet(self.size) if self.has_given_sides]
        far = {} if self.has_given_sides else {RimOnCurve.label: fit.distances.get(RimOnCurve.label, 0.0)}
        if (off := far.get(RimOnCurve.label, 0.0)) > _MET * self.size:
            less = _LESS.get(self.height_parameter, "flatter shell")
            text = (
                f"The rim stays up to {{}} off the curve; loosen the other goals (supports, tilts, smooth normals), or "
                f"choose a {less}."
            )
            sentences.append(Sentence(text, off))
        far = fit.distances
        for label, power in ((Crown.label, 1), (Volume.label, 3)):
            if (miss := far.get(label, 0.0)) > _HEIGHT_MET * self.number:
                text = f"The {label} is missed by {{}}; no surface with this rim reaches it."
                sentences.append(Sentence(text, miss, power=power))
        if (off := far.get(Closed.label, 0.0)) > _CLOSED * self.size:
            text = "A gap of {} is left around the holes; make the shell flatter, or its rims freer."
            sentences.append(Sentence(text, off))
        if (off := far.get(TiltBounds.label, 0.0)) > _TILT_MET:
            sentences.append(
                f"Tangent planes along the rim lie up to {np.degrees(off):.2g}° outside the bounds on their tilt; "
                "widen the bounds, or free the heights of the rim."
            )
        if (off := far.get(Anchors.label, 0.0)) > _MET * self.size:
            text = "An anchor is missed by {}; move it, give it more weight, or remove another one."
            sentences.append(Sentence(text, off))
        return sentences


def _check_bounds(tilt: tuple[float, float]) -> None:
    bounds = as_numbers(tilt, "The bounds on the tilt", ConditionError)
    if bounds.shape != (2,):
        raise ConditionError("The bounds on the tilt are two angles, the least and the most.")
    if not -0.5 * np.pi <= bounds[0] < bounds[1] <= 0.5 * np.pi:
        if np.abs(bounds).max() > np.pi:
            raise ConditionError(
                f"The tilts {bounds[0]:g} and {bounds[1]:g} are more than half a turn: angles are in radians. For "
                f"degrees write np.radians([{bounds[0]:g}, {bounds[1]:g}])."
            )
        least, most = np.degrees(bounds)
        raise ConditionError(f"Tilts lie between -90° and 90°, the least below the most, not {least:g}° and {most:g}°.")


def _check_size(height_parameter: str, number: float, size: float) -> None:
    """Raise `ConditionError` on a height, volume or H that no shell over an outline of this size can have."""
    power = {"volume": 3, "mean_curvature": -1}.get(height_parameter, 1)
    least, most = sorted(size**power * EXTREME**end for end in (power, -power))
    if number and not least <= abs(number) <= most:
        label = HEIGHT_PARAMETERS[height_parameter].label.lower()
        raise ConditionError(
            f"The {label} {number:.3g} does not go with an outline that measures {size:.3g}; choose one between "
            f"{least:.3g} and {most:.3g}."
        )
