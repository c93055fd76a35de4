"""Close Gaps and Repeat by Gaps: from a plan with holes to the shell that closes, or to its copies.

A closed shell takes the place of the shell of Solve. The groups of the plan stay, so that the next Solve gives the
shell with its gap again.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from types import SimpleNamespace

import bpy
import numpy as np
from bpy.app.handlers import persistent
from numpy.typing import NDArray

from ...solver.errors import Progress
from ...solver.notes import Note
from ...solver.shells.close import ClosedShell, ClosingOptions, close_plan, closing_report
from ...solver.shells.complete import Completed, CopySelection
from ...solver.shells.plan import Plan
from ...solver.shells.tile import tile_plan, tile_times
from ..background import plan_cache, solve_cache
from ..bridges.mesh_bridge import read_plan
from ..bridges.periods_bridge import check_movable, move_vertices
from ..properties.periods_settings import CLOSE_SETTINGS, TILE_SETTINGS, closure_of, may_move
from ..properties.registration import registration
from ..properties.stored import ROLES
from .complete import CompleteResult, CompleteTask
from .shell_task import ShellResult, ShellTask, read_solve
from .solve import SolveResult, plan_depsgraph, solver_settings


@dataclass(frozen=True, eq=False)
class CloseResult(ShellResult):
    """A shell that closes, or that comes as near to it as the settings allow."""

    closed: ClosedShell

    @property
    def converged(self) -> bool:
        return self.closed.closing.closed and self.solved.converged

    @property
    def moved(self) -> NDArray[np.float64] | None:
        """Positions (V, 3) of the plan, where its holes have moved."""
        if self.closed.moving is None or not self.closed.closing.moduli.any():
            return None
        return self.closed.plan.positions


@dataclass(frozen=True, eq=False)
class CloseTask(ShellTask[CloseResult]):
    """Closes the shell of a plan. wanted: `CLOSE_SETTINGS`. options: those of a job, in their place."""

    wanted: SimpleNamespace
    options: ClosingOptions | None = None

    @classmethod
    def read(cls, context: bpy.types.Context, plan: bpy.types.Object, wanted: SimpleNamespace) -> CloseTask:
        """Read the plan. Raises `CmcError` where it cannot be read or its holes cannot be moved."""
        closure_of(wanted)
        if may_move(wanted):
            check_movable(plan, plan.cmc.apply_modifiers)
        solve, known = read_solve(context, plan)
        return cls(solve, None if known is None or known.more else known, wanted)

    def shows(self) -> str:
        return self.solve.shows()

    @property
    def closing(self) -> ClosingOptions:
        """What may change."""
        return self.options or closure_of(self.wanted)

    def work(self, progress: Progress) -> CloseResult:
        settings, mesh = solver_settings(self.solve.settings), self.solve.mesh
        prepared = plan_cache.prepare(mesh, settings.solver_choice)
        with prepared.plan_numbers(mesh):
            closed = close_plan(
                self.solve.plan(prepared),
                settings,
                self.closing,
                solver=prepared.solver,
                start=None if self.known is None else self.known.shell.surface,
                progress=progress,
                intersections=self.solve.settings.intersections,
            )
        shell = closed.shell
        assert shell.solver is not None
        prepared = replace(prepared, solver=shell.solver)
        return CloseResult(self.solve.result(shell, prepared, {"closing": closing_report(closed)}), closed)

    def write(self, context: bpy.types.Context, plan: bpy.types.Object, result: CloseResult) -> list[Note]:
        """Write the closed shell, and move the holes of the plan where they have moved."""
        solve = self.solve
        solve.check_unchanged(context, plan)
        if result.moved is not None:
            check_movable(plan, solve.settings.apply_modifiers)
            move_vertices(plan, result.moved)
            context.view_layer.update()
            solve = replace(solve, mesh=read_plan(plan, plan_depsgraph(context, solve.settings)))
        warnings = solve.write(context, plan, result.solved)
        solve_cache.remember(solve, result.solved)
        for name in CLOSE_SETTINGS:
            setattr(plan.cmc, name, getattr(self.wanted, name))
        return warnings


# --- tiling --------------------------------------------------------------------------------

class TileResult(CompleteResult):
    """Copies across the gap; the gap itself is no reason for a warning."""

    @property
    def converged(self) -> bool:
        return self.solved.shell.report.converged


@dataclass(frozen=True, eq=False)
class TileTask(CompleteTask):
    """Copies by periods. wanted: `TILE_SETTINGS`."""

    @classmethod
    def read(cls, context: bpy.types.Context, plan: bpy.types.Object, wanted: SimpleNamespace) -> TileTask:
        """Read the plan. Raises `CmcError` where it cannot be read."""
        wanted.complete_as = wanted.tile_as
        return cls(*read_solve(context, plan), CopySelection(), wanted)

    def work(self, progress: Progress) -> TileResult:
        result = super().work(progress)
        return TileResult(result.solved, result.completed, result.report, result.cut)

    def completed(self, plan: Plan, solved: SolveResult) -> Completed:
        return tile_plan(solved.shell, self.wanted.tile_repeat, ROLES[self.solve.settings.sheet])

    def store(self, plan: bpy.types.Object) -> None:
        for name in TILE_SETTINGS:
            setattr(plan.cmc, name, getattr(self.wanted, name))


def tile_counts(plan: bpy.types.Object, holes: int, repeat) -> tuple[int, int]:
    """Copies and faces that a tiling would have now. Raises `CmcError` if there are too many."""
    copies = int(np.prod(tile_times(holes, list(repeat))))
    return copies, copies * len(plan.data.polygons)


@persistent
def _on_undo(*_: object) -> None:
    """After undo the plan no longer has its closed shell: Repeat by Symmetry must not start from it."""
    solve_cache.forget(lambda result: bool(result.more))


register, unregister = registration(handlers={"undo_post": _on_undo, "redo_post": _on_undo})
