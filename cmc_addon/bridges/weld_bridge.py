"""Parts of a plan that only touch: vertices of its rim that coincide with those of another part, and T-junctions."""

from __future__ import annotations

from dataclasses import dataclass

import bmesh
import bpy
import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from ...solver.linalg import reach_of_place, same_places
from ...solver.shells.t_junctions import t_junctions
from .edge_bridge import is_boundary
from .mesh_bridge import read

Array = NDArray[np.float64]
Int = NDArray[np.integer]


@dataclass(frozen=True, eq=False)
class Contact:
    """Where parts touch: vertices (k,) that coincide with others, and the vertex (k,) that each becomes; vertices
    (j,) that lie inside an edge, and that edge (j,)."""

    twins: Int
    places: Int
    lying: Int
    edges: Int

    @property
    def count(self) -> int:
        """How many vertices are not joined as they should be."""
        return len(self.twins) + len(self.lying)


def contact_count(mesh: bpy.types.Mesh) -> int:
    """How many vertices of a mesh, in any mode, should be joined to another part; quick where there are none."""
    if not mesh.is_editmode:
        ends = read(mesh, ".edge_verts", len(mesh.edges), np.int32, 2)
        positions = read(mesh, "position", len(mesh.vertices), np.float32, 3).astype(np.float64)
        if not Rim.of(ends[is_boundary(mesh)], positions).touches:
            return 0
    bm = _opened(mesh)
    try:
        return _contact(bm).count
    finally:
        _closed(mesh, bm, keep=False)


def weld(mesh: bpy.types.Mesh) -> int:
    """Split edges at T-junctions and merge the vertices where parts touch, in any mode; how many there were.

    Layers of the mesh, its boundary groups among them, stay.
    """
    bm = _opened(mesh)
    contact = _contact(bm)
    _split(bm, contact)
    if len(contact.lying):
        bm.verts.index_update()
        bm.edges.index_update()
    _merge(bm, _contact(bm))
    _closed(mesh, bm, keep=True)
    return contact.count


def _opened(mesh: bpy.types.Mesh) -> bmesh.types.BMesh:
    if mesh.is_editmode:
        bm = bmesh.from_edit_mesh(mesh)
    else:
        bm = bmesh.new()
        bm.from_mesh(mesh)
    bm.verts.index_update()
    bm.edges.index_update()
    return bm


def _closed(mesh: bpy.types.Mesh, bm: bmesh.types.BMesh, keep: bool) -> None:
    if mesh.is_editmode:
        if keep:
            bmesh.update_edit_mesh(mesh)
        return
    if keep:
        bm.to_mesh(mesh)
        mesh.update()
    bm.free()


@dataclass(frozen=True, eq=False)
class Rim:
    """The rim of a mesh. vertices (n,): its vertices; positions (n, 3) and first (n,): of each the first one in its
    place, among the n; ends (e, 2): of its edges, among the n."""

    vertices: Int
    positions: Array
    ends: Int
    first: Int

    @classmethod
    def of(cls, ends: Int, positions: Array) -> Rim:
        """ends (e, 2): vertices of the edges of the rim; positions (V, 3)."""
        vertices, local = np.unique(ends, return_inverse=True)
        places = positions[vertices]
        if not np.isfinite(places).all():
            vertices, local, places = vertices[:0], local[:0], places[:0]
        return cls(vertices, places, local.reshape(-1, 2), same_places(places, reach_of_place(places)))

    @property
    def touches(self) -> bool:
        """Whether there are vertices in one place, or inside an edge."""
        return bool((self.first != np.arange(len(self.first))).any() or len(self.junctions[0]))

    @property
    def junctions(self) -> tuple[Int, Int]:
        """Vertices inside an edge, and that edge, among those of the rim."""
        none = np.zeros(0, dtype=np.int64)
        return t_junctions(self.positions, self.ends) if len(self.ends) else (none, none)

    def twins(self, parts: Int) -> Int:
        """Vertices, among those of the rim, in the place of an earlier one of another part; parts (e,): of each edge.

        A slit of one part is meant to be open.
        """
        meetings = np.unique(np.column_stack([self.first[self.ends].ravel(), np.repeat(parts, 2)]), axis=0)
        shared, times = np.unique(meetings[:, 0], return_counts=True)
        return np.flatnonzero(np.isin(self.first, shared[times > 1]) & (self.first != np.arange(len(self.first))))


def _contact(bm: bmesh.types.BMesh) -> Contact:
    outer = [edge for edge in bm.edges if len(edge.link_faces) < 2]
    ends = np.array([[vertex.index for vertex in edge.verts] for edge in outer], dtype=np.int64).reshape(-1, 2)
    positions = np.zeros((len(bm.verts), 3))
    for edge in outer:
        for vertex in edge.verts:
            positions[vertex.index] = vertex.co
    rim, none = Rim.of(ends, positions), np.zeros(0, dtype=np.int64)
    if not rim.touches:
        return Contact(none, none, none, none)
    edges = np.array([edge.index for edge in outer])
    twins = rim.twins(_parts(bm)[edges])
    lying, along = rim.junctions
    return Contact(rim.vertices[twins], rim.vertices[rim.first[twins]], rim.vertices[lying], edges[along])


def _parts(bm: bmesh.types.BMesh) -> Int:
    """The part (E,) of the mesh that each edge is of: faces are joined across edges, edges without faces at their ends.
    """
    bm.faces.index_update()
    count, faces = len(bm.edges), len(bm.faces)
    links = [(edge.index, count + face.index) for edge in bm.edges for face in edge.link_faces]
    wire = [edge for edge in bm.edges if not edge.link_faces]
    links += [(edge.index, count + faces + vertex.index) for edge in wire for vertex in edge.verts]
    rows, columns = np.array(links, dtype=np.int64).reshape(-1, 2).T
    size = count + faces + len(bm.verts)
    graph = coo_array((np.ones(len(rows)), (rows, columns)), shape=(size, size))
    return connected_components(graph, directed=False)[1][:count]


def _split(bm: bmesh.types.BMesh, contact: Contact) -> None:
    """Give each edge with vertices inside it vertices of its own in their places."""
    bm.verts.ensure_lookup_table()
    bm.edges.ensure_lookup_table()
    every = [bm.edges[index] for index in contact.edges.tolist()]
    points = [bm.verts[index].co.copy() for index in contact.lying.tolist()]
    for edge in dict.fromkeys(every):
        start, end = edge.verts
        along = end.co - start.co
        inside = sorted((point for own, point in zip(every, points, strict=True) if own == edge), key=along.dot)
        rest, vertex = edge, start
        for point in inside:
            new, vertex = bmesh.utils.edge_split(rest, vertex, 0.5)
            vertex.co = point
            rest = new if end in new.verts else rest


def _merge(bm: bmesh.types.BMesh, contact: Contact) -> None:
    bm.verts.ensure_lookup_table()
    targets = {bm.verts[a]: bm.verts[b] for a, b in zip(contact.twins.tolist(), contact.places.tolist(), strict=True)}
    bmesh.ops.weld_verts(bm, targetmap=targets)
