"""Repeat by Gaps; it runs as Solve does, see `solve`."""

from types import SimpleNamespace

import bpy

from ..properties.closing_settings import TILE_SETTINGS, draw_tile, tile_annotations
from ..tasks.tile import TileTask
from .poll import allow, why_not_object_mode, why_not_solve
from .solve import ShellOperator, as_settings


class CMC_OT_tile_periods(ShellOperator, bpy.types.Operator):
    """Leave the shell open around holes, and repeat it: each copy continues the last one across the gap"""

    bl_idname = "cmc.tile_periods"
    bl_label = "Repeat by Gaps"
    __annotations__ = tile_annotations({"SKIP_SAVE"})

    @classmethod
    def poll(cls, context):
        return allow(cls, why_not_object_mode(context) or why_not_solve(context))

    def read_task(self, context, plan):
        """The settings of the call; those that it leaves out are the plan's own."""
        for name in TILE_SETTINGS:
            if not self.properties.is_property_set(name):
                setattr(self, name, getattr(plan.cmc, name))
        wanted = SimpleNamespace(tile_as=self.tile_as, tile_repeat=tuple(self.tile_repeat))
        return TileTask.read(context, plan, wanted)

    def draw(self, context):
        as_settings(self.layout)
        draw_tile(self.layout, self)


CLASSES = (CMC_OT_tile_periods,)
