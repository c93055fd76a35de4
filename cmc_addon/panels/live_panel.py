"""The switch of Live, below Solve, and why the shell does not follow where it does not."""

from __future__ import annotations

import textwrap

import bpy

from ..live.live import problem_of
from .tab import BESIDE_SOLVE

_WIDTH = 38


def draw_live(layout: bpy.types.UILayout, plan: bpy.types.Object) -> None:
    """A toggle; a problem in a few short lines."""
    row = layout.row()
    row.enabled = plan.is_editable
    row.prop(plan.cmc, "live", toggle=True, icon="PLAY")
    problem = problem_of(plan) if plan.cmc.live else ""
    if problem:
        column = layout.column(align=True)
        column.scale_y = 0.8
        for k, line in enumerate(textwrap.wrap(problem, _WIDTH)):
            column.label(text=line, icon="ERROR" if k == 0 else "BLANK1")


def _beside_solve(layout: bpy.types.UILayout, _context: bpy.types.Context, plan: bpy.types.Object) -> None:
    draw_live(layout, plan)


def register() -> None:
    BESIDE_SOLVE.insert(0, _beside_solve)


def unregister() -> None:
    if _beside_solve in BESIDE_SOLVE:
        BESIDE_SOLVE.remove(_beside_solve)
