"""Wente's cylinders and tori: a quarter on which the map is a minimiser, closed over its height.

Constant normals on the two ends of a cylinder, N going the long way from one to the other (paper, Sec. 5.3.3, Figures
13 and 15). On the whole cylinder that map is a saddle. It is mirror-symmetric about two lines along it and even about
two others, and on the quarter between two of these, π/2 wide, it is a minimiser. It is mirror-symmetric about the line
half-way between the ends, too, so that half of the quarter says all.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..closing.close import ClosingResult, close_periods
from ..closing.moduli import tube
from ..domain.domain import Domain
from ..errors import ConditionError, Progress
from ..gauss import conditions as ways
from ..gauss.boundary_data import Conditions
from ..gauss.modes import flat_axis
from ..gauss.sphere import exp
from ..linalg import as_numbers, check_number
from ..surface.cmc_surface import CmcSurface
from ..surface.solve import CmcSolver
from ..symmetry.sides import Side
from . import shapes
from .wente_heights import check_angle, discrete_height, needed_columns

Array = NDArray[np.float64]

FIRST, AXIS = np.array([1.0, 0.0, 0.0]), np.array([0.0, 0.0, 1.0])
# Parts of a half turn with denominators up to this one, and how near to one an angle has to be, as such a part.
_MOST_PARTS, _EXACT = 100, 1e-9
_FEWEST = 4


@dataclass(frozen=True, eq=False)
class Bubble:
    """A quarter of a Wente cylinder, or half of one.

    angle: between the normals of its two ends, radians. domain: a rectangle of near-equilateral triangles, positions
    (V, 2) in [0, π/2] × [0, height]. sides: "left", a mirror with normal (0, 0, 1), along which N goes the long way;
    "right", free; "bottom" and "top", tangent with the normals of the ends: what `complete` needs. Of half a quarter,
    [0, π/2] × [0, height/2], the top is a mirror. closing: how the height was found, None where it was given.
    cylinders: how many make a torus 2π × cylinders · height; None where it never ends. covers: how often this one goes
    over the surface, twice where it is the same at (x + π, y + cylinders/2 · height). Copies of a quarter do so, too;
    those of half a quarter are there once.

    Four quarters are a cylinder. Where the surface is not closed they are a strip instead, one bubble after the other
    in the direction (0, 0, 1).
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

    @property
    def closed(self) -> bool:
        return self.closing is not None and self.closing.closed

    @property
    def collapsed(self) -> bool:
        """Whether N came to lie in the plane of the end normals: the other solution, a piece of a straight line."""
        return flat_axis(self.surface.normals) is not None

    @property
    def message(self) -> str:
        """What was found, and what to do where it was not a bubble."""
        if self.collapsed or (self.closing is not None and not self.closing.closed):
            found = "The normals collapsed into one plane" if self.collapsed else "The cylinder does not close"
            return (
                f"{found}: the mesh is too coarse for a bubble, or the height too far from the one that closes. "
                f"Ends {np.degrees(self.angle):.5g}° apart need about {needed_columns(self.angle)} columns or more."
            )
        if not self.closed:
            return f"A piece of a cylinder of height {self.height:.6g}, as given; it need not close."
        ending = "never ends" if self.cylinders is None else f"closes after {self.cylinders} cylinders"
        twice = ", which go over it twice" if self.covers == 2 else ""
        return f"A piece of a cylinder that closes at the height {self.height:.6g}; the torus {ending}{twice}."


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
    that closes. closed: look for that height, by Newton's method from the one given, until the gap is below the
    `tolerance` as a part of the size; else the height is left as it is. halved: only the lower half of the quarter,
    whose copies never lie on each other. progress: as in `close_periods`.

    A map that collapses, or a height that is not found, is no error: see `collapsed`, `closed` and `message`; the
    surface is then that at the height given. Raises `ConditionError` on other angles and senseless numbers.
    """
    check_angle(angle)
    check_number(columns, "number of columns")
    if not (isinstance(columns, (int, np.integer)) and columns >= _FEWEST):
        raise ConditionError(f"A Wente cylinder needs {_FEWEST} columns a quarter or more, not {columns!r}.")
    if height is not None:
        check_number(height, "height of the cylinder", positive=True)
    first = discrete_height(angle, columns) if height is None else float(height)
    shape = shapes.strip(0.5 * np.pi, 0.5 * first if halved else first, columns)
    held, sides = _held(shape, float(angle), halved)
    domain, positions = shape.domain, shape.positions
    start = wente_start(positions, angle, first) if halved else None  # its corner normals do not say the long way
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


def wente_start(points: ArrayLike, angle: float, height: float, push: float = 1.5) -> Array:
    """N (V, 3) of a start on the whole cylinder, of unrolled points (x, y) in [0, 2π) × [0, height].

    The long arc, pushed off its plane by `push` radians times sin(π y / height) sin x. From there `saddle` finds the
    map of index 1 on meshes that have none of its symmetries; a push of 0.6 is too little.
    """
    check_angle(angle)
    x, y = as_numbers(points, "Points of a cylinder", ConditionError)[:, :2].T
    turn = (angle - 2.0 * np.pi) * y / height
    arc = np.column_stack([np.cos(turn), np.sin(turn), np.zeros_like(turn)])
    return exp(arc, np.outer(push * np.sin(np.pi * y / height) * np.sin(x), AXIS))


def cylinder_count(angle: float) -> int | None:
    """Cylinders of a torus: each but turns the next by 2 angle, mirrored, so twice the denominator of angle / π.

    None where the angle is no such part of a half turn with a denominator up to 100.
    """
    part = Fraction(float(angle) / np.pi).limit_denominator(_MOST_PARTS)
    return 2 * part.denominator if abs(float(part) - angle / np.pi) <= _EXACT else None


def cover_count(angle: float) -> int:
    """How often these cylinders go over the surface: 2 where half of them, an odd number, turn by whole turns."""
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
    """It closes where the mirror's plane goes through the point in which the free side inverts."""
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
