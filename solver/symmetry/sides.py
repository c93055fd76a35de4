"""Sides of a surface that lie in planes, and the isometry of space by which the surface continues across each.

For `N∘σ = Q N` with σ the reflection of the domain across a side, `dg = N × *dN` gives `g∘σ = -det(Q) Q g + v`, so
that f± = g ± N continue by a reflection R = -det(Q) Q (paper, Theorem G.1 and its appendix):

mirror, N·ν = 0: reflection in the plane g·ν = d; f+ stays f+.
tangent, N = a: reflection in the plane g·a = d, which is that of g, not of f±; f+ continues as f-.
free, ∂N/∂ν = 0: g is one point c, R = -1 is the inversion in it, and f+ continues as f-; both touch the sphere about c.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..domain.shape import is_names
from ..errors import CmcError, ConditionError, check_choice
from ..gauss.frames import boundary_edges
from ..linalg import as_numbers
from ..signatures import checked
from ..surface.cmc_surface import CmcSurface, SurfaceLike, as_surface

Array = NDArray[np.float64]
Int = NDArray[np.integer]

# Root mean square by which normals may miss the condition of a side: the sine of six degrees.
_MISSED = 0.1
# Second singular value of the normals along a mirror, as a part of the first, below which they define no plane.
_STRAIGHT = 0.05
# A surface smaller than this part of 1/(2H) is a point; its shape is rounding.
_POINT = 1e-6


class SymmetryError(CmcError):
    """Sides that do not have the kind they are given, or contradict each other."""


@dataclass(frozen=True, eq=False)
class Side:
    """A part of the boundary across which the surface continues.

    edges: indices into `domain.edges`, or (K, 2) vertex pairs. kind: a name in `RULES`.
    normal: (3,) of the plane; by default taken from the normals of the surface. A free side has none.
    Raises `ConditionError` on names of sides in place of edges.
    """

    name: str
    edges: ArrayLike
    kind: str = "mirror"
    normal: ArrayLike | None = None

    def __post_init__(self) -> None:
        if is_names(self.edges):
            raise ConditionError(
                f"Side {self.name!r}: edges are indices or vertex pairs, not {self.edges!r}; "
                f"write shape.sides[{str(np.ravel(self.edges)[0])!r}]."
            )

    def __repr__(self) -> str:
        normal = "" if self.normal is None else ", normal ({:.4g}, {:.4g}, {:.4g})".format(*np.ravel(self.normal)[:3])
        return f"Side({self.name!r}, {self.kind}, {len(np.asarray(self.edges))} edges{normal})"


@dataclass(frozen=True, eq=False)
class Rule:
    """How a surface continues across a kind of side.

    plane_normal: from the normals N (n, 3) along the side and their weights (n,). missed: (n,) how far N is from the
    condition of the side, as a sine. switches: whether f+ continues as f-.
    """

    label: str
    description: str
    switches: bool
    plane_normal: Callable[[Array, Array], Array | None]
    missed: Callable[[Array, Array], Array] | None = None


def _common_normal(N: Array, weights: Array) -> Array | None:
    """The direction orthogonal to all of N; None if they are (almost) the same and define none."""
    _, s, axes = np.linalg.svd(np.sqrt(weights)[:, None] * N, full_matrices=False)
    return axes[2] if len(s) == 3 and s[1] > _STRAIGHT * s[0] else None


def _mean_normal(N: Array, weights: Array) -> Array | None:
    mean = weights @ N
    length = float(np.linalg.norm(mean))
    return mean / length if length > 0.5 * weights.sum() else None


RULES: dict[str, Rule] = {
    "mirror": Rule(
        "Mirror",
        "The surface meets a plane at right angles and is reflected in it",
        False,
        _common_normal,
        lambda N, normal: N @ normal,
    ),
    "tangent": Rule(
        "Tangent plane",
        "The surface touches a plane; its parallel surface continues, reflected",
        True,
        _mean_normal,
        lambda N, normal: np.linalg.norm(N - normal, axis=1),
    ),
    "free": Rule(
        "Free",
        "The surface touches a sphere; its parallel surface continues, inverted in the centre",
        True,
        lambda N, weights: None,
    ),
}


@dataclass(frozen=True, eq=False)
class SidePlane:
    """Where a side lies, in the units of the surface.

    normal: (3,) unit ν or a, None for a free side. offset: d, the mean of g·normal; for a free side nan.
    point: (3,) a point of the plane, or the point c that g is along a free side.
    error: the largest distance of g from the plane, or from c. relative: as a part of the size of the surface.
    missed: the root mean square of N·ν or |N - a| without the ends, where other conditions hold; 0 for a free side.
    cut_vertices: (n,) of the surface along the side; weights: (n,) their shares of its length in the domain, sum one.

    Along a mirror f± lie in the same plane; along a tangent side in the planes offset ± scale; f± of a free side on
    the sphere of radius scale about the point.
    """

    name: str
    kind: str
    normal: Array | None
    offset: float
    point: Array
    error: float
    relative: float
    missed: float
    cut_vertices: Int
    weights: Array

    @property
    def switches(self) -> bool:
        return RULES[self.kind].switches

    def __repr__(self) -> str:
        return f"SidePlane({self})"

    def __str__(self) -> str:
        x, y, z = self.point if self.normal is None else self.normal
        where = f"about ({x:.4g}, {y:.4g}, {z:.4g})"
        if self.normal is not None:
            where = f"in the plane ({x:.4g}, {y:.4g}, {z:.4g}) · x = {self.offset:.6g}"
        return (
            f"Side {self.name!r} ({self.kind}) lies {where}, within {self.error:.2g} ({self.relative:.1e} of the size)."
        )


@checked
def side_plane(surface: SurfaceLike, side: Side) -> SidePlane:
    """The plane in which a side of a solved surface lies, and how far the side is from it.

    Raises `ConditionError` on edges that are not on the boundary, `SymmetryError` where the normals along the side
    contradict its kind (the given normal is wrong, or the condition was not imposed) or define no plane, and on
    surfaces that have collapsed to a point.
    """
    surface = as_surface(surface)
    check_choice(side.kind, RULES, "kind of side")
    rule = RULES[side.kind]
    edges = boundary_edges(surface.domain, side.edges)
    if edges.size == 0:
        raise SymmetryError(f"Side {side.name!r} has no edges.")
    vertices, weights = side_cut_vertices(surface, edges)
    N, g = surface.normals[vertices], surface.g[vertices]
    normal = _normal(side, rule, N, weights)
    missed = _missed(side, rule, N, np.where(_is_end(surface, edges, vertices), 0.0, weights), normal)
    centre = weights @ g
    size = surface_size(surface)
    if size <= _POINT * surface.scale < np.inf:  # infinite where H = 0
        raise SymmetryError(
            "The surface is a point, since its normals are the same everywhere; prescribe normals that differ, or "
            "start from an initial map."
        )
    if normal is None:
        error = float(np.linalg.norm(g - centre, axis=1).max())
        return SidePlane(side.name, side.kind, None, np.nan, centre, error, error / size, missed, vertices, weights)
    offset = float(centre @ normal)
    error = float(np.abs(g @ normal - offset).max())
    return SidePlane(side.name, side.kind, normal, offset, centre, error, error / size, missed, vertices, weights)


def surface_size(surface: CmcSurface) -> float:
    """Diagonal of the bounding box of the larger of f±."""
    return max(float(np.linalg.norm(np.ptp(points, axis=0))) for points in (surface.f_plus, surface.f_minus))


def side_cut_vertices(surface: CmcSurface, edges: Int) -> tuple[Int, Array]:
    """Cut vertices (n,) of the surface along boundary edges (K,), sorted, and their shares (n,) of the length."""
    ends = edge_cut_vertices(surface, edges)
    lengths = surface.domain.edge_lengths[edges]
    shares = np.bincount(ends.ravel(), np.repeat(0.5 * lengths, 2))
    vertices = np.unique(ends)
    return vertices, shares[vertices] / lengths.sum()


def edge_cut_vertices(surface: CmcSurface, edges: Int) -> Int:
    """Cut vertices (K, 2) at the ends of edges, those of the face on the left, in its direction."""
    face, corner = np.divmod(surface.domain.half_edges[edges, 0], 3)
    return np.stack([surface.faces[face, (corner + 1) % 3], surface.faces[face, (corner + 2) % 3]], axis=1)


def _is_end(surface: CmcSurface, edges: Int, cut_vertices: Int) -> NDArray[np.bool_]:
    """Which of the cut vertices of a side (sorted) are on only one of its edges."""
    ends = edge_cut_vertices(surface, edges)
    return np.bincount(ends.ravel())[cut_vertices] < 2


def _normal(side: Side, rule: Rule, N: Array, weights: Array) -> Array | None:
    if side.kind == "free":
        return None
    if side.normal is None:
        normal = rule.plane_normal(N, weights)
        if normal is None:
            raise SymmetryError(
                f"The normals along side {side.name!r} do not define the plane of a {side.kind} side; give its normal."
            )
        return normal
    normal = as_numbers(side.normal, f"The normal of side {side.name!r}", SymmetryError)
    length = float(np.linalg.norm(normal)) if normal.shape == (3,) else np.nan
    if not (np.isfinite(length) and length > 1e-9):
        raise SymmetryError(f"The normal of side {side.name!r} must be three numbers, not all zero.")
    return normal / length


def _missed(side: Side, rule: Rule, N: Array, weights: Array, normal: Array | None) -> float:
    if rule.missed is None or normal is None:
        return 0.0
    missed = float(np.sqrt(weights @ rule.missed(N, normal) ** 2 / max(weights.sum(), 1e-300)))
    if missed > _MISSED:
        what = {"mirror": "orthogonal to its plane", "tangent": "tangent to its plane"}[side.kind]
        raise SymmetryError(
            f"The surface is not {what} along side {side.name!r}: the normals miss it by {missed:.2g} (root mean "
            "square); impose that condition when solving, or give the side its own normal or kind."
        )
    return missed
