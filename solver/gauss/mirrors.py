"""Mirrors: boundary edges along which the surface meets a plane at right angles, N · ν = 0 (paper, Sec. 5.1.1).

A boundary vertex between two mirrors has N = ±ν₁ × ν₂. The constraint leaves the sign open; the start decides it. Over
a plan N points to the plan's upper side. Without a plan, plane normals that point out of the surface decide: on f+,
whose outward conormal along a mirror is then ν, the tangent along the boundary is N × ν, so that N is ν₁ × ν₂ where f+
turns left from the first mirror to the second.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ..domain.domain import Domain
from ..errors import ConditionError, plural
from ..linalg import sum_rows
from .boundary_data import Conditions
from .frames import of_boundary
from .sphere import dot, normalize

Array = NDArray[np.float64]
Int = NDArray[np.integer]

# Planes with a smaller angle between them, in radians, count as one.
_PARALLEL = 1e-6
# Corners up to this much more than straight count as such: they turn left.
_STRAIGHT = 1e-6
# Square of the cosine between a prescribed normal and ν below which the normal blends with its reflection.
_REFLECTED = 0.5
# A normal is on one side of a plan when its cosine with "up" is at least this; else it lies in the plan.
_UPRIGHT = 0.05
# A vector whose cosine with a corner normal is smaller does not decide its sign.
_UNDECIDED = 1e-3


@dataclass(frozen=True, eq=False)
class Mirrors:
    """Sorted sites (m,) held in a plane, and the unit normals ν (m, 3) of their planes."""

    sites: Int
    normals: Array

    @classmethod
    def none(cls) -> Mirrors:
        return cls(np.zeros(0, dtype=np.int64), np.zeros((0, 3)))

    def planes(self, count: int) -> Array:
        """(count, 3): ν at each site, zero at sites on no mirror."""
        planes = np.zeros((count, 3))
        planes[self.sites] = self.normals
        return planes

    def flatten(self, X: Array) -> Array:
        """X (S, 3) without its parts along ν; X itself if there are no mirrors."""
        if not len(self.sites):
            return X
        flat = X.copy()
        flat[self.sites] -= dot(flat[self.sites], self.normals) * self.normals
        return flat


@dataclass(frozen=True, eq=False)
class MirrorSides:
    """The mirrors along the boundary of a domain.

    planes: (E, 3) unit normals, zero on edges on no mirror. windings: (E,). corners (k,): vertices between two mirrors,
    their normals (k, 3), and whether the caller decided these (k,).
    """

    domain: Domain
    planes: Array
    windings: Int
    corners: Int
    corner_normals: Array
    decided: NDArray[np.bool_]

    @classmethod
    def of(cls, domain: Domain, conditions: Conditions, side: int = +1) -> MirrorSides:
        """The mirrors of the conditions; corner normals are on that side unless `conditions.corner` chose one.

        Edges along which a condition fixes the normals are on no mirror. Raises `ConditionError` on an edge with two
        mirrors, and on a chosen normal at a vertex that is not between two mirrors.
        """
        planes, windings = _on_edges(domain, conditions)
        corners, normals = _corners(domain, planes, conditions.vertices)
        decided = np.zeros(len(corners), dtype=bool)
        normals = on_side(normals, conditions.up, side)
        for vertex, wanted in zip(conditions.corners, conditions.corner_normals, strict=True):
            at = np.flatnonzero(corners == vertex)
            cosine = float(normals[at[0]] @ wanted) if at.size else 0.0
            if abs(cosine) < _UNDECIDED:
                raise ConditionError(
                    f"A normal is chosen at vertex {vertex}, where "
                    + ("it is orthogonal to the two that the mirrors leave." if at.size else "no two mirrors meet.")
                    + " Choose one at corners between two mirrors, along their intersection.",
                    vertices=[int(vertex)],
                )
            normals[at[0]] *= np.sign(cosine)
            decided[at[0]] = True
        return cls(domain, planes, windings, corners, normals, decided)

    @cached_property
    def edges(self) -> Int:
        """Sorted edges on mirrors."""
        return np.flatnonzero(self.planes.any(axis=1))

    def blended(self, vertices: Int, normals: Array) -> Array:
        """Normals (n, 3) that conditions prescribe at vertices, blended with their reflections where a mirror begins.

        Conditions know only the edges on this side of the mirror; the sum with the reflection lies in its plane. A
        normal nearer to ν than to the plane is kept as it is.
        """
        place = np.full(self.domain.vertex_count, -1)
        place[vertices] = np.arange(len(vertices))
        ends = place[self.domain.edges[self.edges].ravel()]
        planes = np.repeat(self.planes[self.edges], 2, axis=0)[ends >= 0]
        blended, at = normals.copy(), ends[ends >= 0]
        across = dot(blended[at], planes)
        meant = across[:, 0] ** 2 < _REFLECTED
        at = at[meant]
        blended[at] = normalize(blended[at] - across[meant] * planes[meant])
        return blended


def on_side(normals: Array, up: Array, side: int) -> Array:
    """Unit normals (n, 3) turned to the side ±1 of `up` (3,); those in its plane, or all if `up` is 0, times `side`."""
    height = normals @ up
    upright = np.abs(height) > _UPRIGHT * np.linalg.norm(up)
    return side * np.where(upright, np.sign(height), 1.0)[:, None] * normals


def parallel(first: Array, second: Array) -> NDArray[np.bool_]:
    """Whether unit vectors (n, 3) agree up to sign, (n,)."""
    return np.linalg.norm(np.cross(first, second), axis=-1) < _PARALLEL


def _on_edges(domain: Domain, conditions: Conditions) -> tuple[Array, Int]:
    edges, normals, windings = conditions.mirrors, conditions.mirror_normals, conditions.windings
    of_boundary(edges, np.where(domain.edge_faces[:, 1] < 0, 0, -1))  # refuses edges of another domain
    planes, turns = np.zeros((len(domain.edge_lengths), 3)), np.zeros(len(domain.edge_lengths), dtype=np.int64)
    planes[edges[::-1]] = normals[::-1]  # where an edge is given twice, the first one stays
    turns[edges[::-1]] = windings[::-1]
    bad = np.unique(edges[~parallel(planes[edges], normals)])
    if bad.size:
        raise ConditionError(
            f"Two mirrors with different planes hold {plural('edge', bad)}; take the edges out of one of them.",
            edges=bad,
        )
    planes[conditions.edges] = 0.0
    return planes, turns


def _corners(domain: Domain, planes: Array, taken: Int) -> tuple[Int, Array]:
    """Sorted vertices between mirrors in two planes, without those `taken`; ν₁ × ν₂ as on f+."""
    arriving, leaving = np.zeros((2, domain.vertex_count, 3))
    rim = domain.boundary_edges
    tail, head = domain.edges[rim].T
    arriving[head], leaving[tail] = planes[rim], planes[rim]
    is_corner = arriving.any(axis=1) & leaving.any(axis=1) & ~parallel(arriving, leaving)
    is_corner[taken] = False
    corners = np.flatnonzero(is_corner)
    angles = sum_rows(domain.faces.ravel(), domain.corner_angles.ravel(), domain.vertex_count)[corners]
    turn = np.where(angles <= np.pi + _STRAIGHT, 1.0, -1.0)[:, None]
    return corners, turn * normalize(np.cross(arriving[corners], leaving[corners]))
