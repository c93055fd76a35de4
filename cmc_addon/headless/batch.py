"""Forming shells without a window: files in, results and reports out; a failure does not stop the rest.

Every input gets a folder of its own below the output, and every plan one in it (see `folders`):

===================================  ===================================================================
`<input>/<plan>/shell.glb`, `.obj`   the results of a plan; `completed.…` where it is repeated
`<input>/<plan>/report.json`         the report of the shell, or `{"plan": …, "error": …}`
`<input>/<input>.blend`              the whole scene, plans and results (format "blend")
`<input>/plans.json`                 the folder of each plan
`<input>/report.json`                why the input cannot be used
===================================  ===================================================================

Files come through an `Outbox`: whole, those of a plan together, and its report last. A report so belongs to the files
beside it; files of an earlier run with other inputs or settings go. Where files cannot be written, those of before
stay.
"""

from __future__ import annotations

import json
import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import bpy

from ...solver import interrupts
from ...solver.errors import CmcError, JobError
from ...solver.io.whole_files import Outbox, remove_stale
from ...solver.jobs.job import Job
from ...solver.jobs.outcomes import FAILED, UNUSABLE, Outcome, exit_code, failed
from ...solver.jobs.provenance import file_sizes, is_done, key_of, provenance, read_made
from ...solver.notes import notes_data
from ..bridges.start_bridge import has_start
from ..properties.links import results_of
from ..properties.made import conditions_of, plain
from ..tasks.solve import SolveTask
from ..tasks.task import Task
from .batch_files import input_hashes, open_input
from .exporters import EXPORTED, take_blend, take_export
from .folders import folder_names
from .plan_work import Formed, Steps, check, drop_results, override, run_step, steps_of

OUTPUTS = ("blend", *EXPORTED)
REPORT, LIST = "report.json", "plans.json"


@dataclass(frozen=True)
class Request:
    """What a run makes of an input.

    folder: for its files. formats: of `OUTPUTS`. plans: names of the plan objects, all if empty. task: of `TASKS`.
    settings: names of settings of a plan → values that override its own. conditions, up: for mesh files, as in a job
    file. resume: whether what an earlier run has finished is skipped.
    """

    folder: Path
    formats: Sequence[str] = ("blend",)
    plans: Sequence[str] = ()
    task: str = "auto"
    settings: Mapping[str, object] = field(default_factory=dict)
    conditions: Sequence[Mapping[str, object]] = ()
    up: str | None = None
    resume: bool = False


def run_file(path: Path, request: Request) -> Iterator[Outcome]:
    """Form all plans of a file and write their results; the open file is closed without saving."""
    run = FileRun(path, request)
    try:
        plans = run.open()
    except CmcError as error:
        yield run.refused(error)
        return
    names = [plan.name for plan in plans]
    skipped = run.done(names)
    for number, name in enumerate(names):
        # by name, since reports of one plan may free the data of another
        yield skipped[number] if skipped is not None else run.plan(bpy.context.scene.objects[name])
    if skipped is None:
        yield from run.finish()


