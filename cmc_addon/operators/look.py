"""Normals on a Sphere: show the Gauss image beside the shell or hide it."""

import bpy

from ...solver.errors import CmcError
from ..properties.links import plan_of, result_of
from ..results import gauss_image


class CMC_OT_gauss_image(bpy.types.Operator):
    """Show the normals of the shell as points of a sphere beside it, in its colours; click again to hide them"""

    bl_idname = "cmc.gauss_image"
    bl_label = "Normals on a Sphere"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        try:
            plan = plan_of(context.object)
        except CmcError as error:
            cls.poll_message_set(str(error))
            return False
        if not plan.is_editable or result_of(plan, plan.cmc.sheet) is None:
            cls.poll_message_set(f"'{plan.name}' has no shell yet: Solve makes it.")
            return False
        return True

    def execute(self, context: bpy.types.Context) -> set[str]:
        try:
            plan = plan_of(context.object)
            if gauss_image.is_shown(plan):
                gauss_image.hide(plan)
            else:
                gauss_image.show(context, plan)
        except CmcError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        return {"FINISHED"}


CLASSES = (CMC_OT_gauss_image,)
