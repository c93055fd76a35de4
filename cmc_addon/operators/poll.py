"""Why a button is disabled, in a sentence."""

from __future__ import annotations

import math
from collections.abc import Iterable

import bpy

from ...solver.errors import CmcError
from ..bridges.drawn_bridge import has_seen_faces
from ..bridges.edge_bridge import has_faces
from ..bridges.mesh_cache import boundary_counts
from ..bridges.start_bridge import has_start
from ..properties.libraries import keeps_changes
from ..properties.links import plan_of, plan_to_solve
from ..results.objects import check_writable

RUNNING = "A solve is running; wait for it, or cancel it (Esc) first"


def why_not_object_mode(context: bpy.types.Context) -> str:
    """The step to take first where an operator needs object mode; "" in object mode."""
    return "" if context.mode == "OBJECT" else "Leave edit mode first"


def why_not_solve(context: bpy.types.Context) -> str:
    """Why the active object's plan cannot be solved; "" if it can, as far as is known without reading its mesh."""
    return RUNNING if context.window_manager.cmc.running else _why_no_plan(context)


def why_not_live(context: bpy.types.Context) -> str:
    """Why the shell of the active object's plan cannot follow; "" if it can, or if it does."""
    reason, plan = _why_no_plan(context), plan_to_solve(context)
    if plan is None or (plan.cmc.live and keeps_changes(plan)):
        return "" if plan is not None else reason
    if reason or boundary_counts(plan.data)[0] or has_start(plan.data) or (plan.cmc.apply_modifiers and plan.modifiers):
        return reason
    return f"'{plan.name}' is closed, and a plan has a boundary; delete the faces beyond its rim"


def _why_no_plan(context: bpy.types.Context) -> str:
    try:
        plan = plan_of(context.view_layer.objects.active)
        check_writable(plan)
    except CmcError as error:
        return str(error).removesuffix(".")
    if plan.type != "MESH":
        return f"'{plan.name}' is not a mesh; select a plan, or make one with Mesh Plan"
    if not has_faces(plan.data) and not has_seen_faces(context, plan):
        return f"'{plan.name}' has no faces; fill its outline (F), or use Mesh Plan"
    return ""


def allow(operator: type, reason: str) -> bool:
    """For a `poll`: whether there is no reason against it; a reason becomes the tooltip of the disabled button."""
    if reason:
        operator.poll_message_set(reason)
    return not reason


def check_numbers(operator: bpy.types.Operator, names: Iterable[str]) -> None:
    """Raise `CmcError` where a script has given one of these properties a value that is no number."""
    for name in names:
        if not math.isfinite(getattr(operator, name)):
            raise CmcError(f"{operator.properties.bl_rna.properties[name].name} is not a number; give one.")
