"""One completion of one plan's shell: from the plan to its copies, as instances or as one welded mesh.

The counterpart of `forming`. Where the plan was not solved since it was changed it is solved first, and its results are
brought up to date as Solve does it.
"""

from __future__ import annotations

import json
import math
from dataclasses import dataclass
from functools import lru_cache
from types import SimpleNamespace

import bpy
import numpy as np
from numpy.typing import NDArray

from ...solver.errors import CmcError, Progress
from ...solver.jobs.outputs import completed_report
from ...solver.shells.complete import Completed, CopySelection, complete_plan
from ...solver.shells.plan import Group, Plan
from ...solver.shells.plan_sides import goes_on
from ...solver.symmetry.complete import TooManyError
from ...solver.symmetry.sides import surface_size
from ..background import solve_cache
from ..bridges.mesh_bridge import set_attribute
from ..bridges.numbering import in_plan_numbers
from ..bridges.result_bridge import Cut, corners_of
from ..properties.attributes import ATTRIBUTES, DEVIATION
from ..properties.links import result_of
from ..properties.stored import ROLES
from ..properties.symmetry_settings import COMPLETE_SETTINGS
from ..results import colours
from ..results.instances import delete_instances, write_instances
from ..results.measures import Measured
from ..results.objects import Writer, delete_result, hide_completed, write_report
from .solve import Order, Outcome, check_unchanged, deliver, plan_depsgraph, settings_of, take_order

COPY_ATTRIBUTE = "cmc_copy"
"""Attribute of the faces of one welded mesh: which copy they are of, 0 the shell itself."""

# No finite group of a shell has as many copies as this.
_LARGEST_GROUP = 200
# Copies in a box are counted up to this many for the screen.
_COUNTED = 400
# Of the box of an object: what has no extent is given this much, relative to the largest.
_THIN = 1e-6


@dataclass(frozen=True, eq=False)
class CompleteOrder:
    """All that a completion needs, without any Blender data: safe in a thread.

    solve: the solve of the plan. known: what it gave, if it was done before.
    """

    solve: Order
    known: Outcome | None
    extent: CopySelection
    wanted: SimpleNamespace

    @property
    def name(self) -> str:
        return self.solve.name

    @property
    def settings(self) -> SimpleNamespace:
        return self.solve.settings

    def work(self, progress: Progress) -> CompleteOutcome:
        """Solve if need be, find the copies, and weld them if one mesh is wanted. Raises `CmcError`."""
        outcome = self.known or self.solve.work(progress)
        prepared, mesh = outcome.prepared, self.solve.mesh
        plan = self.solve.plan(prepared)
        try:
            completed = self.completed(plan, outcome)
            told = completed_report(completed, welded=self.wanted.complete_as == "MESH")
        except CmcError as error:
            raise in_plan_numbers(error, mesh, prepared.triangles, prepared.owners) from error
        cut = whole_mesh(completed, plan, mesh) if self.wanted.complete_as == "MESH" else None
        return CompleteOutcome(outcome, completed, told, cut)

    def completed(self, plan: Plan, outcome: Outcome) -> Completed:
        """The copies of the shell over a plan."""
        return complete_plan(plan, outcome.shell, self.extent, ROLES[self.settings.sheet])

    def deliver(self, context: bpy.types.Context, plan: bpy.types.Object, outcome: CompleteOutcome) -> list[str]:
        """Write the copies, in the place of those that were made before; returns what the user should be warned of.

        Raises `CmcError`, with nothing changed, where the plan is not what it was when the order was taken.
        """
        depsgraph = plan_depsgraph(context, self.settings)
        check_unchanged(plan, depsgraph, self.solve.mesh)
        warnings = []
        if self.known is None or result_of(plan, self.settings.sheet) is None:
            warnings = deliver(context, plan, self.solve, outcome.outcome)
        if outcome.cut is not None:
            delete_instances(plan)
            self._write_mesh(context, plan, depsgraph, outcome)
        else:
            existing = result_of(plan, "COMPLETED")
            if existing is not None:
                delete_result(existing)
            cut = outcome.outcome.cut
            numbers = {sheet: sheet_numbers(outcome.outcome, sheet, self.solve) for sheet in outcome.completed.sheets}
            write_instances(context, plan, depsgraph, self.solve.mesh, cut, outcome.completed, numbers)
        hide_completed(plan, False)
        _hide_shell(plan, self.settings.sheet)
        plan.cmc.complete_report = json.dumps(outcome.report, ensure_ascii=False)
        self.keep(plan)
        colours.repaint(plan)
        return [*warnings, *outcome.warnings]

    def keep(self, plan: bpy.types.Object) -> None:
        """Store with the plan what was wanted."""
        for name in COMPLETE_SETTINGS:
            setattr(plan.cmc, name, getattr(self.wanted, name))
        plan.cmc.complete_box = bpy.data.objects.get(self.wanted.box) if self.wanted.box else None

    def _write_mesh(self, context, plan, depsgraph, outcome: CompleteOutcome) -> None:
        completed = outcome.completed
        writer = Writer(context, plan, depsgraph, self.solve.mesh, outcome.cut)
        writer.write("COMPLETED", completed.points, completed.normals, outcome.measures(self.solve))
        result = result_of(plan, "COMPLETED")
        each = len(result.data.polygons) // completed.copy_count
        numbers = np.repeat(np.arange(completed.copy_count, dtype=np.int32), each)
        set_attribute(result.data, COPY_ATTRIBUTE, "INT", "FACE", numbers)
        write_report(result, outcome.report)


