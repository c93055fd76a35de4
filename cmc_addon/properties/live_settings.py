"""The Live switch of a plan, and the size up to which Live solves in full while you drag."""

from __future__ import annotations

import bpy
from bpy.props import BoolProperty

from .changes import notify

LIMIT = 50_000
"""Vertices; the default of the preference."""


def live_annotations() -> dict:
    return {
        "live": BoolProperty(
            name="Live",
            description="The shell follows while you change the plan, its groups or the settings of Solve",
            update=notify,
        )
    }


def limit() -> int:
    """Vertices of a plan above which Live solves roughly until the mouse rests."""
    addon = bpy.context.preferences.addons.get(__package__.partition(".cmc_addon")[0])
    return getattr(addon.preferences if addon is not None else None, "live_limit", LIMIT)
