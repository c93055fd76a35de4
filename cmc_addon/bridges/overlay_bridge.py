"""Meshes for the overlay: as shown on the screen, in any mode, without side effects.

Drawing must not create data-blocks nor flush the edit mesh: both would announce a change, and cause another redraw. The
evaluated mesh holds the edits, and is read instead.
"""

from __future__ import annotations

import bmesh
import bpy
import numpy as np
from numpy.typing import NDArray

from ..properties.stored import GROUP_ATTRIBUTE
from .mesh_bridge import CORNER_ATTRIBUTE, LENGTH_ATTRIBUTE, PlanMesh, plan_arrays, read
from .result_bridge import CUT_ATTRIBUTE, SOURCE_ATTRIBUTE

Array = NDArray[np.float64]


def seen_plan(
    ob: bpy.types.Object, depsgraph: bpy.types.Depsgraph, matrix: Array, apply_modifiers: bool
) -> PlanMesh:
    """The arrays of a plan as from `read_plan`, placed by `matrix` (4, 4), in any mode.

    A mesh in edit mode whose modifiers are not applied is read element by element.
    """
    if not ob.data.is_editmode and not (apply_modifiers and ob.modifiers):
        return plan_arrays(ob.data, matrix)
    if ob.data.is_editmode and ob.modifiers and not apply_modifiers:
        return _edited_arrays(bmesh.from_edit_mesh(ob.data), matrix)
    evaluated = ob.evaluated_get(depsgraph)
    try:
        return plan_arrays(evaluated.to_mesh(), matrix)
    finally:
        evaluated.to_mesh_clear()


def _edited_arrays(bm: bmesh.types.BMesh, matrix: Array) -> PlanMesh:
    for sequence in (bm.verts, bm.edges):
        sequence.index_update()
    groups, lengths = bm.edges.layers.int.get(GROUP_ATTRIBUTE), bm.edges.layers.float.get(LENGTH_ATTRIBUTE)
    marks = bm.verts.layers.int.get(CORNER_ATTRIBUTE)
    loops = [loop for face in bm.faces for loop in face.loops]
    local = np.array([vertex.co for vertex in bm.verts], dtype=np.float64).reshape(-1, 3)
    ends = [(edge.verts[0].index, edge.verts[1].index) for edge in bm.edges]
    return PlanMesh(
        positions=local @ matrix[:3, :3].T + matrix[:3, 3],
        corners=np.array([loop.vert.index for loop in loops], dtype=np.int32),
        starts=np.cumsum([0, *(len(face.verts) for face in bm.faces)], dtype=np.int32),
        edges=np.array(ends, dtype=np.int32).reshape(-1, 2),
        corner_edges=np.array([loop.edge.index for loop in loops], dtype=np.int32),
        groups=np.array([edge[groups] if groups else 0 for edge in bm.edges], dtype=np.int32),
        selected=np.zeros(len(bm.edges), dtype=bool),
        mirrored=bool(np.linalg.det(matrix[:3, :3]) < 0),
        flipped_corners=tuple(vertex.index for vertex in bm.verts if marks and vertex[marks]),
        lengths=np.array([edge[lengths] for edge in bm.edges], dtype=np.float32) if lengths else None,
    )


def line_of(ob: bpy.types.Object, context: bpy.types.Context) -> Array:
    """Ends (n, 2, 3) of the edges of a curve, or of the boundary of a mesh, as seen, in its own coordinates."""
    evaluated = ob.evaluated_get(context.view_layer.depsgraph or context.evaluated_depsgraph_get())
    try:
        mesh = evaluated.to_mesh()
        edges = read(mesh, ".edge_verts", len(mesh.edges), np.int32, 2)
        faces = np.bincount(read(mesh, ".corner_edge", len(mesh.loops), np.int32), minlength=len(edges))
        return points_of(mesh)[edges[faces <= (1 if len(mesh.polygons) else 0)]]
    finally:
        evaluated.to_mesh_clear()


def points_of(mesh: bpy.types.Mesh) -> Array:
    """Positions (V, 3) of a mesh that is not in edit mode, in its own coordinates."""
    return read(mesh, "position", len(mesh.vertices), np.float32, 3).astype(np.float64)


def cut_of(mesh: bpy.types.Mesh) -> tuple[Array, NDArray[np.int32]]:
    """The cut of an open result: ends (n, 2, 3) of its edges, and pairs (k, 2) of the plan's vertices."""
    attributes = mesh.attributes
    if mesh.is_editmode or CUT_ATTRIBUTE not in attributes or SOURCE_ATTRIBUTE not in attributes:
        return np.zeros((0, 2, 3)), np.zeros((0, 2), dtype=np.int32)
    edges = read(mesh, ".edge_verts", len(mesh.edges), np.int32, 2)[
        read(mesh, CUT_ATTRIBUTE, len(mesh.edges), np.bool_)
    ]
    sources = read(mesh, SOURCE_ATTRIBUTE, len(mesh.vertices), np.int32)
    return points_of(mesh)[edges], np.unique(np.sort(sources[edges], axis=1), axis=0)
