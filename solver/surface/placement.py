"""Size and place a surface over its plan.

The Gauss map determines neither size nor place. Both are chosen here: one positive scale and one translation, a mirror
image in the plan's plane if the shell is flipped, and a turn about the plan's normal only on request, since a turn
moves the planes that the boundary conditions prescribe.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial import KDTree
from scipy.spatial.distance import pdist

from ..domain.domain import Domain
from ..errors import CmcError, check_choice
from ..gauss.sphere import tangent_axes
from ..limits import EXTREME, NUMBERS, POSITIVE, Range, check_number

Array = NDArray[np.float64]

SIZES = {
    "match_plan": "Match Plan",
    "span": "Span",
    "height": "Height",
    "radius": "Radius",
    "mean_curvature": "Mean Curvature",
    "rise": "Rise",
    "volume": "Volume",
}
FREE_SIZES = ("match_plan", "span", "height", "rise", "radius", "mean_curvature")
"""Of shells that find their rim by themselves."""
SPANNED_SIZES = ("match_plan", "rise", "height", "volume", "mean_curvature")
"""Of shells on lines."""
RISES = Range(-2.0, 2.0)
"""Parts of half the outline's smaller extent; a length is a height."""
# Height of shells without a size, by the radius of the largest circle in the plan.
_USUAL = 0.35
GROUNDS = {"lowest": "Lowest Point", "rim": "Rim"}

_UP = np.array([0.0, 0.0, 1.0])
# Cosine above which a plan is horizontal; single precision leaves a slope of about 1e-7 in a level plan.
_LEVEL = 1.0 - 1e-11
# A boundary less like the drawn one than this is matched in size only.
ALIKE = 0.25
# An extent below this fraction of 1/H is none: a point, or a flat rim without rise.
_NO_EXTENT = 1e-9
# All pairs of up to this many rim points are compared for the largest distance; with more points, this many
# directions are.
_SPAN_POINTS = 2000


class PlacementError(CmcError):
    """The surface cannot be sized or placed by that rule."""


@dataclass(frozen=True)
class Rule:
    """How a surface is sized and placed.

    size: one of `SIZES`; `value` is the span, the height, the radius 1/H (lengths), H (1/length), the rise as a part of
        half the outline's smaller extent, or the volume, unused by match_plan. Shells on lines may hang, with negative
        numbers.
    ground: "lowest" puts the lowest point of the surface on the plan's plane, "rim" the mean height of its
        boundary; both hold after a flip as well.
    rotate: allow the turn about the plan's normal that brings the boundary nearest to the drawn one.
    flip: take the mirror image in the plan's plane, upside down.
    """

    size: str = "match_plan"
    value: float = 1.0
    ground: str = "lowest"
    rotate: bool = False
    flip: bool = False

    def __post_init__(self) -> None:
        check_choice(self.size, SIZES, "size", PlacementError)
        check_choice(self.ground, GROUNDS, "ground", PlacementError)
        if self.size != "match_plan":
            check_number(self.value, SIZES[self.size].lower(), size_range(self.size), PlacementError)


def usual_height(positions: ArrayLike, rim: ArrayLike) -> float:
    """The height of shells on level lines without a size: a part of the radius of the largest circle in the plan.

    positions (V, 2|3) of the plan, rim (b, 2|3) of its boundary, seen from above.
    """
    points, line = (np.asarray(given, dtype=np.float64)[:, :2] for given in (positions, rim))
    return _USUAL * float(KDTree(line).query(points)[0].max())


def size_range(size: str) -> Range:
    """The numbers that a size of `SIZES` may have; those of shells on lines are negative where they hang."""
    if size == "rise":
        return RISES
    return NUMBERS if size in SPANNED_SIZES else POSITIVE


def check_size(rule: Rule, known: Sequence[str], where: str) -> None:
    """Raise `PlacementError` on a size that is not `known` where the rim of the shell is."""
    if rule.size not in known:
        names = ", ".join(known[1:])
        raise PlacementError(f'A shell with its rim {where} is not sized by "{rule.size}"; choose {names}, or none.')


