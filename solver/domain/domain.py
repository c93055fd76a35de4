"""The domain of a map: triangles and edge lengths, nothing else.

The solver needs the metric only. Positions in the plane or in space are one way to get lengths; a strip glued into a
cylinder, a torus and an intrinsic triangulation are domains, too. A vertex of such a domain has no single position,
but every face has a planar layout of its own.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy.sparse as sp
from numpy.typing import ArrayLike, NDArray

from ..errors import MeshError, listed, plural
from ..linalg import as_numbers, check_near, graph_laplacian, out_of_range, sum_rows
from . import connectivity
from .connectivity import Edges, Int

Array = NDArray[np.float64]

# A face counts as degenerate below this ratio of its area to its longest edge squared: positions in single
# precision leave about 1e-7 in a face that was meant to be flat.
_SMALLEST_AREA_RATIO = 1e-10
# Properties that depend on the faces alone.
_TOPOLOGY = (
    "vertex_count", "twins", "fan_starts", "boundary_edges", "interior_edges", "boundary_vertices", "_loops",
    "euler_characteristic", "genus",
)
# The two faces of an edge may give it lengths that differ by this ratio (glued corners in single precision).
_LENGTH_TOLERANCE = 1e-5


@dataclass(frozen=True, eq=False)
class Domain:
    """A connected, oriented, manifold triangle mesh with a length on every edge.

    Make one with `from_positions`, `from_corners` or `from_edge_lengths`, which validate; the constructor takes its
    arrays unchecked.

    faces: (F, 3) vertex indices, counter-clockwise.
    face_edges: (F, 3) edge indices; edge k of a face is opposite its corner k.
    edge_lengths: (E,).
    """

    faces: Int
    face_edges: Int
    edge_lengths: Array

    def __repr__(self) -> str:
        loops = len(self.boundary_loops)
        counted = f"{loops} boundary loop{'' if loops == 1 else 's'}" if loops else "closed"
        genus = f", genus {self.genus}" if self.genus else ""
        return f"Domain({self.vertex_count} vertices, {len(self.faces)} triangles, {counted}{genus})"

    @classmethod
    def from_positions(cls, vertices: ArrayLike, faces: ArrayLike) -> Domain:
        """Domain of a mesh in the plane or in space: vertices (V, 2) or (V, 3), faces (F, 3).

        Raises `MeshError`, naming the offenders, on a mesh that is not a surface: NaN, indices out of range, repeated
        or degenerate faces, loose vertices, edges with three faces, inconsistent orientation, several components,
        vertices that join parts without a common edge.
        """
        positions = _as_positions(vertices)
        triangles = connectivity.as_faces(faces)
        connectivity.check_faces(triangles, len(positions))
        mesh = _checked_edges(triangles, len(positions), None, positions)
        edge_vectors = positions[mesh.edges[:, 1]] - positions[mesh.edges[:, 0]]
        return _with_proper_faces(mesh, triangles, np.linalg.norm(edge_vectors, axis=1))

    @classmethod
    def from_corners(cls, faces: ArrayLike, corners: ArrayLike, *, face_edges: ArrayLike | None = None) -> Domain:
        """Domain glued from faces with corner positions of their own, `corners` (F, 3, 2) or (F, 3, 3).

        Equal indices in `faces` make corners one vertex; the two sides of a glued edge must be equally long.
        `face_edges` (F, 3) distinguishes edges that join the same two vertices. Raises `MeshError` as
        `from_edge_lengths` does.
        """
        points = as_numbers(corners, "Corners", MeshError)
        triangles = connectivity.as_faces(faces)
        if points.shape not in ((len(triangles), 3, 2), (len(triangles), 3, 3)):
            raise MeshError(
                f"Corners must have shape (F, 3, 2) or (F, 3, 3) with F = {len(triangles)}, not {points.shape}."
            )
        bad, what = out_of_range(points)
        if bad.size:
            raise MeshError(f"A corner of {plural('face', bad)} is {what}.", faces=bad)
        lengths = np.linalg.norm(points[:, [2, 0, 1]] - points[:, [1, 2, 0]], axis=2)
        return cls.from_edge_lengths(triangles, lengths, face_edges=face_edges)

    @classmethod
    def from_edge_lengths(cls, faces: ArrayLike, lengths: ArrayLike, *, face_edges: ArrayLike | None = None) -> Domain:
        """Domain from `lengths` (F, 3), length k of a face opposite its corner k.

        Sides that join the same two vertices are one edge unless `face_edges` (F, 3) numbers them otherwise. Raises
        `MeshError` where two sides of an edge differ, a length is not positive or a triangle inequality fails.
        """
        triangles = connectivity.as_faces(faces)
        sides = as_numbers(lengths, "Lengths", MeshError)
        if sides.shape != triangles.shape:
            raise MeshError(f"Lengths must have the shape of faces, {triangles.shape}, not {sides.shape}.")
        bad, what = out_of_range(sides)
        if bad.size:
            raise MeshError(f"A length of {plural('face', bad)} is {what}.", faces=bad)
        bad = np.flatnonzero(~(sides > 0).all(axis=1))
        if bad.size:
            raise MeshError(f"A length of {plural('face', bad)} is not a positive number.", faces=bad)
        vertex_count = int(triangles.max()) + 1
        if face_edges is None:
            connectivity.check_faces(triangles, vertex_count)
        mesh = _checked_edges(triangles, vertex_count, face_edges)
        return _with_proper_faces(mesh, triangles, _common_lengths(mesh, sides))

    def with_lengths(self, lengths: Array) -> Domain:
        """The same faces with other edge lengths (E,); the topology computed so far is kept.

        Raises `MeshError` on another number of lengths and where a triangle inequality fails.
        """
        lengths = as_numbers(lengths, "The edge lengths", MeshError)
        if lengths.shape != self.edge_lengths.shape:
            raise MeshError(f"The edge lengths must have the shape {self.edge_lengths.shape}, not {lengths.shape}.")
        domain = _with_proper_faces(self._mesh, self.faces, lengths)
        domain.__dict__.update({name: self.__dict__[name] for name in _TOPOLOGY if name in self.__dict__})
        return domain

    @cached_property
    def vertex_count(self) -> int:
        """V."""
        return int(self.faces.max()) + 1

    @cached_property
    def _mesh(self) -> Edges:
        return connectivity.pair_half_edges(self.faces, self.face_edges)

    @property
    def edges(self) -> Int:
        """(E, 2) vertices, directed as in the left face; along the boundary the surface is on the left."""
        return self._mesh.edges

    @property
    def edge_faces(self) -> Int:
        """(E, 2) left and right face of each edge; -1 on the right of a boundary edge."""
        return self._mesh.edge_faces

    @property
    def half_edges(self) -> Int:
        """(E, 2) the half-edges of each edge, in its left and its right face; -1 on the right of a boundary edge.

        Half-edge `3 f + k` is opposite corner k of face f and runs from its corner k + 1 to its corner k + 2.
        """
        return self._mesh.half_edges

    @cached_property
    def twins(self) -> Int:
        """(3 F,) the half-edge on the other side of each, -1 on the boundary."""
        left, right = self.half_edges.T
        twins = np.full(self.faces.size, -1, dtype=np.int32)
        twins[left] = right
        twins[right[right >= 0]] = left[right >= 0]
        return twins

    @cached_property
    def fan_starts(self) -> NDArray[np.int64]:
        """(V,) the first corner `3 f + k` of the fan of faces around each vertex, counter-clockwise.

        At a boundary vertex it is the corner at the boundary edge that leaves; inside, any corner.
        """
        corners = np.arange(self.faces.size)
        starts = np.empty(self.vertex_count, dtype=np.int64)
        starts[self.faces.ravel()] = corners
        on_rim = corners[self.twins[connectivity.before(corners)] < 0]
        starts[self.faces.ravel()[on_rim]] = on_rim
        return starts

    @cached_property
    def boundary_edges(self) -> Int:
        """Indices of the edges with one face, sorted."""
        return np.flatnonzero(self.edge_faces[:, 1] < 0).astype(np.int32)

    @cached_property
    def interior_edges(self) -> Int:
        """Indices of the edges with two faces, sorted."""
        return np.flatnonzero(self.edge_faces[:, 1] >= 0).astype(np.int32)

    @cached_property
    def boundary_vertices(self) -> Int:
        """Vertices on the boundary, sorted."""
        return np.unique(self.edges[self.boundary_edges])

    @cached_property
    def _loops(self) -> tuple[list[Int], list[Int]]:
        return connectivity.boundary_loops(self._mesh)

    @property
    def boundary_loops(self) -> list[Int]:
        """Vertices of each boundary loop, the surface on the left; a loop starts at its smallest vertex."""
        return self._loops[0]

    @property
    def boundary_loop_edges(self) -> list[Int]:
        """Edges of each boundary loop; edge k of a loop runs from its vertex k to its vertex k + 1."""
        return self._loops[1]

    @cached_property
    def euler_characteristic(self) -> int:
        """V - E + F."""
        return self.vertex_count - len(self.edge_lengths) + len(self.faces)

    @cached_property
    def genus(self) -> int:
        """The number of handles."""
        return (2 - self.euler_characteristic - len(self.boundary_loops)) // 2

    @cached_property
    def side_lengths(self) -> Array:
        """(F, 3): length k is opposite corner k."""
        return self.edge_lengths[self.face_edges]

    @cached_property
    def face_areas(self) -> Array:
        """(F,) by Kahan's form of Heron's formula, accurate on needles."""
        c, b, a = np.sort(self.side_lengths, axis=1).T
        product = (a + (b + c)) * (c - (a - b)) * (c + (a - b)) * (a + (b - c))
        return 0.25 * np.sqrt(np.maximum(product, 0.0))

    @cached_property
    def corner_cotans(self) -> Array:
        """(F, 3) cotangents of the corner angles: cot θ_k = (a² + b² - c²) / 4A with c opposite corner k."""
        squares = self.side_lengths**2
        return (squares.sum(axis=1, keepdims=True) - 2.0 * squares) / (4.0 * self.face_areas[:, None])

    @cached_property
    def corner_angles(self) -> Array:
        """(F, 3) in radians."""
        return np.arctan2(1.0, self.corner_cotans)

    @cached_property
    def vertex_areas(self) -> Array:
        """(V,): a third of the area of the faces around each vertex."""
        return sum_rows(self.faces.ravel(), np.repeat(self.face_areas / 3.0, 3), self.vertex_count)

    @cached_property
    def area(self) -> float:
        """The sum of the face areas, in squared model lengths."""
        return float(self.face_areas.sum())

    @cached_property
    def cotan_weights(self) -> Array:
        """(E,) w_ij = ½ (cot θ_k + cot θ_l) (paper, Eq. 6); on the boundary ½ cot θ_k."""
        return 0.5 * sum_rows(self.face_edges.ravel(), self.corner_cotans.ravel(), len(self.edge_lengths))

    @cached_property
    def laplacian(self) -> sp.csr_array:
        """(V, V) positive semidefinite: E(N) = ½ <LN, N>, with the natural (Neumann) condition on the boundary."""
        return graph_laplacian(self.edges, self.cotan_weights, self.vertex_count)

    @cached_property
    def layout(self) -> Array:
        """(F, 3, 2): each face in a plane of its own, corner 0 at the origin, corner 1 on the positive x-axis."""
        _, l1, l2 = self.side_lengths.T
        angle = self.corner_angles[:, 0]
        points = np.zeros((len(self.faces), 3, 2))
        points[:, 1, 0] = l2
        points[:, 2, 0] = l1 * np.cos(angle)
        points[:, 2, 1] = 2.0 * self.face_areas / l2
        return points

    def corner_classes(self, joined: NDArray[np.bool_]) -> Int:
        """Classes (F, 3) of corners connected across the `joined` (E,) interior edges."""
        return connectivity.corner_classes(self.faces, self._mesh, joined)


def _as_positions(vertices: ArrayLike) -> Array:
    positions = as_numbers(vertices, "Vertices", MeshError)
    if positions.size == 0:
        raise MeshError("The mesh has no vertices.")
    if positions.ndim != 2 or positions.shape[1] not in (2, 3):
        raise MeshError(f"Vertices must be a (V, 2) or (V, 3) array, not one of shape {positions.shape}.")
    bad, what = out_of_range(positions)
    if bad.size:
        raise MeshError(
            f"The position of {plural('vertex', bad)} is {what}; move or delete {'it' if bad.size == 1 else 'them'}.",
            vertices=bad,
        )
    check_near(positions, "The mesh")
    return positions


def _checked_edges(
    faces: Int, vertex_count: int, face_edges: ArrayLike | None, positions: Array | None = None
) -> Edges:
    if face_edges is None:
        numbering = connectivity.edges_by_vertex_pairs(faces, vertex_count)
    else:
        numbering = np.asarray(face_edges, dtype=np.int32)
        if numbering.shape != faces.shape or numbering.min() < 0 or (np.bincount(numbering.ravel()) == 0).any():
            raise MeshError(f"Face edges must number the sides {faces.shape} from 0 without gaps.")
    mesh = connectivity.pair_half_edges(faces, numbering)
    connectivity.check_surface(faces, mesh, vertex_count, positions)
    return mesh


def _common_lengths(mesh: Edges, sides: Array) -> Array:
    """One length (E,) an edge, the mean of its two sides, which must agree."""
    e = mesh.face_edges.ravel()
    count = np.bincount(e)
    mean = np.bincount(e, sides.ravel()) / count
    bad = np.unique(e[np.abs(sides.ravel() - mean[e]) > _LENGTH_TOLERANCE * mean[e]])
    if bad.size:
        raise MeshError(
            f"The two faces at {plural('edge', bad)} (vertices {listed(mesh.edges[bad[0]])} first) "
            "give it different lengths.",
            edges=bad,
        )
    return mean


def _with_proper_faces(mesh: Edges, faces: Int, lengths: Array) -> Domain:
    """The domain; `MeshError` if a face has (almost) no area."""
    domain = Domain(faces, mesh.face_edges, lengths)
    domain.__dict__["_mesh"] = mesh  # already paired; the property would pair again
    longest = domain.side_lengths.max(axis=1)
    bad = np.flatnonzero(domain.face_areas <= _SMALLEST_AREA_RATIO * longest**2)
    if bad.size:
        raise MeshError(
            f"{plural('face', bad).capitalize()} {'has' if bad.size == 1 else 'have'} no area; dissolve degenerate "
            "faces, or merge vertices by distance.",
            faces=bad,
            vertices=np.unique(faces[bad]),
        )
    return domain
