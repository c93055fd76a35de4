"""Surfaces with the polygons of the dual mesh, or with one for each face, edge and vertex (paper, Fig. 5).

Every corner c of the domain has a point g_c of the conjugate surface and a normal N_c. With normals at vertices g is
constant on faces, with normals at faces N is. f± = g ± N is then a surface whose vertices are the corners: each face,
each edge and each vertex of the domain becomes a polygon. If N is constant along a polygon, it is orthogonal to it. The
dual mesh has a vertex for each face instead, the average of its corners.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..domain.connectivity import after, before
from ..domain.domain import Domain
from ..domain.sites import SiteGraph
from ..domain.topology import Homology
from .conjugate import Conjugate
from .polygon_mesh import PolygonMesh
from .vertex_fans import Fans

Array = NDArray[np.float64]
Int = NDArray[np.integer]


@dataclass(frozen=True, eq=False)
class CornerValues:
    """g and N at the corners of a domain, and how the sheets of a domain with holes continue each other.

    conjugate, normals: (F, 3, 3), in every face on its own sheet.
    weights: (F, 3) barycentric coordinates of the point in each face where its corners are averaged (A_* of the paper,
    Eq. 12): the circumcentre, where the conjugate of normals at vertices is, or others that sum to one.
    boundary_normals: (B, 3), unit N half-way along each of `domain.boundary_edges`.
    boundary_points: (B, 3), a point of g on each of them, if normals are at vertices; else None.
    crossings: (E, k) of the domain's `Homology` and periods: (k, 3), or k = 0 where g closes.
    """

    domain: Domain
    conjugate: Array
    normals: Array
    weights: Array
    boundary_normals: Array
    boundary_points: Array | None
    crossings: Int
    periods: Array

    @classmethod
    def of(
        cls, graph: SiteGraph, conjugate: Conjugate, N: Array, at_vertices: Array, weights: Array, is_open: bool
    ) -> CornerValues:
        """From normals N (S, 3) and their conjugate; without its periods unless the surface `is_open`.

        at_vertices: (V, 3) N there, as it is or averaged; it gives the normals along the boundary.
        """
        domain = graph.domain
        crossings = np.zeros((len(domain.edges), 0), dtype=np.int64)
        periods, cut_faces = np.zeros((0, 3)), domain.faces
        if is_open:
            homology = Homology.of(domain)  # depends on the domain alone: the cuts of the conjugate
            crossings, periods, cut_faces = homology.crossings, conjugate.periods, homology.sheets.faces
        rim = _unit(at_vertices[domain.edges[domain.boundary_edges]].sum(axis=1))
        if graph.at_vertices:
            g, normals, points = _on_corners(conjugate.g), N[domain.faces], conjugate.boundary_points
        else:
            g, normals, points = conjugate.g[cut_faces], _on_corners(N[: len(domain.faces)]), None
        return cls(domain, g, normals, weights, rim, points, crossings, periods)

    @cached_property
    def fans(self) -> Fans:
        return Fans.of(self.domain, self.crossings)


@dataclass(frozen=True, eq=False)
class DualMesh:
    """g and N (n, 3) at the vertices of a dual or corner mesh, so that f± = g ± N are meshes of the same polygons.

    normals: A_*(N), of length one only where nothing is averaged. The other fields are those of `PolygonMesh`.
    """

    conjugate: Array
    normals: Array
    polygons: list[NDArray[np.int32]]
    source: Int
    triangles: Int
    barycentric: Array
    domain: Domain

    def mesh(self, points: Array) -> PolygonMesh:
        """The mesh with its vertices at `points` (n, 3)."""
        return PolygonMesh(
            vertices=points,
            polygons=self.polygons,
            source=self.source.astype(np.int32),
            normals=_unit(self.normals),
            triangles=self.triangles.astype(np.int32),
            barycentric=self.barycentric,
            anchors=self.domain.faces[self.triangles],
        )


class _Places(NamedTuple):
    """Possible vertices of a mesh, each on the sheet of the face that it belongs to."""

    conjugate: Array
    normals: Array
    source: Int
    triangles: Int
    barycentric: Array


def dual_mesh(corners: CornerValues) -> DualMesh:
    """A vertex for each face and each boundary edge, a polygon for each vertex of the domain (paper, Fig. 5 right).

    A polygon runs counter-clockwise through the faces around its vertex; on the boundary it begins and ends with the
    boundary edges and is closed by one edge between them (Fig. 7). With normals at vertices the polygon of vertex i
    on g is planar and orthogonal to N_i. Interior vertices of the domain with fewer than three faces around them have
    no polygon. A face that meets a vertex twice is twice in its polygon, unless the surface jumps in between.
    """
    fans, faces = corners.fans, len(corners.domain.faces)
    at_rim = fans.places >= 3 * faces
    items = np.where(at_rim, faces + (fans.places - 3 * faces) // 2, fans.places // 3)
    sizes = np.bincount(fans.vertices)
    places = _joined(_face_places(corners), _rim_places(corners))
    return _assemble(corners, places, sizes, items, fans.shifts)


def corner_mesh(corners: CornerValues) -> DualMesh:
    """A vertex for each corner of a face; a polygon for each face, each edge and each vertex, in this order (Fig. 5
    left).

    With normals at vertices a boundary edge has two more vertices, with the normals of its ends, so that it has a quad
    like the others and the polygons of the boundary are closed; on f± - as on g - the polygon of vertex i is planar and
    orthogonal to N_i. With normals at faces the surface ends with the faces: boundary edges have no quad, and boundary
    vertices a polygon only where three faces or more meet; the triangle of face f is orthogonal to N_f. Interior
    vertices with fewer than three faces around them have no polygon either.

    Polygons of faces and of vertices turn with the Gauss map: where f+ is saddle-shaped they lie upside down between
    the quads of their edges, on f+ and f- alike.
    """
    domain, fans = corners.domain, corners.fans
    places = _corner_places(corners)
    kept = np.ones(len(fans.places), dtype=bool)
    if corners.boundary_points is None:
        kept = fans.places < domain.faces.size
    else:
        places = _joined(places, _rim_end_places(corners, corners.boundary_points))
    quads, quad_shifts = _quads(corners)
    k = corners.crossings.shape[1]
    sizes = [np.full(len(domain.faces), 3), np.full(len(quads), 4), np.bincount(fans.vertices[kept])]
    items = [np.arange(domain.faces.size), quads.ravel(), fans.places[kept]]
    shifts = [np.zeros((domain.faces.size, k), dtype=np.int64), quad_shifts.reshape(quads.size, k), fans.shifts[kept]]
    return _assemble(corners, places, np.concatenate(sizes), np.concatenate(items), np.concatenate(shifts))


def _quads(corners: CornerValues) -> tuple[Int, Int]:
    """Corners (n, 4) around each edge, and their shifts (n, 4, k); each on the sheet of the left face of its edge.

    The left face traverses the edge forwards, the right one backwards, the quad against both.
    """
    domain = corners.domain
    edges = domain.interior_edges
    left, right = domain.half_edges[edges].T.astype(np.int64)
    quads = np.stack([before(left), after(left), before(right), after(right)], axis=1)
    shifts = np.zeros((*quads.shape, corners.crossings.shape[1]), dtype=np.int64)
    shifts[:, 2:] = -corners.crossings[edges].astype(np.int64)[:, None]
    if corners.boundary_points is None:
        return quads, shifts
    left = domain.half_edges[domain.boundary_edges, 0].astype(np.int64)
    ends = domain.faces.size + np.arange(2 * len(left)).reshape(-1, 2)
    rim = np.column_stack([before(left), after(left), ends])
    return np.concatenate([quads, rim]), np.concatenate([shifts, np.zeros((*rim.shape, shifts.shape[2]), np.int64)])


def _face_places(corners: CornerValues) -> _Places:
    """(F,): the average of the three corners."""
    weights = corners.weights
    return _Places(
        _average(weights, corners.conjugate),
        _average(weights, corners.normals),
        corners.domain.faces[np.arange(len(weights)), np.argmax(weights, axis=1)],
        np.arange(len(weights)),
        weights,
    )


def _average(weights: Array, values: Array) -> Array:
    """Σ_k weights_k values_k (F, 3), exactly the common value where the three are equal."""
    first = values[:, 0]
    return first + weights[:, 1, None] * (values[:, 1] - first) + weights[:, 2, None] * (values[:, 2] - first)


def _rim_places(corners: CornerValues) -> _Places:
    """(B,): the midpoint of each boundary edge."""
    domain = corners.domain
    behind, tail, head = _rim_corners(domain)
    conjugate = corners.conjugate.reshape(-1, 3)
    points = corners.boundary_points
    if points is None:
        points = 0.5 * (conjugate[tail] + conjugate[head])
    middle = 0.5 * (_one_hot(tail) + _one_hot(head))
    return _Places(points, corners.boundary_normals, domain.faces.ravel()[tail], behind, middle)


def _corner_places(corners: CornerValues) -> _Places:
    """(3 F,): the corners, half-way between their vertex and the point of their face; N is at one, g at the other."""
    every = np.arange(corners.domain.faces.size)
    return _Places(
        corners.conjugate.reshape(-1, 3),
        corners.normals.reshape(-1, 3),
        corners.domain.faces.ravel(),
        every // 3,
        0.5 * (_one_hot(every) + np.repeat(corners.weights, 3, axis=0)),
    )


def _rim_end_places(corners: CornerValues, boundary_points: Array) -> _Places:
    """(2 B,): the start and the end of each boundary edge: its point of g, and the normal there."""
    domain = corners.domain
    _, tail, head = _rim_corners(domain)
    ends, others = (np.stack(pair, axis=1).ravel() for pair in ((tail, head), (head, tail)))
    return _Places(
        np.repeat(boundary_points, 2, axis=0),
        corners.normals.reshape(-1, 3)[ends],
        domain.faces.ravel()[ends],
        ends // 3,
        0.75 * _one_hot(ends) + 0.25 * _one_hot(others),
    )


def _rim_corners(domain: Domain) -> tuple[Int, Int, Int]:
    """The face behind each boundary edge, and its corners at the start and at the end of the edge, (B,) each."""
    half_edge = domain.half_edges[domain.boundary_edges, 0].astype(np.int64)
    return half_edge // 3, after(half_edge), before(half_edge)


def _on_corners(values: Array) -> Array:
    """(F, 3, 3) of values (F, 3) on faces."""
    return np.broadcast_to(values[:, None], (len(values), 3, 3))


def _one_hot(corners: Int) -> Array:
    return np.eye(3)[corners % 3]


def _unit(vectors: Array) -> Array:
    """Rows of length one; a row that vanishes (opposite normals averaged) stays."""
    length = np.linalg.norm(vectors, axis=1, keepdims=True)
    return vectors / np.where(length > 0.0, length, 1.0)


def _joined(a: _Places, b: _Places) -> _Places:
    return _Places(
        np.concatenate([a.conjugate, b.conjugate]),
        np.concatenate([a.normals, b.normals]),
        np.concatenate([a.source, b.source]),
        np.concatenate([a.triangles, b.triangles]),
        np.concatenate([a.barycentric, b.barycentric]),
    )


def _assemble(corners: CornerValues, places: _Places, sizes: Int, items: Int, shifts: Int) -> DualMesh:
    """The mesh of polygons with `sizes` (p,) places each, in `items` (m,) one after the other, shifted by `shifts`.

    A vertex of the mesh is a place on a sheet, (item, shift), that some polygon has.
    """
    count = len(places.source)
    numbers = items.copy()
    moved = np.flatnonzero(shifts.any(axis=1))
    others, which = np.unique(np.column_stack([items[moved], shifts[moved]]), axis=0, return_inverse=True)
    numbers[moved] = count + which.ravel()
    numbers, sizes = _proper(numbers, sizes)
    used = np.zeros(count + len(others), dtype=bool)
    used[numbers] = True
    vertices = (np.cumsum(used) - 1)[numbers].astype(np.int32)
    place = np.concatenate([np.arange(count), others[:, 0]])[used]
    jumps = np.concatenate([np.zeros((count, len(corners.periods)), dtype=np.int64), others[:, 1:]])[used]
    ends = np.cumsum(sizes)
    return DualMesh(
        conjugate=places.conjugate[place] + jumps @ corners.periods,
        normals=places.normals[place],
        polygons=[vertices[a:b] for a, b in zip((ends - sizes).tolist(), ends.tolist(), strict=True)],
        source=places.source[place],
        triangles=places.triangles[place],
        barycentric=places.barycentric[place],
        domain=corners.domain,
    )


def _proper(numbers: Int, sizes: Int) -> tuple[Int, Int]:
    """The polygons without repeated vertices, and only those that keep three vertices or more."""
    ends = np.cumsum(sizes)
    filled = sizes > 0
    previous = np.arange(-1, len(numbers) - 1)
    previous[(ends - sizes)[filled]] = ends[filled] - 1
    kept = numbers != numbers[previous]
    owner = np.repeat(np.arange(len(sizes)), sizes)
    sizes = np.bincount(owner[kept], minlength=len(sizes))
    kept &= sizes[owner] >= 3
    return numbers[kept], sizes[sizes >= 3]
