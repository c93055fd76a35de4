"""A mesh of polygons on a surface, and what it takes to bring other data of the domain to it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..domain.domain import Domain

Array = NDArray[np.float64]
Faces = NDArray[np.int32]


@dataclass(frozen=True, eq=False)
class PolygonMesh:
    """vertices (n, 3); polygons, index arrays counter-clockwise; source (n,), the vertex of the domain of each row.

    normals: (n, 3) unit N, the same on f+ and f-.
    triangles (n,), barycentric (n, 3): the face of the domain that each row lies in, and where in it (possibly outside,
    as the circumcentre of an obtuse triangle does); anchors (n, 3): the vertices of that face.
    """

    vertices: Array
    polygons: list[NDArray[np.int32]]
    source: NDArray[np.int32]
    normals: Array
    triangles: NDArray[np.int32]
    barycentric: Array
    anchors: NDArray[np.int32]

    @classmethod
    def of_triangles(
        cls, vertices: Array, faces: Faces, source: Faces, normals: Array, domain: Domain, rows: Faces
    ) -> PolygonMesh:
        """Triangles `faces` (., 3) on rows that are vertices `source` (n,) of the domain.

        rows: (F, 3) the row of each corner of the domain; a row that is at no corner lies at any one of its vertex.
        """
        every = np.arange(rows.size)
        of_vertex = np.empty(domain.vertex_count, dtype=np.int64)
        of_vertex[domain.faces.ravel()] = every
        corners = of_vertex[source]
        corners[rows.ravel()] = every
        return cls(
            vertices=vertices,
            polygons=list(faces),
            source=source,
            normals=normals,
            triangles=(corners // 3).astype(np.int32),
            barycentric=np.eye(3)[corners % 3],
            anchors=domain.faces[corners // 3],
        )

    def interpolate(self, values: Array) -> Array:
        """Values (n, k) at the rows, linear in each triangle, of `values` (V, k) at the vertices of the domain."""
        return np.einsum("nc,nck->nk", self.barycentric, np.asarray(values)[self.anchors])

    def interpolate_corners(self, values: Array) -> Array:
        """Values (n, k) at the rows of `values` (F, 3, k) at the corners of the domain's faces, which may jump."""
        return np.einsum("nc,nck->nk", self.barycentric, np.asarray(values)[self.triangles])
