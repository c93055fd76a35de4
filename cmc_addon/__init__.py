"""The Blender side of the extension: what the user sees, and the way to the solver and back."""

from __future__ import annotations

import importlib
from types import ModuleType

MODULES = (
    "properties", "session", "operators", "group_history", "mesh_cache",
    "seeing_draw", "shading", "colours",
    "preview", "following", "solved", "symmetry", "panels", "seeing_panel", "boundary_panel", "design_panel",
    "symmetry_panel", "results_panel", "legend", "strokes_overlay", "colours_panel",
    "nearness", "live", "live_panel", "periods", "periods_panel", "export_panel",
    "menus", "preferences", "manual", "cli",
)
"""Sub-modules with register() and unregister(), in the order in which they need each other."""


def _modules() -> list[ModuleType]:
    return [importlib.import_module(f"{__name__}.{name}") for name in MODULES]


def register() -> None:
    """Register every module in order. If one fails, those before it are taken back, in reverse,
    and the error goes on to Blender: a half-registered add-on is worse than none."""
    done: list[ModuleType] = []
    try:
        for module in _modules():
            done.append(module)
            module.register()
    except BaseException:
        _unregister(done)
        raise


def unregister() -> None:
    _unregister(_modules())


def _unregister(modules: list[ModuleType]) -> None:
    """Unregister in reverse order; modules must bear being asked when only half registered."""
    for module in reversed(modules):
        module.unregister()
