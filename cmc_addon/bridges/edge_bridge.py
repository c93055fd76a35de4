"""Edges of a Blender mesh: boundary, groups and selection.

Everything here works in object mode and in edit mode, where the arrays of a mesh are empty and its bmesh holds the
data.

A boundary edge has exactly one face. In a mesh without faces, an outline not yet meshed, every edge is boundary.
"""

from __future__ import annotations

from dataclasses import dataclass

import bmesh
import bpy
import numpy as np

from ...solver.errors import MeshError
from ..properties.stored import GROUP_ATTRIBUTE

_SELECTION = ".select_edge"
_STAMP = ".cmc_list_"


@dataclass(frozen=True)
class EdgeState:
    """Per edge, in the order of the mesh: on the boundary, uid of its group (0: none), selected."""

    boundary: np.ndarray
    group: np.ndarray
    selected: np.ndarray


def has_faces(mesh: bpy.types.Mesh) -> bool:
    """Whether there is a face, in edit mode or not."""
    return bool(len(bmesh.from_edit_mesh(mesh).faces if mesh.is_editmode else mesh.polygons))


def sizes(mesh: bpy.types.Mesh) -> tuple[int, int, int]:
    """Numbers of vertices, edges and faces, in edit mode or not."""
    if mesh.is_editmode:
        bm = bmesh.from_edit_mesh(mesh)
        return len(bm.verts), len(bm.edges), len(bm.faces)
    return len(mesh.vertices), len(mesh.edges), len(mesh.polygons)


def read_edges(mesh: bpy.types.Mesh) -> EdgeState:
    """The state of every edge, in any mode. Raises `MeshError` if another attribute has the name of the groups."""
    if mesh.is_editmode:
        return _read_bmesh(bmesh.from_edit_mesh(mesh))
    return EdgeState(is_boundary(mesh), group_values(mesh), _stored_selection(mesh))


def write_groups(mesh: bpy.types.Mesh, edges: np.ndarray, uid: int) -> None:
    """Put edges (indices) into the group `uid`, or with 0 into none."""
    if mesh.is_editmode:
        bm = bmesh.from_edit_mesh(mesh)
        layer = _layer(bm, create=True)
        bm.edges.ensure_lookup_table()
        for index in edges.tolist():
            bm.edges[index][layer] = uid
        bmesh.update_edit_mesh(mesh, loop_triangles=False, destructive=False)
        return
    values = group_values(mesh)
    values[edges] = uid
    write_group_values(mesh, values)


def write_selection(mesh: bpy.types.Mesh, edges: np.ndarray, select: bool) -> None:
    """Select or deselect edges (indices) with their vertices; hidden edges stay as they are."""
    if mesh.is_editmode:
        bm = bmesh.from_edit_mesh(mesh)
        bm.edges.ensure_lookup_table()
        for index in edges.tolist():
            if not bm.edges[index].hide:
                bm.edges[index].select_set(select)
        bm.select_flush_mode()
        bmesh.update_edit_mesh(mesh, loop_triangles=False, destructive=False)
        return
    _write_stored_selection(mesh, edges, select)


def group_values(mesh: bpy.types.Mesh) -> np.ndarray:
    """Group uid of every edge (E,), 0 by default; object mode only."""
    values = np.zeros(len(mesh.edges), dtype=np.int32)
    attribute = mesh.attributes.get(GROUP_ATTRIBUTE)
    if attribute is not None:
        _check_attribute(attribute)
        attribute.data.foreach_get("value", values)
    return values


def write_group_values(mesh: bpy.types.Mesh, values: np.ndarray) -> None:
    """Set the group uid of every edge (E,), with a new attribute if needed; object mode only."""
    attribute = mesh.attributes.get(GROUP_ATTRIBUTE)
    if attribute is None:
        attribute = mesh.attributes.new(GROUP_ATTRIBUTE, "INT", "EDGE")
    _check_attribute(attribute)
    attribute.data.foreach_set("value", np.ascontiguousarray(values, dtype=np.int32))
    mesh.update()


def repair_selection(mesh: bpy.types.Mesh) -> None:
    """Replace an edge selection of the wrong type, made by Blender 5.0 when it calculates edges: writing it crashes."""
    attribute = mesh.attributes.get(_SELECTION)
    if attribute is not None and attribute.data_type != "BOOLEAN":
        mesh.attributes.remove(attribute)
        mesh.attributes.new(_SELECTION, "BOOLEAN", "EDGE")


def read_stamp(mesh: bpy.types.Mesh) -> int:
    """The number left by `write_stamp`, or 0."""
    names = (layer.name for layer in _stamp_layers(mesh))
    return next((int(name.removeprefix(_STAMP)) for name in names), 0)


