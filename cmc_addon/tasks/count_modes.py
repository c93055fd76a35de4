"""Count Unstable Modes: two numbers for the report of a shell."""

from __future__ import annotations

from dataclasses import dataclass, replace

import bpy

from ...solver.errors import Progress
from ...solver.notes import Note
from ...solver.shells import form
from ..background import solve_cache
from .shell_task import ShellResult, ShellTask, read_solve
from .solve import solver_settings, write_reports


@dataclass(frozen=True, eq=False)
class CountResult(ShellResult):
    """A shell whose report has the modes of its map."""

    @property
    def message(self) -> str:
        report = self.solved.shell.report
        return modes_text(report.index or 0, report.nullity or 0)


@dataclass(frozen=True, eq=False)
class CountTask(ShellTask[CountResult]):
    """Counts the modes of the shell that Solve makes."""

    @classmethod
    def read(cls, context: bpy.types.Context, plan: bpy.types.Object) -> CountTask:
        """Read the plan. Raises `CmcError` where it cannot be read."""
        return cls(*read_solve(context, plan))

    def work(self, progress: Progress) -> CountResult:
        solved = self.known or self.solve.work(progress)
        with solved.prepared.plan_numbers(self.solve.mesh):
            plan, settings = self.solve.plan(solved.prepared), solver_settings(self.solve.settings)
            shell = form.count_modes(plan, settings, solved.shell)
        counted = replace(solved, shell=shell)
        solve_cache.remember(self.solve, counted)
        return CountResult(counted)

    def write(self, context: bpy.types.Context, plan: bpy.types.Object, result: CountResult) -> list[Note]:
        """Write the numbers into the report, and the shell where it was solved just now."""
        if not self.is_shown(plan):
            return self.solve.write(context, plan, result.solved)
        self.solve.check_unchanged(context, plan)
        warnings = self.solve.all_warnings(result.solved)
        write_reports(context, plan, result.solved, warnings, self.solve.made())
        return []


def modes_text(index: int, nullity: int) -> str:
    """The numbers of unstable and of null modes in a sentence."""
    if index:
        text = f"{index} unstable {'mode' if index == 1 else 'modes'}: a saddle, from which minimisers run away"
    else:
        text = "No unstable mode: a minimum among its neighbours"
    return text + (f"; {nullity} null {'mode' if nullity == 1 else 'modes'}." if nullity else ".")
