"""One answer of Live: what of a plan it depends on, how good it is, how it is found, and how it is written.

While a plan is dragged the last map is where the next one begins, the triangles, trees and factors of the last plan go
on serving, and nothing is measured but what colours show; points and normals go into the meshes that are there. Where
there is nothing to go on from, and when the mouse rests, a plan is solved as by Solve, from nothing, so that what is
seen then does not depend on the way there. No Blender data between `read` and `deliver`: the work is safe in a thread.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from types import SimpleNamespace

import bpy
import numpy as np
from numpy.typing import NDArray

from ...solver.errors import CmcError, Progress
from ...solver.shells.update import Update, update
from ...solver.surface.cmc_surface import SHEETS, CmcSurface
from ..background import plan_cache, solve_cache
from ..bridges.mesh_bridge import PlanMesh, read_plan
from ..bridges.numbering import in_plan_numbers
from ..properties.links import copies_of, result_of, wanted_roles
from ..properties.stored import ROLES
from ..results import colours
from ..results.measures import Measured, sheet_measures
from ..results.objects import hide_completed, move_along, put_points, show_wanted
from ..tasks.solve import Order, Outcome, plan_depsgraph, put_results, settings_of, solver_settings, take_order

Array = NDArray[np.float64]

COARSE, QUICK, WHOLE, FINAL = 1, 2, 3, 4
"""How good an answer is: one step from the last map; solved from the last map as exactly as the eye can see; all that
Solve does but the search for self-intersections; all that Solve does."""

# Settings that say which shell is meant, and in which meshes it is written: where one has changed, all begins anew.
_BRANCH = (
    "sites", "energy", "delaunay", "averaging", "method", "side", "shell", "degree", "sheet", "combinatorics",
    "apply_modifiers", "want_twin", "want_g", "want_gauss",
)


@dataclass(frozen=True, eq=False)
class Reading:
    """A plan as it is now. key: equal for readings with equal results. origin (3,): of the object, in the world.
    shown: names of the measures that can be seen."""

    order: Order
    origin: Array
    shown: tuple[str, ...]
    key: tuple

    @property
    def branch(self) -> tuple:
        """Equal for readings of which one can go on from the other's map, if the polygons are the same, too."""
        mesh, settings = self.order.mesh, self.order.settings
        own = tuple(None if a is None else a.tobytes() for a in (mesh.lengths, mesh.initial))
        return own + tuple(getattr(settings, name) for name in _BRANCH)


def read(context: bpy.types.Context, plan: bpy.types.Object) -> Reading:
    """Read a plan. Raises `CmcError` where it cannot be read."""
    order = take_order(context, plan, settings_of(plan.cmc))
    origin = np.array(plan.matrix_world.translation, dtype=np.float64)
    return Reading(order, origin, colours.shown_measures(plan), (*solve_cache.key_of(order), origin.tobytes()))


@dataclass(frozen=True, eq=False)
class Memory:
    """What the next answer goes on from: a reading, what was made ready for it, its map (S, 3), and where the results
    are cut open the triangles (F, 3) of their rows, which a cut elsewhere would not fit."""

    reading: Reading
    prepared: plan_cache.Prepared
    normals: Array
    cut: NDArray[np.int32] | None

    def serves(self, reading: Reading) -> bool:
        mine, other = self.reading.order, reading.order
        return (
            other.settings.combinatorics == "PRIMAL"
            and self.reading.branch == reading.branch
            and plan_cache.same_polygons(mine.mesh, other.mesh)
        )


@dataclass(frozen=True, eq=False)
class Answered:
    """What came of going on from the last map; measures of each sheet."""

    found: Update
    prepared: plan_cache.Prepared
    measures: dict[str, Measured]