class FileRun:
    """A run over one file. folders: plan → name of its folder. hashes: of the file and of what it reads."""

    def __init__(self, path: Path, request: Request) -> None:
        self.path, self.request, self.place = path, request, request.folder
        self.job: Job | None = None
        self.folders: dict[str, str] = {}
        self.hashes: dict[str, str] = {}
        self.codes: dict[str, int] = {}
        self.count = 1
        self.started = time.time()

    @property
    def blend(self) -> Path:
        return self.place / f"{self.path.stem}.blend"

    def open(self) -> list[bpy.types.Object]:
        """The plans of the file. Raises `CmcError`."""
        request = self.request
        self.job = open_input(self.path, request.conditions, request.up)
        plans = find_plans(bpy.context, request.plans)
        known = [plan.name for plan in [*_plans(bpy.context), *plans]]  # with --plan, too: folders keep their names
        self.folders = folder_names(known, (self.blend.name, REPORT, LIST))
        self.count = len(plans)
        self.hashes = input_hashes(self.path, self.job)
        folders = [self.place / self.folders[plan.name] for plan in plans]
        remove_stale([self.place.parent, self.place, *folders])
        return plans

    def refused(self, error: CmcError) -> Outcome:
        return self._fail(self.place, self.path.name, error, UNUSABLE, "")

    # --- what is done already

    def _wanted(self) -> dict[str, object]:
        request = self.request
        given = plain(request.settings)
        return {"task": request.task, "given": given, "conditions": list(request.conditions), "up": request.up or ""}

    def key(self, name: str) -> str:
        """Equal for equal files of a plan."""
        return key_of(self.hashes, self._wanted(), [name])

    def done(self, names: Sequence[str]) -> list[Outcome] | None:
        """The outcomes of plans of which all is done; None where the scene is wanted and is not there."""
        if not self.request.resume or "blend" not in self.request.formats:
            return None
        made = is_done(self.place / LIST, self.key("\n".join(names)), [self.blend])
        outcomes = [self.skipped(name, steps_of(bpy.data.objects[name], self.request.task, self.job)) for name in names]
        return None if made is None or None in outcomes else outcomes  # type: ignore[return-value]

    def skipped(self, name: str, steps: Steps) -> Outcome | None:
        """The outcome of a plan that an earlier run has finished."""
        files = self.files(name, steps)
        made = is_done(self.place / self.folders[name] / REPORT, self.key(name), list(files.values()))
        if made is None:
            return None
        return Outcome(str(self.path), name, made["code"], files=self._named(name, files), skipped=True, of=self.count)

    def files(self, name: str, steps: Steps) -> dict[str, Path]:
        """Format → file of a plan."""
        place = self.place / self.folders[name]
        return {suffix: place / f"{steps.file}.{suffix}" for suffix in self.request.formats if suffix in EXPORTED}

    def _named(self, name: str, files: Mapping[str, Path]) -> dict[str, str]:
        """Format → file of a plan, and its report, as outcomes name them."""
        report = self.place / self.folders[name] / REPORT
        return {form: str(file) for form, file in [*files.items(), ("report", report)]}

    # --- a plan

    def plan(self, plan: bpy.types.Object) -> Outcome:
        """Form one plan and write its files; whatever goes wrong is its outcome."""
        name, started = plan.name, time.time()
        place = self.place / self.folders[name]
        code, writing = UNUSABLE, False
        try:
            steps = steps_of(plan, self.request.task, self.job)
            if self.request.resume and "blend" not in self.request.formats:
                skipped = self.skipped(name, steps)
                if skipped is not None:
                    return skipped
            bpy.context.view_layer.update()
            override(plan, self.request.settings)
            tasks = dict(steps.reads)
            first = tasks[next(iter(tasks))](bpy.context, plan)
            check(first)
            code = FAILED
            formed = self._form(plan, steps, first)
            writing = True
            files = self._write(plan, steps, formed, first, started)
        except Exception as error:
            interrupts.check()
            return self._fail(place, name, error, code, name, writing)
        finally:
            if "blend" not in self.request.formats:
                drop_results(plan)
        code = self.codes[name] = exit_code(formed.ok, formed.warnings)
        seconds, of = round(time.time() - started, 3), self.count
        return Outcome(str(self.path), name, code, formed.message, formed.warnings, files, seconds, formed=True, of=of)

    def _form(self, plan: bpy.types.Object, steps: Steps, task: Task) -> Formed:
        formed = None
        for step, read in steps.reads.items():
            task = task if formed is None else read(bpy.context, plan)
            before = [] if formed is None else formed.warnings
            formed = run_step(bpy.context, plan, step, task)
            formed.warnings[:0] = [note for note in before if note not in formed.warnings]
        assert formed is not None
        return formed

    def _write(
        self, plan: bpy.types.Object, steps: Steps, formed: Formed, task: Task, started: float
    ) -> dict[str, str]:
        """Write the files of a plan, its report last; returns format → file."""
        name, place = plan.name, self.place / self.folders[plan.name]
        files = self.files(name, steps)
        solve = getattr(task, "solve", task)
        groups = solve.groups if isinstance(solve, SolveTask) else []
        settings = {**plain(steps.settings(plan)), "job": self.job.data if self.job is not None else {}}
        with Outbox(seal=place / REPORT, scratch=_made(place.parent)) as outbox:
            for target in files.values():
                take_export(outbox, bpy.context, formed.objects, target)
            made = self._provenance(settings, conditions_of(groups), started)
            made |= {"key": self.key(plan.name), "code": exit_code(formed.ok, formed.warnings)}
            made["files"] = file_sizes(outbox.pending(), place) | self._kept(outbox, place, made["key"])
            report = {**formed.report, "plan": plan.name, "task": steps.last}
            report |= {"warnings": notes_data(formed.warnings), "made": made}
            _take_json(outbox, place / REPORT, report)
            outbox.send()
        return self._named(name, files)

    def _provenance(
        self, settings: Mapping[str, object], conditions: Sequence[object], started: float
    ) -> dict[str, Any]:
        return provenance(self.hashes, settings, conditions, started=started, blender=bpy.app.version_string)

    def _kept(self, outbox: Outbox, place: Path, key: str) -> dict[str, int]:
        """The files of an earlier run that are of the same shell, in other formats; the others of it go."""
        earlier, coming = read_made(place / REPORT), outbox.pending()
        kept = {}
        for name, size in earlier.get("files", {}).items():
            file = place / name
            if Path(name).name != name or file in coming or not file.is_file():
                continue
            if earlier.get("key") == key and file.stat().st_size == size:
                kept[name] = size
            else:
                outbox.remove(file)
        return kept

    def _fail(self, place: Path, name: str, error: Exception, code: int, plan: str, writing: bool = False) -> Outcome:
        """Report a failure; where writing failed, the report and the files of before stay."""
        outcome = failed(str(self.path), error, code, plan, self.count)
        self.codes[name] = outcome.code
        report = {"plan": name, "converged": False, "error": outcome.message}
        try:
            if writing and (place / REPORT).exists():
                return outcome
            with Outbox(seal=place / REPORT, scratch=_made(place.parent)) as outbox:
                made = self._provenance(self._wanted(), [], self.started)
                outbox.at(place / REPORT)
                self._kept(outbox, place, "")
                _take_json(outbox, place / REPORT, report | {"made": {**made, "files": {}}})
                outbox.send()
        except (CmcError, OSError) as other:
            outcome = failed(str(self.path), JobError(f"{outcome.message} {other}"), outcome.code, plan, outcome.of)
        return outcome

    # --- the file

    def finish(self) -> Iterator[Outcome]:
        """Write the scene, if it is wanted, and the folder of each plan; an outcome only where that fails."""
        try:
            with Outbox(seal=self.place / LIST, scratch=_made(self.place.parent)) as outbox:
                outbox.remove(self.place / REPORT)  # of a run that could not use the input
                if "blend" in self.request.formats:
                    take_blend(outbox, self.blend)
                made = self._provenance(self._wanted(), [], self.started)
                made |= {"key": self.key("\n".join(self.codes)), "code": max(self.codes.values(), default=0)}
                outbox.at(self.place / LIST)
                made["files"] = file_sizes(outbox.pending(), self.place)
                report = {"input": str(self.path), "plans": {name: self.folders[name] for name in self.codes}}
                _take_json(outbox, self.place / LIST, {**report, "made": made})
                outbox.send()
        except Exception as error:
            yield failed(str(self.path), error, FAILED)