@dataclass(frozen=True, eq=False)
class Plane:
    """The plan's plane: `origin` (3,) and unit `normal` (3,), which points up unless the plane is vertical."""

    origin: Array
    normal: Array

    def heights(self, points: ArrayLike) -> Array:
        """Signed distances (n,) of points (n, 3) from the plane."""
        return (np.asarray(points, dtype=np.float64) - self.origin) @ self.normal

    @property
    def mirror(self) -> Array:
        """(3, 3) reflection of directions, I - 2 n nᵀ."""
        return np.eye(3) - 2.0 * np.outer(self.normal, self.normal)


@dataclass(frozen=True, eq=False)
class Similarity:
    """x ↦ scale · linear x + translation.

    linear (3, 3) is orthogonal; the image is a mirror image where its determinant is -1.
    likeness: cosine of the boundary and the drawn one, as vectors of all points from their centres: 1 where they
        are similar, 0 where the best scale is 0, negative where it is negative.
    """

    scale: float = 1.0
    linear: Array = field(default_factory=lambda: np.eye(3))
    translation: Array = field(default_factory=lambda: np.zeros(3))
    likeness: float = 1.0

    @property
    def mirrored(self) -> bool:
        return bool(np.linalg.det(self.linear) < 0)

    def points(self, points: ArrayLike) -> Array:
        return self.scale * (np.asarray(points, dtype=np.float64) @ self.linear.T) + self.translation

    def directions(self, directions: ArrayLike) -> Array:
        """Unit directions stay unit directions; normals go with the surface they belong to."""
        return np.asarray(directions, dtype=np.float64) @ self.linear.T


def plan_plane(positions: ArrayLike, faces: ArrayLike, rim: ArrayLike, weights: ArrayLike) -> Plane:
    """The plane in which the outline encloses the largest area, through the outline's centre.

    Its normal is the area vector ½ ∮ x × dx of the boundary, which equals the sum of the faces' area vectors, or the
    vertical if that vanishes (an open tube). A flat plan lies in its plane; a level one gives exactly e_z. positions
    (V, 3), faces (F, 3), rim (b,) boundary vertices and their weights (b,).
    """
    points = np.asarray(positions, dtype=np.float64)
    a, b, c = (points[np.asarray(faces)[:, k]] for k in range(3))
    areas = 0.5 * np.cross(b - a, c - a)
    vector, area = areas.sum(axis=0), np.linalg.norm(areas, axis=1).sum()
    length = np.linalg.norm(vector)
    normal = vector / length if length > 1e-9 * area else _UP
    if normal[2] < -1e-6:
        normal = -normal
    if normal[2] > _LEVEL:
        normal = _UP
    return Plane(_mean(points[np.asarray(rim)], weights), normal)


def plan_frame(positions: ArrayLike, domain: Domain, ground: str) -> tuple[NDArray[np.int32], Array, Plane]:
    """The rim's vertices (b,), their weights (b,), and the plan's plane, by which a shell is placed.

    A closed plan has no rim: all its vertices take that part, weighted by their areas in the domain; its plane is
    horizontal, through its lowest point if the ground is "lowest", else through its centre.
    """
    points = np.asarray(positions, dtype=np.float64)
    if len(domain.boundary_edges):
        vertices, weights = rim_weights(points, domain.edges[domain.boundary_edges])
        return vertices, weights, plan_plane(points, domain.faces, vertices, weights)
    centre = _mean(points, domain.vertex_areas)
    if ground == "lowest":
        centre[2] = points[:, 2].min()
    return np.arange(len(points), dtype=np.int32), domain.vertex_areas, Plane(centre, _UP)


