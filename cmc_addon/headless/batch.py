"""Solving without a window: files in, results and reports out; a failure does not stop the rest.

Every input gets a folder of its own, `<output>/<name of the input>/`:

=============================  =====================================================================
`<name>.blend`                 the whole scene, plans and results (format "blend")
`<plan>/shell.glb`, `.obj`     the wanted results of a plan (formats "glb", "obj")
`<plan>/report.json`           the report of the shell, or `{"plan": …, "error": …}`
=============================  =====================================================================

Files are written under another name and then moved, so that no reader gets half a file.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import bpy

from ...solver.errors import CmcError, JobError
from ...solver.io.mesh_files import write_bytes
from ...solver.notes import Note, as_asked, notes_data
from ..bridges.start_bridge import has_start
from ..properties.links import result_of, results_of, wanted_roles
from ..properties.reports import solve_report
from ..properties.settings import SETTINGS, fitted_settings
from ..results.objects import check_writable
from ..tasks.solve import SolveTask, settings_of
from .batch_files import EXPORTERS, export, open_input, save_blend

OUTPUTS = ("blend", *EXPORTERS)


@dataclass(frozen=True)
class Request:
    """The files that a run writes for every input.

    output: the folder. formats: of `OUTPUTS`. plans: names of the plan objects, all if empty. settings:
    names of SETTINGS → values that override the plan's own. conditions: tables as in a job file, for mesh
    files.
    """

    output: Path
    formats: Sequence[str] = ("blend",)
    plans: Sequence[str] = ()
    settings: Mapping[str, object] = field(default_factory=dict)
    conditions: Sequence[Mapping[str, object]] = ()
    up: str | None = None


@dataclass(frozen=True)
class Done:
    """How one plan ended: a message and warnings for the user, and whether the solve succeeded."""

    plan: str
    good: bool
    message: str
    warnings: Sequence[Note] = ()


def run_file(path: Path, request: Request) -> Iterator[Done]:
    """Solve all plans of a file and write their results; the open file is closed without saving.

    A failure of a plan or of the input itself gives a `Done` and a report.
    """
    folder = request.output / path.stem
    try:
        open_input(path, request.conditions, request.up)
        plans = find_plans(bpy.context, request.plans)
    except CmcError as error:
        yield _failed(folder, path.name, error)
        return
    for plan in plans:
        yield run_plan(bpy.context, plan, request, folder)
    if "blend" in request.formats:
        try:
            save_blend(folder / f"{path.stem}.blend")
        except CmcError as error:
            yield Done(path.name, False, str(error))


def run_plan(context: bpy.types.Context, plan: bpy.types.Object, request: Request, folder: Path) -> Done:
    """Solve one plan and write its files into a folder of its own below `folder`."""
    name = plan.name
    place = folder / bpy.path.clean_name(name)
    try:
        message, warnings = _solve(context, plan, request.settings)
        wanted = [result_of(plan, role) for role in wanted_roles(settings_of(plan.cmc))]
        for suffix in request.formats:
            if suffix in EXPORTERS:
                export(context, [ob for ob in wanted if ob is not None], place, f"shell.{suffix}")
        report = {**(solve_report(plan) or {}), "warnings": notes_data(warnings)}
        _write_report(place, report)
    except CmcError as error:
        return _failed(place, name, error)
    return Done(name, as_asked(warnings), message, warnings)


def find_plans(context: bpy.types.Context, names: Sequence[str] = ()) -> list[bpy.types.Object]:
    """The plans of the scene by name; or all that have boundary groups, a start or results or come from Mesh Plan.

    If the scene has one mesh only, that is the plan. Raises `JobError` without a plan.
    """
    objects = {ob.name: ob for ob in context.view_layer.objects}
    missing = [name for name in names if name not in objects]
    if missing:
        known = ", ".join(f"'{ob.name}'" for ob in objects.values() if ob.type == "MESH") or "none"
        raise JobError(f"There is no object '{missing[0]}' in the scene; its meshes are {known}.")
    if names:
        return [objects[name] for name in names]
    meshes = [ob for ob in objects.values() if ob.type == "MESH" and ob.cmc.role == "NONE" and ob.cmc.plan is None]
    plans = [ob for ob in meshes if ob.data.cmc.groups or ob.cmc.meshed or results_of(ob) or has_start(ob.data)]
    if not plans and len(meshes) == 1:
        return meshes
    if not plans:
        raise JobError(
            f"No plan found: none of the {len(meshes)} meshes of the scene has boundary groups; make groups, or name "
            "the plans with --plan."
        )
    return plans


def _solve(
    context: bpy.types.Context, plan: bpy.types.Object, overrides: Mapping[str, object]
) -> tuple[str, list[Note]]:
    """Message and warnings; the results are in the scene."""
    context.view_layer.update()
    settings = fitted_settings({name: getattr(plan.cmc, name) for name in SETTINGS} | dict(overrides), overrides)
    check_writable(plan)
    task = SolveTask.read(context, plan, settings)
    result = task.work(lambda iteration, residual: True)
    warnings = task.write(context, plan, result)
    return result.shell.report.summary(), warnings


def _failed(place: Path, name: str, error: CmcError) -> Done:
    """Report a failure; the message has two if even the report cannot be written."""
    message = str(error)
    try:
        _write_report(place, {"plan": name, "converged": False, "error": message})
    except CmcError as other:
        message += f" {other}"
    return Done(name, False, message)


def _write_report(place: Path, report: Mapping[str, object]) -> None:
    text = json.dumps(report, indent=2, ensure_ascii=False, allow_nan=False)
    write_bytes(place / "report.json", (text + "\n").encode())
