"""Approximate Surface: the shell nearest to a surface.

It runs as Solve does, see `solve`. In the window the best shape so far is drawn over the scene (`preview`); the scene
itself stays unchanged until the work is done, so that Esc leaves nothing behind.
"""

import math

import bpy

from ...solver.measure.summary import percent
from ..drawing import preview
from ..properties.approximate_settings import APPROXIMATE_SETTINGS, approximate_annotations, take_settings
from ..tasks.approximate import ApproximateTask
from .solve import TaskOperator, as_settings

# Evaluations of a usual fit, after which the progress bar is half full.
_USUAL = 30


class PreviewOperator(TaskOperator):
    """An operator that draws the best shape so far while it runs."""

    _task: ApproximateTask | None = None

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


class CMC_OT_approximate_surface(PreviewOperator, bpy.types.Operator):
    """Find the surface of constant mean curvature whose tangent planes are nearest to those of the active surface"""

    bl_idname = "cmc.approximate_surface"
    bl_label = "Approximate Surface"
    __annotations__ = approximate_annotations({"SKIP_SAVE"})

    def read_task(self, context, plan):
        settings = take_settings(self, plan.cmc, APPROXIMATE_SETTINGS)
        self._task = ApproximateTask.read(context, plan, settings)
        return self._task

    def draw(self, context):
        as_settings(self.layout)
        draw_approximate(self.layout, self)


def draw_approximate(layout: bpy.types.UILayout, owner) -> None:
    """Rows for the settings of Approximate Surface of an object or the operator."""
    layout.prop(owner, "smoothness")
    layout.prop(owner, "match")
    if owner.match == "POSITION":
        layout.prop(owner, "near")


CLASSES = (CMC_OT_approximate_surface,)
