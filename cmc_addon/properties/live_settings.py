"""The switch of Live, for `Object.cmc`, and how large a plan may be to be answered in full while it is dragged."""

from __future__ import annotations

import bpy
from bpy.props import BoolProperty

from .changes import tell

LIMIT = 50_000
"""Vertices, where the preferences say nothing."""


def live_annotations() -> dict:
    return {
        "live": BoolProperty(
            name="Live",
            description="The shell follows while the plan, its groups and the settings of the solve are changed",
            update=tell,
        )
    }


def limit() -> int:
    """Vertices of a plan above which the answer to a change is a rough one until the mouse rests."""
    addon = bpy.context.preferences.addons.get(__package__.partition(".cmc_addon")[0])
    return getattr(addon.preferences if addon is not None else None, "live_limit", LIMIT)
