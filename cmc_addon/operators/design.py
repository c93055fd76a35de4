"""Approximate Surface and Fit to Outline: the shell nearest to what is there or wanted.

They run as Solve does, see `solve`. In the window the best shape so far is drawn over the scene (`preview`), which
itself stays as it is until the fit is done: Esc leaves nothing behind.
"""

import math

import bpy

from ..drawing import preview
from ..properties.design_settings import (
    APPROXIMATE_SETTINGS,
    FIT_SETTINGS,
    HEIGHT_PROPERTY,
    POINTERS,
    approximate_annotations,
    fit_annotations,
    take_settings,
    take_targets,
)
from ..tasks.approximate import ApproximateOrder
from ..tasks.design import DesignOrder, read_order
from ..tasks.fit_outline import take_fit
from .solve import Solving, as_settings

# Evaluations of a usual fit: the bar is half way then.
_USUAL = 30


class Designing(Solving):
    """What the two have in common."""

    _order: DesignOrder | None = None

    def tell(self, update) -> tuple[float, str]:
        off = 100.0 * math.sqrt(2.0 * max(update.residual, 0.0))  # the value is half a square, in parts of the size
        return update.iteration / (update.iteration + _USUAL), f"Step {update.iteration}, off by {off:.2g} %"

    def _say_cancelled(self) -> set[str]:
        self.report({"INFO"}, "The fit was cancelled; nothing was changed.")
        return {"CANCELLED"}

    def _advance(self, context: bpy.types.Context) -> set[str]:
        if self._order is not None and self._order.latest is not None:
            preview.show(*self._order.latest)
            self._order.latest = None
        return super()._advance(context)

    def _cleanup(self, context: bpy.types.Context) -> None:
        preview.clear()
        self._order = None
        super()._cleanup(context)


class CMC_OT_approximate_surface(Designing, bpy.types.Operator):
    """Make the surface of constant mean curvature whose tangent planes are nearest to those of the active surface"""

    bl_idname = "cmc.approximate_surface"
    bl_label = "Approximate Surface"
    __annotations__ = approximate_annotations({"SKIP_SAVE"})

    def take(self, context, plan):
        settings = take_settings(self, plan.cmc, APPROXIMATE_SETTINGS)
        given = read_order(context, plan, settings)
        self._order = ApproximateOrder(**given, stored=APPROXIMATE_SETTINGS, role="NEAREST")
        return self._order

    def draw(self, context):
        as_settings(self.layout)
        draw_approximate(self.layout, self)


class CMC_OT_fit_outline(Designing, bpy.types.Operator):
    """Make the shell over the active plan whose rim lies on its outline, on another curve, or goes through anchors"""

    bl_idname = "cmc.fit_outline"
    bl_label = "Fit to Outline"
    __annotations__ = fit_annotations({"SKIP_SAVE"})

    def take(self, context, plan):
        curve, anchors = take_targets(self, plan.cmc).values()
        settings = take_settings(self, plan.cmc, FIT_SETTINGS)
        self._order = take_fit(context, plan, settings, curve, anchors)
        self._order.stored = FIT_SETTINGS
        return self._order

    def draw(self, context):
        as_settings(self.layout)
        draw_fit(self.layout, self)


def draw_approximate(layout: bpy.types.UILayout, owner) -> None:
    """Rows for the settings of Approximate Surface, of an object or the operator."""
    layout.prop(owner, "smoothness")
    layout.prop(owner, "match")
    if owner.match == "POSITION":
        layout.prop(owner, "near")


def draw_fit(layout: bpy.types.UILayout, owner) -> None:
    """Rows for the settings of Fit to Outline, of an object or the operator; only the ones that count now."""
    layout.prop(owner, "fit_to")  # side by side the choices would be cut off in a narrow sidebar
    stored = isinstance(owner, bpy.types.PropertyGroup)
    if owner.fit_to == "CURVE":
        _target_row(layout, owner, "curve", stored, "objects")
    _target_row(layout, owner, "anchors", stored, "collections")
    layout.prop(owner, "height_parameter")
    layout.prop(owner, HEIGHT_PROPERTY[owner.height_parameter], slider=owner.height_parameter == "RISE")
    if owner.fit_to != "ANCHORS":
        layout.prop(owner, "free_heights")
    layout.prop(owner, "limit_tilt")
    if owner.limit_tilt:
        column = layout.column(align=True)
        column.prop(owner, "tilt_min")
        column.prop(owner, "tilt_max")
    layout.prop(owner, "hanging")


def _target_row(layout: bpy.types.UILayout, owner, name: str, stored: bool, among: str) -> None:
    if stored:
        layout.prop(owner, POINTERS[name])
    else:
        layout.prop_search(owner, name, bpy.data, among)


CLASSES = (CMC_OT_approximate_surface, CMC_OT_fit_outline)
