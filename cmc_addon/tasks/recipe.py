"""The recipe of a plan: what was made of its shell is made again with the next one.

Where that takes long, and while a change is dragged, it is hidden instead and marked as behind: it is of an older shell
until *Update All*.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import bpy

from ...solver.errors import CmcError, Progress
from ...solver.notes import Note
from ..properties.links import copies_of, result_of
from ..properties.reports import complete_report
from .complete import CompleteResult, CompleteTask
from .solve import SolveResult, SolveTask
from .task import Result, Task
from .tile import TileTask

# Faces of all copies up to which they are made again unasked.
_QUICK = 100_000

_WAYS: dict[str, type[CompleteTask]] = {task.way: task for task in (CompleteTask, TileTask)}


def is_behind(plan: bpy.types.Object) -> bool:
    """Whether what was made of the shell is of an older one."""
    return plan.cmc.behind and _is_made(plan)


def with_recipe(plan: bpy.types.Object, solve: SolveTask) -> SolveTask | RecipeTask:
    """A solve of a plan, and the copies of its shell if there are any, unless they are many faces.

    Raises `CmcError` where there are no such copies any more.
    """
    report = complete_report(plan)
    if report is None or not _is_made(plan) or report["copies"] * len(plan.data.polygons) > _QUICK:
        return solve
    task = _WAYS[plan.cmc.repeated]
    return RecipeTask(solve, task.on(plan, solve, None, task.stored(plan)))


def made_again(context: bpy.types.Context, plan: bpy.types.Object) -> CompleteTask:
    """What was made of a plan's shell, again. Raises `CmcError` where that was nothing, or it cannot be read."""
    if not _is_made(plan):
        raise CmcError(f"Nothing was made of the shell of '{plan.name}' that could be made again; repeat it first.")
    task = _WAYS[plan.cmc.repeated]
    return task.read(context, plan, task.stored(plan))


def _is_made(plan: bpy.types.Object) -> bool:
    """Copies by gaps are no longer part of the recipe of a shell that is kept closed."""
    repeats = plan.cmc.repeated == "SYMMETRY" or (plan.cmc.repeated == "GAPS" and not plan.cmc.keep_closed)
    return repeats and (result_of(plan, "COMPLETED") is not None or copies_of(plan) is not None)


@dataclass(frozen=True, eq=False)
class MadeResult(Result):
    """A shell and its copies, or why there are none; None where they were not asked for."""

    solved: SolveResult
    copies: CompleteResult | CmcError | None

    @property
    def converged(self) -> bool:
        return self.solved.converged

    @property
    def message(self) -> str:
        return self.copies.message if isinstance(self.copies, CompleteResult) else self.solved.message


@dataclass(frozen=True, eq=False)
class RecipeTask(Task[MadeResult]):
    """A solve, and the copies of its shell. Where those cannot be made the shell alone is written, with a warning."""

    solve: SolveTask
    repeat: CompleteTask

    @property
    def tolerance(self) -> float:
        return self.solve.tolerance

    def shows(self) -> str:
        return self.repeat.shows()

    def work(self, progress: Progress) -> MadeResult:
        solved = self.solve.work(progress)
        return MadeResult(solved, self.copied(solved, progress))

    def copied(self, solved: SolveResult, progress: Progress) -> CompleteResult | CmcError:
        """The copies of a shell, or why there are none."""
        try:
            return replace(self.repeat, known=solved).work(progress)
        except CmcError as error:
            return error

    def write(self, context: bpy.types.Context, plan: bpy.types.Object, result: MadeResult) -> list[Note]:
        warnings = self.solve.write(context, plan, result.solved)
        return [*warnings, *self.write_copies(context, plan, result.copies, warnings)] if result.copies else warnings

    def write_copies(
        self,
        context: bpy.types.Context,
        plan: bpy.types.Object,
        copies: CompleteResult | CmcError,
        known: list[Note],
    ) -> list[Note]:
        """Write the copies over the shell, which is written; returns the warnings that are not known."""
        if isinstance(copies, CmcError):
            return [Note("not-repeated", f"The shell was not repeated: {copies}")]
        return [note for note in self.repeat.write_copies(context, plan, copies) if note not in known]

