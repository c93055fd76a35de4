"""The tab in every state it can be in: drawn without an error, and saying what to do next."""

from __future__ import annotations

import bpy


def tell(hands):
    yield from hands.picture("nothing")
    bpy.ops.curve.primitive_bezier_circle_add(radius=3)
    yield from hands.picture("curve")
    bpy.ops.cmc.mesh_plan()
    yield from hands.picture("plan")
    bpy.ops.cmc.group_add(name="South", tilt=0.5)
    bpy.ops.cmc.group_add(name="A group with a long name", kind="PLANE")
    bpy.ops.cmc.solve("EXEC_DEFAULT")
    yield from hands.picture("solved")
    bpy.ops.object.mode_set(mode="EDIT")
    yield from hands.picture("edit")
    bpy.ops.object.mode_set(mode="OBJECT")
    bpy.context.view_layer.objects.active = bpy.context.object.cmc.f_plus
    yield from hands.picture("result")
    bpy.ops.object.text_add()
    yield from hands.picture("text")
    bpy.ops.object.empty_add()
    yield from hands.picture("empty")
    bpy.ops.mesh.primitive_cube_add()
    yield from hands.picture("closed")
