"""Unstable modes of one plan's shell, counted: the counterpart of `forming` that adds two numbers to its report."""

from __future__ import annotations

import json
from dataclasses import dataclass, replace
from types import SimpleNamespace

import bpy

from ...solver.errors import CmcError, Progress
from ...solver.shells import form
from ..background import solve_cache
from ..bridges.numbering import in_plan_numbers
from ..properties.links import result_of
from .solve import (
    Order,
    Outcome,
    check_unchanged,
    deliver,
    plan_depsgraph,
    settings_of,
    solver_settings,
    take_order,
    tell,
)


@dataclass(frozen=True, eq=False)
class CountOrder:
    """All that counting needs, without any Blender data: safe in a thread.

    solve: the solve of the plan. known: what it gave, if it was done before.
    """

    solve: Order
    known: Outcome | None

    @property
    def name(self) -> str:
        return self.solve.name

    @property
    def settings(self) -> SimpleNamespace:
        return self.solve.settings

    def work(self, progress: Progress) -> CountOutcome:
        """Solve if need be, and count. Raises `CmcError` in the plan's own numbering."""
        outcome = self.known or self.solve.work(progress)
        mesh, prepared = self.solve.mesh, outcome.prepared
        try:
            plan = self.solve.plan(prepared)
            shell = form.count_modes(plan, solver_settings(self.settings), outcome.shell)
        except CmcError as error:
            raise in_plan_numbers(error, mesh, prepared.triangles, prepared.owners) from error
        counted = replace(outcome, shell=shell)
        solve_cache.remember(self.solve, counted)
        return CountOutcome(counted)

    def deliver(self, context: bpy.types.Context, plan: bpy.types.Object, outcome: CountOutcome) -> list[str]:
        """Write the numbers into the report; the shell, too, where it was solved for just now. Returns warnings.

        Raises `CmcError`, with nothing changed, where the plan is not what it was when the order was taken.
        """
        if self.known is None or result_of(plan, self.settings.sheet) is None:
            return deliver(context, plan, self.solve, outcome.outcome)
        check_unchanged(plan, plan_depsgraph(context, self.settings), self.solve.mesh)
        tell(context, plan, outcome.outcome, [*self.solve.warnings, *outcome.outcome.shell.warnings])
        return []


@dataclass(frozen=True, eq=False)
class CountOutcome:
    """A shell whose report has the modes of its map."""

    outcome: Outcome

    @property
    def converged(self) -> bool:
        return self.outcome.converged

    @property
    def message(self) -> str:
        return modes_text(self.outcome.shell.report.index or 0, self.outcome.shell.report.nullity or 0)


def modes_text(index: int, nullity: int) -> str:
    """What the numbers of unstable and of null modes mean."""
    if index:
        found = f"{index} unstable {'mode' if index == 1 else 'modes'}: a saddle, from which minimisers run away"
    else:
        found = "No unstable mode: a minimum among its neighbours"
    return found + (f"; {nullity} null {'mode' if nullity == 1 else 'modes'}." if nullity else ".")


def take_count(context: bpy.types.Context, plan: bpy.types.Object) -> CountOrder:
    """Read the plan. Raises `CmcError` where it cannot be read, and where its shell is not that of Solve."""
    if _is_closed(plan.cmc.report):
        raise CmcError(
            f"The shell of '{plan.name}' was closed by Close Periods, and modes are counted of the one that Solve "
            "makes; solve again first."
        )
    order = take_order(context, plan, settings_of(plan.cmc))
    return CountOrder(order, solve_cache.recall(order))


def _is_closed(text: str) -> bool:
    try:
        return bool(text) and "closing" in json.loads(text)
    except (ValueError, TypeError):
        return False
