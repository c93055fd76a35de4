"""Redraws 3D views and the sidebar."""

from __future__ import annotations

import bpy


def redraw() -> None:
    """Redraw every 3D viewport, soon; can be called from a timer."""
    manager = bpy.context.window_manager
    for window in manager.windows if manager else ():
        for area in window.screen.areas:
            if area.type == "VIEW_3D":
                area.tag_redraw()
