"""A shell on lines, by hand: Other Edges on the line, a side that leans, H dragged through 0 with Live."""

from __future__ import annotations

import bpy
import numpy as np

from stories.live import at_rest, points


def plan():
    return bpy.data.objects["Rectangle"]


def look(hands, rotation=(0.82, 0.42, 0.17, 0.34)):
    """The plan and its shell in the middle of the view, from the south-east."""
    region = next(region for region in hands.area.regions if region.type == "WINDOW")
    with bpy.context.temp_override(window=hands.window, area=hands.area, region=region):
        hands.area.spaces.active.region_3d.view_rotation = rotation
        bpy.ops.view3d.view_all()
    yield 0.6


def side(inside):
    """Select the boundary edges whose middles are inside, in edit mode."""
    bpy.ops.object.mode_set(mode="OBJECT")
    mesh = plan().data
    faces = np.bincount([loop.edge_index for loop in mesh.loops], minlength=len(mesh.edges))
    for edge in mesh.edges:
        middle = sum((mesh.vertices[v].co for v in edge.vertices), start=mesh.vertices[0].co * 0) / 2
        edge.select = bool(faces[edge.index] == 1 and inside(middle))
    for vertex in mesh.vertices:
        vertex.select = False
    for polygon in mesh.polygons:
        polygon.select = False
    bpy.context.tool_settings.mesh_select_mode = (False, True, False)
    bpy.ops.object.mode_set(mode="EDIT")


def rectangle():
    """Add > Mesh > CMC > Rectangle, its edges in no group and on their line."""
    bpy.ops.cmc.add_plan(shape="RECTANGLE")
    bpy.ops.cmc.mesh_plan(edge_length=0.6)
    bpy.context.object.name = "Rectangle"
    bpy.ops.cmc.group_remove(all=True)
    plan().cmc.default_kind = "LINE"
    bpy.ops.ed.undo_push(message="Plan")


def tell(hands):
    rectangle()
    yield from look(hands)
    yield from hands.picture("on-the-line")
    yield from hands.click_button("cmc.solve")
    yield from hands.wait_for(lambda: plan().cmc.f_plus is not None, "the shell is there")
    yield from look(hands)
    yield from hands.picture("solved")
