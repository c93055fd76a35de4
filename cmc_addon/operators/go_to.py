"""From an outline to its plan, from a plan to its shell, and back: make the other object the active one."""

import bpy
from bpy.props import EnumProperty

from ..properties.links import result_of
from .plan import outline_of
from .plan import plan_of as meshed_plan_of


def target(ob: bpy.types.Object | None, which: str) -> bpy.types.Object | None:
    """The OUTLINE, PLAN, SHELL or FIT that belongs to an object; None where there is no other object of that kind."""
    if ob is None:
        return None
    plan = ob.cmc.source if ob.cmc.role != "NONE" else meshed_plan_of(ob) or ob
    if which == "PLAN":
        found = plan
    elif plan is None:
        return None
    elif which == "OUTLINE":
        found = outline_of(plan)
    else:
        found = result_of(plan, plan.cmc.sheet if which == "SHELL" else which)
    return found if found is not None and found != ob and found.users_scene else None


class CMC_OT_go_to(bpy.types.Operator):
    """Make the outline, plan or shell that belongs to the active object the active one"""

    bl_idname = "cmc.go_to"
    bl_label = "Go To"
    bl_options = {"REGISTER", "UNDO"}

    target: EnumProperty(
        name="Target",
        description="Which of the objects that belong together",
        items=[
            ("OUTLINE", "Outline", "The drawn outline of the plan; it is shown if it was hidden"),
            ("PLAN", "Plan", "The plan that the shell comes from, or that the outline was meshed to"),
            ("SHELL", "Shell", "The surface that was formed over the plan; it is shown if it was hidden"),
            ("FIT", "Fit", "The shell that was fitted to the outline"),
        ],
    )

    @classmethod
    def description(cls, context, properties):
        what = {"FIT": "fitted shell"}.get(properties.target, properties.target.lower())
        return f"Make the {what} of this object the active object"

    @classmethod
    def poll(cls, context):
        ob = context.object
        if ob is None or all(target(ob, which) is None for which in ("OUTLINE", "PLAN", "SHELL", "FIT")):
            cls.poll_message_set("Select an outline, a plan or a shell that has come from one another")
            return False
        return True

    def execute(self, context):
        found = target(context.object, self.target)
        if found is None or found.name not in context.view_layer.objects:
            self.report({"ERROR"}, f"This object has no {self.target.lower()} in this view layer.")
            return {"CANCELLED"}
        if context.mode != "OBJECT":
            bpy.ops.object.mode_set(mode="OBJECT")
        for other in context.selected_objects:
            other.select_set(False)
        if found.cmc.parked:
            found.cmc.parked = found.hide_viewport = found.hide_render = False
        found.hide_set(False)
        found.select_set(True)
        context.view_layer.objects.active = found
        return {"FINISHED"}


CLASSES = (CMC_OT_go_to,)
