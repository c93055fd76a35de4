"""The reports that a solve, a fit and a completion leave with their plan, parsed once for everyone who shows them."""

from __future__ import annotations

import json
from functools import lru_cache

import bpy

from .links import plan_to_solve
from .units import percent_text

# The finest evenness of H that a sentence claims: 0.01 %.
_FINEST = 1e-4


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


def shown_sheet(report: dict) -> dict:
    """The numbers of the sheet that a report is about."""
    return report["sheets"][report["sheet"]]


def done_sentence(report: dict) -> str:
    """The message of a solve; if it converged to a closed shell, with the measured evenness of H."""
    H = shown_sheet(report)["mean_curvature"]
    if not H or not report["converged"] or report.get("is_open") or report.get("closing"):
        return report["message"]
    return f"Done. Curvature is even to {percent_text(max(H['relative_l2'], _FINEST))}."


@lru_cache(maxsize=8)
def _parsed(text: str, needed: tuple[str, ...]) -> dict | None:
    """A report as written; None if it is empty or has other contents."""
    try:
        report = json.loads(text)
        shown_sheet(report)["area"]
        return report if all(name in report for name in ("message", *needed)) else None
    except (ValueError, KeyError, TypeError):
        return None
