"""The reports that a solve, an approximation and a completion leave with their plan, parsed once for all panels."""

from __future__ import annotations

import json
from functools import lru_cache

import bpy

from .links import is_orphan, plan_to_solve, shown_shell
from .stored import DESIGN_ROLES


def last_report(context: bpy.types.Context) -> dict | None:
    """The report of the shell that is shown (see `shown_shell`); without any that of the last solve of the plan."""
    plan, shell = plan_to_solve(context), shown_shell(context)
    if shell is not None and (shell.cmc.role in DESIGN_ROLES or is_orphan(shell)):
        return shell_report(shell)
    return None if plan is None else solve_report(plan)


def shell_report(shell: bpy.types.Object) -> dict | None:
    """The report that a result carries itself; None without one."""
    return _of_shell(str(shell.get("cmc_report", "")), ("converged",))


def is_design(report: dict) -> bool:
    """Whether a report is of Approximate Surface."""
    return "met" in report and "distances" in report


def last_design(context: bpy.types.Context) -> dict | None:
    """The report of the last approximation of the active surface or its result; None without one."""
    plan = plan_to_solve(context)
    return None if plan is None else design_report(plan)


def solve_report(plan: bpy.types.Object) -> dict | None:
    """The report of the last solve of this plan; None without one."""
    return _of_shell(plan.cmc.report, ("converged",))


def design_report(plan: bpy.types.Object) -> dict | None:
    """The report of the last approximation of this surface; None without one."""
    return _of_shell(plan.cmc.design_report, ("met", "distances"))


def complete_report(plan: bpy.types.Object) -> dict | None:
    """The report of the last completion of this plan; None without one."""
    return _parsed(plan.cmc.complete_report, ("copies", "largest_gap", "relative_gap"))


@lru_cache(maxsize=8)
def _of_shell(text: str, needed: tuple[str, ...]) -> dict | None:
    """A report with the measures of the shown sheet; None otherwise."""
    report = _parsed(text, ("message", "sheets", "sheet", *needed))
    try:
        return report if report is None or "area" in report["sheets"][report["sheet"]] else None
    except (KeyError, TypeError, IndexError):
        return None


def warnings_in(report: dict) -> list[tuple[str, str]]:
    """Code and text of the warnings in a report; one of an older version has texts only."""
    notes = report.get("warnings", ())
    return [(note["code"], note["text"]) if isinstance(note, dict) else ("", note) for note in notes]


def shown_sheet(report: dict) -> dict:
    """The numbers of the sheet that a report is about."""
    return report["sheets"][report["sheet"]]


@lru_cache(maxsize=8)
def _parsed(text: str, needed: tuple[str, ...]) -> dict | None:
    """A report with these entries; None if there is none or another program wrote into the property."""
    try:
        report = json.loads(text)
    except (ValueError, RecursionError):
        return None
    return report if isinstance(report, dict) and all(name in report for name in needed) else None
