"""Writing the files of a job together, the report with its provenance last; and whether an earlier run has done it."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Protocol

from ..errors import JobError
from ..io.obj import MeshData
from ..io.whole_files import Outbox, remove_stale
from ..shells.complete import Completed
from ..shells.plan import Plan, Settings
from ..shells.shell import Shell
from .complete_table import CompleteOptions
from .job_paths import named_inputs
from .outcomes import exit_code
from .outputs import report_data, take_completed, take_sheets
from .provenance import file_sizes, hash_of, is_done, key_of, provenance


class Job(Protocol):
    """What of a `job.Job` is needed here."""

    path: Path
    mesh: MeshData
    settings: Settings
    outputs: dict[str, Path]
    up: str | None
    complete: CompleteOptions | None
    data: Mapping[str, object]

    @property
    def files(self) -> dict[str, Path]: ...


def write_job(
    job: Job, shell: Shell, plan: Plan, completed: Completed | None, more: Mapping[str, Any], started: float
) -> list[JobError]:
    """Write the files of a job together, the report last; returns why some cannot be made, and are left out.

    more: tables to add to the report. Raises `JobError`, with nothing changed, where they cannot be written.
    """
    _remove_stale(job)
    report, combinatorics = job.outputs.get("report"), job.settings.combinatorics
    with Outbox(seal=report) as outbox:
        missing = take_sheets(outbox, shell, plan, job.mesh, job.outputs, up=job.up, combinatorics=combinatorics)
        if completed is not None and job.complete is not None:
            take_completed(outbox, completed, job.complete, plan, job.mesh, job.up)
        if report is not None:
            made = provenance(**_what(job), started=started)
            made |= {"code": exit_code(shell.ok and not missing, shell.warnings)}
            made |= {"files": file_sizes(outbox.pending(), report.parent)}
            data = report_data(shell) | dict(more) | {"made": made}
            text = json.dumps(data, indent=2, ensure_ascii=False, allow_nan=False)
            outbox.write(report, (text + "\n").encode())
        outbox.send()
    return missing


def done_before(job: Job) -> dict[str, Any] | None:
    """The table `made` of the report of an earlier run, if it has done all of this job; None without a report."""
    _remove_stale(job)
    report = job.outputs.get("report")
    if report is None:
        return None
    wanted = [file for file in job.files.values() if file != report]
    return is_done(report, key_of(**_what(job)), wanted)


def _remove_stale(job: Job) -> None:
    """What interrupted runs have left beside the files of a job, or beside those that links lead to."""
    files = [*job.files.values(), *(Path(os.path.realpath(file)) for file in job.files.values())]
    remove_stale({file.parent for file in files})


def _what(job: Job) -> dict[str, Any]:
    """The inputs, settings and conditions of a job, as `provenance` and `key_of` take them."""
    settings = {name: table for name, table in job.data.items() if name != "conditions"}
    return {"inputs": job_inputs(job), "settings": settings, "conditions": job.data.get("conditions", [])}


def job_inputs(job: Job) -> dict[str, str]:
    """Name → hash of the files that a job reads; the job file itself is in its settings and conditions."""
    return {path: hash_of(job.path.parent / path) for path in named_inputs(job.data).values()}
