"""What the viewport shows of plans and shells: properties of `Scene.cmc` and their rows in the panel."""

from __future__ import annotations

from functools import partial

import bpy
from bpy.props import BoolProperty, FloatProperty, IntProperty

_SHOWN = {
    "show_all": partial(
        BoolProperty, name="Show", description="Draw what belongs to the active plan over the viewport", default=True),
    "show_groups": partial(
        BoolProperty, name="Boundary Groups", default=True,
        description="Draw the boundary groups of the active plan as coloured lines"),
    "show_ungrouped": partial(
        BoolProperty, name="Edges in No Group", default=True,
        description="Draw boundary edges that are in no group as dashed grey lines"),
    "show_normals": partial(
        BoolProperty, name="Boundary Normals", default=True,
        description="Draw where the shell will face at its rim: an arrow square to its tangent plane. "
        "Along a mirror, strokes in the plane in which it may turn"),
    "show_tangents": partial(
        BoolProperty, name="Tangent Planes", default=False,
        description="Draw pieces of the planes that the shell will touch along its rim"),
    "show_mirrors": partial(
        BoolProperty, name="Mirrors and Planes", default=False,
        description="Draw the planes of mirrors and constant planes: as the plan's edges suggest them, and after a "
        "solve where the shell has them"),
    "show_gaps": partial(
        BoolProperty, name="Gaps", default=True,
        description="Draw the gap around each hole of the active plan as an arrow"),
    "show_cut": partial(
        BoolProperty, name="Cut", default=True,
        description="Draw the line along which a shell that does not close is cut open, on the plan and on the shell"),
}
_SIZES = {
    "arrow_scale": partial(
        FloatProperty, name="Arrow Size", description="Length of the arrows, relative to the usual one",
        default=1.0, min=0.05, soft_min=0.2, soft_max=4.0, max=50.0),
    "arrow_count": partial(
        IntProperty, name="Arrows", description="How many arrows there are at most around the whole boundary",
        default=64, min=4, soft_max=200, max=2000),
}
SHOWN = tuple(name for name in _SHOWN if name != "show_all")
"""Names of the switches, without the one above them all."""

OVERLAY_SETTINGS = (*_SHOWN, *_SIZES)


def overlay_annotations() -> dict:
    """The settings as annotations of `Scene.cmc`; they are of the view, so that they are not animated."""
    return {name: make(options=set()) for name, make in (_SHOWN | _SIZES).items()}


def draw_overlay(layout: bpy.types.UILayout, settings, columns: bool = False) -> None:
    """Rows for `Scene.cmc`, in two columns as Blender's own popover of overlays has them, or in one."""
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
