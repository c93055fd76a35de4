"""Presets of boundary groups: for the active group, or for a new one from the selected edges."""

import bpy
import numpy as np
from bpy.props import EnumProperty

from ..bridges import edge_bridge
from ..bridges.mesh_bridge import read_plan
from ..properties import group_list
from ..properties.group_presets import PRESETS, GroupPreset, preset_items
from .boundary import GroupOperator, OnOneGroup, selected_boundary


class Preset:
    """Shows the preset's description as the tooltip."""

    @classmethod
    def description(cls, context, properties):
        return PRESETS[properties.preset].description


class CMC_OT_group_preset(Preset, OnOneGroup, bpy.types.Operator):
    """Give the active boundary group a common kind and angle, or the plane of a wall or floor"""

    bl_idname = "cmc.group_preset"
    bl_label = "Set Preset of Boundary Group"

    preset: EnumProperty(name="Preset", description="What the shell does along the group", items=preset_items())

    def act(self, context, mesh):
        apply(PRESETS[self.preset], context.object, self.chosen(mesh))


class CMC_OT_group_new(Preset, GroupOperator, bpy.types.Operator):
    """Put the selected boundary edges into a new group with a common kind and angle"""

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


def apply(preset: GroupPreset, plan: bpy.types.Object, group) -> None:
    """Give a group of a plan the kind and the parameters of a preset. Raises `CmcError` if the plan is not readable."""
    group.kind = preset.kind
    for name, value in preset.values.items():
        setattr(group, name, value)
    if preset.axis is not None:
        group.normal = outwards(plan, group.uid, preset.axis)


def outwards(plan: bpy.types.Object, uid: int, axis: tuple[float, float, float]) -> tuple[float, ...]:
    """The axis, or its opposite, whichever points out of the plan at the edges of a group; in the world."""
    mesh = read_plan(plan)
    edges = mesh.edges[(mesh.groups == uid) & mesh.boundary]
    if not len(edges):
        return axis
    rim = mesh.positions[edges].mean(axis=(0, 1))
    centre = 0.5 * (mesh.positions.min(axis=0) + mesh.positions.max(axis=0))
    sign = -1.0 if float(np.dot(rim - centre, axis)) < 0.0 else 1.0
    return tuple(sign * part + 0.0 for part in axis)
