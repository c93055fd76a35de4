"""Close Periods and Tile by Periods: from a plan with holes to the shell that closes, or to its copies.

The counterparts of `forming` and of `symmetry`. A closed shell takes the place of the shell of Solve; the groups of the
plan stay what they are, so that the next Solve gives the shell with its gap again.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from types import SimpleNamespace

import bpy
import numpy as np
from bpy.app.handlers import persistent
from numpy.typing import NDArray

from ...solver.errors import CmcError, Progress
from ...solver.shells.close import ClosedShell, close_plan, closing_report
from ...solver.shells.complete import Completed, CopySelection
from ...solver.shells.plan import Plan
from ...solver.shells.tile import tile_plan, tile_times
from ..background import plan_cache, solve_cache
from ..bridges.mesh_bridge import read_plan
from ..bridges.numbering import in_plan_numbers
from ..bridges.periods_bridge import check_movable, move_vertices
from ..bridges.result_bridge import find_cut
from ..properties.links import wanted_roles
from ..properties.periods_settings import CLOSE_SETTINGS, TILE_SETTINGS, closure_of, may_move
from ..properties.registration import registration
from ..properties.stored import ROLES
from .complete import CompleteOrder, CompleteOutcome
from .solve import Order, Outcome, check_unchanged, deliver, plan_depsgraph, settings_of, solver_settings, take_order


@dataclass(frozen=True, eq=False)
class CloseOrder:
    """All that closing needs, without any Blender data: safe in a thread.

    solve: the solve of the plan. known: what it gave, if it was done before. wanted: `CLOSE_SETTINGS`.
    """

    solve: Order
    known: Outcome | None
    wanted: SimpleNamespace

    @property
    def name(self) -> str:
        return self.solve.name

    @property
    def settings(self) -> SimpleNamespace:
        return self.solve.settings

    def work(self, progress: Progress) -> CloseOutcome:
        """Close. Raises `CmcError` in the plan's own numbering."""
        settings, mesh = solver_settings(self.settings), self.solve.mesh
        prepared = plan_cache.prepare(mesh, settings.solver_choice)
        try:
            closed = close_plan(
                self.solve.plan(prepared),
                settings,
                closure_of(self.wanted),
                solver=prepared.solver,
                initial=None if self.known is None else self.known.shell.surface.harmonic.normals,
                progress=progress,
                intersections=self.settings.intersections,
            )
        except CmcError as error:
            raise in_plan_numbers(error, mesh, prepared.triangles, prepared.owners) from error
        shell = closed.shell
        cut = find_cut(mesh, prepared.triangles, prepared.owners, shell.faces, shell.source)
        assert shell.solver is not None
        solver = replace(prepared, solver=shell.solver)
        outcome = Outcome(shell, solver, settings.combinatorics, cut, {"closing": closing_report(closed)})
        for name in (ROLES[role] for role in wanted_roles(self.settings)):
            if name in shell.placed:
                outcome.polygons(name)
        return CloseOutcome(outcome, closed)

    def deliver(self, context: bpy.types.Context, plan: bpy.types.Object, outcome: CloseOutcome) -> list[str]:
        """Write the closed shell, and where holes moved the plan; returns what the user should be warned of.

        Raises `CmcError`, with nothing changed, where the plan is not what it was when the order was taken.
        """
        order, depsgraph = self.solve, plan_depsgraph(context, self.settings)
        check_unchanged(plan, depsgraph, order.mesh)
        if outcome.moved is not None:
            check_movable(plan, self.settings.apply_modifiers)
            move_vertices(plan, outcome.moved)
            context.view_layer.update()
            order = replace(order, mesh=read_plan(plan, plan_depsgraph(context, self.settings)))
        warnings = deliver(context, plan, order, outcome.outcome)
        solve_cache.remember(order, outcome.outcome)
        for name in CLOSE_SETTINGS:
            setattr(plan.cmc, name, getattr(self.wanted, name))
        return warnings


@dataclass(frozen=True, eq=False)
class CloseOutcome:
    """What the work gave."""

    outcome: Outcome
    closed: ClosedShell

    @property
    def converged(self) -> bool:
        return self.closed.closing.closed and self.outcome.converged

    @property
    def message(self) -> str:
        return self.outcome.message

    @property
    def moved(self) -> NDArray[np.float64] | None:
        """(V, 3) of the plan, where its holes have moved."""
        if self.closed.moving is None or not self.closed.closing.moduli.any():
            return None
        return self.closed.plan.positions


def take_closing(context: bpy.types.Context, plan: bpy.types.Object, wanted: SimpleNamespace) -> CloseOrder:
    """Read the plan. Raises `CmcError` where it cannot be read, or would have to move and cannot."""
    closure_of(wanted)
    settings = settings_of(plan.cmc)
    if may_move(wanted):
        check_movable(plan, settings.apply_modifiers)
    order = take_order(context, plan, settings)
    known = solve_cache.recall(order)
    return CloseOrder(order, None if known is None or known.more else known, wanted)


# --- tiling --------------------------------------------------------------------------------

@dataclass(frozen=True, eq=False)
class TileOrder(CompleteOrder):
    """Copies by periods; wanted has `TILE_SETTINGS`, and what they are as `complete_as`."""

    def work(self, progress: Progress) -> TileOutcome:
        found = super().work(progress)
        return TileOutcome(found.outcome, found.completed, found.report, found.cut)

    def completed(self, plan: Plan, outcome: Outcome) -> Completed:
        return tile_plan(outcome.shell, self.wanted.tile_repeat, ROLES[self.settings.sheet])

    def keep(self, plan: bpy.types.Object) -> None:
        for name in TILE_SETTINGS:
            setattr(plan.cmc, name, getattr(self.wanted, name))


class TileOutcome(CompleteOutcome):
    """The copies; the gap, across which they go on, is nothing to be warned of."""

    @property
    def converged(self) -> bool:
        return self.outcome.shell.report.converged


def take_tiling(context: bpy.types.Context, plan: bpy.types.Object, wanted: SimpleNamespace) -> TileOrder:
    """Read the plan and what is wanted of its copies. Raises `CmcError` where the plan cannot be read."""
    order = take_order(context, plan, settings_of(plan.cmc))
    wanted.complete_as = wanted.tile_as
    return TileOrder(order, solve_cache.recall(order), CopySelection(), wanted)


def tile_counts(plan: bpy.types.Object, holes: int, repeat) -> tuple[int, int]:
    """Copies and faces that a tiling would have now. Raises `CmcError` on too many."""
    copies = int(np.prod(tile_times(holes, list(repeat))))
    return copies, copies * len(plan.data.polygons)


@persistent
def _on_undo(*_: object) -> None:
    """A closed shell that was undone is not what the plan has: Complete by Symmetry must not take it for that."""
    solve_cache.forget(lambda outcome: bool(outcome.more))


register, unregister = registration(handlers={"undo_post": _on_undo, "redo_post": _on_undo})