@dataclass(frozen=True, eq=False)
class GoingOn:
    """To answer from the last map. steps: of Newton's method, at most."""

    reading: Reading
    memory: Memory
    grade: int

    @property
    def settings(self) -> SimpleNamespace:
        return self.reading.order.settings

    def work(self, progress: Progress) -> Answered:
        """Solve. Raises `CmcError` in the plan's own numbering."""
        order, settings, last = self.reading.order, solver_settings(self.settings), self.memory.reading.order.mesh
        prepared = plan_cache.prepare_near(order.mesh, settings.solver_choice, last, self.memory.prepared)
        plan = order.mesh.as_plan(prepared.triangles)
        plan = replace(plan, groups=order.groups, flipped_corners=order.mesh.flipped_corners)
        steps = 1 if self.grade == COARSE else None
        try:
            found = update(plan, settings, prepared.solver, self.memory.normals, steps=steps, progress=progress)
        except CmcError as error:
            raise in_plan_numbers(error, order.mesh, prepared.triangles, prepared.owners) from error
        sheets = [ROLES[role] for role in wanted_roles(self.settings)]
        return Answered(found, prepared, {name: self._measure(found, name) for name in sheets if name in SHEETS})

    def _measure(self, found: Update, sheet: str) -> Measured:
        names = [name for name in self.reading.shown if name != "deviation" or sheet == ROLES[self.settings.sheet]]
        if sheet not in found.placed or not names:
            return {}
        outline = self.reading.order.mesh.positions
        return sheet_measures(found.surface, found.similarity, found.placed[sheet], sheet, names, outline)

    def deliver(self, context: bpy.types.Context, plan: bpy.types.Object, outcome: Answered) -> Memory | None:
        """Write points and normals into the results that are wanted; None, and nothing, where these do not fit."""
        found, wanted = outcome.found, wanted_roles(self.settings)
        results = {role: result_of(plan, role) for role in wanted}
        cut = _cut_of(found.surface)
        if not _alike(cut, self.memory.cut) or not all(
            ROLES[role] in found.placed and ob is not None and len(ob.data.vertices) == len(found.surface.source)
            for role, ob in results.items()
        ):
            return None
        for role, result in results.items():
            sheet = ROLES[role]
            move_along(result, self.reading.origin)
            put_points(
                result, self.reading.origin, found.placed[sheet], found.normals[sheet], outcome.measures.get(sheet)
            )
        _hide_older(plan, wanted)
        if self.reading.shown:
            colours.repaint(plan, target=found.surface.mean_curvature / found.similarity.scale)
        return Memory(self.reading, outcome.prepared, found.surface.harmonic.normals, cut)


def _cut_of(surface: CmcSurface) -> NDArray[np.int32] | None:
    return surface.faces if surface.is_open else None


def _alike(a: NDArray[np.int32] | None, b: NDArray[np.int32] | None) -> bool:
    return a is b is None or (a is not None and b is not None and np.array_equal(a, b))


def _hide_older(plan: bpy.types.Object, wanted: list[str]) -> None:
    """Hide what was completed from an older shell, if that has not been done yet, and show the shell."""
    completed = [thing for thing in (result_of(plan, "COMPLETED"), copies_of(plan)) if thing is not None]
    if any(not thing.hide_viewport for thing in completed):
        hide_completed(plan, True)
        show_wanted(plan, wanted)


@dataclass(frozen=True, eq=False)
class Anew:
    """To do what Solve does."""

    reading: Reading
    grade: int

    @property
    def settings(self) -> SimpleNamespace:
        settings = self.reading.order.settings
        return SimpleNamespace(**{**vars(settings), "intersections": settings.intersections and self.grade == FINAL})

    def work(self, progress: Progress) -> Outcome:
        """Solve, if that was not done just now. Raises `CmcError` in the plan's own numbering."""
        order = replace(self.reading.order, settings=self.settings)
        return solve_cache.recall(order) or order.work(progress)

    def deliver(self, context: bpy.types.Context, plan: bpy.types.Object, outcome: Outcome) -> Memory | None:
        """Write the results; None, and nothing, where the plan has other polygons by now."""
        order = self.reading.order
        if not plan_cache.same_polygons(_mesh_of(context, plan, order), order.mesh):
            return None
        put_results(context, plan, order, outcome)
        surface = outcome.shell.surface
        return Memory(self.reading, outcome.prepared, surface.harmonic.normals, _cut_of(surface))


def _mesh_of(context: bpy.types.Context, plan: bpy.types.Object, order: Order) -> PlanMesh:
    return read_plan(plan, plan_depsgraph(context, order.settings))
