"""Solve, Solve from Selection, Flip, Cancel; and `TaskOperator`, which runs a task of the room `tasks`."""

import bpy

from ...solver.errors import CmcError
from ..background import worker
from ..properties.closing_settings import draw_closing
from ..properties.group_settings import condition_annotations, kind_parameters, parameter_values
from ..properties.links import by_uid, plan_of, plan_to_solve
from ..properties.settings import SETTINGS, SIZE_PROPERTY, energies_on, fitted_settings, setting_annotations
from ..results.objects import check_writable
from ..results.visibility import why_not_seen
from ..tasks.recipe import is_behind, made_again, with_recipe
from ..tasks.solve import SolveTask, settings_of
from ..tasks.task import Task
from .modal import ModalOperator, Steps
from .poll import allow, why_not_object_mode, why_not_solve


class TaskOperator(ModalOperator):
    """An operator that reads a task from the active plan, works on it in a thread and writes its result."""

    # --- what differs between operators

    def task_settings(self, plan: bpy.types.Object):
        """The settings of the solve."""
        given = [name for name in SETTINGS if self.properties.is_property_set(name)]
        stored = {name: getattr(self if name in given else plan.cmc, name) for name in SETTINGS}
        settings = fitted_settings(stored, given)
        for name in SETTINGS:
            setattr(self, name, getattr(settings, name))
        return settings

    def selection(self) -> dict | None:
        """Kind and parameters for the selected boundary edges, if the operator uses the selection."""
        return None

    def read_task(self, context: bpy.types.Context, plan: bpy.types.Object) -> Task:
        """The task that the operator runs: the solve, and what was made of the shell."""
        return with_recipe(plan, SolveTask.read(context, plan, self.task_settings(plan), self.selection()))

    # --- what all have in common

    def steps(self, context: bpy.types.Context, wait: float) -> Steps:
        context.view_layer.update()
        plan = plan_of(context.view_layer.objects.active)
        check_writable(plan)
        task = self.read_task(context, plan)
        uid, name = plan.session_uid, plan.name
        result = yield from worker.steps(task.work, task.tolerance, wait)
        if result is None:
            return self._report_cancelled()
        plan = by_uid(uid)
        if plan is None:
            raise CmcError(f"The plan '{name}' was deleted while it was being solved.")
        check_writable(plan)
        warnings = task.write(context, plan, result)
        if unseen := why_not_seen(context, plan, task.shows()):
            warnings.append(unseen)
        for warning in warnings:
            self.report({"WARNING"}, warning)
        if result.converged:  # otherwise the warnings say how it ended
            self.report({"INFO"}, f"{plan.name}: {result.message}")
        return {"FINISHED"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return allow(cls, why_not_solve(context))

    def progress_of(self, step: worker.Step) -> tuple[float, str]:
        if step.fraction >= 1.0:
            return 1.0, "Measuring"
        return step.fraction, f"Step {step.iteration}, residual {step.residual:.1e}"

    def about(self, context: bpy.types.Context) -> bpy.types.Object | None:
        return plan_of(context.view_layer.objects.active)


class ShellOperator(TaskOperator):
    """An operator that continues from the shell, which is solved first where that is not known."""

    def progress_of(self, step: worker.Step) -> tuple[float, str]:
        return 0.5 * step.fraction, f"Solving, step {step.iteration}"


def as_settings(layout: bpy.types.UILayout) -> None:
    """Names on the left, values on the right, as in the panels."""
    layout.use_property_split = True
    layout.use_property_decorate = False


def draw_settings(layout: bpy.types.UILayout, owner) -> None:
    """Rows for the solve settings of an object or an operator; only those with an effect now."""
    layout.prop(owner, "default_kind")
    layout.prop(owner, "size")
    value = SIZE_PROPERTY[owner.size]
    if value:
        layout.prop(owner, value)
    elif owner.size == "MATCH_PLAN":
        layout.prop(owner, "rotate")
    for name in ("blend", "against", "ground"):
        layout.prop(owner, name)
    draw_shell(layout, owner)
    layout.prop(owner, "keep_closed")
    if owner.keep_closed:
        draw_closing(layout, owner)
    for name in ("corners", "holes", "sheet", "flip", "apply_modifiers"):
        layout.prop(owner, name)
    column = layout.column(heading="Also Make")
    for name in ("want_twin", "want_g", "want_gauss"):
        column.prop(owner, name)
    for name in ("tolerance", "intersections", "count_modes"):
        layout.prop(owner, name)
    draw_advanced(layout, owner)


def draw_shell(layout: bpy.types.UILayout, owner) -> None:
    """Rows for the choice among the shells over one rim."""
    layout.prop(owner, "shell")
    if owner.shell == "DEGREE":
        layout.prop(owner, "degree")


def draw_advanced(layout: bpy.types.UILayout, owner) -> None:
    """Rows for the discretisation and the faces of the result; only the energies that are defined on the sites."""
    layout.prop(owner, "sites")
    split = layout.split(factor=0.4)
    title = split.row()
    title.alignment = "RIGHT"
    title.label(text="Energy")
    choices = split.column(align=True)
    choices.use_property_split = False
    for energy in energies_on(owner.sites):
        choices.prop_enum(owner, "energy", energy)
    for name in ("method", "side", "delaunay", "averaging"):
        layout.prop(owner, name)
    layout.separator()
    layout.prop(owner, "combinatorics")


class CMC_OT_solve(TaskOperator, bpy.types.Operator):
    """Form the shell of constant mean curvature over the active plan, or over the plan of the active result"""

    bl_idname = "cmc.solve"
    bl_label = "Solve"
    __annotations__ = setting_annotations({"SKIP_SAVE"})

    def draw(self, context: bpy.types.Context) -> None:
        as_settings(self.layout)
        draw_settings(self.layout, self)


class CMC_OT_solve_selection(TaskOperator, bpy.types.Operator):
    """Solve with one condition on the selected boundary edges; all other edges keep their group or the default"""

    bl_idname = "cmc.solve_selection"
    bl_label = "Solve from Selection"
    __annotations__ = {**condition_annotations({"SKIP_SAVE"}), **setting_annotations({"SKIP_SAVE"})}

    def selection(self) -> dict:
        return {"kind": self.kind, "parameters": parameter_values(self.kind, self)}

    def draw(self, context: bpy.types.Context) -> None:
        as_settings(self.layout)
        self.layout.prop(self, "kind")
        for name in kind_parameters(self.kind):
            self.layout.prop(self, name)
        draw_settings(self.layout, self)


class CMC_OT_update_all(ShellOperator, bpy.types.Operator):
    """Make again what was made of an older shell: its copies"""

    bl_idname = "cmc.update_all"
    bl_label = "Update All"

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return allow(cls, why_not_object_mode(context) or why_not_solve(context) or _why_not_behind(context))

    def read_task(self, context: bpy.types.Context, plan: bpy.types.Object) -> Task:
        return made_again(context, plan)


def _why_not_behind(context: bpy.types.Context) -> str:
    plan = plan_to_solve(context)
    return "" if plan is not None and is_behind(plan) else "Nothing made of this shell is out of date."


class CMC_OT_flip(TaskOperator, bpy.types.Operator):
    """Turn the shell upside down, from standing to hanging or back"""

    bl_idname = "cmc.flip"
    bl_label = "Flip"

    def task_settings(self, plan: bpy.types.Object):
        settings = settings_of(plan.cmc)
        settings.flip = not settings.flip
        return settings


class CMC_OT_cancel(bpy.types.Operator):
    """Stop the running solve; nothing is changed"""

    bl_idname = "cmc.cancel"
    bl_label = "Cancel"
    bl_options = {"INTERNAL"}

    def execute(self, context: bpy.types.Context) -> set[str]:
        if not worker.cancel():
            self.report({"INFO"}, "No solve is running.")
            return {"CANCELLED"}
        return {"FINISHED"}


CLASSES = (CMC_OT_solve, CMC_OT_solve_selection, CMC_OT_update_all, CMC_OT_flip, CMC_OT_cancel)
