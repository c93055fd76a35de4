"""The reports that a solve, a fit and a completion leave with their plan, parsed once for everyone who shows them."""

from __future__ import annotations

import json
from functools import lru_cache

import bpy

from .links import plan_to_solve


def last_report(context: bpy.types.Context) -> dict | None:
    """The report of the last solve of the active plan or result; None without one."""
    plan = plan_to_solve(context)
    return None if plan is None else solve_report(plan)


def last_design(context: bpy.types.Context) -> dict | None:
    """The report of the last fit of the active plan or result; None without one."""
    plan = plan_to_solve(context)
    return None if plan is None else design_report(plan)


def solve_report(plan: bpy.types.Object) -> dict | None:
    """The report of the last solve of this plan; None without one."""
    return _parsed(plan.cmc.report, ("converged",))


def design_report(plan: bpy.types.Object) -> dict | None:
    """The report of the last fit of this plan; None without one."""
    return _parsed(plan.cmc.design_report, ("met", "distances"))


@lru_cache(maxsize=8)
def _parsed(text: str, needed: tuple[str, ...]) -> dict | None:
    """A report as written; None if it is empty or has other contents."""
    try:
        report = json.loads(text)
        report["sheets"][report["sheet"]]["area"]
        return report if all(name in report for name in ("message", *needed)) else None
    except (ValueError, KeyError, TypeError):
        return None
