"""Weld: join the parts of a plan that only touch, so that they are one plan."""

import bpy

from ...solver.errors import CmcError
from ..bridges.mesh_cache import contacts
from ..bridges.weld_bridge import weld
from ..properties.libraries import why_not_kept
from .poll import RUNNING, allow


def why_not_weld(context: bpy.types.Context) -> str:
    """Why there is nothing to weld; "" where there is."""
    ob = context.object
    if context.window_manager.cmc.running:
        return RUNNING
    if ob is None or ob.type != "MESH" or ob.cmc.role != "NONE":
        return "Select a plan, or an outline that is a mesh"
    if reason := why_not_kept(ob.data):
        return reason
    return "" if contacts(ob.data) else f"The parts of '{ob.name}' are joined wherever they touch"


class CMC_OT_weld(bpy.types.Operator):
    """Join parts that only touch: merge the vertices that coincide, and split edges where the vertices of another part
    lie inside them"""

    bl_idname = "cmc.weld"
    bl_label = "Weld"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        return allow(cls, why_not_weld(context))

    def execute(self, context):
        ob = context.object
        try:
            count = weld(ob.data)
        except CmcError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        self.report({"INFO"}, f"{count} vertices of '{ob.name}' were joined to those of other parts.")
        return {"FINISHED"}


CLASSES = (CMC_OT_weld,)
