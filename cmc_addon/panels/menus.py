"""Menus: "CMC" in the Object and Mesh menus, where F3 finds every operator; "Assign to Boundary Group" in the context
menu and the Edge menu of edit mode; presets of boundary groups; Export in File > Export; and a pie menu.

The pie has no key by default: in Preferences > Keymap add `wm.call_menu_pie` with the name CMC_MT_pie.
"""

import bpy

from ..drawing.palette import icon_of
from ..properties.group_presets import PRESETS
from ..properties.links import plan_to_solve
from ..properties.registration import registration


class CMC_MT_group_presets(bpy.types.Menu):
    bl_idname = "CMC_MT_group_presets"
    bl_label = "Boundary Group Presets"

    def draw(self, context):
        for name, preset in PRESETS.items():
            self.layout.operator("cmc.group_preset", text=preset.label, icon=preset.icon).preset = name
        self.layout.separator()
        self.layout.operator("cmc.rim_free", icon="MOD_WAVE")


class CMC_MT_assign(bpy.types.Menu):
    bl_idname = "CMC_MT_assign"
    bl_label = "Assign to Boundary Group"

    def draw(self, context):
        layout, mesh = self.layout, context.object.data
        for group in mesh.cmc.groups:
            layout.operator("cmc.group_assign", text=group.name, icon=icon_of(group.uid)).group = group.name
        if mesh.cmc.groups:
            layout.separator()
        layout.operator("cmc.group_add", text="New Group", icon="ADD").assign = True
        for name, preset in PRESETS.items():
            layout.operator("cmc.group_new", text=f"New: {preset.label}", icon=preset.icon).preset = name
        layout.separator()
        layout.operator("cmc.group_remove_from", text="Remove from All Groups", icon="X").all = True


class CMC_MT_object(bpy.types.Menu):
    """All steps, in the order of the work"""

    bl_idname = "CMC_MT_object"
    bl_label = "CMC"

    def draw(self, context):
        layout = self.layout
        layout.operator("cmc.mesh_plan")
        layout.operator("cmc.weld")
        layout.separator()
        for name in ("cmc.solve", "cmc.live", "cmc.flip", "cmc.approximate_surface"):
            layout.operator(name)
        layout.separator()
        for name in ("cmc.complete", "cmc.tile_periods", "cmc.update_all"):
            layout.operator(name)
        layout.separator()
        for name in ("cmc.gauss_image", "cmc.count_modes", "cmc.start_from_shell", "cmc.start_clear"):
            layout.operator(name)
        layout.separator()
        for which in ("OUTLINE", "PLAN", "SHELL"):
            layout.operator("cmc.go_to", text=f"Go to {which.capitalize()}").target = which
        layout.separator()
        layout.operator("cmc.export", text="Export Shell…")


class CMC_MT_mesh(bpy.types.Menu):
    """Actions on the edges of a plan"""

    bl_idname = "CMC_MT_mesh"
    bl_label = "CMC"

    def draw(self, context):
        layout = self.layout
        layout.menu("CMC_MT_assign")
        layout.operator("cmc.group_assign", text="Assign to Active Boundary Group")
        for name in ("cmc.group_remove_from", "cmc.group_select", "cmc.group_deselect", "cmc.select_ungrouped"):
            layout.operator(name)
        layout.menu("CMC_MT_group_presets")
        layout.operator("cmc.rim_free")
        layout.separator()
        for name in ("cmc.solve", "cmc.solve_selection", "cmc.flip", "cmc.mesh_plan", "cmc.weld"):
            layout.operator(name)


class CMC_MT_pie(bpy.types.Menu):
    """The most used actions, around the mouse"""

    bl_idname = "CMC_MT_pie"
    bl_label = "CMC"

    def draw(self, context):
        pie = self.layout.menu_pie()
        editing = context.mode == "EDIT_MESH"
        pie.operator("cmc.group_assign" if editing else "cmc.mesh_plan")
        pie.operator("cmc.solve_selection" if editing else "cmc.complete")
        pie.operator("cmc.solve")
        pie.operator("cmc.flip")
        if not editing:
            return
        pie.operator("cmc.group_add", text="New Group from Selection").assign = True
        pie.operator("cmc.select_ungrouped")
        pie.operator("cmc.group_select")
        pie.operator("cmc.group_remove_from")


def _in_object_menu(menu: bpy.types.Menu, context: bpy.types.Context) -> None:
    menu.layout.separator()
    menu.layout.menu("CMC_MT_object")


def _in_mesh_menu(menu: bpy.types.Menu, context: bpy.types.Context) -> None:
    menu.layout.separator()
    menu.layout.menu("CMC_MT_mesh")


def _in_edge_menu(menu: bpy.types.Menu, context: bpy.types.Context) -> None:
    if plan_to_solve(context) == context.object:
        menu.layout.separator()
        menu.layout.menu("CMC_MT_assign", icon="MESH_GRID")


def _in_export_menu(menu: bpy.types.Menu, context: bpy.types.Context) -> None:
    menu.layout.operator("cmc.export", text="CMC Shell (.glb/.obj/.ply/.stl)")


CLASSES = (CMC_MT_group_presets, CMC_MT_assign, CMC_MT_object, CMC_MT_mesh, CMC_MT_pie)
PLACES = {
    "VIEW3D_MT_object": _in_object_menu,
    "VIEW3D_MT_edit_mesh": _in_mesh_menu,
    "VIEW3D_MT_edit_mesh_context_menu": _in_edge_menu,
    "VIEW3D_MT_edit_mesh_edges": _in_edge_menu,
    "TOPBAR_MT_file_export": _in_export_menu,
}
"""Blender's menu → our entries at its end."""
_register, _unregister = registration(CLASSES)


def register() -> None:
    _register()
    for name, draw in PLACES.items():
        getattr(bpy.types, name).append(draw)


def unregister() -> None:
    for name, draw in PLACES.items():
        getattr(bpy.types, name).remove(draw)
    _unregister()
