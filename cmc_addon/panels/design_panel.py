"""Design: fit a shell to an outline, a curve, anchors or a surface; and the distances that remain."""

import math

import bpy

from ...solver.fitting.targets import (
    Anchors,
    Area,
    Closed,
    Crown,
    GaussMap,
    MinimalChange,
    NearSurface,
    RimOnCurve,
    SmoothRim,
    TiltBounds,
    Volume,
)
from ..live.follow import problem_of
from ..operators.design import draw_approximate, draw_fit
from ..properties.libraries import keeps_changes
from ..properties.links import plan_to_solve, result_of
from ..properties.registration import registration
from ..properties.reports import last_design
from ..properties.units import length_text
from .results_panel import numbers, paragraph, size_rows
from .tab import TALL, Tab, properties_column

_LENGTHS = {target.label for target in (RimOnCurve, Crown, Anchors, NearSurface, Closed)}
_NAMES = {
    RimOnCurve.label: "Off Line",
    Crown.label: "Off Height",
    Volume.label: "Off Volume",
    Area.label: "Off Area",
    Anchors.label: "Off Anchors",
    NearSurface.label: "Off Surface",
    GaussMap.label: "Off Normals",
    MinimalChange.label: "Turn of Normals",
    SmoothRim.label: "Rim Roughness",
    TiltBounds.label: "Off Lean",
    Closed.label: "Gap",
}
"""The solver's name of a distance -> the panel's."""


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
            paragraph(layout, context, report["message"], "CHECKMARK" if report["met"] else "ERROR")
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
    """The size of the fitted shell, and its distances from its goals."""
    rows = size_rows(report)
    if report.get("deviation"):
        mean, most = (length_text(report["deviation"][name], digits=2) for name in ("mean", "max"))
        rows.append(("Deviation", f"{mean}, at most {most}"))
    return rows + [_distance_row(label, off) for label, off in report["distances"].items()]


def _distance_row(label: str, off: float) -> tuple[str, str]:
    name = _NAMES.get(label, label.capitalize())
    if label == TiltBounds.label:
        return name, f"{math.degrees(off):.2g}°"
    return name, length_text(off, digits=2) if label in _LENGTHS else f"{off:.2g}" if off >= 1e-6 else "0"


CLASSES = (CMC_PT_design,)
register, unregister = registration(CLASSES)
