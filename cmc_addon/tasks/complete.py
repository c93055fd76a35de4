"""Repeat by Symmetry: the copies of a shell, as instances or as one welded mesh."""

from __future__ import annotations

import json
import math
from dataclasses import dataclass
from functools import lru_cache
from types import SimpleNamespace
from typing import ClassVar

import bpy
import numpy as np
from numpy.typing import NDArray

from ...solver.errors import CmcError, Progress, Status
from ...solver.jobs.outputs import completed_report
from ...solver.measure.summary import percent
from ...solver.notes import Note
from ...solver.shells.complete import Completed, CopySelection, complete_plan
from ...solver.shells.plan import Group, Plan
from ...solver.shells.plan_sides import goes_on
from ...solver.symmetry.complete import TooManyError
from ...solver.symmetry.sides import surface_size
from ..background import solve_cache
from ..bridges.mesh_bridge import set_attribute
from ..bridges.result_bridge import Cut, corners_of
from ..properties.attributes import ATTRIBUTES, DEVIATION
from ..properties.links import result_of
from ..properties.stored import ROLES
from ..properties.symmetry_settings import COMPLETE_SETTINGS
from ..properties.units import in_scene_units, length_text
from ..results import colours
from ..results.instances import delete_instances, write_instances
from ..results.measures import Measured
from ..results.objects import Writer, delete_result, hide_completed, park, world_box, write_report
from .shell_task import ShellResult, ShellTask, read_solve
from .solve import SolveResult, SolveTask, plan_depsgraph

COPY_ATTRIBUTE = "cmc_copy"
"""Attribute of the faces of one welded mesh: which copy they are of, 0 the shell itself."""

# No finite group of a shell has as many copies as this.
_LARGEST_GROUP = 200
# Copies in a box are counted up to this many for the screen.
_COUNTED = 400
# Margin of an object's box, relative to its largest extent: a flat object has a box, too.
_THIN = 1e-6
# Gaps and offsets larger than this part of the shell's size are worth a warning.
_WIDE = 0.01


@dataclass(frozen=True, eq=False)
class CompleteResult(ShellResult):
    """The copies. cut: the welded mesh, each part with its source in the plan; None for instances."""

    completed: Completed
    report: dict
    cut: Cut | None

    @property
    def message(self) -> str:
        return in_scene_units(self.completed.summary())

    def measures(self, task: SolveTask) -> Measured:
        """The measures at the vertices of the welded mesh: those of the shell, at every copy."""
        completion = self.completed.completion
        table = {sheet: sheet_numbers(self.solved, sheet, task) for sheet in set(completion.sheets)}
        measured: Measured = {}
        for name in table[completion.sheets[0]]:
            measured[name] = np.empty(len(self.completed.points))
            measured[name][completion.members.ravel()] = np.concatenate([table[s][name] for s in completion.sheets])
        return measured

    @property
    def warnings(self) -> list[Note]:
        """Gaps and offsets that were closed, and how the solve ended."""
        code = "gap" if self.solved.shell.surface.status is Status.GAP else "not-converged"
        notes = [] if self.converged else [Note(code, self.solved.message)]
        scale = self.solved.shell.similarity.scale
        if self.report["relative_gap"] > _WIDE:
            gap, part = length_text(self.completed.largest_gap, digits=2), percent(self.report["relative_gap"])
            text = (
                f"Seams were up to {gap} apart, {part} of the shell's size, and were closed. A finer mesh, or a plan "
                "with the corner angles of the surface, makes them meet by themselves."
            )
            notes.append(Note("seams", text))
        if self.completed.largest_offset > _WIDE * surface_size(self.solved.shell.surface) * scale:
            text = f"Sides that share a plane are up to {length_text(self.completed.largest_offset, digits=2)} apart."
            notes.append(Note("seams", text))
        return notes


