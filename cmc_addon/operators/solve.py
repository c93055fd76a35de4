"""Solve, Solve from Selection, Flip, Cancel.

The three that solve are one generator, `Solving.steps`, which runs as `working` says.
"""

from collections.abc import Generator

import bpy

from ...solver.errors import CmcError
from ..background import worker
from ..drawing.viewport import redraw as redraw
from ..properties.group_settings import condition_annotations, kind_parameters, parameter_values
from ..properties.links import by_uid, plan_of
from ..properties.settings import SETTINGS, SIZE_PROPERTY, energies_on, fitted_settings, setting_annotations
from ..results.objects import check_writable
from ..tasks.solve import settings_of, take_order
from .modal import Working
from .poll import allow, why_not_solve


class Solving(Working):
    """What the operators that solve have in common."""

    # --- what they do differently

    def order_settings(self, plan: bpy.types.Object):
        """The settings to solve with."""
        given = [name for name in SETTINGS if self.properties.is_property_set(name)]
        stored = {name: getattr(self if name in given else plan.cmc, name) for name in SETTINGS}
        settings = fitted_settings(stored, given)
        for name in SETTINGS:
            setattr(self, name, getattr(settings, name))
        return settings

    def selection(self) -> dict | None:
        """Kind and parameters for the selected boundary edges, if the selection counts."""
        return None

    def take(self, context: bpy.types.Context, plan: bpy.types.Object):
        """What is to be done, without Blender data: `work(progress)`, and `deliver` for what that returns."""
        return take_order(context, plan, self.order_settings(plan), self.selection())

    # --- what they do alike

    def steps(self, context: bpy.types.Context, wait: float) -> Generator:
        """Solve and write the results; yields updates, or None after `wait` seconds without one.

        Returns what the operator returns.
        """
        context.view_layer.update()
        plan = plan_of(context.view_layer.objects.active)
        check_writable(plan)
        order = self.take(context, plan)
        uid = plan.session_uid
        outcome = yield from worker.steps(order.work, order.settings.tolerance, wait)
        if outcome is None:
            return self._say_cancelled()
        plan = by_uid(uid)
        if plan is None:
            raise CmcError(f"The plan '{order.name}' was deleted while it was being solved.")
        check_writable(plan)
        for warning in order.deliver(context, plan, outcome):
            self.report({"WARNING"}, warning)
        if outcome.converged:  # otherwise the warnings say how it ended
            self.report({"INFO"}, f"{plan.name}: {outcome.message}")
        return {"FINISHED"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return allow(cls, why_not_solve(context))

    def tell(self, update: worker.Update) -> tuple[float, str]:
        if update.part >= 1.0:
            return 1.0, "Measuring"
        return update.part, f"Step {update.iteration}, residual {update.residual:.1e}"

    def about(self, context: bpy.types.Context) -> bpy.types.Object | None:
        return plan_of(context.view_layer.objects.active)

    def _say_cancelled(self) -> set[str]:
        self.report({"INFO"}, "The solve was cancelled; nothing was changed.")
        return {"CANCELLED"}


def as_settings(layout: bpy.types.UILayout) -> None:
    """Names on the left, values on the right, as in the panels."""
    layout.use_property_split = True
    layout.use_property_decorate = False


def draw_settings(layout: bpy.types.UILayout, owner) -> None:
    """Rows for the settings of a solve, of an object or an operator; only the ones that count now."""
    layout.prop(owner, "size")
    value = SIZE_PROPERTY[owner.size]
    if value:
        layout.prop(owner, value)
    elif owner.size == "MATCH_PLAN":
        layout.prop(owner, "rotate")
    for name in ("blend", "ground"):
        layout.prop(owner, name)
    draw_shell(layout, owner)
    for name in ("sheet", "flip", "apply_modifiers"):
        layout.prop(owner, name)
    column = layout.column(heading="Also Make")
    for name in ("want_twin", "want_g", "want_gauss"):
        column.prop(owner, name)
    for name in ("tolerance", "intersections", "count_modes"):
        layout.prop(owner, name)
    draw_advanced(layout, owner)


def draw_shell(layout: bpy.types.UILayout, owner) -> None:
    """Rows for which of the shells over one rim is made."""
    layout.prop(owner, "shell")
    if owner.shell == "DEGREE":
        layout.prop(owner, "degree")


def draw_advanced(layout: bpy.types.UILayout, owner) -> None:
    """Rows for what is solved and which faces it gets; of the energies those that are defined on the sites."""
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


class CMC_OT_solve(Solving, bpy.types.Operator):
    """Form the shell of constant mean curvature over the active plan (or the plan of the active result)"""

    bl_idname = "cmc.solve"
    bl_label = "Solve"
    __annotations__ = setting_annotations({"SKIP_SAVE"})

    def draw(self, context: bpy.types.Context) -> None:
        as_settings(self.layout)
        draw_settings(self.layout, self)


class CMC_OT_solve_selection(Solving, bpy.types.Operator):
    """Solve with one condition on the selected boundary edges; the others keep their groups or the default"""

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


class CMC_OT_flip(Solving, bpy.types.Operator):
    """Turn the shell upside down: standing or hanging"""

    bl_idname = "cmc.flip"
    bl_label = "Flip"

    def order_settings(self, plan: bpy.types.Object):
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


CLASSES = (CMC_OT_solve, CMC_OT_solve_selection, CMC_OT_flip, CMC_OT_cancel)
