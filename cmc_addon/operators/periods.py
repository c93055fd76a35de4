"""Close Gaps and Repeat by Gaps; they run as Solve does, see `solve`."""

from types import SimpleNamespace

import bpy

from ...solver.measure.summary import percent
from ..background import worker
from ..properties.periods_settings import (
    CLOSE_SETTINGS,
    TILE_SETTINGS,
    close_annotations,
    draw_close,
    draw_tile,
    tile_annotations,
)
from ..tasks.close_periods import CloseTask, TileTask
from .poll import allow, why_not_object_mode, why_not_solve
from .solve import ShellOperator, TaskOperator, as_settings

# Newton steps of a usual closing, after which the progress bar is half full.
_USUAL = 4


class PeriodsOperator(TaskOperator):
    """The common part of Close Gaps and Repeat by Gaps."""

    names: tuple[str, ...] = ()

    def wanted(self, plan: bpy.types.Object) -> SimpleNamespace:
        """The settings of the call; those that it leaves out are the plan's own."""
        for name in self.names:
            if not self.properties.is_property_set(name):
                setattr(self, name, getattr(plan.cmc, name))
        values = {name: getattr(self, name) for name in self.names}
        return SimpleNamespace(**{k: v if isinstance(v, (str, int, float)) else tuple(v) for k, v in values.items()})


class CMC_OT_close_periods(PeriodsOperator, bpy.types.Operator):
    """Close the shell's gaps around the holes of its plan, by the least change of its rim or by moving the holes"""

    bl_idname = "cmc.close_periods"
    bl_label = "Close Gaps"
    __annotations__ = close_annotations({"SKIP_SAVE"})
    names = CLOSE_SETTINGS

    def read_task(self, context, plan):
        return CloseTask.read(context, plan, self.wanted(plan))

    def progress_of(self, step: worker.Step) -> tuple[float, str]:
        return step.iteration / (step.iteration + _USUAL), f"Step {step.iteration}, gap {percent(step.residual)}"

    def draw(self, context):
        as_settings(self.layout)
        draw_close(self.layout, self)


class CMC_OT_tile_periods(PeriodsOperator, ShellOperator, bpy.types.Operator):
    """Repeat the shell by its gaps around the holes of the plan: each copy continues the last one across the gap"""

    bl_idname = "cmc.tile_periods"
    bl_label = "Repeat by Gaps"
    __annotations__ = tile_annotations({"SKIP_SAVE"})
    names = TILE_SETTINGS

    @classmethod
    def poll(cls, context):
        return allow(cls, why_not_object_mode(context) or why_not_solve(context))

    def read_task(self, context, plan):
        return TileTask.read(context, plan, self.wanted(plan))

    def draw(self, context):
        as_settings(self.layout)
        draw_tile(self.layout, self)


CLASSES = (CMC_OT_close_periods, CMC_OT_tile_periods)
