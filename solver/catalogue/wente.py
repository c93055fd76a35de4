"""Wente's cylinders and tori: a quarter on which the map is a minimiser, closed over its height.

The normals are constant on the two ends of a cylinder, and N goes the long way from one to the other (paper, Sec.
5.3.3, Figures 13 and 15). On the whole cylinder that map is a saddle. It is mirror-symmetric about two lines along it
and even about two others, and on the quarter between two of these, π/2 wide, it is a minimiser. It is also
mirror-symmetric about the line half-way between the ends, so that half of the quarter suffices.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..closing.close import ClosingResult, close_periods
from ..closing.moduli import tube
from ..domain.domain import Domain
from ..errors import ConditionError, Progress, Status
from ..gauss import conditions as ways
from ..gauss.boundary_data import Conditions
from ..gauss.modes import flat_axis
from ..gauss.sphere import exp
from ..limits import POSITIVE, Range, check_number
from ..linalg import as_numbers
from ..signatures import checked
from ..surface.cmc_surface import CmcSurface
from ..surface.solve import CmcSolver
from ..symmetry.sides import Side
from . import shapes
from .wente_heights import check_angle, discrete_height, needed_columns

Array = NDArray[np.float64]

FIRST, AXIS = np.array([1.0, 0.0, 0.0]), np.array([0.0, 0.0, 1.0])
# Largest denominator of a part of a half turn, and how near an angle must be to count as that part.
_MOST_PARTS, _EXACT = 100, 1e-9
_COLUMNS = Range(4, 1000, whole=True)


@dataclass(frozen=True, eq=False)
class Bubble:
    """A quarter of a Wente cylinder, or half of one.

    angle: between the normals of its two ends, radians. domain: a rectangle of near-equilateral triangles, positions
    (V, 2) in [0, π/2] × [0, height]. sides: "left", a mirror with normal (0, 0, 1), along which N goes the long way;
    "right", free; "bottom" and "top", tangent with the normals of the ends, as `complete` takes them. In half a
    quarter, [0, π/2] × [0, height/2], the top is a mirror. closing: how the height was found; None if it was given.
    cylinders: the number that makes a torus 2π × cylinders · height; None if it never ends. covers: how often that
    torus covers the surface, twice if it is the same at (x + π, y + cylinders/2 · height). So do the copies of a
    quarter; those of half a quarter cover it once.

    Four quarters are a cylinder. If the surface is not closed they are a strip instead, one bubble after the other in
    the direction (0, 0, 1).
    """

    angle: float
    domain: Domain
    positions: Array
    conditions: Conditions
    sides: list[Side]
    surface: CmcSurface
    height: float
    closing: ClosingResult | None
    cylinders: int | None
    covers: int

    def __repr__(self) -> str:
        state = "collapsed" if self.collapsed else "closed" if self.closed else "open"
        return f"Bubble({np.degrees(self.angle):.5g}° between the ends, height {self.height:.6g}, {state})"

    @property
    def ok(self) -> bool:
        """Whether the map converged and did not collapse, and the height closes the cylinder unless it was given."""
        closes = self.closing is None or self.closing.closed
        return closes and not self.collapsed and self.surface.harmonic.status is Status.CONVERGED

    @property
    def closed(self) -> bool:
        return self.closing is not None and self.closing.closed

    @property
    def collapsed(self) -> bool:
        """Whether N lies in the plane of the end normals: the other solution, a piece of a straight line."""
        return flat_axis(self.surface.normals) is not None

    @property
    def message(self) -> str:
        """The result in a sentence, and the way out if it is no bubble."""
        if self.collapsed or (self.closing is not None and not self.closing.closed):
            failure = "The normals collapsed into one plane" if self.collapsed else "The cylinder does not close"
            return (
                f"{failure}: the mesh is too coarse for a bubble, or the height too far from the one that closes. "
                f"Ends {np.degrees(self.angle):.5g}° apart need about {needed_columns(self.angle)} columns or more."
            )
        if not self.closed:
            return f"A piece of a cylinder of height {self.height:.6g}, as given; it need not close."
        ending = "never ends" if self.cylinders is None else f"closes after {self.cylinders} cylinders"
        twice = ", which cover it twice" if self.covers == 2 else ""
        return f"A piece of a cylinder that closes at the height {self.height:.6g}; the torus {ending}{twice}."


@checked
def wente(
    angle: float,
    columns: int,
    *,
    height: float | None = None,
    closed: bool = True,
    halved: bool = False,
    mean_curvature: float = 0.5,
    tolerance: float = 1e-10,
    progress: Progress | None = None,
) -> Bubble:
    """A quarter of the Wente cylinder whose ends have normals (1, 0, 0) and, `angle` from it, (cos, sin, 0).

    angle: radians, more than 0 and less than π. columns: of the quarter, which is π/2 wide; small angles need more of
    them (`wente_heights.needed_columns`). height: of the flat cylinder of circumference 2π; by default about the one
    that closes. closed: find that height, by Newton's method from the one given, until the gap is below the `tolerance`
    as a part of the size; else the height stays as given. halved: only the lower half of the quarter, whose copies
    never lie on each other. progress: as in `close_periods`.

    A map that collapses, or a height that is not found, is no error: see `ok`, `collapsed`, `closed` and `message`; the
    surface is then that of the given height. Raises `ConditionError` on other angles and numbers out of range.
    """
    check_angle(angle)
    check_number(columns, "number of columns of a quarter", _COLUMNS)
    if height is not None:
        check_number(height, "height of the cylinder", POSITIVE)
    first = discrete_height(angle, columns) if height is None else float(height)
    shape = shapes.strip(0.5 * np.pi, 0.5 * first if halved else first, columns)
    held, sides = _held(shape, float(angle), halved)
    domain, positions = shape.domain, shape.positions
    start = wente_start(positions, angle, first) if halved else None  # its corner normals do not determine the long way
    closing = _closed(shape, held, sides, start, mean_curvature, tolerance, progress) if closed else None
    if closing is not None and closing.closed:
        stretch = float(np.exp(closing.moduli[0]))
        domain, positions, first, surface = closing.domain, positions * [1.0, stretch], first * stretch, closing.surface
    else:
        solver = CmcSolver(domain)
        watch = progress if closing is None else None
        surface = solver.solve(held, start, mean_curvature=mean_curvature, progress=watch)
    count, covers = cylinder_count(angle), cover_count(angle)
    return Bubble(float(angle), domain, positions, held, sides, surface, first, closing, count, covers)


@checked
def wente_start(points: ArrayLike, angle: float, height: float, push: float = 1.5) -> Array:
    """N (V, 3) of a start on the whole cylinder, of unrolled points (x, y) in [0, 2π) × [0, height].

    The long arc, pushed off its plane by `push` radians times sin(π y / height) sin x. From it `saddle` finds the map
    of index 1 on meshes without its symmetries; a push of 0.6 is too little.
    """
    check_angle(angle)
    flat = as_numbers(points, "Points of a cylinder", ConditionError)
    if flat.ndim != 2 or flat.shape[1] < 2:
        raise ConditionError(f"Points of a cylinder must have shape (V, 2), not {flat.shape}.")
    x, y = flat[:, :2].T
    turn = (angle - 2.0 * np.pi) * y / height
    arc = np.column_stack([np.cos(turn), np.sin(turn), np.zeros_like(turn)])
    return exp(arc, np.outer(push * np.sin(np.pi * y / height) * np.sin(x), AXIS))


def cylinder_count(angle: float) -> int | None:
    """Cylinders in a torus: twice the denominator of angle / π, since each turns the next by 2 angle, mirrored.

    None if angle / π is no fraction with a denominator up to 100.
    """
    part = Fraction(float(angle) / np.pi).limit_denominator(_MOST_PARTS)
    return 2 * part.denominator if abs(float(part) - angle / np.pi) <= _EXACT else None


def cover_count(angle: float) -> int:
    """How often these cylinders cover the surface: 2 if half of them, an odd number, turn by whole turns."""
    count = cylinder_count(angle)
    if count is None or count % 4 != 2:
        return 1
    turns = 0.5 * count * angle / (2.0 * np.pi)
    return 2 if abs(turns - round(turns)) <= count * _EXACT else 1


def _held(shape: shapes.Shape, angle: float, halved: bool) -> tuple[Conditions, list[Side]]:
    domain, sides = shape.domain, shape.sides
    far = np.array([np.cos(angle), np.sin(angle), 0.0])
    kind = "mirror" if halved else "tangent"
    top = (FIRST - far) / np.linalg.norm(FIRST - far) if halved else far  # in the plane between the two, N is reflected
    held = ways.fixed(domain, sides["bottom"], FIRST)
    held += (ways.mirror if halved else ways.fixed)(domain, sides["top"], top)
    held += ways.mirror(domain, sides["left"], AXIS, winding=0 if halved else 1)
    return held, [
        Side("left", sides["left"], "mirror", AXIS),
        Side("right", sides["right"], "free"),
        Side("bottom", sides["bottom"], "tangent", FIRST),
        Side("top", sides["top"], kind, top),
    ]


def _closed(
    shape: shapes.Shape,
    held: Conditions,
    sides: list[Side],
    start: Array | None,
    H: float,
    tolerance: float,
    progress: Progress | None,
) -> ClosingResult:
    """The cylinder closes when the mirror's plane contains the point in which the free side inverts."""
    domain = shape.domain
    every = np.arange(len(domain.faces))
    height = tube(domain, shape.positions[domain.faces], every, (0, 1), "height")
    return close_periods(
        domain,
        held,
        by="moduli",
        moduli=height,
        coplanar=[sides[:2]],
        initial=start,
        mean_curvature=H,
        tolerance=tolerance,
        progress=progress,
    )
