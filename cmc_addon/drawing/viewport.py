"""3D views: what they show, and how to draw them again."""

from __future__ import annotations

import bpy
import numpy as np

from .screen import Screen


def screen_of(context: bpy.types.Context) -> Screen:
    """The screen of the 3D view that is drawn or under the mouse."""
    region = context.region
    matrix = np.array(context.region_data.perspective_matrix, dtype=np.float64)
    return Screen(matrix, float(region.width), float(region.height))


def right_end(context: bpy.types.Context) -> float:
    """Where the sidebar begins that lies over the view, in pixels of the region."""
    sides = [region.x - context.region.x for region in context.area.regions if region.type == "UI" and region.width > 1]
    return float(min([context.region.width, *sides]))


def redraw() -> None:
    """Redraw every 3D viewport, soon; can be called from a timer."""
    manager = bpy.context.window_manager
    for window in manager.windows if manager else ():
        for area in window.screen.areas:
            if area.type == "VIEW_3D":
                area.tag_redraw()
