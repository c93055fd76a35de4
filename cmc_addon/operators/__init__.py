"""The operators `bpy.ops.cmc.*`, one file an idea.

An operator checks whether it can run (`poll.py`), reads its settings and runs a task (`modal.py`, `solve.py`). What it
does to the scene is written in `tasks` and `results`. A new file goes into MODULES.
"""

from __future__ import annotations

from ..properties.registration import registration
from . import (
    add,
    add_bubble,
    add_plan,
    approximate,
    boundary,
    export,
    go_to,
    group_presets,
    live,
    look,
    modes,
    periods,
    plan,
    solve,
    symmetry,
    weld,
)

MODULES = (
    boundary, plan, go_to, solve, approximate, symmetry, add, add_plan, add_bubble, modes, periods, look, export,
    group_presets, weld, live,
)
"""Files with a tuple CLASSES of operator classes."""

CLASSES = tuple(cls for module in MODULES for cls in module.CLASSES)

register, unregister = registration(CLASSES)
