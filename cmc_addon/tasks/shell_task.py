"""The common part of Count Unstable Modes, Repeat by Symmetry and Repeat by Gaps: a shell to start from.

Where the plan has changed since its last solve it is solved first, and its results are written as Solve writes them.
"""

from __future__ import annotations

from dataclasses import dataclass

import bpy

from ..background import solve_cache
from ..properties.links import result_of
from .solve import SolveResult, SolveTask, settings_of
from .task import R, Result, Task


@dataclass(frozen=True, eq=False)
class ShellResult(Result):
    """A result made from a shell."""

    solved: SolveResult

    @property
    def converged(self) -> bool:
        return self.solved.converged

    @property
    def message(self) -> str:
        return self.solved.message


@dataclass(frozen=True, eq=False)
class ShellTask(Task[R]):
    """A task on a plan's shell. solve: the solve of the plan; known: its result, if it is in the cache."""

    solve: SolveTask
    known: SolveResult | None

    @property
    def tolerance(self) -> float:
        return self.solve.tolerance

    def is_shown(self, plan: bpy.types.Object) -> bool:
        """Whether the plan's results show the shell already."""
        return self.known is not None and result_of(plan, self.solve.settings.sheet) is not None


def read_solve(context: bpy.types.Context, plan: bpy.types.Object) -> tuple[SolveTask, SolveResult | None]:
    """The solve of a plan with the settings stored with it, and its result if that is in the cache."""
    solve = SolveTask.read(context, plan, settings_of(plan.cmc))
    return solve, solve_cache.recall(solve)
