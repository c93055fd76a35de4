"""Approximate a Surface: the settings of Approximate Surface, and how near the result is."""

import bpy

from ..operators.approximate import draw_approximate
from ..properties.distances import NAMES, goal_text
from ..properties.libraries import keeps_changes
from ..properties.registration import registration
from ..properties.reports import last_design, shown_sheet
from ..properties.units import length_text
from .tab import TALL, PlanPart, numbers, properties_column


class CMC_PT_approximate(PlanPart, bpy.types.Panel):
    bl_idname = "CMC_PT_approximate"
    bl_label = "Approximate a Surface"
    bl_parent_id = "CMC_PT_options"
    bl_options = {"DEFAULT_CLOSED"}
    bl_order = 2

    def draw_plan(self, plan):
        layout, context = self.layout, bpy.context
        column = properties_column(layout)
        column.enabled = keeps_changes(plan) and not context.window_manager.cmc.running
        draw_approximate(column, plan.cmc)
        row = layout.row()
        row.scale_y = TALL
        row.operator("cmc.approximate_surface")
        report = last_design(context)
        if report is not None:
            numbers(layout, design_rows(report))


def design_rows(report: dict) -> list[tuple[str, str]]:
    """The distances of the nearest surface; Results has its size."""
    rows, size = [], shown_sheet(report)["span"]
    if report.get("deviation"):
        mean, most = (length_text(report["deviation"][name], digits=2) for name in ("mean", "max"))
        rows.append(("Deviation", f"{mean}, at most {most}"))
    named = {NAMES.get(label, label.capitalize()): (label, off) for label, off in report["distances"].items()}
    return rows + [(name, goal_text(label, off, size)) for name, (label, off) in named.items()]


CLASSES = (CMC_PT_approximate,)
register, unregister = registration(CLASSES)
