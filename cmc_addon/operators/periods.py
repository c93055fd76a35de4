"""Close Periods and Tile by Periods. They run as Solve does, see `solve`."""

from types import SimpleNamespace

import bpy

from ..background import worker
from ..properties.periods_settings import (
    CLOSE_SETTINGS,
    TILE_SETTINGS,
    close_annotations,
    draw_close,
    draw_tile,
    tile_annotations,
)
from ..tasks.close_periods import take_closing, take_tiling
from .poll import LEAVE_EDIT_MODE, allow, why_not_solve
from .solve import Solving, as_settings

# Steps of Newton's method that closing usually takes: the bar is half way then.
_USUAL = 4


class Periodic(Solving):
    """What the two have in common."""

    names: tuple[str, ...] = ()

    def wanted(self, plan: bpy.types.Object) -> SimpleNamespace:
        """What the call says, and where it says nothing what is stored with the plan."""
        for name in self.names:
            if not self.properties.is_property_set(name):
                setattr(self, name, getattr(plan.cmc, name))
        values = {name: getattr(self, name) for name in self.names}
        return SimpleNamespace(**{k: v if isinstance(v, (str, int, float)) else tuple(v) for k, v in values.items()})

    def _say_cancelled(self) -> set[str]:
        self.report({"INFO"}, f"{self.bl_label} was cancelled; nothing was changed.")
        return {"CANCELLED"}


class CMC_OT_close_periods(Periodic, bpy.types.Operator):
    """Close the gaps of the shell around the holes of its plan, by a least change of its rim or by moving the holes"""

    bl_idname = "cmc.close_periods"
    bl_label = "Close Periods"
    __annotations__ = close_annotations({"SKIP_SAVE"})
    names = CLOSE_SETTINGS

    def take(self, context, plan):
        return take_closing(context, plan, self.wanted(plan))

    def tell(self, update: worker.Update) -> tuple[float, str]:
        gap = 100.0 * update.residual
        return update.iteration / (update.iteration + _USUAL), f"Step {update.iteration}, gap {gap:.2g} %"

    def draw(self, context):
        as_settings(self.layout)
        draw_close(self.layout, self)


class CMC_OT_tile_periods(Periodic, bpy.types.Operator):
    """Repeat the shell by the gaps around the holes of its plan, across which it goes on as its own copy"""

    bl_idname = "cmc.tile_periods"
    bl_label = "Tile by Periods"
    __annotations__ = tile_annotations({"SKIP_SAVE"})
    names = TILE_SETTINGS

    @classmethod
    def poll(cls, context):
        return allow(cls, LEAVE_EDIT_MODE if context.mode != "OBJECT" else why_not_solve(context))

    def take(self, context, plan):
        return take_tiling(context, plan, self.wanted(plan))

    def tell(self, update: worker.Update) -> tuple[float, str]:
        return 0.5 * update.part, f"Solving, step {update.iteration}"

    def draw(self, context):
        as_settings(self.layout)
        draw_tile(self.layout, self)


CLASSES = (CMC_OT_close_periods, CMC_OT_tile_periods)
