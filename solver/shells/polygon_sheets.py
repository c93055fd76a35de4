"""A placed sheet as dual or corner mesh (paper, Fig. 5), with the attributes of the plan.

Its vertices are not the plan's: each lies in a triangle, at barycentric coordinates. Attributes of the plan's vertices
and face corners are interpolated there; attributes of faces go to the polygons.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from numpy.typing import ArrayLike, NDArray

from .measured import placed_normals
from .shell import Shell

Array = NDArray[np.float64]
Int = NDArray[np.integer]


@dataclass(frozen=True, eq=False)
class PolygonSheet:
    """points (n, 3), unit normals (n, 3) and polygons, counter-clockwise like the plan's triangles.

    vertices (n, 3): the plan's vertices around each point; triangles (n,): its triangle of the plan, None on other
    triangles (intrinsic Delaunay); barycentric (n, 3): its place between those vertices. source (n,): the plan's vertex
    that it belongs to.
    """

    points: Array
    normals: Array
    polygons: list[NDArray[np.int32]]
    source: NDArray[np.int32]
    vertices: Int
    triangles: Int | None
    barycentric: Array

    def from_vertices(self, values: ArrayLike) -> Array:
        """(n, k) of values (V, k) at the plan's vertices."""
        return np.einsum("nc,nck->nk", self.barycentric, np.asarray(values, dtype=np.float64)[self.vertices])

    def from_corners(self, values: ArrayLike, drawn: Int) -> Array:
        """(n, k) of values (T, 3, k) at the corners of the plan's triangles `drawn` (T, 3).

        On other triangles a vertex counts with the value at the first of its corners.
        """
        given = np.asarray(values, dtype=np.float64)
        if self.triangles is not None:
            return np.einsum("nc,nck->nk", self.barycentric, given[self.triangles])
        first = np.unique(drawn, return_index=True)[1]
        return self.from_vertices(given.reshape(drawn.size, -1)[first])

    def owners(self, drawn: Int, triangle_polygons: Int) -> Int:
        """(P,) the plan's polygon with which each polygon shares most.

        drawn (T, 3), triangle_polygons (T,): the plan's triangles and the polygon of each. The points of a polygon
        vote for the polygons of their triangles; on other triangles their vertices vote for the polygons around them.
        """
        rows = np.concatenate(self.polygons)
        number = np.repeat(np.arange(len(self.polygons)), [len(polygon) for polygon in self.polygons])
        if self.triangles is not None:
            return _winners(_sums(number, triangle_polygons[self.triangles[rows]], np.ones(len(rows))))
        around = _sums(drawn.ravel(), np.repeat(triangle_polygons, 3), np.ones(drawn.size)).minimum(1.0)
        near = self.barycentric[rows].clip(min=0.0).ravel()
        return _winners(_sums(np.repeat(number, 3), self.vertices[rows].ravel(), near, int(drawn.max()) + 1) @ around)


def polygon_sheet(shell: Shell, sheet: str, combinatorics: str) -> PolygonSheet:
    """A placed sheet ("f+", "f-", "g", "gauss") as "dual" or "corner" mesh; `Shell.placed` has the "primal" one."""
    surface, similarity = shell.surface, shell.similarity
    mesh = surface.as_mesh(sheet, combinatorics)
    own = surface.graph.domain is surface.domain
    # the Gauss image has its own translation, the same at all points
    moved = shell.placed[sheet][0] - similarity.points(surface.sheet(sheet)[0])
    return PolygonSheet(
        points=similarity.points(mesh.vertices) + moved,
        normals=placed_normals(mesh.normals, sheet, similarity),
        polygons=mesh.polygons,
        source=mesh.source,
        vertices=mesh.anchors,
        triangles=mesh.triangles if own else None,
        barycentric=mesh.barycentric,
    )


def _sums(rows: Int, columns: Int, values: Array, width: int | None = None) -> sp.csr_array:
    """The sums of values (m,) with the same row and column, in a table of `width` columns."""
    shape = (int(rows.max()) + 1, width or int(columns.max()) + 1)
    return sp.csr_array((values, (rows, columns)), shape=shape)


def _winners(votes: sp.csr_array) -> Int:
    """The column of the largest number in each row; the first of several that are equal up to rounding."""
    table = sp.coo_array(votes)
    order = np.lexsort((table.col, -np.round(table.data, 6), table.row))
    return table.col[order[np.unique(table.row[order], return_index=True)[1]]]
