"""Shell: Solve and what says which shell; its options."""

import bpy

from ...solver.surface.placement import FREE_SIZES, SIZES, SPANNED_SIZES
from ..bridges.edge_bridge import has_faces
from ..bridges.mesh_cache import has_courts, is_on_lines, usual_size
from ..bridges.start_bridge import has_lengths, has_start
from ..live.live import problem_of
from ..operators.go_to import target
from ..operators.solve import draw_advanced, draw_shell
from ..properties.closing_settings import draw_closing
from ..properties.libraries import keeps_changes
from ..properties.links import plan_to_solve
from ..properties.registration import registration
from ..properties.settings import SIZE_PROPERTY
from ..properties.units import length_text
from .tab import PlanPart, Tab, go_to_row, hint, paragraph, properties_column, running_row

_LARGE = 1.6  # the one button


class CMC_MT_size(bpy.types.Menu):
    """The ways to choose the size of a shell that its sides leave"""

    bl_idname = "CMC_MT_size"
    bl_label = "Size"

    def draw(self, context):
        assert context is not None
        plan = plan_to_solve(context)
        if plan is None:
            return
        on_lines = is_on_lines(plan)
        for name in SPANNED_SIZES if on_lines else FREE_SIZES:
            self.layout.prop_enum(plan.cmc, "size", name.upper(), text=size_label(plan, name, on_lines))


def size_rows(column, plan: bpy.types.Object) -> None:
    """The way in which the size is chosen, and its number; red where the sides do not leave it."""
    settings, on_lines = plan.cmc, is_on_lines(plan)
    name = settings.size.lower()
    split = column.split(factor=0.4)
    title = split.row()
    title.alignment = "RIGHT"
    title.label(text="Size by")
    row = split.row()
    row.alert = name not in (SPANNED_SIZES if on_lines else FREE_SIZES)
    row.menu("CMC_MT_size", text=size_label(plan, name, on_lines))
    value = SIZE_PROPERTY[settings.size]
    if value:
        column.prop(settings, value)


def size_label(plan: bpy.types.Object, name: str, on_lines: bool) -> str:
    """The name of a size; the usual one with its number."""
    if not on_lines or name != "match_plan":
        return "Nearest to Plan" if name == "match_plan" else SIZES[name]
    height = usual_size(plan)
    return "Usual: a soap film" if height is None else f"Usual: {length_text(height)} high"


class CMC_PT_shell(Tab, bpy.types.Panel):
    bl_idname = "CMC_PT_shell"
    bl_label = "Shell"
    bl_order = 2

    @classmethod
    def poll(cls, context):
        plan = plan_to_solve(context)
        return context.window_manager.cmc.running or (plan is not None and has_faces(plan.data))

    def draw(self, context):
        layout, plan, ob = self.layout, plan_to_solve(context), context.object
        if context.window_manager.cmc.running:
            running_row(layout, context)
            return
        if plan is None or ob is None:
            return
        if plan == ob and not plan.cmc.meshed and target(plan, "PLAN") is not None:
            hint(layout, "This is the outline;", "Solve works on its plan")
            go_to_row(layout, plan, "PLAN")
            return
        if not plan.is_editable:
            hint(layout, "This plan is linked from another", "file; make it local to solve it")
        elif not keeps_changes(plan):
            hint(layout, "This plan is a library override;", "make it local to solve it")
        self._buttons(layout, context, plan)
        column = properties_column(layout)
        column.enabled = keeps_changes(plan)
        size_rows(column, plan)
        if has_courts(plan.data) and not is_on_lines(plan):
            row = layout.row()
            row.enabled = keeps_changes(plan)
            row.prop(plan.cmc, "keep_closed")  # with its whole name
        go_to_row(layout, ob, "SHELL")

    def _buttons(self, layout, context, plan):
        row = layout.split(factor=0.5, align=True)
        row.scale_y = _LARGE
        row.operator("cmc.solve")
        row.operator("cmc.live", depress=plan.cmc.live, icon="PLAY")
        row.operator("cmc.flip")
        if context.mode == "EDIT_MESH":
            layout.operator("cmc.solve_selection")
        problem = problem_of(plan) if plan.cmc.live else ""
        if problem:
            paragraph(layout, context, problem, "ERROR")


class CMC_PT_options(PlanPart, bpy.types.Panel):
    bl_idname = "CMC_PT_options"
    bl_label = "Options"
    bl_parent_id = "CMC_PT_shell"
    bl_options = {"DEFAULT_CLOSED"}
    bl_order = 1

    def draw_plan(self, plan):
        settings = plan.cmc
        column = properties_column(self.layout)
        column.enabled = keeps_changes(plan)
        on_lines = is_on_lines(plan)
        if on_lines:
            column.prop(settings, "corners")
            column.prop(settings, "holes")
        else:
            self._rim_free(column, plan)
        checks = column.column(heading="Also Make")
        for name in ("want_twin", "want_g", "want_gauss"):
            checks.prop(settings, name)
        column.prop(settings, "apply_modifiers")
        column.separator()
        for name in ("tolerance", "intersections", "count_modes"):
            column.prop(settings, name)

    def _rim_free(self, column, plan):
        """Of shells that find their rim by themselves."""
        settings = plan.cmc
        column.prop(settings, "ground")
        if settings.size == "MATCH_PLAN":
            column.prop(settings, "rotate")
        if plan.data.cmc.groups:
            column.prop(settings, "blend")
        column.prop(settings, "against")
        draw_shell(column, settings)
        column.prop(settings, "sheet")
        if settings.keep_closed and has_courts(plan.data):
            draw_closing(column, settings)


class CMC_PT_advanced(PlanPart, bpy.types.Panel):
    bl_idname = "CMC_PT_advanced"
    bl_label = "Advanced"
    bl_parent_id = "CMC_PT_options"
    bl_options = {"DEFAULT_CLOSED"}
    bl_order = 1

    def draw_plan(self, plan):
        column = properties_column(self.layout)
        column.enabled = keeps_changes(plan)
        draw_advanced(column, plan.cmc)
        draw_start(column, plan)


def draw_start(layout: bpy.types.UILayout, plan: bpy.types.Object) -> None:
    """The start map and edge lengths stored with a plan, and the buttons to set and clear them."""
    layout.separator()
    known = {"start map": has_start(plan.data), "edge lengths": has_lengths(plan.data)}
    if any(known.values()):
        row = layout.row()
        row.label(text=f"Own {' and '.join(name for name, there in known.items() if there)}", icon="INFO")
        row.operator("cmc.start_clear", text="", icon="X")
    layout.operator("cmc.start_from_shell")


CLASSES = (CMC_MT_size, CMC_PT_shell, CMC_PT_options, CMC_PT_advanced)
register, unregister = registration(CLASSES)
