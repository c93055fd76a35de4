"""Approximate Surface and Fit to Outline: the shell nearest to a surface, an outline or anchors.

They run as Solve does, see `solve`. In the window the best shape so far is drawn over the scene (`preview`); the scene
itself stays unchanged until the fit is done, so that Esc leaves nothing behind.
"""

import math

import bpy

from ...solver.measure.summary import percent
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
from ..tasks.approximate import ApproximateTask
from ..tasks.design import DesignTask
from ..tasks.fit_outline import FitTask
from .solve import TaskOperator, as_settings

# Evaluations of a usual fit, after which the progress bar is half full.
_USUAL = 30


class DesignOperator(TaskOperator):
    """The common part of Fit to Outline and Approximate Surface."""

    _task: DesignTask | None = None

    def progress_of(self, step) -> tuple[float, str]:
        off = math.sqrt(2.0 * max(step.residual, 0.0))  # the value is half a square, relative to the size
        return step.iteration / (step.iteration + _USUAL), f"Step {step.iteration}, off by {percent(off)}"

    def _advance(self, context: bpy.types.Context) -> set[str]:
        if self._task is not None and self._task.latest is not None:
            preview.show(*self._task.latest)
            self._task.latest = None
        return super()._advance(context)

    def _cleanup(self, context: bpy.types.Context) -> None:
        preview.clear()
        self._task = None
        super()._cleanup(context)


class CMC_OT_approximate_surface(DesignOperator, bpy.types.Operator):
    """Find the surface of constant mean curvature whose tangent planes are nearest to those of the active surface"""

    bl_idname = "cmc.approximate_surface"
    bl_label = "Approximate Surface"
    __annotations__ = approximate_annotations({"SKIP_SAVE"})

    def read_task(self, context, plan):
        settings = take_settings(self, plan.cmc, APPROXIMATE_SETTINGS)
        self._task = ApproximateTask.read(context, plan, settings, stored=APPROXIMATE_SETTINGS)
        return self._task

    def draw(self, context):
        as_settings(self.layout)
        draw_approximate(self.layout, self)


class CMC_OT_fit_outline(DesignOperator, bpy.types.Operator):
    """Find the shell over the active plan whose rim lies on its outline or another curve, or passes through anchors"""

    bl_idname = "cmc.fit_outline"
    bl_label = "Fit to Outline"
    __annotations__ = fit_annotations({"SKIP_SAVE"})

    def read_task(self, context, plan):
        curve, anchors = take_targets(self, plan.cmc).values()
        settings = take_settings(self, plan.cmc, FIT_SETTINGS)
        self._task = FitTask.read(context, plan, settings, curve, anchors, stored=FIT_SETTINGS)
        return self._task

    def draw(self, context):
        as_settings(self.layout)
        draw_fit(self.layout, self)


def draw_approximate(layout: bpy.types.UILayout, owner) -> None:
    """Rows for the settings of Approximate Surface of an object or the operator."""
    layout.prop(owner, "smoothness")
    layout.prop(owner, "match")
    if owner.match == "POSITION":
        layout.prop(owner, "near")


def draw_fit(layout: bpy.types.UILayout, owner) -> None:
    """Rows for the settings of Fit to Outline of an object or the operator; only those with an effect now."""
    layout.prop(owner, "fit_to")  # in one row a narrow sidebar cuts the choices off
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
