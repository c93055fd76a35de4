"""The sidebar tab of the panels: Blender moves a panel only when it is registered anew."""

from __future__ import annotations

import bpy

from ..properties import preferences
from ..properties.preferences import CATEGORY
from .tab import Tab


def put_into(category: str) -> None:
    """Move all panels into a tab; an empty name means the default."""
    category = category.strip() or CATEGORY
    if Tab.bl_category == category:
        return
    Tab.bl_category = category
    panels = sorted(_registered(Tab), key=_depth)
    for cls in reversed(panels):
        bpy.utils.unregister_class(cls)
    for cls in panels:
        bpy.utils.register_class(cls)


def _registered(base: type) -> list[type]:
    """Registered panels that derive from a class."""
    panels = []
    for cls in base.__subclasses__():
        if issubclass(cls, bpy.types.Panel) and cls.is_registered:
            panels.append(cls)
        panels += _registered(cls)
    return list(dict.fromkeys(panels))


def _depth(cls: type) -> int:
    """Number of panels around a panel; a parent must be registered before its children."""
    parent = getattr(cls, "bl_parent_id", "")
    return 1 + _depth(getattr(bpy.types, parent)) if parent else 0


def register() -> None:
    put_into(preferences.get("category"))
    preferences.CATEGORY_CHANGED.append(put_into)


def unregister() -> None:
    if put_into in preferences.CATEGORY_CHANGED:
        preferences.CATEGORY_CHANGED.remove(put_into)
    put_into(CATEGORY)
