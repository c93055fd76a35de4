"""Presets of boundary groups: for the active group, for a new one from the selected edges, and for all sides."""

import bpy
import numpy as np
from bpy.props import EnumProperty

from ...solver.surface.placement import FREE_SIZES
from ..bridges import edge_bridge
from ..bridges.mesh_bridge import plan_arrays, readable_mesh
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
        group, preset = self.chosen(mesh), PRESETS[self.preset]
        edges = np.flatnonzero(edge_bridge.read_edges(mesh).group == group.uid)
        apply(preset, group, plane_normal(preset, context.object, edges))


class CMC_OT_group_new(Preset, GroupOperator, bpy.types.Operator):
    """Put the selected boundary edges into a new group with a common kind and angle"""

    bl_idname = "cmc.group_new"
    bl_label = "New Boundary Group from Preset"
    needs_group = False

    preset: EnumProperty(name="Preset", description="What the shell does along the group", items=preset_items())

    def act(self, context, mesh):
        edges, preset = selected_boundary(self, mesh), PRESETS[self.preset]
        normal = plane_normal(preset, context.object, edges)
        group = group_list.add(mesh, preset.label)
        edge_bridge.write_groups(mesh, edges, group.uid)
        apply(preset, group, normal)


class CMC_OT_rim_free(GroupOperator, bpy.types.Operator):
    """Let the rim be free all around: sides on lines stand upright, leaning ones keep their angle"""

    bl_idname = "cmc.rim_free"
    bl_label = "Rim Free All Around"
    needs_group = False

    def act(self, context, mesh):
        settings = context.object.cmc
        settings.default_kind = "BINORMAL"
        if settings.size.lower() not in FREE_SIZES:
            settings.size = "MATCH_PLAN"
        for group in mesh.cmc.groups:
            if group.kind in ("LINE", "LEAN"):
                group.tilt = group.angle if group.kind == "LEAN" else 0.0
                group.kind = "BINORMAL"


CLASSES = (CMC_OT_group_preset, CMC_OT_group_new, CMC_OT_rim_free)


def apply(preset: GroupPreset, group, normal: tuple[float, ...] | None) -> None:
    """Give a group the kind and the parameters of a preset, and the normal of its plane where it has one."""
    group.kind = preset.kind
    for name, value in preset.values.items():
        setattr(group, name, value)
    if normal is not None:
        group.normal = normal


def plane_normal(preset: GroupPreset, plan: bpy.types.Object, edges: np.ndarray) -> tuple[float, ...] | None:
    """The axis of a preset or its opposite, whichever points out of the plan at these edges (indices); in the world."""
    axis = preset.axis
    if axis is None or not len(edges):
        return axis
    with readable_mesh(plan) as mesh:  # also an outline without faces
        drawn = plan_arrays(mesh, np.array(plan.matrix_world))
    rim = drawn.positions[drawn.edges[edges]].mean(axis=(0, 1))
    centre = 0.5 * (drawn.positions.min(axis=0) + drawn.positions.max(axis=0))
    sign = -1.0 if float(np.dot(rim - centre, axis)) < 0.0 else 1.0
    return tuple(sign * part + 0.0 for part in axis)
