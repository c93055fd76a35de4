"""The operators `bpy.ops.cmc.*`, one file an idea. A new file is named in MODULES."""

from __future__ import annotations

import importlib

import bpy

MODULES = (
    "boundary", "plan", "go_to", "solve", "design", "symmetry", "add", "add_plan", "add_bubble", "modes", "periods",
    "look", "export", "group_presets",
)
"""Files with a tuple CLASSES of operator (and list) classes."""


def _classes() -> list[type]:
    modules = [importlib.import_module(f"{__name__}.{name}") for name in MODULES]
    return [cls for module in modules for cls in module.CLASSES]


def register() -> None:
    for cls in _classes():
        bpy.utils.register_class(cls)


def unregister() -> None:
    for cls in reversed(_classes()):
        if cls.is_registered:
            bpy.utils.unregister_class(cls)
