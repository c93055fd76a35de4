"""Sides: the list of boundary groups, handled like Blender's vertex groups, and what the shell does along each."""

import math

import bpy

from ...solver.gauss.conditions import KINDS
from ..bridges.mesh_cache import boundary_counts
from ..bridges.start_bridge import has_start
from ..drawing.palette import icon_of
from ..properties import group_list
from ..properties.group_settings import kind_parameters
from ..properties.libraries import keeps_changes
from ..properties.links import plan_to_solve
from ..properties.registration import registration
from .symmetry_panel import draw_group
from .tab import Tab, hint, properties_column


class CMC_UL_groups(bpy.types.UIList):
    """Boundary groups: their names, renamed by a double click, and their conditions"""

    def draw_item(self, context, layout, data, item, icon, active_data, active_property, index=0, flag=0):
        split = layout.split(factor=0.72)
        split.prop(item, "name", text="", emboss=False, icon=icon_of(item.uid))
        row = split.row()
        row.alignment = "RIGHT"
        row.label(text=summary(item))


def summary(group) -> str:
    """The kind in one word, or its angle."""
    for parameter in KINDS[group.kind.lower()].parameters:
        if parameter.unit == "radians":
            return f"{math.degrees(getattr(group, parameter.name)):.4g}°"
    return KINDS[group.kind.lower()].label.split()[-1].capitalize()


class CMC_MT_groups(bpy.types.Menu):
    bl_idname = "CMC_MT_groups"
    bl_label = "Boundary Group Specials"

    def draw(self, context):
        layout = self.layout
        layout.operator("cmc.group_add", text="New Group from Selection", icon="ADD").assign = True
        layout.operator("cmc.select_ungrouped", text="Select Edges in No Group")
        layout.separator()
        layout.operator("cmc.group_remove_from", text="Remove Selected from All Groups").all = True
        layout.operator("cmc.group_remove", text="Remove All Groups", icon="X").all = True


class CMC_PT_boundary(Tab, bpy.types.Panel):
    bl_idname = "CMC_PT_boundary"
    bl_label = "Sides"
    bl_order = 1

    @classmethod
    def poll(cls, context):
        return plan_to_solve(context) is not None

    def draw_header_preset(self, context):
        self.layout.prop(context.scene.cmc, "show_groups", text="", icon="OVERLAY")

    def draw(self, context):
        layout, plan = self.layout, plan_to_solve(context)
        if plan is None:
            return
        mesh = plan.data
        own = plan == context.object
        self._list(layout, mesh, own)
        if mesh.is_editmode and mesh.cmc.groups:
            self._membership(layout)
        group = group_list.active(mesh)
        if group is not None:
            self._parameters(layout, mesh, group)
            draw_group(layout, context, mesh, group)
        if own:
            self._ungrouped(layout, plan, mesh)

    def _list(self, layout, mesh, own):
        """The list; with a result active the groups of its plan, to edit but not to add or remove."""
        cmc = mesh.cmc
        row = layout.row()
        row.template_list("CMC_UL_groups", "", cmc, "groups", cmc, "active_index", rows=4)
        if not own:
            return
        side = row.column(align=True)
        side.operator("cmc.group_add", text="", icon="ADD")
        side.operator("cmc.group_remove", text="", icon="REMOVE")
        side.separator()
        side.menu("CMC_MT_groups", text="", icon="DOWNARROW_HLT")
        if len(cmc.groups) > 1:
            side.separator()
            side.operator("cmc.group_move", text="", icon="TRIA_UP").direction = "UP"
            side.operator("cmc.group_move", text="", icon="TRIA_DOWN").direction = "DOWN"

    def _parameters(self, layout, mesh, group):
        column = properties_column(layout)
        column.enabled = keeps_changes(mesh)
        row = column.row(align=True)
        row.prop(group, "kind", text="Side")
        row.menu("CMC_MT_group_presets", text="", icon="PRESET")
        if KINDS[group.kind.lower()].curve:
            column.prop(group, "curve")
        for name in kind_parameters(group.kind):
            if isinstance(getattr(group, name), float):
                column.prop(group, name)
                continue
            label = group.bl_rna.properties[name].name
            numbers = column.column(align=True)
            for k, axis in enumerate("XYZ"):
                numbers.prop(group, name, index=k, text=f"{label} {axis}" if k == 0 else axis)

    def _membership(self, layout):
        row = layout.row()
        pair = row.row(align=True)
        pair.operator("cmc.group_assign", text="Assign")
        pair.operator("cmc.group_remove_from", text="Remove")
        pair = row.row(align=True)
        pair.operator("cmc.group_select", text="Select")
        pair.operator("cmc.group_deselect", text="Deselect")

    def _ungrouped(self, layout, plan, mesh):
        boundary, ungrouped = boundary_counts(mesh)
        if not boundary and has_start(mesh):
            hint(layout, "This mesh is closed: its start map", "selects the shell")
        elif not boundary:
            hint(layout, "This mesh has no boundary:", "delete the faces beyond its rim")
        elif ungrouped:
            column = properties_column(layout)
            column.enabled = keeps_changes(plan)
            row = column.row(align=True)
            row.prop(plan.cmc, "default_kind", text="Other Edges" if mesh.cmc.groups else "All Edges")
            if not mesh.cmc.groups:
                row.operator("cmc.rim_free", text="", icon="MOD_WAVE")
            if mesh.cmc.groups:
                row.operator("cmc.select_ungrouped", text="", icon="RESTRICT_SELECT_OFF")


CLASSES = (CMC_UL_groups, CMC_MT_groups, CMC_PT_boundary)
register, unregister = registration(CLASSES)
