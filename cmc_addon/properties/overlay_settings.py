"""Settings of the overlay: properties of `Scene.cmc` and their rows in the panel."""

from __future__ import annotations

from functools import partial

import bpy
from bpy.props import BoolProperty, FloatProperty, IntProperty

_SHOWN = {
    "show_all": partial(
        BoolProperty, name="Overlay", default=True,
        description="Draw the boundary of the active plan, and planes, cuts and gaps of its shell, over the viewport"),
    "show_groups": partial(
        BoolProperty, name="Boundary Groups", default=True,
        description="Draw the boundary groups of the active plan as coloured lines"),
    "show_ungrouped": partial(
        BoolProperty, name="Edges in No Group", default=True,
        description="Draw boundary edges that are in no group as dashed grey lines"),
    "show_normals": partial(
        BoolProperty, name="Boundary Normals", default=True,
        description="Draw the prescribed rim normals as arrows. Along a mirror, draw lines in the plane in which "
        "the normal is free to turn"),
    "show_tangents": partial(
        BoolProperty, name="Tangent Planes", default=False,
        description="Draw patches of the tangent planes prescribed along the rim"),
    "show_mirrors": partial(
        BoolProperty, name="Mirrors and Planes", default=False,
        description="Draw the planes of mirrors and constant planes: before a solve at the plan's edges, after it "
        "where the shell meets them"),
    "show_handles": partial(
        BoolProperty, name="Handles", default=True,
        description="Levers at the sides that lean and an arrow at the crown of the shell, to drag with the mouse in "
        "object mode"),
    "show_gaps": partial(
        BoolProperty, name="Gaps", default=True,
        description="Draw the gap around each hole of the active plan as an arrow"),
    "show_cut": partial(
        BoolProperty, name="Cut", default=True,
        description="Draw the line where an open shell is cut, on the plan and on the shell"),
}
_SIZES = {
    "arrow_scale": partial(
        FloatProperty, name="Arrow Size", description="Length of the arrows, relative to the default",
        default=1.0, min=0.05, soft_min=0.2, soft_max=4.0, max=50.0),
    "arrow_count": partial(
        IntProperty, name="Arrows", description="Largest number of arrows around the whole boundary",
        default=64, min=4, soft_max=200, max=2000),
}
SHOWN = tuple(name for name in _SHOWN if name != "show_all")
"""Names of the switches, without the main one."""

OVERLAY_SETTINGS = (*_SHOWN, *_SIZES)


def overlay_annotations() -> dict:
    """The settings as annotations of `Scene.cmc`; not animated, since they belong to the view."""
    return {name: make(options=set()) for name, make in (_SHOWN | _SIZES).items()}


def draw_overlay(layout: bpy.types.UILayout, settings, columns: bool = False) -> None:
    """Rows for `Scene.cmc`, in one column, or in two as in Blender's overlay popover."""
    body = layout.column()
    body.active = settings.show_all
    sides = [body, body]
    if columns:
        split = body.split()
        sides = [split.column(align=True), split.column(align=True)]
    for k, name in enumerate(SHOWN):
        sides[2 * k // len(SHOWN)].prop(settings, name)
    sizes = body.column(align=True)
    sizes.active = settings.show_normals or settings.show_tangents
    sizes.use_property_split = not columns
    sizes.use_property_decorate = False
    sizes.prop(settings, "arrow_scale")
    sizes.prop(settings, "arrow_count")
