"""Points and normals projected into the planes of mirrors, in which they lie up to discretisation.

An average or a fit on one side of a mirror ignores the other side, so only its part along the plane is right. Projected
into the plane, g is second order there as it is inside, and copies of the surface meet.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ..domain.domain import Domain
from ..gauss.sphere import dot, normalize
from ..linalg import sum_rows

Array = NDArray[np.float64]
Int = NDArray[np.integer]

# Planes through a vertex count as one below this ratio of the moments of their normals: an angle of about a degree.
_RANK = 1e-4


@dataclass(frozen=True, eq=False)
class VertexPlanes:
    """The planes at some vertices (n,): m pairs of a place among these vertices (m,) and a unit normal (m, 3).

    edges: (m,) the boundary edges of the planes, if they come from edges.
    """

    vertices: Int
    places: Int
    normals: Array
    edges: Int

    @classmethod
    def of(cls, domain: Domain, planes: Array) -> VertexPlanes:
        """The planes at the ends of boundary edges, from their normals `planes` (E, 3), zero on other edges."""
        edges = np.flatnonzero(planes.any(axis=1))
        vertices, places = np.unique(domain.edges[edges].ravel().astype(np.int64), return_inverse=True)
        return cls(vertices, places, np.repeat(planes[edges], 2, axis=0), np.repeat(edges, 2))

    def nearest(self, points: Array, offsets: Array) -> Array:
        """The nearest points (n, 3) to `points`, one for each vertex, with <p, normal> = offset (m,) for each plane."""
        missing = offsets - dot(points[self.places], self.normals)[:, 0]
        pull = sum_rows(self.places, missing[:, None] * self.normals, len(points))
        return points + np.einsum("nij,nj->ni", self._inverse, pull)

    def along(self, normals: Array) -> Array:
        """Unit normals (n, 3), one for each vertex, projected into the planes; unchanged if nothing would be left."""
        flat = self.nearest(normals, np.zeros(len(self.places)))
        return normalize(np.where(dot(flat, flat) > _RANK, flat, normals))

    @cached_property
    def _inverse(self) -> Array:
        outer = np.einsum("mi,mj->mij", self.normals, self.normals).reshape(-1, 9)
        moments = sum_rows(self.places, outer, len(self.vertices)).reshape(-1, 3, 3)
        return np.asarray(np.linalg.pinv(moments, rcond=_RANK, hermitian=True))
