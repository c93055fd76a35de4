"""The tab in every state: drawn without an error, with a hint on the next step."""

from __future__ import annotations

import bpy


def tell(hands):
    yield from hands.picture("nothing")
    bpy.ops.curve.primitive_bezier_circle_add(radius=3)
    yield from hands.picture("curve")
    bpy.ops.cmc.mesh_plan()
    yield from hands.picture("plan")
    select_side(-1)
    bpy.ops.cmc.group_add(name="South", assign=True)
    select_side(1)
    bpy.ops.cmc.group_add(name="A group with a long name", assign=True)
    bpy.ops.cmc.group_add(name="Nowhere", kind="PLANE")
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


def select_side(sign) -> None:
    """Select the quarter of the rim on that side, in object mode."""
    bpy.ops.cmc.select_ungrouped()
    mesh = bpy.context.object.data
    for edge in mesh.edges:
        points = [mesh.vertices[k].co for k in edge.vertices]
        edge.select = edge.select and all(sign * p.y > 2.1 for p in points)
