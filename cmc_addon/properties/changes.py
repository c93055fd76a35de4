"""Notifies watchers when a setting of a plan changes, by hand or by a script."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import bpy

watchers: list[Callable[[bpy.types.ID], None]] = []
"""Called with the data-block that changed: settings belong to the object, groups to the mesh."""


def notify(owner, _context) -> None:
    """The `update` callback of a stored property."""
    for watcher in watchers:
        watcher(owner.id_data)


def notifying(make: partial):
    """The property of this maker; it notifies the watchers after its own update callback."""
    own = make.keywords.get("update")
    if own is None:
        return make(update=notify)

    def both(owner, context) -> None:
        own(owner, context)
        notify(owner, context)

    return make(update=both)
