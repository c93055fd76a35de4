"""Beside Solve: how near the rim comes to the drawn outline, and the way to a shell whose rim lies on it."""

from __future__ import annotations

import json

import bpy

from ...solver.design.targets import RimOnCurve
from ..panels.results_panel import last_report, numbers
from ..panels.tab import BESIDE_SOLVE, length_text
from .results import result_of


def draw_nearness(layout: bpy.types.UILayout, context: bpy.types.Context, plan: bpy.types.Object) -> None:
    """After a solve: how far its rim is from the drawn outline, and the button that puts it there."""
    rows = outline_rows(last_report(context))
    if rows:
        numbers(layout, rows + fitted_rows(plan))
        layout.operator("cmc.fit_outline", icon="SNAP_ON")


def outline_rows(report: dict | None) -> list[tuple[str, str]]:
    """Mean and largest distance between the rim and the outline, in the scene's unit and as a part of the span."""
    shown = None if report is None else report["sheets"][report["sheet"]]
    if shown is None or not shown.get("outline"):
        return []
    return [
        (name, distance_text(shown["outline"][key], shown["span"]))
        for name, key in (("Off Outline", "mean"), ("At Most", "max"))
    ]


def fitted_rows(plan: bpy.types.Object) -> list[tuple[str, str]]:
    """The largest distance of the shell that was fitted, if there is one."""
    if result_of(plan, "FIT") is None:
        return []
    try:
        told = json.loads(plan.cmc.design_report)
        off, span = told["distances"][RimOnCurve.label], told["sheets"][told["sheet"]]["span"]
    except (ValueError, KeyError, TypeError):  # of another design, or somebody else wrote into the property
        return []
    return [("Fitted", distance_text(off, span))]


def distance_text(length: float, span: float) -> str:
    """Two digits of the part, but no powers of ten: "7.5 m (150 % of span)"."""
    part = 100 * length / (span or 1.0)
    digits = ".2g" if part < 99.5 else ".0f"
    return f"{length_text(length, digits=2)} ({part:{digits}} % of span)"


def register() -> None:
    BESIDE_SOLVE.append(draw_nearness)


def unregister() -> None:
    if draw_nearness in BESIDE_SOLVE:
        BESIDE_SOLVE.remove(draw_nearness)