def write_stamp(mesh: bpy.types.Mesh, number: int) -> None:
    """Leave a number in a mesh in edit mode, where undo includes it; the dot in its name hides it from the user."""
    bm = bmesh.from_edit_mesh(mesh)
    for layer in _stamp_layers(mesh):
        bm.faces.layers.int.remove(layer)
    bm.faces.layers.int.new(f"{_STAMP}{number}")
    bmesh.update_edit_mesh(mesh, loop_triangles=False, destructive=False)


def count_boundary(mesh: bpy.types.Mesh, uids: frozenset[int]) -> tuple[int, int]:
    """Numbers of boundary edges, and of those in none of the groups `uids`.

    Never raises: the panel draws a mesh in any state.
    """
    if not mesh.is_editmode:
        attribute = mesh.attributes.get(GROUP_ATTRIBUTE)
        boundary = is_boundary(mesh)
        if attribute is None or (attribute.domain, attribute.data_type) != ("EDGE", "INT"):
            return int(boundary.sum()), int(boundary.sum())
        groups = group_values(mesh)[boundary]
        return groups.size, int((~np.isin(groups, list(uids))).sum())
    bm = bmesh.from_edit_mesh(mesh)
    layer = _layer(bm)
    edges = [edge for edge in bm.edges if edge.is_boundary] if bm.faces else list(bm.edges)
    if layer is None:
        return len(edges), len(edges)
    return len(edges), sum(edge[layer] not in uids for edge in edges)


def mend_selection(mesh: bpy.types.Mesh) -> None:
    """Remove an edge selection of the wrong type, made by Blender 5.0 when it calculates edges: writing it crashes."""
    attribute = mesh.attributes.get(".select_edge")
    if attribute is not None and attribute.data_type != "BOOLEAN":
        mesh.attributes.remove(attribute)


# --- by mode ------------------------------------------------------------------------

def is_boundary(mesh: bpy.types.Mesh) -> np.ndarray:
    """(E,) whether each edge is on the boundary; object mode only."""
    if not mesh.polygons:
        return np.ones(len(mesh.edges), dtype=bool)
    corners = np.empty(len(mesh.loops), dtype=np.int32)
    mesh.attributes[".corner_edge"].data.foreach_get("value", corners)
    return np.bincount(corners, minlength=len(mesh.edges)) == 1


def _check_attribute(attribute: bpy.types.Attribute) -> None:
    if (attribute.domain, attribute.data_type) != ("EDGE", "INT"):
        raise MeshError(
            f"The attribute {GROUP_ATTRIBUTE!r} of this mesh is not an integer on edges, so it cannot store boundary "
            "groups; rename or remove it."
        )


def _layer(bm: bmesh.types.BMesh, create: bool = False):
    layer = bm.edges.layers.int.get(GROUP_ATTRIBUTE)
    if layer is None and create:
        layer = bm.edges.layers.int.new(GROUP_ATTRIBUTE)
    return layer


def _stamp_layers(mesh: bpy.types.Mesh) -> list:
    layers = bmesh.from_edit_mesh(mesh).faces.layers.int.values()
    return [layer for layer in layers if layer.name.startswith(_STAMP)]


def _read_bmesh(bm: bmesh.types.BMesh) -> EdgeState:
    count, layer = len(bm.edges), _layer(bm)
    if bm.faces:
        boundary = np.fromiter((edge.is_boundary for edge in bm.edges), dtype=bool, count=count)
    else:
        boundary = np.ones(count, dtype=bool)
    group = np.zeros(count, dtype=np.int32)
    if layer is not None:
        group[:] = [edge[layer] for edge in bm.edges]
    selected = np.fromiter((edge.select for edge in bm.edges), dtype=bool, count=count)
    return EdgeState(boundary, group, selected)


def _stored_selection(mesh: bpy.types.Mesh) -> np.ndarray:
    selected = np.zeros(len(mesh.edges), dtype=bool)
    attribute = mesh.attributes.get(_SELECTION)
    if attribute is not None and attribute.data_type == "BOOLEAN":
        attribute.data.foreach_get("value", selected)
    return selected


def _write_stored_selection(mesh: bpy.types.Mesh, edges: np.ndarray, select: bool) -> None:
    """Edge and vertex flags together: on entering edit mode Blender flushes from one to the other."""
    mend_selection(mesh)
    count = len(mesh.edges)
    flags, hidden = _stored_selection(mesh), np.empty(count, dtype=bool)
    mesh.edges.foreach_get("hide", hidden)
    ends = np.empty(2 * count, dtype=np.int32)
    mesh.edges.foreach_get("vertices", ends)
    ends = ends.reshape(-1, 2)
    flags[edges] = select
    flags &= ~hidden
    vertices = np.empty(len(mesh.vertices), dtype=bool)
    mesh.vertices.foreach_get("select", vertices)
    vertices[ends[edges]] = False
    vertices[ends[flags]] = True
    repair_selection(mesh)
    mesh.edges.foreach_set("select", flags)
    mesh.vertices.foreach_set("select", vertices)
    mesh.update()
