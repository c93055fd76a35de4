"""Repeat by Symmetry; and on the plan the planes of its mirrors and the corners between two of them.

Repeat by Symmetry runs as Solve does, see `solve`.
"""

from types import SimpleNamespace

import bpy
import numpy as np
from bpy.props import EnumProperty, IntProperty

from ...solver.errors import CmcError, ConditionError
from ...solver.shells.plan_sides import own_plane
from ..background import plan_cache
from ..bridges import corner_bridge
from ..bridges.mesh_bridge import read_plan
from ..properties.symmetry_settings import COMPLETE_SETTINGS, complete_annotations, draw_complete
from ..tasks.complete import CompleteTask
from .boundary import GroupOperator, OnOneGroup
from .poll import allow, why_not_object_mode, why_not_solve
from .solve import ShellOperator, as_settings


class CMC_OT_complete(ShellOperator, bpy.types.Operator):
    """Continue the shell across its mirrors and the planes it touches, with as many copies as you want"""

    bl_idname = "cmc.complete"
    bl_label = "Repeat by Symmetry"
    __annotations__ = complete_annotations({"SKIP_SAVE"})

    @classmethod
    def poll(cls, context):
        return allow(cls, why_not_object_mode(context) or why_not_solve(context))

    def read_task(self, context, plan):
        return CompleteTask.read(context, plan, self._wanted(plan))

    def _wanted(self, plan: bpy.types.Object) -> SimpleNamespace:
        """The settings of the call; those that it leaves out are the plan's own.

        A number, a box or a repetition without an extent chooses the extent.
        """
        given = {name for name in (*COMPLETE_SETTINGS, "box") if self.properties.is_property_set(name)}
        for name in set(COMPLETE_SETTINGS) - given:
            setattr(self, name, getattr(plan.cmc, name))
        if "box" not in given:
            self.box = plan.cmc.complete_box.name if plan.cmc.complete_box is not None else ""
        for name, extent in (("complete_repeat", "UNIT"), ("complete_count", "COUNT"), ("box", "BOX")):
            if name in given and "complete_extent" not in given:
                self.complete_extent = extent
        return SimpleNamespace(**{name: getattr(self, name) for name in (*COMPLETE_SETTINGS, "box")})

    def draw(self, context):
        as_settings(self.layout)
        draw_complete(self.layout, self)


_AXES = {"X": (1.0, 0.0, 0.0), "Y": (0.0, 1.0, 0.0), "Z": (0.0, 0.0, 1.0)}


class CMC_OT_group_plane(OnOneGroup, bpy.types.Operator):
    """Set the normal of the plane of the active group"""

    bl_idname = "cmc.group_plane"
    bl_label = "Plane of Boundary Group"

    plane: EnumProperty(
        name="Plane",
        description="How the plane lies",
        items=[
            ("X", "X", "The plane is square to the X axis"),
            ("Y", "Y", "The plane is square to the Y axis"),
            ("Z", "Z", "The plane is level"),
            ("EDGES", "From Edges", "The plane of the group's own edges; if they are straight, the plane through "
             "them square to the plan. Its normal points out of the plan"),
            ("FLIP", "Flip", "Reverse the normal. It usually points out of the shell; the normals of two mirrors "
             "decide which way the shell faces at their corner"),
        ],
    )

    @classmethod
    def description(cls, context, properties):
        return properties.bl_rna.properties["plane"].enum_items[properties.plane].description

    def act(self, context, mesh):
        group = self.chosen(mesh)
        if group.kind not in ("MIRROR", "PLANE"):
            raise ConditionError(f"Group {group.name!r} has no plane; make it a mirror or a constant plane first.")
        if self.plane == "FLIP":
            group.normal = [-part for part in group.normal]
        elif self.plane == "EDGES":
            group.normal = edge_plane(context.object, group)
        else:
            group.normal = _AXES[self.plane]


def edge_plane(plan: bpy.types.Object, group) -> list[float]:
    """The normal of the plane of a group's edges, in the world. Raises `CmcError` where they lie in none."""
    mesh = read_plan(plan)
    edges = mesh.edges[(mesh.groups == group.uid) & mesh.boundary]
    if not len(edges):
        raise ConditionError(f"Group {group.name!r} has no edges on the boundary; assign some first.")
    normal = own_plane(plan_cache.prepare(mesh).solver.domain, mesh.positions, edges)
    return np.where(np.abs(normal) < 1e-7, 0.0, normal).tolist()


class CMC_OT_flip_corner(GroupOperator, bpy.types.Operator):
    """Let the shell face the other way at this corner between two mirrors"""

    bl_idname = "cmc.flip_corner"
    bl_label = "Flip Corner"

    vertex: IntProperty(name="Vertex", description="Where the two mirrors meet", min=0, options={"SKIP_SAVE"})

    def act(self, context, mesh):
        known = [corner.vertex for corner in corner_bridge.corners(mesh)]
        if self.vertex not in known:
            listed = ", ".join(map(str, known)) or "none"
            raise CmcError(f"No two mirrors meet at vertex {self.vertex}; the corners between mirrors are {listed}.")
        corner_bridge.flip(mesh, self.vertex)


CLASSES = (CMC_OT_complete, CMC_OT_group_plane, CMC_OT_flip_corner)
