"""Presets for boundary groups: for the active one, or a new one of the selected edges."""

import bpy
from bpy.props import EnumProperty

from ..bridges import edge_bridge
from ..plans.group_presets import PRESETS, apply, preset_items
from ..stored import group_list
from .boundary import GroupOperator, OnOneGroup, selected_boundary


class Preset:
    """The preset's own words are the tooltip."""

    @classmethod
    def description(cls, context, properties):
        return PRESETS[properties.preset].description


class CMC_OT_group_preset(Preset, OnOneGroup, bpy.types.Operator):
    """Give the active boundary group a usual kind and angle, or the plane of a wall or the floor"""

    bl_idname = "cmc.group_preset"
    bl_label = "Set Preset of Boundary Group"

    preset: EnumProperty(name="Preset", description="What the shell does along the group", items=preset_items())

    def act(self, context, mesh):
        apply(PRESETS[self.preset], context.object, self.chosen(mesh))


class CMC_OT_group_new(Preset, GroupOperator, bpy.types.Operator):
    """Put the selected boundary edges into a new group of a usual kind and angle"""

    bl_idname = "cmc.group_new"
    bl_label = "New Boundary Group from Preset"
    needs_group = False

    preset: EnumProperty(name="Preset", description="What the shell does along the group", items=preset_items())

    def act(self, context, mesh):
        edges = selected_boundary(self, mesh)
        group = group_list.add(mesh, PRESETS[self.preset].label)
        edge_bridge.write_groups(mesh, edges, group.uid)
        apply(PRESETS[self.preset], context.object, group)


CLASSES = (CMC_OT_group_preset, CMC_OT_group_new)
