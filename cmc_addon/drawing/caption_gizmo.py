"""A caption beside the mouse over the rim of the plan: what the shell does along that side.

It is a gizmo only to hear where the mouse is: it is never found there, so that a click goes to what lies below.
"""

from __future__ import annotations

from dataclasses import dataclass

import bpy
import numpy as np
from numpy.typing import NDArray

from . import handle_draw
from .screen import distance
from .viewport import right_end, screen_of

Array = NDArray[np.float64]

# Pixels at an interface scale of 1 from which on the mouse is over a side.
_NEAR = 8.0


@dataclass(frozen=True, eq=False)
class Side:
    """Points (n, 3) of a part of the rim, in the world, and what to say of it."""

    points: Array
    text: str


class CMC_GT_caption(bpy.types.Gizmo):
    """Says what the shell does along the side under the mouse"""

    bl_idname = "CMC_GT_caption"
    __slots__ = ("at", "sides", "text")

    def setup(self) -> None:
        self.sides, self.text, self.at = [], "", np.zeros(2)

    def test_select(self, context, location) -> int:
        mouse, near = np.array(location, dtype=np.float64), _NEAR * context.preferences.system.ui_scale
        text, screen = "", screen_of(context)
        for side in self.sides:
            away = distance(screen.pixels(side.points), mouse)
            if away <= near:
                text, near = side.text, away
        if text != self.text:
            context.area.tag_redraw()
        self.text, self.at = text, mouse
        return -1

    def draw(self, context) -> None:
        if self.text:
            with handle_draw.blended():
                handle_draw.caption(self.text, self.at, context.preferences.system.ui_scale, right_end(context))
