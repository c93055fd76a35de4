"""Solid shading by *Attribute* while the results of a plan are coloured, and the former shading afterwards.

Only a change of *Colour By*, or its undo, switches the shading: another shading chosen meanwhile stays.
"""

from __future__ import annotations

import bpy
from bpy.app.handlers import persistent

from ..properties.links import families, plan_to_solve, seen_results
from ..properties.registration import registration

BY_ATTRIBUTE = "VERTEX"
"""Blender's identifier of colours by attribute in Solid shading."""


class Switched:
    """Whether we switched the viewports to colours, and the former shading of each, by its address."""

    on: bool = False
    before: dict[int, str] = {}


def coloured() -> bool:
    """Whether the results of any plan are coloured."""
    return any(ob.cmc.colour_by != "NONE" for ob in bpy.data.objects)


def look_plan(context: bpy.types.Context) -> bpy.types.Object | None:
    """The plan whose colours are shown: that of the active object if it has shells, else the first coloured one with
    a result that is seen, since colours stay when another object becomes active."""
    plan = plan_to_solve(context)
    if plan is not None and families(plan):
        return plan
    if not Switched.on:
        return None
    results = (ob for ob in context.view_layer.objects if ob.cmc.role != "NONE" and ob.cmc.source is not None)
    plans = dict.fromkeys(ob.cmc.source for ob in results if ob.cmc.source.cmc.colour_by != "NONE")
    return next((plan for plan in plans if next(seen_results(context, plan), None) is not None), None)


def views(window_manager: bpy.types.WindowManager) -> list[bpy.types.SpaceView3D]:
    areas = [area for window in window_manager.windows for area in window.screen.areas]
    return [area.spaces.active for area in areas if area.type == "VIEW_3D"]


def follow(context: bpy.types.Context) -> None:
    """Show colours if any plan is coloured, else restore the former shading."""
    if coloured():
        _show(context)
    else:
        _go_back(context)


def _show(context: bpy.types.Context) -> None:
    for view in views(context.window_manager):
        if view.shading.color_type != BY_ATTRIBUTE:
            Switched.before[view.as_pointer()] = view.shading.color_type
            _usual(context.scene, view.shading.color_type)
            view.shading.color_type = BY_ATTRIBUTE
    Switched.on = True


def _go_back(context: bpy.types.Context) -> None:
    """Restore the former shading; in a file that was loaded, the one that its scene remembers."""
    for view in views(context.window_manager):
        before = Switched.before.pop(view.as_pointer(), None) or context.scene.cmc.shading_before
        if view.shading.color_type == BY_ATTRIBUTE and before:
            view.shading.color_type = before
    Switched.on = False
    context.scene.cmc.shading_before = ""


def _usual(scene: bpy.types.Scene, color_type: str) -> None:
    if not scene.cmc.shading_before:
        scene.cmc.shading_before = color_type


@persistent
def _on_undo(*_) -> None:
    if bpy.context.window_manager is not None and coloured() != Switched.on:
        follow(bpy.context)


@persistent
def _on_load(*_) -> None:
    Switched.before.clear()
    Switched.on = coloured()


register, _unlisten = registration(handlers={"undo_post": _on_undo, "redo_post": _on_undo, "load_post": _on_load})


def unregister() -> None:
    _unlisten()
    Switched.before.clear()
    Switched.on = False
