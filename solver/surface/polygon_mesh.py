"""A mesh of polygons on a surface, with the weights that carry other data of the domain to it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..domain.domain import Domain

Array = NDArray[np.float64]
Faces = NDArray[np.int32]


@dataclass(frozen=True, eq=False)
class PolygonMesh:
    """Vertices (n, 3) and polygons, index arrays counter-clockwise; source (n,), the domain's vertex for each vertex.

    normals: (n, 3) unit N, the same on f+ and f-.
    triangles (n,), barycentric (n, 3): the face of the domain in which each vertex lies, and where (possibly outside,
    like the circumcentre of an obtuse triangle); anchors (n, 3): the vertices of that face.
    """

    vertices: Array
    polygons: list[NDArray[np.int32]]
    source: NDArray[np.int32]
    normals: Array
    triangles: NDArray[np.int32]
    barycentric: Array
    anchors: NDArray[np.int32]

    def __repr__(self) -> str:
        return f"PolygonMesh({len(self.vertices)} vertices, {len(self.polygons)} polygons)"

    @classmethod
    def of_triangles(
        cls, vertices: Array, faces: Faces, source: Faces, normals: Array, domain: Domain, cut_faces: Faces
    ) -> PolygonMesh:
        """Triangles `faces` (., 3) on cut vertices that come from the vertices `source` (n,) of the domain.

        cut_faces: (F, 3) the cut vertex at each corner of the domain; one that is at no corner takes any corner of its
        vertex.
        """
        every = np.arange(cut_faces.size)
        of_vertex = np.empty(domain.vertex_count, dtype=np.int64)
        of_vertex[domain.faces.ravel()] = every
        corners = of_vertex[source]
        corners[cut_faces.ravel()] = every
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
        """Values (n, k) at the mesh's vertices from `values` (V, k) at the domain's, linear in each triangle."""
        return np.einsum("nc,nck->nk", self.barycentric, np.asarray(values)[self.anchors])
