"""Corners between two mirrors of a plan: the normal of the shell there, and the mark that flips it.

Where two mirrors with normals ν₁, ν₂ meet, the normal of the shell is ±ν₁ × ν₂ (see `conditions.mirror`). By default it
points out of the shell; a mark on the vertex, an integer other than 0, flips it.
"""

from __future__ import annotations

from dataclasses import dataclass

import bmesh
import bpy
import numpy as np

from .edge_bridge import group_values
from .mesh_bridge import CORNER_ATTRIBUTE, read, set_attribute

# Corners up to this much beyond straight count as convex, in radians.
_STRAIGHT = 1e-4


@dataclass(frozen=True)
class Corner:
    """A vertex between the mirrors of two groups, in the order of the boundary with the plan on its left.

    uids: of the groups. turn: +1 at a corner of less than 180° in the plan, else -1. flipped: whether it is marked.
    """

    vertex: int
    uids: tuple[int, int]
    turn: float
    flipped: bool

    def normal(self, mesh: bpy.types.Mesh) -> np.ndarray | None:
        """Normal (3,) of the shell here; None if the two mirrors share a plane."""
        normals = {group.uid: np.array(group.normal) for group in mesh.cmc.groups}
        before, after = (normals[uid] for uid in self.uids)
        product = np.cross(before, after)
        length = np.linalg.norm(product)
        return (-self.turn if self.flipped else self.turn) * product / length if length > 1e-6 else None


def corners(mesh: bpy.types.Mesh) -> list[Corner]:
    """All corners between two mirrors of different groups, in any mode."""
    mirrors = {group.uid for group in mesh.cmc.groups if group.kind == "MIRROR"}
    if len(mirrors) < 2:
        return []
    sides, points, up, marked = _edit_sides(mesh) if mesh.is_editmode else _stored_sides(mesh)
    arriving = {head: (uid, tail) for tail, head, uid in sides if uid in mirrors}
    mirrored = []
    for tail, head, uid in sides:
        before = arriving.get(tail)
        if uid in mirrors and before is not None and before[0] != uid:
            turn = _turn(points[before[1]], points[tail], points[head], up)
            mirrored.append(Corner(tail, (before[0], uid), turn, tail in marked))
    return mirrored


def flip(mesh: bpy.types.Mesh, vertex: int) -> None:
    """Set or clear the mark of a vertex."""
    if mesh.is_editmode:
        bm = bmesh.from_edit_mesh(mesh)
        layer = bm.verts.layers.int.get(CORNER_ATTRIBUTE) or bm.verts.layers.int.new(CORNER_ATTRIBUTE)
        bm.verts.ensure_lookup_table()
        bm.verts[vertex][layer] = int(not bm.verts[vertex][layer])
        bmesh.update_edit_mesh(mesh, loop_triangles=False, destructive=False)
        return
    marks = read(mesh, CORNER_ATTRIBUTE, len(mesh.vertices), np.int32)
    marks[vertex] = int(not marks[vertex])
    set_attribute(mesh, CORNER_ATTRIBUTE, "INT", "POINT", marks)
    mesh.update()


def _turn(before: np.ndarray, here: np.ndarray, after: np.ndarray, up: np.ndarray) -> float:
    first, second = here - before, after - here
    return 1.0 if np.cross(first, second) @ up >= -_STRAIGHT * np.linalg.norm(first) * np.linalg.norm(second) else -1.0


def _stored_sides(mesh: bpy.types.Mesh):
    """Boundary edges as (tail, head, uid) with the faces on their left; points; mean normal; marked vertices."""
    corner_edges = read(mesh, ".corner_edge", len(mesh.loops), np.int32)
    starts = read(mesh, ".corner_vert", len(mesh.loops), np.int32)
    ends = np.empty_like(starts)
    first = np.empty(len(mesh.polygons), dtype=np.int32)
    mesh.polygons.foreach_get("loop_start", first)
    ends[:-1] = starts[1:]
    ends[np.append(first[1:], len(starts)) - 1] = starts[first]
    rim = np.bincount(corner_edges, minlength=len(mesh.edges))[corner_edges] == 1
    uids = group_values(mesh)[corner_edges[rim]]
    points = read(mesh, "position", len(mesh.vertices), np.float32, 3).astype(np.float64)
    sides = list(zip(starts[rim].tolist(), ends[rim].tolist(), uids.tolist(), strict=True))
    marks = read(mesh, CORNER_ATTRIBUTE, len(mesh.vertices), np.int32)
    return sides, points, _area_vector(sides, points), set(np.flatnonzero(marks).tolist())


def _edit_sides(mesh: bpy.types.Mesh):
    bm = bmesh.from_edit_mesh(mesh)
    groups, marks = bm.edges.layers.int.get("cmc_group"), bm.verts.layers.int.get(CORNER_ATTRIBUTE)
    loops = [edge.link_loops[0] for edge in bm.edges if edge.is_boundary] if groups is not None else []
    sides = [(loop.vert.index, loop.link_loop_next.vert.index, loop.edge[groups]) for loop in loops]
    points = {loop.vert.index: np.array(loop.vert.co) for loop in loops}
    marked = {loop.vert.index for loop in loops if marks is not None and loop.vert[marks]}
    return sides, points, _area_vector(sides, points), marked


def _area_vector(sides, points) -> np.ndarray:
    """Unit vector along ½ ∮ x × dx over the boundary: the mean normal of the faces."""
    if not sides:
        return np.zeros(3)
    tails, heads = (np.array([points[side[k]] for side in sides]) for k in (0, 1))
    middle = tails.mean(axis=0)
    vector = np.cross(tails - middle, heads - middle).sum(axis=0)
    length = np.linalg.norm(vector)
    return vector / length if length > 0 else vector
