"""The Blender side of the extension: the user interface, and the way to the solver and back.

One Solve, from the click to the shell, room by room:

1. `panels` draw the button; `operators/poll.py` says whether it can be pressed.
2. `operators/modal.py` runs the steps of `operators/solve.py` a little at a time, so that the window keeps drawing.
3. `properties/links.py` finds the plan of the active object.
4. `tasks/solve.py`, `SolveTask.read`: `bridges/mesh_bridge.py` reads the mesh and its boundary groups into arrays.
5. `background/worker.py` starts a thread; in it `SolveTask.work` takes triangles and solver of the plan from
   `background/plan_cache.py`, and `solver.shells.form` forms, sizes, places and measures the shell.
6. `background/solve_cache.py` keeps the result for Repeat by Symmetry and its like.
7. Back in Blender's thread `SolveTask.write` checks that the plan is unchanged; `results/objects.py` makes or updates
   the result objects through `bridges/result_bridge.py`, and `results/colours.py` colours them.
8. `drawing` shows the overlay at the next redraw, and the panels the report, parsed by `properties/reports.py`.

`live` and `headless` are the two other ways in; both run the same tasks.
"""

from __future__ import annotations

import importlib
from types import ModuleType

import bpy

MODULES = (
    "properties.stored", "background.worker", "operators", "bridges.group_history", "bridges.geometry_changes",
    "drawing.overlay_draw", "drawing.handle_gizmos", "drawing.shading", "results.colours", "drawing.preview",
    "background.solve_cache", "tasks.complete", "panels.plan_panel", "panels.shell_panel", "panels.overlay_panel",
    "panels.boundary_panel", "panels.approximate_panel", "panels.symmetry_panel", "panels.results_panel",
    "drawing.legend", "drawing.curvature_lines_overlay", "panels.colours_panel", "live.live",
    "panels.periods_panel", "panels.export_panel", "panels.menus", "properties.preferences",
    "panels.sidebar", "operators.manual", "headless.cli",
)
"""Sub-modules with register() and unregister(), each after those it needs."""


def _modules() -> list[ModuleType]:
    return [importlib.import_module(f"{__name__}.{name}") for name in MODULES]


def register() -> None:
    """Register every module in order.

    If one fails, unregister those before it, in reverse, and raise: a half-registered add-on is worse than none. What
    is registered already is taken back first, or everything would be called twice.
    """
    if hasattr(bpy.types.Object, "cmc"):
        unregister()
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
    """Unregister in reverse order. A module may be only half registered, see `properties.registration`."""
    for module in reversed(modules):
        module.unregister()
