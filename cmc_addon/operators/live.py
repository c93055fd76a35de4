"""Live: the switch of a plan whose shell follows (see the room `live`)."""

import bpy

from ..properties.links import plan_of
from .poll import allow, why_not_live


class CMC_OT_live(bpy.types.Operator):
    """Have the shell follow while you change the plan, its groups or the settings of Solve; click again to stop"""

    bl_idname = "cmc.live"
    bl_label = "Live"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        return allow(cls, why_not_live(context))

    def execute(self, context):
        plan = plan_of(context.object)
        plan.cmc.live = not plan.cmc.live
        return {"FINISHED"}


CLASSES = (CMC_OT_live,)
