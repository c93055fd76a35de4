"""Go from an outline to its plan, from a plan to its shell, and back."""

import bpy
from bpy.props import EnumProperty

from ..properties.links import result_of
from .activate import activate
from .plan import outline_of
from .plan import plan_of as meshed_plan_of


def target(ob: bpy.types.Object | None, which: str) -> bpy.types.Object | None:
    """The OUTLINE, PLAN, SHELL or FIT that belongs to an object; None if it has none or is that itself."""
    if ob is None:
        return None
    plan = ob.cmc.source if ob.cmc.role != "NONE" else meshed_plan_of(ob) or ob
    if which == "PLAN":
        other = plan
    elif plan is None:
        return None
    elif which == "OUTLINE":
        other = outline_of(plan)
    else:
        other = result_of(plan, plan.cmc.sheet if which == "SHELL" else which)
    return other if other is not None and other != ob and other.users_scene else None


class CMC_OT_go_to(bpy.types.Operator):
    """Make the outline, plan or shell of the active object the active object"""

    bl_idname = "cmc.go_to"
    bl_label = "Go To"
    bl_options = {"REGISTER", "UNDO"}

    target: EnumProperty(
        name="Target",
        description="Which of the related objects",
        items=[
            ("OUTLINE", "Outline", "The drawn outline of the plan, shown if it was hidden"),
            ("PLAN", "Plan", "The plan of the shell, or the plan meshed from the outline"),
            ("SHELL", "Shell", "The shell over the plan, shown if it was hidden"),
        ],
    )

    @classmethod
    def description(cls, context, properties):
        return f"Make the {properties.target.lower()} of this object the active object"

    @classmethod
    def poll(cls, context):
        ob = context.object
        if ob is None or all(target(ob, which) is None for which in ("OUTLINE", "PLAN", "SHELL")):
            cls.poll_message_set("Select an outline that has a plan, a plan that has a shell, or a shell")
            return False
        return True

    def execute(self, context):
        there = target(context.object, self.target)
        if there is None or there.name not in context.view_layer.objects:
            self.report({"ERROR"}, f"This object has no {self.target.lower()} in this view layer.")
            return {"CANCELLED"}
        if context.mode != "OBJECT":
            bpy.ops.object.mode_set(mode="OBJECT")
        if there.cmc.parked:
            there.cmc.parked = there.hide_viewport = there.hide_render = False
        activate(context, there)
        return {"FINISHED"}


CLASSES = (CMC_OT_go_to,)
