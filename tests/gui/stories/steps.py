"""The sidebar step by step: presets, the context menu of edit mode, Export by its browser."""

from __future__ import annotations

import os
import subprocess

import bpy


def tell(hands):
    bpy.context.preferences.view.filebrowser_display_type = "SCREEN"
    bpy.ops.cmc.add_plan(shape="RECTANGLE")
    plan = bpy.context.object
    bpy.ops.ed.undo_push(message="Plan")
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.context.tool_settings.mesh_select_mode = (False, True, False)
    bpy.ops.mesh.select_all(action="DESELECT")
    bpy.ops.cmc.select_ungrouped()
    bpy.ops.cmc.group_add(name="Rim", kind="LINE", assign=True)
    yield from hands.picture("edit")
    yield from menu(hands, "VIEW3D_MT_edit_mesh_context_menu", "context-menu")
    yield from menu(hands, "CMC_MT_assign", "assign")
    yield from menu(hands, "CMC_MT_group_presets", "presets")
    yield from menu(hands, "CMC_MT_mesh", "mesh-menu")
    with bpy.context.temp_override(window=hands.window, area=hands.area, region=view(hands)):
        bpy.ops.wm.call_menu_pie("INVOKE_DEFAULT", name="CMC_MT_pie")
    yield 1.0
    yield from hands.picture("pie")
    yield from hands.press("ESC")
    bpy.ops.object.mode_set(mode="OBJECT")
    yield from menu(hands, "CMC_MT_object", "object-menu")
    yield from menu(hands, "CMC_MT_add", "add-menu")

    yield from hands.click_button("cmc.solve")
    yield from hands.wait_for(lambda: plan.cmc.f_plus is not None, "the shell is there")
    yield 1.0
    yield from hands.picture("solved")
    yield from hands.panel("Export")
    yield from hands.picture("export")
    with bpy.context.temp_override(window=hands.window, area=hands.area, region=view(hands)):
        bpy.ops.cmc.export("INVOKE_DEFAULT")  # as File > Export does it; to look for the button takes minutes
    yield 1.5
    snap(hands, "browser")
    yield from hands.press("RET", (640, 450))
    home = os.path.expanduser("~")
    for name in ("Rectangle shell.glb", "Rectangle shell.json"):
        yield from hands.wait_for(lambda name=name: name in os.listdir(home), f"{name} is written")
    yield from hands.picture("exported")


def snap(hands, name):
    """A picture where there is no viewport to redraw."""
    hands.shots += 1
    file = f"/pictures/{hands.story}-{hands.shots:02d}-{name}.png"
    subprocess.run(["import", "-window", "root", file], check=True)


def view(hands):
    return next(region for region in hands.area.regions if region.type == "WINDOW")


def menu(hands, name, label):
    x, y = hands.view
    hands.move(x + 300, y + 500)
    yield 0.2
    with bpy.context.temp_override(window=hands.window, area=hands.area, region=view(hands)):
        bpy.ops.wm.call_menu("INVOKE_DEFAULT", name=name)
    yield from hands.picture(label)
    yield from hands.press("ESC")
    yield from hands.press("ESC")