@dataclass(frozen=True, eq=False)
class CompleteTask(ShellTask[CompleteResult]):
    """Copies of a shell. copies: which ones. wanted: `COMPLETE_SETTINGS` and the name of a `box`."""

    way: ClassVar[str] = "SYMMETRY"
    copies: CopySelection
    wanted: SimpleNamespace

    @classmethod
    def read(cls, context: bpy.types.Context, plan: bpy.types.Object, wanted: SimpleNamespace) -> CompleteTask:
        """Read the plan. Raises `CmcError` where it cannot be read or there is no such box."""
        return cls.on(plan, *read_solve(context, plan), wanted)

    @classmethod
    def on(
        cls, plan: bpy.types.Object, solve: SolveTask, known: SolveResult | None, wanted: SimpleNamespace
    ) -> CompleteTask:
        """The copies of the shell of a solve, which may be known."""
        return cls(solve, known, copies_wanted(plan, wanted), wanted)

    @staticmethod
    def stored(plan: bpy.types.Object) -> SimpleNamespace:
        """The settings stored with a plan."""
        box = plan.cmc.complete_box.name if plan.cmc.complete_box is not None else ""
        return SimpleNamespace(**{name: getattr(plan.cmc, name) for name in COMPLETE_SETTINGS}, box=box)

    @property
    def kind(self) -> str:
        """One mesh or instances."""
        return self.wanted.complete_as

    def shows(self) -> str:
        return "COMPLETED"

    def work(self, progress: Progress) -> CompleteResult:
        """Solve if need be, find the copies, and weld them if one mesh is wanted."""
        solved, mesh = self.known or self.solve.work(progress), self.solve.mesh
        plan, is_welded = self.solve.plan(solved.prepared), self.kind == "MESH"
        with solved.prepared.plan_numbers(mesh):
            completed = self.completed(plan, solved)
            report = completed_report(completed, welded=is_welded)
        return CompleteResult(solved, completed, report, whole_mesh(completed, plan, mesh) if is_welded else None)

    def completed(self, plan: Plan, solved: SolveResult) -> Completed:
        """The copies of the shell over a plan."""
        return complete_plan(plan, solved.shell, self.copies, ROLES[self.solve.settings.sheet])

    def write(self, context: bpy.types.Context, plan: bpy.types.Object, result: CompleteResult) -> list[Note]:
        """Write the copies in place of earlier ones, and the shell where it was solved just now."""
        self.solve.check_unchanged(context, plan)
        warnings = [] if self.is_shown(plan) else self.solve.write(context, plan, result.solved)
        return [*warnings, *(note for note in self.write_copies(context, plan, result) if note not in warnings)]

    def write_copies(self, context: bpy.types.Context, plan: bpy.types.Object, result: CompleteResult) -> list[Note]:
        """The same for the copies alone, where the shell is written."""
        depsgraph = plan_depsgraph(context, self.solve.settings)
        if result.cut is not None:
            delete_instances(plan)
            self._write_mesh(context, plan, depsgraph, result)
        else:
            existing = result_of(plan, "COMPLETED")
            if existing is not None:
                delete_result(existing)
            numbers = {sheet: sheet_numbers(result.solved, sheet, self.solve) for sheet in result.completed.sheets}
            mesh, cut = self.solve.mesh, result.solved.cut
            write_instances(context, plan, depsgraph, mesh, cut, result.completed, numbers)
        hide_completed(plan, False)
        park(result_of(plan, self.solve.settings.sheet))  # it is one of the copies
        plan.cmc.latest = "COMPLETED"
        report = {**result.report, "made": self.solve.made(self.wanted)}
        plan.cmc.complete_report = json.dumps(report, ensure_ascii=False)
        plan.cmc.repeated = self.way
        self.store(plan)
        colours.repaint(plan)
        return result.warnings

    def store(self, plan: bpy.types.Object) -> None:
        """Keep the settings with the plan."""
        for name in COMPLETE_SETTINGS:
            setattr(plan.cmc, name, getattr(self.wanted, name))
        plan.cmc.complete_box = bpy.data.objects.get(self.wanted.box) if self.wanted.box else None

    def _write_mesh(self, context, plan, depsgraph, result: CompleteResult) -> None:
        completed = result.completed
        writer = Writer(context, plan, depsgraph, self.solve.mesh, result.cut)
        ob = writer.write("COMPLETED", completed.points, completed.normals, result.measures(self.solve))
        each = len(ob.data.polygons) // completed.copy_count
        numbers = np.repeat(np.arange(completed.copy_count, dtype=np.int32), each)
        set_attribute(ob.data, COPY_ATTRIBUTE, "INT", "FACE", numbers)
        write_report(ob, result.report)


