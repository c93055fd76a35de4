"""One update of Live, as a task: a quick one from the last map, or a full one as by Solve.

During a drag each solve starts from the last map and reuses the triangles, trees and factors of the last plan. It
measures only what the colours show, and writes points and normals into the meshes that are there. Without a last map,
and when the mouse rests, the plan is solved from scratch, so that the final shell does not depend on the way there.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass, replace
from types import SimpleNamespace
from typing import Generic

import bpy
import numpy as np
from numpy.typing import NDArray

from ...solver.errors import Progress
from ...solver.fitting.fit import Fit
from ...solver.shells.update import Update, update
from ...solver.spanning.span import Span
from ...solver.surface.cmc_surface import SHEETS, CmcSurface
from ..background import plan_cache, solve_cache
from ..bridges.mesh_bridge import read_plan
from ..properties.links import copies_of, result_of, results_of, wanted_roles
from ..properties.stored import ROLES
from ..results import colours
from ..results.measures import Measured, sheet_measures
from ..results.objects import hide_completed, move_along, put_points, result_origin, show_wanted
from ..tasks.recipe import MadeResult, RecipeTask, with_recipe
from ..tasks.solve import SolveResult, SolveTask, plan_depsgraph, settings_of, solver_settings
from ..tasks.task import R

Array = NDArray[np.float64]

COARSE, QUICK, WHOLE, FINAL = 1, 2, 3, 4
"""How good an update is: one step from the last map; solved from the last map as exactly as the eye can see; all that
Solve does except the search for self-intersections; all that Solve does."""

# Settings that choose the branch of solutions and the meshes of the results: a change of one needs a full solve.
_BRANCH = (
    "sites", "energy", "delaunay", "averaging", "method", "side", "shell", "degree", "sheet", "combinatorics",
    "apply_modifiers", "holes", "corners", "want_twin", "want_g", "want_gauss",
)


@dataclass(frozen=True, eq=False)
class Reading:
    """A plan as it is now. key: equal for readings with equal results. origin (3,): of the results, in the world.
    shown: names of the measures that can be seen. recipe: the solve with what was made of its shell, if anything."""

    solve: SolveTask
    recipe: RecipeTask | None
    origin: Array
    shown: tuple[str, ...]
    key: tuple

    @property
    def branch(self) -> tuple:
        """Equal for readings that can start from each other's map, if their polygons are equal, too."""
        mesh, settings = self.solve.mesh, self.solve.settings
        own = tuple(None if a is None else a.tobytes() for a in (mesh.lengths, mesh.initial))
        return own + tuple(getattr(settings, name) for name in _BRANCH)


def read(context: bpy.types.Context, plan: bpy.types.Object) -> Reading:
    """Read a plan. Raises `CmcError` where it cannot be read."""
    solve = SolveTask.read(context, plan, settings_of(plan.cmc))
    origin = result_origin(plan, solve.mesh)
    made = with_recipe(plan, solve)
    recipe = made if isinstance(made, RecipeTask) else None
    return Reading(solve, recipe, origin, colours.shown_measures(plan), (*solve_cache.key_of(solve), origin.tobytes()))


@dataclass(frozen=True, eq=False)
class Memory:
    """The start of the next quick update: a reading, its prepared plan, its map (S, 3), span or fit, and where the
    results are cut open their triangles (F, 3), which a cut elsewhere would not fit."""

    reading: Reading
    prepared: plan_cache.Prepared
    last: Array | Span | Fit
    cut: NDArray[np.int32] | None

    def serves(self, reading: Reading) -> bool:
        mine, other = self.reading.solve, reading.solve
        return (
            other.settings.combinatorics == "PRIMAL"
            and self.reading.branch == reading.branch
            and plan_cache.same_polygons(mine.mesh, other.mesh)
        )


@dataclass(frozen=True, eq=False)
class LiveTask(ABC, Generic[R]):
    """A task as those of `tasks.task`, whose writing returns the start of the next quick update."""

    reading: Reading
    grade: int

    @property
    def tolerance(self) -> float:
        return self.reading.solve.tolerance

    @abstractmethod
    def work(self, progress: Progress) -> R:
        """Solve. Raises `CmcError` in the plan's own numbering."""

    @abstractmethod
    def write(self, context: bpy.types.Context, plan: bpy.types.Object, result: R) -> Memory | None:
        """Write the results; None, and nothing, where the plan or the results have changed their polygons."""


@dataclass(frozen=True, eq=False)
class QuickResult:
    """A solve from the last map; measures of each sheet."""

    update: Update
    prepared: plan_cache.Prepared
    measures: dict[str, Measured]