@dataclass(frozen=True, eq=False)
class CompleteOutcome:
    """What the work gave. cut: the welded mesh by where all of it comes from, None for instances."""

    outcome: Outcome
    completed: Completed
    report: dict
    cut: Cut | None

    @property
    def converged(self) -> bool:
        return self.outcome.converged

    @property
    def message(self) -> str:
        return self.completed.summary()

    def measures(self, order: Order) -> Measured:
        """What is measured at the vertices of the welded mesh: the numbers of the shell, at every copy."""
        completion = self.completed.completion
        table = {sheet: sheet_numbers(self.outcome, sheet, order) for sheet in set(completion.sheets)}
        found: Measured = {}
        for name in table[completion.sheets[0]]:
            found[name] = np.empty(len(self.completed.points))
            found[name][completion.members.ravel()] = np.concatenate([table[s][name] for s in completion.sheets])
        return found

    @property
    def warnings(self) -> list[str]:
        """What did not come out as it is meant to be."""
        notes, scale = [] if self.converged else [self.outcome.message], self.outcome.shell.similarity.scale
        if self.report["relative_gap"] > _WIDE:
            notes.append(
                f"Seams were up to {self.completed.largest_gap:.2g} apart, {100 * self.report['relative_gap']:.2g} % "
                "of the shell's size; they were closed, but a finer mesh, or a plan with the corner angles of the "
                "surface, makes them meet by themselves."
            )
        if self.completed.largest_offset > _WIDE * surface_size(self.outcome.shell.surface) * scale:
            notes.append(f"Sides that share a plane came out up to {self.completed.largest_offset:.2g} apart.")
        return notes


def sheet_numbers(outcome: Outcome, sheet: str, order: Order) -> Measured:
    """What an order measures of a sheet, as far as it is the same on every copy: numbers, and not from the outline."""
    found = outcome.measures(sheet, order) or {}
    return {name: values for name, values in found.items() if values.ndim == 1 and name != ATTRIBUTES[DEVIATION]}


# Gaps and offsets larger than this part of the size are worth a warning.
_WIDE = 0.01


def take_completion(
    context: bpy.types.Context, plan: bpy.types.Object, wanted: SimpleNamespace
) -> CompleteOrder:
    """Read the plan and what is wanted of its copies (`COMPLETE_SETTINGS` and the name of a `box`).

    Raises `CmcError` where the plan cannot be read or there is no such box.
    """
    order = take_order(context, plan, settings_of(plan.cmc))
    return CompleteOrder(order, solve_cache.recall(order), extent_of(plan, wanted), wanted)


def extent_of(plan: bpy.types.Object, wanted: SimpleNamespace) -> CopySelection:
    """Which copies are wanted; raises `CmcError` without an object for the box."""
    sides = [group.name for group in plan.data.cmc.groups if _goes_on(group)]
    if wanted.complete_extent == "COUNT":
        return CopySelection(sides, copies=wanted.complete_count)
    if wanted.complete_extent == "BOX":
        return CopySelection(sides, box=_box(wanted.box))
    return CopySelection(sides, repeat=tuple(wanted.complete_repeat))


