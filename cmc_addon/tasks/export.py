"""Export: from result objects to one mesh file and its report, written as jobs write theirs."""

from __future__ import annotations

import json
import os
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import bpy

from ...solver.errors import CmcError, JobError, Progress
from ...solver.io.mesh_files import FORMATS, mesh_bytes
from ...solver.io.whole_files import Outbox
from ...solver.notes import Note
from ..bridges.export_bridge import Placed, joined, read_objects
from ..properties.links import copies_of, is_orphan, plan_of, result_of, shown_shell
from ..properties.reports import complete_report, shell_report, solve_report
from ..properties.stored import COMPLETED_ROLES, DESIGN_ROLES
from .task import Task

_MADE_BY = {"SHELL": "Solve", "COMPLETED": "Repeat by Symmetry"}


@dataclass(frozen=True, eq=False)
class ExportTask(Task[list[Path]]):
    """An export; here the work writes the files.

    parts: the meshes, written as one, their coordinates times `scale`. report: text of the JSON file beside it, if one
    is wanted. what: the choice of results, kept with the plan. warnings: for the user.
    """

    path: Path
    parts: list[Placed]
    report: str | None
    what: str
    scale: float = 1.0
    warnings: tuple[Note, ...] = ()

    @classmethod
    def read(
        cls, context: bpy.types.Context, plan: bpy.types.Object, path: Path, what: str, modifiers: bool, report: bool
    ) -> ExportTask:
        """Read the results.

        Raises `CmcError` where there are none, they have no faces, the format is not known, or a file that is not of
        this program would be lost.
        """
        if path.suffix.lower() not in FORMATS:
            raise JobError(f'{path} has no format known here; use one of {", ".join(FORMATS)}.')
        objects = wanted_objects(context, plan, what)
        parts = read_objects(objects, context.evaluated_depsgraph_get() if modifiers else None)
        if not any(len(part.mesh.starts) for part in parts):
            raise CmcError(f"'{objects[0].name}' has no faces, so there is nothing to export.")
        _check_targets(path, report)
        stored = _stored_report(plan, objects)
        return cls(
            path,
            parts,
            _report(plan, objects, stored or {}) if report else None,
            what,
            # glTF's unit is the metre by definition; the other formats have none
            context.scene.unit_settings.scale_length if path.suffix.lower() == ".glb" else 1.0,
            () if stored or not report else (_no_report(plan),),
        )

    def work(self, progress: Progress) -> list[Path]:
        """Write the files, each whole or not at all; returns their paths, none if the export was cancelled meanwhile.

        Raises `JobError`.
        """
        mesh, normals = joined(self.parts)
        mesh = replace(mesh, positions=self.scale * mesh.positions)
        report = self.path.with_suffix(".json")
        with Outbox(seal=report) as outbox:
            outbox.write(self.path, mesh_bytes(self.path, mesh, normals=normals))
            if self.report is not None:
                outbox.write(report, self.report.encode())
            return [] if progress(1, 1.0) is False else outbox.send()

    def write(self, context: bpy.types.Context, plan: bpy.types.Object, result: list[Path]) -> list[Note]:
        """Keep the choices with the plan."""
        plan.cmc.export_what, plan.cmc.export_format = self.what, self.path.suffix[1:].upper()
        return list(self.warnings)


def _no_report(plan: bpy.types.Object) -> Note:
    return Note("no-report", f"'{plan.name}' has no report to write beside the mesh; solve again.")


def _check_targets(path: Path, report: bool) -> None:
    """Raise `JobError` where a folder has the name of a file, or a file that is not a report that of the report."""
    beside = path.with_suffix(".json")
    for file in (path, beside) if report else (path,):
        if os.path.isdir(file):  # which, unlike Path.is_dir, takes a name that is too long
            raise JobError(f"{file} cannot be written: it is a folder; add the name of a file.")
    if report and os.path.exists(beside) and not _is_report(beside):
        raise JobError(
            f"The report would replace {beside}, which is not a report of this program; choose another name, or export "
            "without *Report*."
        )


def _is_report(file: Path) -> bool:
    """Whether a file is a report that an export has written."""
    try:
        found = json.loads(file.read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError):
        return False
    return isinstance(found, dict) and {"plan", "objects"} <= found.keys()


def wanted_objects(context: bpy.types.Context, plan: bpy.types.Object, what: str) -> list[bpy.types.Object]:
    """The results to export. Raises `CmcError` where there are none."""
    if what == "SELECTED":
        selected = [ob for ob in context.selected_objects if ob.type == "MESH" and ob.cmc.role != "NONE"]
        if not selected:
            raise CmcError("No result is selected; select the shells to export.")
        return selected
    if what != "AUTO":
        results = _in_role(plan, what)
        if not results:
            raise CmcError(f"'{plan.name}' has no such result yet; {_MADE_BY[what]} makes it.")
        return results
    active = context.view_layer.objects.active
    if active is not None and active.type == "MESH" and active.cmc.role != "NONE":
        return _in_role(plan, "COMPLETED") if active.cmc.role == "COMPLETED" else [active]
    shell = shown_shell(context)
    if shell is None:
        raise CmcError(f"'{plan.name}' has no shell yet; Solve makes one.")
    return _in_role(plan, "COMPLETED") if shell.cmc.role == "COMPLETED" else [shell]


def export_owner(ob: bpy.types.Object | None) -> bpy.types.Object:
    """The object that keeps the settings of an export: the plan, or a result whose plan has been deleted.

    Raises `CmcError` where no object is active.
    """
    return ob if ob is not None and is_orphan(ob) else plan_of(ob)


def _in_role(plan: bpy.types.Object, what: str) -> list[bpy.types.Object]:
    if is_orphan(plan):
        beside = plan.users_collection[0].objects if what == "COMPLETED" else [plan]
        return [ob for ob in beside if ob.cmc.role == plan.cmc.role and is_orphan(ob)]
    if what == "COMPLETED" and (copies := copies_of(plan)) is not None:
        return list(copies.objects)
    result = result_of(plan, plan.cmc.sheet if what == "SHELL" else what)
    return [] if result is None else [result]


def _stored_report(plan: bpy.types.Object, objects: Sequence[bpy.types.Object]) -> dict | None:
    """The report of the exported shell; None if its plan has none, or one of another program."""
    first = objects[0]
    own = first.cmc.role in DESIGN_ROLES or is_orphan(first)
    if own:
        return shell_report(first)
    return complete_report(plan) if first.cmc.role in COMPLETED_ROLES else solve_report(plan)


def _report(plan: bpy.types.Object, objects: Sequence[bpy.types.Object], report: dict) -> str:
    """The text of a report, with the names of the exported objects."""
    names = [ob.name for ob in objects]
    return json.dumps({"plan": plan.name, "objects": names, **report}, indent=2, ensure_ascii=False) + "\n"