def sheet_numbers(solved: SolveResult, sheet: str, task: SolveTask) -> Measured:
    """The measures that are the same on every copy: no directions, no distance from the outline."""
    measured = solved.measures(sheet, task) or {}
    return {name: values for name, values in measured.items() if values.ndim == 1 and name != ATTRIBUTES[DEVIATION]}


def copies_wanted(plan: bpy.types.Object, wanted: SimpleNamespace) -> CopySelection:
    """Which copies the settings select; raises `CmcError` without an object for the box."""
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
            else "No object is chosen for the box; add a cube around the copies you want, and choose it."
        )
    corners = world_box(ob)
    low, high = corners.min(axis=0), corners.max(axis=0)
    margin = _THIN * float((high - low).max())
    if not margin > 0.0:
        raise CmcError(f"The object '{name}' has no extent, so it is no box; choose another.")
    return np.array([low - margin, high + margin])


def counts(plan: bpy.types.Object, wanted: SimpleNamespace) -> tuple[int, bool] | None:
    """How many copies a completion would have now, and whether there are more; None before the first solve.

    Quick enough for the screen: units are multiplied, and copies in a box counted up to a limit. Raises `CmcError`.
    """
    known = solve_cache.latest(plan.name)
    if known is None:
        return None
    selection = copies_wanted(plan, wanted)
    sides = tuple(selection.sides or ())
    if selection.copies is not None:
        number, _ = _count(*known, sides, min(selection.copies, _LARGEST_GROUP), None)
        return (selection.copies if number == _LARGEST_GROUP else number), False
    if selection.box is not None:
        number, _ = _count(*known, sides, None, tuple(map(tuple, selection.box.tolist())))
        return min(number, _COUNTED), number > _COUNTED
    unit, directions = _count(*known, sides, None, None)
    return unit * math.prod(wanted.complete_repeat[:directions]), False


def _count(task: SolveTask, solved: SolveResult, *which) -> tuple[int, int]:
    """Copies, and the directions in which they repeat."""
    counted = _counted(task, solved, *which)
    if isinstance(counted, CmcError):
        raise counted
    return counted


@lru_cache(maxsize=8)
def _counted(task: SolveTask, solved: SolveResult, sides, copies, box) -> tuple[int, int] | CmcError:
    """The same, or why there are none; both are worth keeping between redraws."""
    limit = copies if box is None else _COUNTED
    selection = CopySelection(sides, limit, None if box is None else np.array(box))
    try:
        completed = complete_plan(task.plan(solved.prepared), solved.shell, selection, ROLES[task.settings.sheet])
    except TooManyError:
        return _COUNTED + 1, 0
    except CmcError as error:
        return error
    return completed.copy_count, len(completed.completion.lattice)


def whole_mesh(completed: Completed, plan, mesh) -> Cut:
    """The welded mesh, each part with its source in the plan `mesh`, a PlanMesh, from which it takes its layers."""
    polygons = completed.polygons(plan)
    sizes = np.diff(polygons.starts)
    owner = np.repeat(polygons.faces, sizes).astype(np.int32)
    corners = corners_of(mesh, owner, completed.shell.source[polygons.cut_vertices])
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


def register() -> None:
    """Nothing to do: the operator is with the others."""


def unregister() -> None:
    _counted.cache_clear()
