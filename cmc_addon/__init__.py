"""The Blender side of the extension: what the user sees, and the way to the solver and back."""

from __future__ import annotations

import importlib
from types import ModuleType

MODULES = (
    "properties.stored", "background.worker", "operators", "bridges.group_history", "bridges.geometry_changes",
    "drawing.overlay_draw", "drawing.shading", "results.colours", "drawing.preview", "live.follow",
    "background.solve_cache", "tasks.complete", "panels.tab", "panels.overlay_panel", "panels.boundary_panel",
    "panels.design_panel", "panels.symmetry_panel", "panels.results_panel", "drawing.legend",
    "drawing.curvature_lines_overlay", "panels.colours_panel", "live.live", "panels.live_panel",
    "tasks.close_periods", "panels.periods_panel", "panels.export_panel", "panels.menus", "properties.preferences",
    "panels.sidebar", "operators.manual", "headless.cli",
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
