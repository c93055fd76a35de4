"""Export: write the shell to a file."""

import bpy

from ...solver.errors import CmcError
from ..properties.export_settings import draw_export
from ..properties.libraries import keeps_changes
from ..properties.links import is_orphan, plan_to_solve
from ..properties.registration import registration
from ..tasks.export import wanted_objects
from .tab import TALL, Tab, hint, properties_column


class CMC_PT_export(Tab, bpy.types.Panel):
    bl_idname = "CMC_PT_export"
    bl_label = "Export"
    bl_options = {"DEFAULT_CLOSED"}
    bl_order = 60

    @classmethod
    def poll(cls, context):
        return plan_to_solve(context) is not None or is_orphan(context.object)

    def draw(self, context):
        layout, plan = self.layout, plan_to_solve(context) or context.object
        if plan is None:
            return
        column = properties_column(layout)
        column.enabled = keeps_changes(plan)
        draw_export(column, plan.cmc)
        row = layout.row()
        row.scale_y = TALL
        try:
            objects = wanted_objects(context, plan, plan.cmc.export_what)
        except CmcError as error:
            hint(layout, *str(error).split("; "))
            row.enabled = False
        else:
            hint(layout, objects[0].name if len(objects) == 1 else f"{len(objects)} objects as one mesh")
        row.operator("cmc.export", text="Export…", icon="EXPORT")


CLASSES = (CMC_PT_export,)
register, unregister = registration(CLASSES)