def find_plans(context: bpy.types.Context, names: Sequence[str] = ()) -> list[bpy.types.Object]:
    """The plans of the scene by name; or all that have boundary groups, a start or results or come from Mesh Plan.

    If the scene has one mesh only, that is the plan. Raises `JobError` without a plan.
    """
    objects = {ob.name: ob for ob in context.view_layer.objects}
    meshes, plans = _meshes(context), _plans(context)
    missing = [name for name in names if name not in objects]
    if missing:
        known = ", ".join(f"'{ob.name}'" for ob in objects.values() if ob.type == "MESH") or "none"
        raise JobError(f"There is no object '{missing[0]}' in the scene; its meshes are {known}.")
    if names:
        return [objects[name] for name in names]
    if not plans:
        raise JobError(
            f"No plan found: none of the {len(meshes)} meshes of the scene has boundary groups; make groups, or name "
            "the plans with --plan."
        )
    return plans


def _plans(context: bpy.types.Context) -> list[bpy.types.Object]:
    meshes = _meshes(context)
    plans = [ob for ob in meshes if ob.data.cmc.groups or ob.cmc.meshed or results_of(ob) or has_start(ob.data)]
    return plans or (meshes if len(meshes) == 1 else [])


def _meshes(context: bpy.types.Context) -> list[bpy.types.Object]:
    objects = context.view_layer.objects
    return [ob for ob in objects if ob.type == "MESH" and ob.cmc.role == "NONE" and ob.cmc.plan is None]


def _made(folder: Path) -> Path:
    """The folder, made if it is missing. Raises `JobError`."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise JobError(f"{folder} cannot be made: {error.strerror or error}.") from error
    return folder


def _take_json(outbox: Outbox, target: Path, report: Mapping[str, object]) -> None:
    text = json.dumps(report, indent=2, ensure_ascii=False, allow_nan=False, default=str)
    outbox.write(target, (text + "\n").encode("utf-8", "backslashreplace"))
