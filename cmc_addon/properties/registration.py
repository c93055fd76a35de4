"""How a module registers with Blender: its classes and its functions on the lists of `bpy.app.handlers`.

    register, unregister = registration(CLASSES)

`bpy.utils.register_classes_factory` does the same for classes; its `unregister` raises where registering stopped
half-way. This one leaves out what is not registered, see `cmc_addon.register`, and registers nothing twice.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping

import bpy


def registration(
    classes: Iterable[type] = (), handlers: Mapping[str, Callable] | None = None
) -> tuple[Callable[[], None], Callable[[], None]]:
    """`register()` and `unregister()` for classes, in order and in reverse, and for handlers.

    handlers: name of a list in `bpy.app.handlers` -> the function to append to it.
    """
    known, lists = tuple(classes), dict(handlers or {})

    def register() -> None:
        for cls in known:
            if not _is_registered(cls):
                bpy.utils.register_class(cls)
        for name, handler in lists.items():
            if handler not in getattr(bpy.app.handlers, name):
                getattr(bpy.app.handlers, name).append(handler)

    def unregister() -> None:
        for name, handler in lists.items():
            if handler in getattr(bpy.app.handlers, name):
                getattr(bpy.app.handlers, name).remove(handler)
        for cls in reversed(known):
            if _is_registered(cls):
                bpy.utils.unregister_class(cls)

    return register, unregister


def _is_registered(cls: type) -> bool:
    """As `cls.is_registered` says, which gizmos and their groups do not have."""
    return "bl_rna" in cls.__dict__
