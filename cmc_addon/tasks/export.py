"""Export: from result objects to one mesh file and its report, by the writers that jobs use as well.

Reading the objects takes no time and is done in Blender's thread; what writes the files sees arrays only.
"""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

import bpy

from ...solver.errors import CmcError, JobError
from ...solver.io.mesh_files import FORMATS, write_bytes, write_mesh
from ..bridges.export_bridge import Placed, joined, read_objects
from ..properties.links import copies_of, result_of

_MADE_BY = {"SHELL": "Solve", "FIT": "Fit to Outline", "COMPLETED": "Complete by Symmetry"}


@dataclass(frozen=True, eq=False)
class ExportOrder:
    """All that writing needs, without any Blender data: safe in a thread.

    parts: the meshes, to be written as one. report: text of the JSON file beside it, if one is wanted.
    """

    path: Path
    parts: list[Placed]
    report: str | None

    def work(self, progress: Callable[[int, float], bool]) -> list[Path]:
        """Write, each file at once or not at all; returns what was written: nothing where it was cancelled meanwhile.

        Raises `JobError`.
        """
        place = self.path.parent
        try:
            place.mkdir(parents=True, exist_ok=True)
            with TemporaryDirectory(prefix=".export-", dir=place) as scratch:
                files = self._write(Path(scratch))
                return [_move(file, place) for file in files] if progress(1, 1.0) else []
        except OSError as error:
            raise JobError(f"{self.path} cannot be written: {error.strerror or error}.") from error

    def _write(self, folder: Path) -> list[Path]:
        files = [folder / self.path.name]
        mesh, normals = joined(self.parts)
        write_mesh(files[0], mesh, normals=normals)
        if self.report is not None:
            files.append(files[0].with_suffix(".json"))
            write_bytes(files[1], self.report.encode())
        return files


def _move(file: Path, place: Path) -> Path:
    os.replace(file, place / file.name)
    return place / file.name


def wanted_objects(context: bpy.types.Context, plan: bpy.types.Object, what: str) -> list[bpy.types.Object]:
    """The results to be written. Raises `CmcError` where there are none."""
    if what == "SELECTED":
        found = [ob for ob in context.selected_objects if ob.type == "MESH" and ob.cmc.role != "NONE"]
        if not found:
            raise CmcError("No result is selected; select the shells to export.")
        return found
    if what != "AUTO":
        found = _in_role(plan, what)
        if not found:
            raise CmcError(f"'{plan.name}' has no such result yet; {_MADE_BY[what]} makes it.")
        return found
    active = context.view_layer.objects.active
    if active is not None and active.type == "MESH" and active.cmc.role != "NONE":
        return _in_role(plan, "COMPLETED") if active.cmc.role == "COMPLETED" else [active]
    completed = [ob for ob in _in_role(plan, "COMPLETED") if not ob.hide_viewport]
    found = completed or _in_role(plan, "FIT") or _in_role(plan, "SHELL") or _in_role(plan, "NEAREST")
    if not found:
        raise CmcError(f"'{plan.name}' has no shell yet; Solve makes one.")
    return found


def _in_role(plan: bpy.types.Object, what: str) -> list[bpy.types.Object]:
    if what == "COMPLETED" and (copies := copies_of(plan)) is not None:
        return list(copies.objects)
    result = result_of(plan, plan.cmc.sheet if what == "SHELL" else what)
    return [] if result is None else [result]


def take_export(
    context: bpy.types.Context, plan: bpy.types.Object, path: Path, what: str, modifiers: bool, with_report: bool
) -> ExportOrder:
    """Read the results. Raises `CmcError` where there are none, they have no faces, or the format is not known."""
    if path.suffix.lower() not in FORMATS:
        raise JobError(f'{path} has no format known here; use one of {", ".join(FORMATS)}.')
    objects = wanted_objects(context, plan, what)
    parts = read_objects(objects, context.evaluated_depsgraph_get() if modifiers else None)
    if not any(len(part.mesh.starts) for part in parts):
        raise CmcError(f"'{objects[0].name}' has no faces, so there is nothing to export.")
    report = _report(plan, objects) if with_report else None
    return ExportOrder(path, parts, report)


def _report(plan: bpy.types.Object, objects: Sequence[bpy.types.Object]) -> str:
    """The report of what is written, and the names of its objects."""
    texts = {"FIT": plan.cmc.design_report, "NEAREST": plan.cmc.design_report, "COMPLETED": plan.cmc.complete_report}
    try:
        told = json.loads(texts.get(objects[0].cmc.role, plan.cmc.report))
    except ValueError:
        told = {}  # nobody has solved yet, or somebody else wrote into the property
    names = [ob.name for ob in objects]
    return json.dumps({"plan": plan.name, "objects": names, **told}, indent=2, ensure_ascii=False) + "\n"
