"""The reports that a solve and a fit leave with their plan, parsed once and shared by all that show them."""

from __future__ import annotations

import json
from functools import lru_cache

import bpy

from .links import plan_to_solve


def last_report(context: bpy.types.Context) -> dict | None:
    """The report of the active plan or result; None where nothing was solved."""
    plan = plan_to_solve(context)
    return None if plan is None else solve_report(plan)


def last_design(context: bpy.types.Context) -> dict | None:
    """The report of the last fit of the active plan or result; None where there was none."""
    plan = plan_to_solve(context)
    return None if plan is None else design_report(plan)


def solve_report(plan: bpy.types.Object) -> dict | None:
    """What the last solve of this plan left; None where there was none."""
    return _parsed(plan.cmc.report, ("converged",))


def design_report(plan: bpy.types.Object) -> dict | None:
    """What the last fit of this plan left; None where there was none."""
    return _parsed(plan.cmc.design_report, ("met", "distances"))


@lru_cache(maxsize=8)
def _parsed(text: str, needed: tuple[str, ...]) -> dict | None:
    """A report as it was written; None if there is none or somebody else wrote into the property."""
    try:
        found = json.loads(text)
        found["sheets"][found["sheet"]]["area"]
        return found if all(name in found for name in ("message", *needed)) else None
    except (ValueError, KeyError, TypeError):
        return None
