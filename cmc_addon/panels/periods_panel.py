"""Gaps, under Repeat: the gaps around the holes of a plan, and the copies of its shell across them."""

import bpy

from ...solver.errors import CmcError
from ..operators import add_bubble
from ..operators.add_plan import first_in_add_menu, in_add_menu
from ..properties.closing_settings import draw_tile
from ..properties.libraries import keeps_changes
from ..properties.links import plan_to_solve
from ..properties.registration import registration
from ..properties.reports import complete_report
from ..tasks.tile import tile_counts
from .periods_text import closing_rows, gap_rows
from .results_panel import ResultPanel
from .symmetry_panel import completed_rows, has_gaps
from .tab import TALL, numbers, paragraph, properties_column


class CMC_PT_periods(ResultPanel, bpy.types.Panel):
    bl_idname = "CMC_PT_periods"
    bl_label = "Gaps"
    bl_parent_id = "CMC_PT_complete"
    bl_order = 1

    @classmethod
    def poll(cls, context):
        return has_gaps(context)

    def draw_header_preset(self, context):
        self.layout.prop(context.scene.cmc, "show_gaps", text="", icon="OVERLAY")

    def draw_report(self, context, report):
        layout, plan = self.layout, plan_to_solve(context)
        if plan is None:
            return
        numbers(layout, gap_rows(report))
        numbers(layout, closing_rows(report))
        column = properties_column(layout)
        column.enabled = keeps_changes(plan) and not context.window_manager.cmc.running
        draw_tile(column, plan.cmc, len(report["holes"]))
        self._counts(layout, context, plan, len(report["holes"]))
        self._button(layout, "cmc.tile_periods")
        if plan.cmc.complete_report:
            numbers(layout, completed_rows(complete_report(plan)))

    def _counts(self, layout, context, plan, holes):
        """The number of copies to expect."""
        try:
            copies, faces = tile_counts(plan, holes, plan.cmc.tile_repeat)
        except CmcError as error:
            paragraph(layout, context, str(error), "ERROR")
            return
        numbers(layout, [("Copies", f"{copies:,}"), ("Faces", f"{faces:,}")])

    def _button(self, layout, name):
        row = layout.row()
        row.scale_y = TALL
        row.operator(name)


CLASSES = (CMC_PT_periods,)
_register, _unregister = registration(CLASSES)


def register() -> None:
    _register()
    bpy.types.CMC_MT_add.prepend(first_in_add_menu)
    bpy.types.CMC_MT_add.append(in_add_menu)
    bpy.types.CMC_MT_add.append(add_bubble.in_add_menu)


def unregister() -> None:
    if hasattr(bpy.types, "CMC_MT_add"):
        bpy.types.CMC_MT_add.remove(add_bubble.in_add_menu)
        bpy.types.CMC_MT_add.remove(in_add_menu)
        bpy.types.CMC_MT_add.remove(first_in_add_menu)
    _unregister()
