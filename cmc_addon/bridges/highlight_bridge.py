"""Highlights an error in the mesh: selects the elements that it names, in edit mode."""

from __future__ import annotations

from collections.abc import Sequence

import bmesh
import bpy

from ...solver.errors import CmcError


def show(context: bpy.types.Context, ob: bpy.types.Object | None, error: CmcError) -> bool:
    """Make an object active and enter edit mode with exactly the elements of an error selected, in one undo step.

    Returns False and changes nothing if the error names no elements, or none of the object's own mesh.
    """
    if ob is None or not _can_show(context, ob, error):
        return False
    if context.mode != "OBJECT":
        bpy.ops.object.mode_set(mode="OBJECT")
    ob.hide_set(False)
    for other in context.selected_objects:
        other.select_set(False)
    ob.select_set(True)
    context.view_layer.objects.active = ob
    bpy.ops.object.mode_set(mode="EDIT")
    _select(context, ob.data, error)
    bpy.ops.ed.undo_push(message="Select Offending Elements")
    return True


def _can_show(context: bpy.types.Context, ob: bpy.types.Object, error: CmcError) -> bool:
    if ob.type != "MESH" or ob.name not in context.view_layer.objects or not (ob.is_editable and ob.data.is_editable):
        return False
    if ob.cmc.apply_modifiers and len(ob.modifiers):
        return False  # the indices belong to the mesh after its modifiers
    if context.mode not in {"OBJECT", "EDIT_MESH"}:
        return False
    if ob.data.is_editmode:
        ob.update_from_editmode()
    counted = ((error.vertices, ob.data.vertices), (error.edges, ob.data.edges), (error.faces, ob.data.polygons))
    if not any(len(indices) for indices, _ in counted):
        return False
    return all(0 <= index < len(elements) for indices, elements in counted for index in indices)


def _select(context: bpy.types.Context, mesh: bpy.types.Mesh, error: CmcError) -> None:
    tools = context.tool_settings
    tools.mesh_select_mode = (bool(len(error.vertices)), bool(len(error.edges)), bool(len(error.faces)))
    bpy.ops.mesh.reveal(select=False)
    bpy.ops.mesh.select_all(action="DESELECT")
    bm = bmesh.from_edit_mesh(mesh)
    for elements, indices in ((bm.verts, error.vertices), (bm.edges, error.edges), (bm.faces, error.faces)):
        _mark(elements, indices)
    bm.select_flush_mode()
    bmesh.update_edit_mesh(mesh, loop_triangles=False, destructive=False)


def _mark(elements, indices: Sequence[int]) -> None:
    elements.ensure_lookup_table()
    for index in indices:
        elements[index].select_set(True)