def rim_weights(positions: ArrayLike, edges: ArrayLike) -> tuple[NDArray[np.int32], Array]:
    """Boundary vertices (b,), sorted, and half the length of the boundary edges at each (trapezoidal ∮).

    positions (V, 3), edges (K, 2) vertex pairs of the boundary.
    """
    points, pairs = np.asarray(positions, dtype=np.float64), np.asarray(edges)
    lengths = np.linalg.norm(points[pairs[:, 1]] - points[pairs[:, 0]], axis=1)
    sums = np.bincount(pairs.ravel(), np.repeat(0.5 * lengths, 2), len(points)).astype(np.float64)
    vertices = np.unique(pairs).astype(np.int32)
    return vertices, sums[vertices]


def procrustes(
    points: ArrayLike, targets: ArrayLike, weights: ArrayLike, axis: ArrayLike | None = None
) -> tuple[float, Array, Array]:
    """Scale s, rotation R (3, 3) about `axis` and translation t that minimise Σ w_i |s R p_i + t - q_i|².

    With p̃, q̃ taken from the weighted means, R turns about the unit axis n by the angle θ = atan2(b, a)
    where a = Σ w (p̃·q̃ - (n·p̃)(n·q̃)), b = Σ w n·(p̃ × q̃); then s = Σ w (R p̃)·q̃ / Σ w |p̃|² and t = q̄ -
    s R p̄ (weighted Procrustes, closed form). Without an axis R is the identity. s can be zero or negative, where the
    points run against their targets; it is nan if all points coincide. points, targets (n, 3), weights (n,).
    """
    p, q = np.asarray(points, dtype=np.float64), np.asarray(targets, dtype=np.float64)
    w = np.asarray(weights, dtype=np.float64)
    p_mean, q_mean = _mean(p, w), _mean(q, w)
    cross = np.einsum("n,ni,nj->ij", w, p - p_mean, q - q_mean)
    spread = float(np.einsum("n,ni,ni->", w, p - p_mean, p - p_mean))
    rotation = np.eye(3) if axis is None else _turn(cross, np.asarray(axis, dtype=np.float64))
    scale = float(np.einsum("ij,ji->", rotation, cross)) / spread if spread > 0 else float("nan")
    return scale, rotation, q_mean - scale * rotation @ p_mean


def _turn(cross: Array, n: Array) -> Array:
    """Rotation about n that maximises tr(R cross), cross = Σ w p̃ q̃ᵀ."""
    a = np.trace(cross) - n @ cross @ n
    b = n @ np.array([cross[1, 2] - cross[2, 1], cross[2, 0] - cross[0, 2], cross[0, 1] - cross[1, 0]])
    theta = np.arctan2(b, a)
    skew = np.array([[0.0, -n[2], n[1]], [n[2], 0.0, -n[0]], [-n[1], n[0], 0.0]])
    return np.cos(theta) * np.eye(3) + np.sin(theta) * skew + (1.0 - np.cos(theta)) * np.outer(n, n)


