"""Errors by hand: a popup with one sentence, the named elements selected; Esc while a plan is meshed, and the text
in the status bar."""

from __future__ import annotations

import bmesh
import bpy


def tell(hands):
    bpy.ops.cmc.add_plan(shape="RECTANGLE", columns=12)
    plan = bpy.context.object
    fin = add_fin(plan)
    bpy.ops.ed.undo_push(message="Fin")
    yield from hands.click_button("cmc.solve")
    yield from hands.wait_for(lambda: bpy.context.mode == "EDIT_MESH", "the named edge is shown")
    yield from hands.picture("popup")
    bm = bmesh.from_edit_mesh(plan.data)
    assert [tuple(sorted(v.index for v in edge.verts)) for edge in bm.edges if edge.select] == [fin]
    yield from hands.press("ESC")
    yield from hands.picture("selected")
    bpy.ops.object.mode_set(mode="OBJECT")
    bpy.data.objects.remove(plan)

    bpy.ops.mesh.primitive_circle_add(vertices=64, radius=5, fill_type="NGON")
    bpy.context.scene.cmc.edge_length = 0.04
    bpy.ops.ed.undo_push(message="Outline")
    yield from hands.click_button("cmc.mesh_plan")
    yield from hands.wait_for(lambda: bpy.context.window_manager.cmc.running, "it is being meshed")
    yield from hands.picture("meshing")
    yield from hands.press("ESC")
    yield from hands.wait_for(lambda: not bpy.context.window_manager.cmc.running, "Esc has stopped it")
    assert len(bpy.data.objects) == 1
    yield from hands.picture("cancelled")


def add_fin(plan) -> tuple[int, int]:
    """A third face on an edge inside; the edge's vertices."""
    bm = bmesh.new()
    bm.from_mesh(plan.data)
    edge = next(edge for edge in bm.edges if len(edge.link_faces) == 2 and edge.calc_length() > 0.1)
    pair = tuple(sorted(v.index for v in edge.verts))
    top = bm.verts.new(edge.verts[0].co.lerp(edge.verts[1].co, 0.5))
    top.co.z += 1.0
    bm.faces.new((edge.verts[0], edge.verts[1], top))
    bm.to_mesh(plan.data)
    bm.free()
    return pair
