"""The work on a plan without a window: the tasks of the operators, one after the other, and what they make.

`steps_of` gives the tasks of a plan: those of its job's tables, the one that the command line names, or the one that
made the shell it shows.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from functools import partial

import bpy

from ...solver import interrupts
from ...solver.errors import JobError
from ...solver.fitting.gauss_map import GaussMapOptions
from ...solver.jobs.job import Job
from ...solver.notes import Note
from ...solver.shells.complete import CopySelection
from ...solver.shells.form import check_plan
from ..background import plan_cache
from ..properties.approximate_settings import APPROXIMATE_SETTINGS, stored_settings
from ..properties.links import copies_of, result_of, results_of, wanted_roles
from ..properties.reports import complete_report, design_report, solve_report
from ..properties.settings import SETTINGS, fitted_settings
from ..properties.stored import COMPLETED_ROLES, DESIGN_ROLES, ROLES
from ..properties.symmetry_settings import COMPLETE_SETTINGS
from ..results.instances import delete_instances
from ..results.objects import check_writable, delete_result
from ..tasks.approximate import ApproximateTask
from ..tasks.complete import CompleteTask
from ..tasks.shell_task import ShellTask, read_solve
from ..tasks.solve import SolveTask, settings_of, solver_settings
from ..tasks.task import Task
from .batch_files import short_name

Read = Callable[[bpy.types.Context, bpy.types.Object], Task]

TASKS: dict[str, str] = {
    "auto": "what the job says, or what made the shell that the plan shows",
    "solve": "the shell over the plan",
    "approximate": "the shell nearest to the plan, a surface in space",
    "complete": "the shell and its copies by symmetry",
}
"""What to do with a plan, for `--task`."""

GIVEN = (*SETTINGS, *APPROXIMATE_SETTINGS, *COMPLETE_SETTINGS)
"""The settings of a plan that the command line can override."""

# The settings of each task beside those of a solve.
_OWN = {"approximate": APPROXIMATE_SETTINGS, "complete": COMPLETE_SETTINGS}


@dataclass(frozen=True)
class Formed:
    """What a task has made: a message, warnings, whether it is as asked, the objects and their report."""

    message: str
    warnings: list[Note]
    ok: bool
    objects: list[bpy.types.Object]
    report: dict


@dataclass(frozen=True)
class Steps:
    """The tasks of a plan by name, in their order, and how each is read."""

    reads: dict[str, Read]

    @property
    def last(self) -> str:
        return list(self.reads)[-1]

    @property
    def file(self) -> str:
        """The name of the files, without the ending."""
        return "completed" if self.last == "complete" else "shell"

    def settings(self, plan: bpy.types.Object) -> dict[str, object]:
        """The settings that the tasks use, with their names."""
        names = dict.fromkeys([*SETTINGS, *(name for step in self.reads for name in _OWN.get(step, ()))])
        return {"task": list(self.reads), **{name: getattr(plan.cmc, name) for name in names}}


def task_for(task: str, given: Iterable[str]) -> str:
    """The task that settings given by name belong to. Raises `JobError` where they do not go together."""
    for name in given:
        owner = next((owner for owner, names in _OWN.items() if name in names), task)
        if task not in ("auto", owner):
            raise JobError(f"--{name.replace('_', '-')} goes with --task {owner}, not with {task}.")
        task = owner
    return task


def override(plan: bpy.types.Object, given: Mapping[str, object]) -> None:
    """Give a plan these settings. Raises `CmcError` where they contradict each other, or the plan is not to be
    changed."""
    check_writable(plan)
    mine = {name: value for name, value in given.items() if name in SETTINGS}
    settings = fitted_settings({name: getattr(plan.cmc, name) for name in SETTINGS} | mine, mine)
    for name, value in [*vars(settings).items(), *((name, given[name]) for name in given if name not in mine)]:
        setattr(plan.cmc, name, value)


def steps_of(plan: bpy.types.Object, wanted: str, job: Job | None) -> Steps:
    if wanted == "auto" and job is not None:
        return Steps(_of_job(job))
    return Steps({step: _READ[step] for step in [_shown(plan) if wanted == "auto" else wanted]})


def _shown(plan: bpy.types.Object) -> str:
    """The task that made the shell that a plan shows."""
    copies = copies_of(plan)
    results = results_of(plan, (*DESIGN_ROLES, *COMPLETED_ROLES))
    seen = {role for role, ob in results.items() if not ob.hide_viewport}
    if "COMPLETED" in seen or (copies is not None and any(not ob.hide_viewport for ob in copies.objects)):
        return "complete"
    if "NEAREST" in seen and not results_of(plan):
        return "approximate"
    return "solve"


def check(task: Task) -> None:
    """Raise `CmcError` where the conditions of a solve contradict each other, before it begins."""
    solve = task.solve if isinstance(task, ShellTask) else task
    if isinstance(solve, SolveTask):
        settings = solver_settings(solve.settings)
        prepared = plan_cache.prepare(solve.mesh, settings.solver_choice)
        plan, domain = solve.plan(prepared), prepared.solver.domain
        with prepared.plan_numbers(solve.mesh):
            check_plan(plan, settings, domain)


def run_step(context: bpy.types.Context, plan: bpy.types.Object, step: str, task: Task) -> Formed:
    """Do a task and write its results into the scene."""
    result = task.work(lambda iteration, residual: not interrupts.Pressed.yes)
    interrupts.check()
    warnings = task.write(context, plan, result)
    interrupts.check()
    if isinstance(task, ApproximateTask):
        shown = result_of(plan, "NEAREST")
        report = design_report(plan) or {}
        return Formed(result.message, warnings, result.converged, [] if shown is None else [shown], report)
    report, shell = solve_report(plan) or {}, result.solved.shell if step != "solve" else result.shell
    if isinstance(task, CompleteTask):
        copies = copies_of(plan)
        welded = result_of(plan, "COMPLETED")
        objects = [welded] if welded is not None else [] if copies is None else list(copies.objects)
        report = {**report, "completed": complete_report(plan) or {}}
        return Formed(f"{shell.summary()}\n{result.message}", warnings, result.converged, objects, report)
    objects = [result_of(plan, role) for role in wanted_roles(settings_of(plan.cmc))]
    return Formed(shell.summary(), warnings, result.converged, [ob for ob in objects if ob is not None], report)


def drop_results(plan: bpy.types.Object) -> None:
    """Delete the results of a plan, which are in files now: a long run does not grow."""
    delete_instances(plan)
    for result in results_of(plan, (*ROLES, *DESIGN_ROLES, *COMPLETED_ROLES)).values():
        delete_result(result)


# --- how tasks are read --------------------------------------------------------------------


def _solve(context: bpy.types.Context, plan: bpy.types.Object) -> Task:
    return SolveTask.read(context, plan, settings_of(plan.cmc))


def _approximate(context: bpy.types.Context, plan: bpy.types.Object) -> Task:
    return ApproximateTask.read(context, plan, stored_settings(plan.cmc, APPROXIMATE_SETTINGS))


def _complete(context: bpy.types.Context, plan: bpy.types.Object) -> Task:
    wanted = stored_settings(plan.cmc, COMPLETE_SETTINGS)
    wanted.complete_repeat = tuple(wanted.complete_repeat)
    wanted.box = plan.cmc.complete_box.name if plan.cmc.complete_box is not None else ""
    return CompleteTask.read(context, plan, wanted)


_READ: dict[str, Read] = {"solve": _solve, "approximate": _approximate, "complete": _complete}


def _of_job(job: Job) -> dict[str, Read]:
    """The tasks of a job's tables, with their options."""
    fit, complete = job.fit, job.complete
    if isinstance(fit, GaussMapOptions):
        stored = partial(stored_settings, names=APPROXIMATE_SETTINGS)
        return {"approximate": lambda context, plan: ApproximateTask.read(context, plan, stored(plan.cmc), fit)}
    reads: dict[str, Read] = {}
    if complete is not None:
        copies = complete.copies
        named = lambda names: [short_name(name) for name in names]  # noqa: E731
        selection = replace(
            copies,
            sides=None if copies.sides is None else named(copies.sides),
            around=[named(ring) for ring in copies.around],
        )
        reads["complete"] = lambda context, plan: _read_copies(context, plan, selection, complete.mesh is not None)
    return reads or {"solve": _solve}


def _read_copies(
    context: bpy.types.Context, plan: bpy.types.Object, selection: CopySelection, welded: bool
) -> CompleteTask:
    wanted = stored_settings(plan.cmc, COMPLETE_SETTINGS)
    wanted.complete_repeat, wanted.box = tuple(wanted.complete_repeat), ""
    wanted.complete_as = "MESH" if welded else "INSTANCES"
    if selection.copies is not None:
        wanted.complete_extent, wanted.complete_count = "COUNT", selection.copies
    return CompleteTask(*read_solve(context, plan), selection, wanted)
