"""The overlay in a window: normals, tangent planes, edges in no group, mirrors, a cut and its gap."""

from __future__ import annotations

import sys

import bmesh
import bpy
import numpy as np

# From the south-east, and from the north-east into the corner of the walls.
FROM_OUTSIDE, FROM_INSIDE = (0.86, 0.31, 0.13, 0.37), (0.36, 0.17, 0.39, 0.83)


def drawing():
    """The drawing of the installed extension."""
    return _module("drawing.overlay_draw").Drawing


def seen(hands):
    """All that is drawn now."""
    parts = _module("drawing.overlay").frame(bpy.context, hands.area.spaces.active)
    return [layer for part in parts for layer in part.layers]


def _module(last):
    return next(module for name, module in sys.modules.items() if name.endswith(f"cmc_addon.{last}"))


def look(hands, rotation=FROM_OUTSIDE):
    """Everything that is selected in the middle of the view."""
    region = next(region for region in hands.area.regions if region.type == "WINDOW")
    with bpy.context.temp_override(window=hands.window, area=hands.area, region=region):
        hands.area.spaces.active.region_3d.view_rotation = rotation
        bpy.ops.view3d.view_selected()
    yield 0.6


def hall():
    """An oblong plan whose sides are in three groups and one in none."""
    mesh = bpy.data.meshes.new("Hall")
    mesh.from_pydata([(-6, -3, 0), (6, -3, 0), (6, 3, 0), (-6, 3, 0)], [], [(0, 1, 2, 3)])
    ob = bpy.data.objects.new("Hall", mesh)
    bpy.context.collection.objects.link(ob)
    bpy.context.view_layer.objects.active = ob
    ob.select_set(True)
    bpy.ops.cmc.mesh_plan(edge_length=0.35)
    plan = bpy.context.object
    for name, tilt, inside in (
        ("Long sides", 0.0, lambda x, y: abs(y) > 2.99),
        ("Gate", np.radians(45), lambda x, y: x > 5.99),
    ):
        assign(plan, name, inside, tilt=tilt)
    return plan


def assign(plan, name, inside, **parameters):
    """A group of the boundary edges whose middles are inside."""
    mesh = plan.data
    group = mesh.cmc.groups.add()
    group.name, group.uid = name, mesh.cmc.next_uid
    mesh.cmc.next_uid += 1
    for key, value in parameters.items():
        setattr(group, key, value)
    attribute = mesh.attributes.get("cmc_group") or mesh.attributes.new("cmc_group", "INT", "EDGE")
    for edge in mesh.edges:
        x, y = (sum(mesh.vertices[v].co[k] for v in edge.vertices) / 2 for k in range(2))
        if inside(x, y):
            attribute.data[edge.index].value = group.uid
    mesh.update()
    return group


def select_only(ob):
    for other in bpy.context.selected_objects:
        other.select_set(False)
    ob.select_set(True)
    bpy.context.view_layer.objects.active = ob


def clear():
    for ob in list(bpy.data.objects):
        bpy.data.objects.remove(ob)


def tell(hands):
    settings, view = bpy.context.scene.cmc, hands.area.spaces.active
    sky = bpy.context.preferences.themes[0].view_3d.space.gradients
    plan = hall()
    yield from look(hands)
    yield from hands.picture("normals")
    settings.show_tangents = True
    yield from hands.picture("tangent-planes")
    settings.show_tangents, dark = False, tuple(sky.high_gradient)
    sky.high_gradient = (0.9, 0.9, 0.9)
    yield from hands.picture("light")
    sky.high_gradient = dark

    yield from hands.press("TAB")
    yield from hands.press("TWO")
    for edge in bmesh.from_edit_mesh(plan.data).edges:
        edge.select_set(edge.is_boundary and edge.verts[0].co.x > 2)
    bmesh.update_edit_mesh(plan.data)
    yield from hands.picture("edited")
    bpy.ops.transform.translate(value=(3, 0, 1))
    yield from hands.picture("moved")
    bpy.ops.transform.translate(value=(-3, 0, -1))
    yield from hands.press("TAB")

    plan.cmc.blend = 6.0
    bpy.ops.cmc.solve()
    yield from look(hands)
    yield from hands.picture("solved")
    view.shading.show_xray = True
    yield from hands.picture("x-ray")
    view.shading.show_xray = False

    yield from mirrors(hands, settings)
    yield from court(hands)
    yield from popover(hands)
    assert drawing().reported == "", drawing().reported
    assert drawing().handle is not None and 0 < len(drawing().batches) < 200


def mirrors(hands, settings):
    """A corner between two walls, before and after the solve."""
    clear()
    plan = square()
    settings.show_mirrors = True
    yield from look(hands, FROM_INSIDE)
    yield from hands.picture("mirrors")
    bpy.ops.cmc.solve()
    select_only(plan.cmc.f_plus)
    yield from look(hands, FROM_INSIDE)
    yield from hands.picture("mirrors-solved")
    settings.show_mirrors = False


def court(hands):
    """A shell that does not close: its gap and its cut, on the shell and on the plan."""
    clear()
    bpy.ops.cmc.add_plan(shape="ANNULUS", columns=96)
    plan = bpy.context.object
    bpy.ops.cmc.solve()
    for ob in bpy.context.view_layer.objects:
        ob.select_set(True)
    yield from look(hands)
    yield from hands.picture("cut-and-gap")
    plan.cmc.f_plus.hide_set(True)
    select_only(plan)
    yield from hands.picture("cut-on-the-plan")
    plan.hide_set(True)
    yield from hands.picture("hidden")
    assert not seen(hands)
    plan.hide_set(False)
    bpy.ops.mesh.primitive_cube_add()
    local_view(hands)
    bpy.context.view_layer.objects.active = plan
    yield 0.5
    assert not seen(hands), "only the cube is viewed"
    local_view(hands)
    yield 0.5
    assert seen(hands)


def local_view(hands):
    """View only what is selected, or everything again."""
    region = next(region for region in hands.area.regions if region.type == "WINDOW")
    with bpy.context.temp_override(window=hands.window, area=hands.area, region=region):
        bpy.ops.view3d.localview()


def popover(hands):
    """Blender's own popover of overlays has our switches."""
    area = hands.area
    region = next(region for region in area.regions if region.type == "WINDOW")
    hands.move(area.x + 500, area.y + area.height // 2)
    yield 0.2
    with bpy.context.temp_override(window=hands.window, area=area, region=region):
        bpy.ops.wm.call_panel(name="VIEW3D_PT_overlay", keep_open=True)
    yield 0.5
    yield from hands.picture("popover")


def square():
    """A quarter of a court: two sides are walls, the others stand on the ground."""
    count, size = 13, 6.0
    ticks = np.linspace(0.0, size, count)
    points = [(x, y, 0.0) for y in ticks for x in ticks]
    faces = [
        (r * count + c, r * count + c + 1, (r + 1) * count + c + 1, (r + 1) * count + c)
        for r in range(count - 1) for c in range(count - 1)
    ]
    mesh = bpy.data.meshes.new("Corner")
    mesh.from_pydata(points, [], faces)
    ob = bpy.data.objects.new("Corner", mesh)
    bpy.context.collection.objects.link(ob)
    select_only(ob)
    assign(ob, "Wall", lambda x, y: x < 1e-4, kind="MIRROR", normal=(-1, 0, 0))
    assign(ob, "Other wall", lambda x, y: y < 1e-4, kind="MIRROR", normal=(0, -1, 0))
    assign(ob, "Ground", lambda x, y: x > size - 1e-4 or y > size - 1e-4, tilt=0.2)
    return ob
