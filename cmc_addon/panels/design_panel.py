"""Design: fit a shell to an outline, a curve, anchors or a surface; and the distances that remain."""

import bpy

from ..live.follow import problem_of
from ..operators.design import draw_approximate, draw_fit
from ..properties.distances import NAMES, goal_text
from ..properties.libraries import keeps_changes
from ..properties.links import plan_to_solve, result_of
from ..properties.registration import registration
from ..properties.reports import last_design, shown_sheet
from ..properties.units import length_text
from .results_panel import numbers, paragraph
from .tab import TALL, Tab, properties_column


class CMC_PT_design(Tab, bpy.types.Panel):
    bl_idname = "CMC_PT_design"
    bl_label = "Design"
    bl_parent_id = "CMC_PT_shell"
    bl_options = {"DEFAULT_CLOSED"}
    bl_order = 2

    @classmethod
    def poll(cls, context):
        return plan_to_solve(context) is not None or _is_anchor(context.object)

    def draw(self, context):
        layout, plan = self.layout, plan_to_solve(context)
        if plan is None:
            properties_column(layout).prop(context.object.cmc, "anchor_weight", text="Anchor Weight")
            return
        draw_fit(self._settings(layout, context, plan), plan.cmc)
        self._button(layout, "cmc.fit_outline")
        if result_of(plan, "FIT") is not None:
            self._settings(layout, context, plan).prop(plan.cmc, "follow")
            if problem_of(plan):
                paragraph(layout, context, problem_of(plan), "ERROR")
        layout.separator()
        draw_approximate(self._settings(layout, context, plan), plan.cmc)
        self._button(layout, "cmc.approximate_surface")
        report = last_design(context)
        if report is not None:
            numbers(layout, design_rows(report))

    def _settings(self, layout, context, plan):
        """A column of settings. The buttons stay outside: only a button disabled by its own poll explains why."""
        column = properties_column(layout)
        column.enabled = keeps_changes(plan) and not context.window_manager.cmc.running
        return column

    def _button(self, layout, name):
        row = layout.row()
        row.scale_y = TALL
        row.operator(name)


def _is_anchor(ob: bpy.types.Object | None) -> bool:
    return ob is not None and ob.type == "EMPTY"


def design_rows(report: dict) -> list[tuple[str, str]]:
    """The distances of a fitted shell from its goals; Results has its size."""
    rows, size = [], shown_sheet(report)["span"]
    if report.get("deviation"):
        mean, most = (length_text(report["deviation"][name], digits=2) for name in ("mean", "max"))
        rows.append(("Deviation", f"{mean}, at most {most}"))
    named = {NAMES.get(label, label.capitalize()): (label, off) for label, off in report["distances"].items()}
    return rows + [(name, goal_text(label, off, size)) for name, (label, off) in named.items()]


CLASSES = (CMC_PT_design,)
register, unregister = registration(CLASSES)
