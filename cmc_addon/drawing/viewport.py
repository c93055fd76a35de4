"""Redraws 3D views and the sidebar."""

from __future__ import annotations

import bpy


def redraw(context: bpy.types.Context) -> None:
    for window in context.window_manager.windows:
        for area in window.screen.areas:
            if area.type == "VIEW_3D":
                area.tag_redraw()
