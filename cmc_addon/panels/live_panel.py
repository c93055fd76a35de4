"""The Live switch below Solve, and the reason when the shell cannot follow."""

from __future__ import annotations

import bpy

from ..live.live import problem_of
from .results_panel import paragraph
from .tab import BESIDE_SOLVE


def draw_live(layout: bpy.types.UILayout, context: bpy.types.Context, plan: bpy.types.Object) -> None:
    """A toggle, and the problem if Live has one."""
    layout.operator("cmc.live", depress=plan.cmc.live, icon="PLAY")
    problem = problem_of(plan) if plan.cmc.live else ""
    if problem:
        paragraph(layout, context, problem, "ERROR")


def register() -> None:
    BESIDE_SOLVE.insert(0, draw_live)


def unregister() -> None:
    if draw_live in BESIDE_SOLVE:
        BESIDE_SOLVE.remove(draw_live)
