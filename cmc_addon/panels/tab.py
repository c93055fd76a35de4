"""The CMC tab of the sidebar, in the order of the work: the panels Plan and Shell, and the parts that all panels share.

The `bl_order` of the panels:

    Plan 0, Boundary 1, Shell 2 (Options, Advanced, Approximate a Surface), Results 3, Look 4, Overlay 5, Repeat 50,
    Export 60

The panels depend on the active object alone, and no state raises. Grey is what has no effect now; texts are not, since
Blender's light theme makes grey ones hard to read. A button that cannot be pressed is disabled by
its operator's `poll`, and its tooltip explains why.
"""

from collections.abc import Callable

import bpy

from ...solver.meshing.wires import default_corner_radius, default_edge_length
from ...solver.surface.placement import FREE_SIZES, SIZES, SPANNED_SIZES
from ..bridges.edge_bridge import has_faces
from ..bridges.mesh_cache import contacts, is_on_lines
from ..bridges.outline_bridge import local_size
from ..bridges.start_bridge import has_lengths, has_start
from ..operators.add_plan import ORDINARY, draw_shapes
from ..operators.go_to import target
from ..operators.plan import is_ready_made, outline_of, plan_of
from ..operators.solve import draw_advanced, draw_shell
from ..properties.closing_settings import draw_closing
from ..properties.libraries import keeps_changes
from ..properties.links import plan_to_solve
from ..properties.preferences import CATEGORY
from ..properties.registration import registration
from ..properties.settings import SIZE_PROPERTY
from ..properties.units import length_text

TALL = 1.3  # the buttons that do the work

BESIDE_SOLVE: list[Callable[[bpy.types.UILayout, bpy.types.Context, bpy.types.Object], None]] = []
"""Called with the layout below Solve, the context and the plan; modules registered later add their rows."""


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


# --- Mesh Plan -----------------------------------------------------------------------------

class CMC_PT_plan(Tab, bpy.types.Panel):
    bl_idname = "CMC_PT_plan"
    bl_label = "Plan"
    bl_order = 0

    def draw(self, context):
        layout, ob = self.layout, context.object
        if ob is None or ob.type not in {"MESH", "CURVE"}:
            hint(layout, "Select a mesh or a closed curve", "to use as the plan, or add one:")
            self._shapes(layout)
            return
        if ob.cmc.role != "NONE":
            if target(ob, "PLAN"):
                go_to_row(layout, ob, "PLAN")
            else:
                hint(layout, "The plan of this result", "has been deleted")
            return
        if is_ready_made(ob):
            hint(layout, "This plan is meshed already:", "Solve works on it")
            return
        self._settings(layout, context.scene.cmc, ob)
        go_to_row(layout, ob, "OUTLINE" if ob.cmc.meshed else "PLAN")
        row = layout.row()
        row.scale_y = TALL
        row.operator("cmc.mesh_plan", text="Mesh Plan" if plan_of(ob) is None else "Update Plan")
        if ob.type == "MESH" and (count := contacts(ob.data)):
            row = layout.row()
            row.label(text=f"{count} vertices touch, unjoined", icon="ERROR")
            row.operator("cmc.weld")

    def _shapes(self, layout):
        """Buttons that add plans."""
        column = layout.column(align=True)
        draw_shapes(column, ORDINARY)
        column.menu("CMC_MT_add", text="More")

    def _settings(self, layout, settings, ob):
        column = properties_column(layout)
        size = local_size(outline_of(ob))
        column.prop(settings, "edge_length")
        if not settings.edge_length:
            automatic(column, default_edge_length(size))
        column.prop(settings, "corners")
        if settings.corners != "NONE":
            column.prop(settings, "corner_radius", text="Radius")
            if not settings.corner_radius:
                automatic(column, default_corner_radius(size), "up to ")


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


# --- the size ------------------------------------------------------------------------------

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
            self.layout.prop_enum(plan.cmc, "size", name.upper(), text=_size_label(name, on_lines))


def size_row(column, settings, on_lines: bool) -> None:
    """The way in which the size is chosen; red where the sides do not leave it."""
    name = settings.size.lower()
    split = column.split(factor=0.4)
    title = split.row()
    title.alignment = "RIGHT"
    title.label(text="Size")
    row = split.row()
    row.alert = name not in (SPANNED_SIZES if on_lines else FREE_SIZES)
    row.menu("CMC_MT_size", text=_size_label(name, on_lines))


def _size_label(name: str, on_lines: bool) -> str:
    return "Usual" if on_lines and name == "match_plan" else SIZES[name]


# --- the shell -----------------------------------------------------------------------------

class CMC_PT_shell(Tab, bpy.types.Panel):
    bl_idname = "CMC_PT_shell"
    bl_label = "Shell"
    bl_order = 2

    def draw(self, context):
        layout, plan, ob = self.layout, plan_to_solve(context), context.object
        if context.window_manager.cmc.running:
            running_row(layout, context)
            return
        if plan is None or ob is None:
            hint(layout, "Select a plan; from a curve", "Mesh Plan makes one")
            self._solve(layout)
            return
        if not has_faces(plan.data):
            hint(layout, "This mesh has no faces:", "Mesh Plan makes them")
            self._solve(layout)
            return
        if plan == ob and not plan.cmc.meshed and target(plan, "PLAN") is not None:
            hint(layout, "This is the outline;", "Solve works on its plan")
            go_to_row(layout, plan, "PLAN")
            return
        if not plan.is_editable:
            hint(layout, "This plan is linked from another", "file; make it local to solve it")
        elif not keeps_changes(plan):
            hint(layout, "This plan is a library override;", "make it local to solve it")
        self._settings(layout, plan)
        self._solve(layout)
        if context.mode == "EDIT_MESH":
            layout.operator("cmc.solve_selection")
        for draw in BESIDE_SOLVE:
            draw(layout, context, plan)
        go_to_row(layout, ob, "SHELL")

    def _solve(self, layout):
        row = layout.split(factor=0.75, align=True)
        row.scale_y = TALL
        row.operator("cmc.solve")
        row.operator("cmc.flip")

    def _settings(self, layout, plan):
        settings = plan.cmc
        column = properties_column(layout)
        column.enabled = keeps_changes(plan)
        on_lines = is_on_lines(plan)
        size_row(column, settings, on_lines)
        value = SIZE_PROPERTY[settings.size]
        if value:
            column.prop(settings, value)
        if not on_lines:
            column.prop(settings, "ground")
            column.prop(settings, "keep_closed")


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
            draw_shell(column, settings)
            column.prop(settings, "sheet")
            if settings.keep_closed:
                draw_closing(column, settings)
        checks = column.column(heading="Also Make")
        for name in ("want_twin", "want_g", "want_gauss"):
            checks.prop(settings, name)
        column.prop(settings, "apply_modifiers")
        if settings.size == "MATCH_PLAN" and not on_lines:
            column.prop(settings, "rotate")
        column.separator()
        for name in ("tolerance", "intersections", "count_modes"):
            column.prop(settings, name)


class CMC_PT_advanced(PlanPart, bpy.types.Panel):
    bl_idname = "CMC_PT_advanced"
    bl_label = "Advanced"
    bl_parent_id = "CMC_PT_shell"
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


CLASSES = (CMC_MT_size, CMC_PT_plan, CMC_PT_shell, CMC_PT_options, CMC_PT_advanced)
register, unregister = registration(CLASSES)
