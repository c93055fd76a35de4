"""Who is told when a setting of a plan is changed, by hand or by a script."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import bpy

watchers: list[Callable[[bpy.types.ID], None]] = []
"""Called with the object or the mesh of which something has changed: settings are the object's, groups the mesh's."""


def tell(owner, _context) -> None:
    """For `update` of a property that is stored."""
    for told in watchers:
        told(owner.id_data)


def telling(make: partial):
    """The property of this maker, telling of its changes after what it does on them by itself."""
    own = make.keywords.get("update")

    def both(owner, context) -> None:
        own(owner, context)
        tell(owner, context)

    return make(update=tell if own is None else both)