@dataclass(frozen=True, eq=False)
class QuickTask(LiveTask[QuickResult]):
    """Solves from the last map: COARSE or QUICK."""

    memory: Memory

    def work(self, progress: Progress) -> QuickResult:
        solve, last = self.reading.solve, self.memory.reading.solve.mesh
        settings = solver_settings(solve.settings)
        prepared = plan_cache.prepare_near(solve.mesh, settings.solver_choice, last, self.memory.prepared)
        plan = solve.mesh.as_plan(prepared.triangles)
        plan = replace(plan, groups=solve.groups, flipped_corners=solve.mesh.flipped_corners)
        steps = 1 if self.grade == COARSE else None
        with prepared.plan_numbers(solve.mesh):
            updated = update(plan, settings, prepared.solver, self.memory.last, steps=steps, progress=progress)
        sheets = [ROLES[role] for role in wanted_roles(solve.settings)]
        measures = {name: self._measure(updated, name) for name in sheets if name in SHEETS}
        return QuickResult(updated, prepared, measures)

    def _measure(self, updated: Update, sheet: str) -> Measured:
        shown_sheet, outline = ROLES[self.reading.solve.settings.sheet], self.reading.solve.mesh.positions
        names = [name for name in self.reading.shown if name != "deviation" or sheet == shown_sheet]
        if sheet not in updated.placed or not names:
            return {}
        return sheet_measures(updated.surface, updated.similarity, updated.placed[sheet], sheet, names, outline)

    def write(self, context: bpy.types.Context, plan: bpy.types.Object, result: QuickResult) -> Memory | None:
        """Write points and normals into the wanted results; None, and nothing, where these do not fit."""
        updated, origin, wanted = result.update, self.reading.origin, wanted_roles(self.reading.solve.settings)
        objects = results_of(plan, wanted)
        cut = _cut_of(updated.surface)
        if len(objects) < len(wanted) or not _alike(cut, self.memory.cut) or not all(
            ROLES[role] in updated.placed and len(ob.data.vertices) == len(updated.surface.source)
            for role, ob in objects.items()
        ):
            return None
        for role, ob in objects.items():
            sheet = ROLES[role]
            move_along(ob, origin)
            put_points(ob, origin, updated.placed[sheet], updated.normals[sheet], result.measures.get(sheet))
        _hide_older(plan, wanted)
        if self.reading.shown:
            colours.repaint(plan, target=updated.surface.mean_curvature / updated.similarity.scale)
        return Memory(self.reading, result.prepared, updated.last, cut)


@dataclass(frozen=True, eq=False)
class FullTask(LiveTask[MadeResult]):
    """Solves as Solve does, WHOLE or FINAL, and at last makes what was made of the shell."""

    @property
    def _is_last(self) -> bool:
        return self.grade == FINAL or not self.reading.solve.settings.intersections

    def work(self, progress: Progress) -> MadeResult:
        solved, recipe = self._solved(progress), self.reading.recipe
        return MadeResult(solved, recipe.copied(solved, progress) if recipe is not None and self._is_last else None)

    def _solved(self, progress: Progress) -> SolveResult:
        """Solve, unless the solve cache has the result."""
        settings = self.reading.solve.settings
        intersections = settings.intersections and self.grade == FINAL
        solve = replace(
            self.reading.solve, settings=SimpleNamespace(**{**vars(settings), "intersections": intersections})
        )
        return solve_cache.recall(solve) or solve.work(progress)

    def write(self, context: bpy.types.Context, plan: bpy.types.Object, result: MadeResult) -> Memory | None:
        solve, solved = self.reading.solve, result.solved
        shell = solved.shell
        mesh = read_plan(plan, plan_depsgraph(context, solve.settings))
        if not plan_cache.same_polygons(mesh, solve.mesh):
            return None
        warnings = solve.write_results(context, plan, solved)
        if self.reading.recipe is not None and result.copies is not None:
            self.reading.recipe.write_copies(context, plan, result.copies, warnings)
        last = shell.span or shell.fit or shell.surface.harmonic.normals
        return Memory(self.reading, solved.prepared, last, _cut_of(shell.surface))


def _cut_of(surface: CmcSurface) -> NDArray[np.int32] | None:
    return surface.faces if surface.is_open else None


def _alike(a: NDArray[np.int32] | None, b: NDArray[np.int32] | None) -> bool:
    return a is b is None or (a is not None and b is not None and np.array_equal(a, b))


def _hide_older(plan: bpy.types.Object, wanted: list[str]) -> None:
    """Hide copies of an older shell that are shown, and show the shell."""
    completed = [thing for thing in (result_of(plan, "COMPLETED"), copies_of(plan)) if thing is not None]
    if any(not thing.hide_viewport for thing in completed):
        hide_completed(plan, True)
        show_wanted(plan, wanted)
