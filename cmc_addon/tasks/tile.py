"""Repeat by Gaps: the copies of a shell that is left open around the holes of its plan."""

from __future__ import annotations

from dataclasses import dataclass
from types import SimpleNamespace

import bpy
import numpy as np

from ...solver.errors import Progress
from ...solver.shells.complete import Completed, CopySelection
from ...solver.shells.plan import Plan
from ...solver.shells.tile import tile_plan, tile_times
from ..background import solve_cache
from ..properties.closing_settings import TILE_SETTINGS
from ..properties.stored import ROLES
from .complete import CompleteResult, CompleteTask
from .solve import SolveResult, SolveTask, settings_of


class TileResult(CompleteResult):
    """Copies across the gap; the gap itself is no reason for a warning."""

    @property
    def converged(self) -> bool:
        return self.solved.shell.report.converged


@dataclass(frozen=True, eq=False)
class TileTask(CompleteTask):
    """Copies by periods of the shell with its gaps. wanted: `TILE_SETTINGS`."""

    way = "GAPS"

    @classmethod
    def read(cls, context: bpy.types.Context, plan: bpy.types.Object, wanted: SimpleNamespace) -> TileTask:
        """Read the plan. Raises `CmcError` where it cannot be read."""
        settings = settings_of(plan.cmc)
        settings.keep_closed = False
        solve = SolveTask.read(context, plan, settings)
        return cls.on(plan, solve, solve_cache.recall(solve), wanted)

    @classmethod
    def on(
        cls, plan: bpy.types.Object, solve: SolveTask, known: SolveResult | None, wanted: SimpleNamespace
    ) -> TileTask:
        return cls(solve, known, CopySelection(), wanted)

    @staticmethod
    def stored(plan: bpy.types.Object) -> SimpleNamespace:
        return SimpleNamespace(tile_as=plan.cmc.tile_as, tile_repeat=tuple(plan.cmc.tile_repeat))

    @property
    def kind(self) -> str:
        return self.wanted.tile_as

    def is_shown(self, plan: bpy.types.Object) -> bool:
        return not plan.cmc.keep_closed and super().is_shown(plan)

    def work(self, progress: Progress) -> TileResult:
        result = super().work(progress)
        return TileResult(result.solved, result.completed, result.report, result.cut)

    def completed(self, plan: Plan, solved: SolveResult) -> Completed:
        return tile_plan(solved.shell, self.wanted.tile_repeat, ROLES[self.solve.settings.sheet])

    def store(self, plan: bpy.types.Object) -> None:
        plan.cmc.keep_closed = False
        for name in TILE_SETTINGS:
            setattr(plan.cmc, name, getattr(self.wanted, name))


def tile_counts(plan: bpy.types.Object, holes: int, repeat) -> tuple[int, int]:
    """Copies and faces that a tiling would have now. Raises `CmcError` if there are too many."""
    copies = int(np.prod(tile_times(holes, list(repeat))))
    return copies, copies * len(plan.data.polygons)
