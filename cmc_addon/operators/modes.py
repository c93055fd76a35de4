"""Count Unstable Modes; and the start of a plan: taken from its shell, or cleared."""

import bpy
import numpy as np

from ...solver.errors import CmcError
from ..bridges import start_bridge
from ..properties.libraries import why_not_kept
from ..properties.links import plan_of
from ..tasks.count_modes import CountTask
from ..tasks.shell_task import read_solve
from .poll import allow, why_not_object_mode, why_not_solve
from .solve import ShellOperator


class CMC_OT_count_modes(ShellOperator, bpy.types.Operator):
    """Count the ways in which the shell is unstable, as a saddle is; a minimum has none"""

    bl_idname = "cmc.count_modes"
    bl_label = "Count Unstable Modes"

    def read_task(self, context, plan):
        return CountTask.read(context, plan)


class OnStart:
    """An operator on the start of the active plan, or of the plan of the active result."""

    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        return allow(cls, why_not_object_mode(context) or why_not_solve(context))

    def execute(self, context):
        try:
            plan = plan_of(context.view_layer.objects.active)
            if reason := why_not_kept(plan.data):
                raise CmcError(f"{reason}.")
            if plan.data.is_editmode:  # while another object is active
                raise CmcError(f"The plan '{plan.name}' is in edit mode; leave it (Tab) first.")
            self.act(context, plan)
        except CmcError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        return {"FINISHED"}


class CMC_OT_start_from_shell(OnStart, bpy.types.Operator):
    """Keep the normals of the present shell with the plan: the next solves start from them"""

    bl_idname = "cmc.start_from_shell"
    bl_label = "Start from This Shell"

    def act(self, context, plan):
        _, known = read_solve(context, plan)
        if known is None:
            raise CmcError(f"'{plan.name}' has no shell, or was changed since it was made; solve first.")
        if plan.cmc.apply_modifiers and len(plan.modifiers):
            raise CmcError(f"The shell was solved with the modifiers of '{plan.name}'; apply them first.")
        surface = known.shell.surface
        first = np.unique(surface.source, return_index=True)[1]  # all copies of a vertex along a cut have its normal
        start_bridge.write_normals(plan.data, surface.normals[first])
        plan.data.update_tag()


class CMC_OT_start_clear(OnStart, bpy.types.Operator):
    """Remove the normals that solves of this plan start from, and its own edge lengths: the drawing counts again"""

    bl_idname = "cmc.start_clear"
    bl_label = "Clear Start"

    def act(self, context, plan):
        if not (start_bridge.has_start(plan.data) or start_bridge.has_lengths(plan.data)):
            raise CmcError(f"'{plan.name}' has no start and no edge lengths of its own.")
        start_bridge.clear_start(plan.data)
        plan.data.update_tag()


CLASSES = (CMC_OT_count_modes, CMC_OT_start_from_shell, CMC_OT_start_clear)
