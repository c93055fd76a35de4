"""Plans for tests of result objects: a solve, a partly tilted rim."""

from __future__ import annotations

import bpy

# isort: split

from .scenes import activate, add_group, boundary_edges


def solve(plan, **settings):
    activate(plan)
    assert bpy.ops.cmc.solve(**settings) == {"FINISHED"}
    return plan.cmc.f_plus


def tilted(plan, first: int = 12, tilt: float = 0.7):
    """Tilted planes on part of the rim, so that f- is a surface too."""
    add_group(plan, "Tilted", boundary_edges(plan.data)[:first], "BINORMAL", tilt=tilt)
    return plan
