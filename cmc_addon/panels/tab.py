"""The CMC tab of the sidebar, in the order of the work, and the parts that all panels share.

The `bl_order` of the panels:

    Plan 0, Sides 1, Shell 2 (Options: Advanced, Approximate a Surface), Result 3 (Checks: Solver), Look 4, Overlay 5,
    Repeat 50, Export 60

The panels depend on the active object alone, and no state raises. A panel is there where it has something to do, and
open where one looks first: Plan, Sides, Shell, Result. Grey is what has no effect now; texts are not, since Blender's
light theme makes grey ones hard to read. A button that cannot be pressed is disabled by its operator's `poll`, and its
tooltip explains why.
"""

import re
import textwrap

import bpy

from ..operators.go_to import target
from ..properties.links import plan_to_solve
from ..properties.preferences import CATEGORY
from ..properties.units import length_text

TALL = 1.3  # the buttons that do the work

_LETTER = 7.0  # pixels, of the interface font at scale 1
_UNIT = r"(?<=\d) (?=%|[a-zµ]{1,2}[²³]?\b)"


class Tab:
    """Base of all panels of the sidebar; `bl_order` sorts them."""

    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = CATEGORY


class PlanPart(Tab):
    """Base of panels about the plan, which are shown where there is one."""

    @classmethod
    def poll(cls, context):
        return plan_to_solve(context) is not None

    def draw(self, context):
        plan = plan_to_solve(context)
        if plan is not None:
            self.draw_plan(plan)


def hint(layout: bpy.types.UILayout, *lines: str) -> None:
    """A hint on the next step, in lines short enough for a narrow sidebar."""
    column = layout.column(align=True)
    column.scale_y = 0.8
    for k, line in enumerate(lines):
        column.label(text=line, icon="INFO" if k == 0 else "BLANK1")


def properties_column(layout: bpy.types.UILayout) -> bpy.types.UILayout:
    """A column of settings in the style of Blender's panels."""
    column = layout.column()
    column.use_property_split = True
    column.use_property_decorate = False
    return column


def go_to_row(layout: bpy.types.UILayout, ob: bpy.types.Object, which: str) -> None:
    """The name of a linked object, if it exists; a click makes it active."""
    other = target(ob, which)
    if other is not None:
        split = layout.split(factor=0.4)
        name = split.row()
        name.alignment = "RIGHT"
        name.label(text=which.capitalize())
        split.operator("cmc.go_to", text=other.name, icon=_ICONS[which]).target = which


_ICONS = {"OUTLINE": "CURVE_DATA", "PLAN": "MESH_GRID", "SHELL": "SURFACE_NSURFACE"}


def running_row(layout: bpy.types.UILayout, context: bpy.types.Context) -> None:
    """The progress of the running task, whichever it is, in place of Solve, with a cross to cancel it."""
    run = context.window_manager.cmc
    row = layout.row(align=True)
    row.progress(factor=run.progress, text=run.message or "Working")
    row.operator("cmc.cancel", text="", icon="X")


def automatic(column: bpy.types.UILayout, length: float, bound: str = "") -> None:
    """The value that a setting of 0 stands for, below that setting; bound: "up to " where it is the largest one."""
    split = column.split(factor=0.4)
    split.label()
    split.label(text=f"Automatic: {bound}{length_text(length)}")


def paragraph(layout: bpy.types.UILayout, context: bpy.types.Context, text: str, icon: str) -> None:
    """A text wrapped to the width of the sidebar."""
    scale = context.preferences.system.ui_scale or 1.0  # 0 where there is no window
    letters = max(16, int((context.region.width / scale - 60) / _LETTER))
    column = layout.column(align=True)
    column.scale_y = 0.8
    text = re.sub(_UNIT, "\u00a0", text)  # a unit stays with its number
    for k, line in enumerate(textwrap.wrap(text, letters)):
        column.label(text=line, icon=icon if k == 0 else "BLANK1")


def numbers(layout: bpy.types.UILayout, rows: list[tuple[str, str]]) -> None:
    """Names on the left, values on the right, aligned with the settings above."""
    column = layout.column(align=True)
    column.scale_y = 0.85
    for name, value in rows:
        split = column.split(factor=0.4)
        left = split.row()
        left.alignment = "RIGHT"
        left.label(text=name)
        split.label(text=value)


# Longer names run over the title of a panel.
_LONGEST = 20


def fitting(name: str) -> str:
    """The name, its middle left out if it is long: it ends in what kind of shell it is."""
    return name if len(name) <= _LONGEST else f"{name[:9].rstrip()}…{name[-10:].lstrip()}"