def _goes_on(group) -> bool:
    chosen = {"AUTO": None, "ON": True, "OFF": False}[group.across]
    return goes_on(Group(group.name, np.zeros((0, 2), dtype=np.int32), group.kind.lower(), goes_on=chosen))


def _box(name: str) -> NDArray[np.float64]:
    ob = bpy.data.objects.get(name)
    if ob is None:
        raise CmcError(
            f"There is no object '{name}' for the box; choose another."
            if name
            else "No object is chosen for the box; add a cube around the copies that are wanted, and choose it."
        )
    corners = np.array([ob.matrix_world @ type(ob.location)(corner) for corner in ob.bound_box])
    low, high = corners.min(axis=0), corners.max(axis=0)
    margin = _THIN * float((high - low).max())
    if not margin > 0.0:
        raise CmcError(f"The object '{name}' has no extent, so it is no box; choose another.")
    return np.array([low - margin, high + margin])


def counts(plan: bpy.types.Object, wanted: SimpleNamespace) -> tuple[int, bool] | None:
    """How many copies a completion would have now, and whether there are more than that; None before the first solve.

    Quick enough for the screen: units are multiplied, and copies in a box counted up to a limit. Raises `CmcError`.
    """
    known = solve_cache.latest(plan.name)
    if known is None:
        return None
    extent = extent_of(plan, wanted)
    sides = tuple(extent.sides or ())
    if extent.copies is not None:
        found, _ = _count(*known, sides, min(extent.copies, _LARGEST_GROUP), None)
        return (extent.copies if found == _LARGEST_GROUP else found), False
    if extent.box is not None:
        found, _ = _count(*known, sides, None, tuple(map(tuple, extent.box.tolist())))
        return min(found, _COUNTED), found > _COUNTED
    unit, directions = _count(*known, sides, None, None)
    return unit * math.prod(wanted.complete_repeat[:directions]), False


def _count(order: Order, outcome: Outcome, *which) -> tuple[int, int]:
    """Copies, and the directions in which they repeat."""
    found = _counted(order, outcome, *which)
    if isinstance(found, CmcError):
        raise found
    return found


@lru_cache(maxsize=8)
def _counted(order: Order, outcome: Outcome, sides, copies, box) -> tuple[int, int] | CmcError:
    """The same, or why there are none; both are worth keeping between redraws."""
    limit = copies if box is None else _COUNTED
    extent = CopySelection(sides, limit, None if box is None else np.array(box))
    try:
        found = complete_plan(order.plan(outcome.prepared), outcome.shell, extent, ROLES[order.settings.sheet])
    except TooManyError:
        return _COUNTED + 1, 0
    except CmcError as error:
        return error
    return found.copy_count, len(found.completion.lattice)


def whole_mesh(completed: Completed, plan, mesh) -> Cut:
    """The welded mesh by where everything in it comes from in the plan, a PlanMesh, whose layers it is to have."""
    polygons = completed.polygons(plan)
    sizes = np.diff(polygons.starts)
    owner = np.repeat(polygons.faces, sizes)
    corners = corners_of(mesh, owner, completed.shell.source[polygons.rows])
    rows = polygons.corners
    if mesh.mirrored:  # a mesh stores its polygons the other way round, see `find_cut`
        back = np.repeat(polygons.starts[1:] + polygons.starts[:-1] - 1, sizes) - np.arange(len(rows))
        rows, corners = rows[back], corners[back]
    return Cut(
        vertices=completed.source,
        corners=corners,
        faces=polygons.faces.astype(np.int32),
        corner_vertices=rows.astype(np.int32),
        starts=polygons.starts.astype(np.int32),
    )


def _hide_shell(plan: bpy.types.Object, sheet: str) -> None:
    """The shell is one of the copies; the next solve shows it again."""
    shell = result_of(plan, sheet)
    if shell is not None:
        shell.cmc.parked = shell.hide_viewport = shell.hide_render = True


def register() -> None:
    """Nothing to do: the operator is with the others."""


def unregister() -> None:
    _counted.cache_clear()