def place(
    points: ArrayLike,
    rim: ArrayLike,
    drawn: ArrayLike,
    weights: ArrayLike,
    plane: Plane,
    rule: Rule,
    *,
    mean_curvature: float = 0.5,
    name: str = "The surface",
    alike: float = ALIKE,
) -> Similarity:
    """The similarity that sizes and places a sheet by a `rule`.

    points (n, 3): the sheet, of mean curvature H = `mean_curvature`; a scale s makes it H/s.
    rim (b,): the indices of `points` on its boundary; drawn (b, 3): where each of them was drawn; weights (b,).
    Sizes: match_plan by `procrustes` of the rim; span, the largest distance of two rim points seen along the plane's
    normal; height, the extent of all points along it; rise, the same as a part of half the smaller extent of the drawn
    rim; radius and mean_curvature through H. The weighted centres of rim and drawing coincide, except along the normal,
    where the ground rule decides. A boundary that does not follow the drawn one (`likeness` below `alike`: the best
    scale would be nearly zero, or negative) is matched in size only, by the mean square distance from its centre.
    Raises `PlacementError` if the sheet has no such extent.
    """
    linear = plane.mirror if rule.flip else np.eye(3)
    turned = np.asarray(points, dtype=np.float64) @ linear.T
    edge = turned[np.asarray(rim)]
    best, rotation, _ = procrustes(edge, drawn, weights, plane.normal if rule.rotate else None)
    sizes = _radius(edge, weights), _radius(drawn, weights)
    if not sizes[0] > _NO_EXTENT / mean_curvature:
        raise PlacementError(f"{name} shrinks to a point on its boundary, so it cannot be placed over the plan.")
    likeness = best * sizes[0] / sizes[1]
    if rule.size == "match_plan":
        scale = best if likeness >= alike else sizes[1] / sizes[0]
    else:
        check_number(rule.value, SIZES[rule.size].lower(), POSITIVE, PlacementError)
        scale = _scale(rule, turned, edge, np.asarray(drawn), plane, mean_curvature, name)
        _check_scale(scale * sizes[0] / sizes[1], rule)
    linear = rotation @ linear
    centre, target = _mean(edge, weights), _mean(drawn, weights)
    translation = target - scale * rotation @ centre
    heights = plane.heights(scale * (turned if rule.ground == "lowest" else edge) @ rotation.T + translation)
    base = heights.min() if rule.ground == "lowest" else float(_mean(heights, weights))
    return Similarity(scale, linear, translation - base * plane.normal, likeness)


def _radius(points: ArrayLike, weights: ArrayLike) -> float:
    """Root of the weighted mean square distance from the weighted mean."""
    p = np.asarray(points, dtype=np.float64)
    offsets = p - _mean(p, weights)
    return float(np.sqrt(_mean(np.einsum("ni,ni->n", offsets, offsets), weights)))


def _mean(values: ArrayLike, weights: ArrayLike) -> Array:
    return np.average(np.asarray(values, dtype=np.float64), axis=0, weights=np.asarray(weights, dtype=np.float64))


def _scale(rule: Rule, points: Array, edge: Array, drawn: Array, plane: Plane, H: float, name: str) -> float:
    if rule.size == "radius":
        return H * rule.value
    if rule.size == "mean_curvature":
        return H / rule.value
    extent = span(edge, plane.normal) if rule.size == "span" else float(np.ptp(points @ plane.normal))
    if not extent > _NO_EXTENT / H:
        raise PlacementError(f"{name} has no {rule.size}, so it cannot be sized by it; choose another size.")
    value = rule.value
    if rule.size == "rise":
        value *= 0.5 * float(np.ptp(drawn @ tangent_axes(plane.normal[None])[0].T, axis=0).min())
    return value / extent


def _check_scale(ratio: float, rule: Rule) -> None:
    if not EXTREME < ratio < 1.0 / EXTREME:
        raise PlacementError(
            f"With the {SIZES[rule.size].lower()} {rule.value:.3g} the shell is {ratio:.1g} times as large as its "
            "plan; choose another size."
        )


def span(points: ArrayLike, normal: ArrayLike) -> float:
    """The largest distance of two points (n, 3), seen along the unit `normal`.

    Exact up to 2000 points; with more, the largest width in 2000 directions, too small by less than a millionth.
    """
    p, n = np.asarray(points, dtype=np.float64), np.asarray(normal, dtype=np.float64)
    flat = p @ tangent_axes(n[None])[0].T
    if len(flat) < 2:
        return 0.0
    if len(flat) <= _SPAN_POINTS:
        return float(pdist(flat).max())
    # The width of a set in the direction of its diameter is the diameter, and in one at an angle of δ at
    # least cos δ of it.
    angles = np.arange(_SPAN_POINTS) * np.pi / _SPAN_POINTS
    return max(float(np.ptp(flat @ direction)) for direction in np.column_stack([np.cos(angles), np.sin(angles)]))
