"""The command line, `cmc job.toml` or `python -m solver job.toml`: form the shells of job files without Blender."""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Iterator, Sequence

from .errors import CmcError, Progress
from .jobs.job import EXAMPLE, Job, load_job, run_job
from .jobs.job_files import done_before
from .jobs.outcomes import EXIT_CODES, FAILED, Outcome, exit_code, failed
from .jobs.outcomes import UNUSABLE as BAD_JOB
from .jobs.runs import add_options, command_line
from .version import PROGRAM

_EPILOG = f"{EXIT_CODES}\n\na job:\n\n{EXAMPLE}"


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command line and return the exit code; argparse itself exits with 2 on bad arguments."""
    worker = [sys.executable, "-m", str(__package__), "--worker"]
    return command_line(sys.argv[1:] if argv is None else argv, _parser(), _read, worker)


def _read(arguments: argparse.Namespace):
    return arguments.jobs_files, lambda path: run(path, resume=arguments.resume, verbose=arguments.verbose)


def run(job_file: str, *, resume: bool = False, verbose: bool = False) -> Iterator[Outcome]:
    """Run one job, which has one outcome. resume: unless an earlier run has finished it."""
    started = time.time()
    try:
        job = load_job(job_file)
        made = done_before(job) if resume else None
    except CmcError as error:
        yield failed(job_file, error, BAD_JOB)
        return
    files = {name: str(file) for name, file in job.files.items()}
    if made is not None:
        yield Outcome(job_file, code=made["code"], files=files, skipped=True)
        return
    try:
        shell = run_job(job, progress=_shown_steps(job) if verbose else None)
    except CmcError as error:
        yield failed(job_file, error, FAILED)
        return
    code = exit_code(shell.ok, shell.warnings)
    seconds = round(time.time() - started, 3)
    yield Outcome(job_file, "", code, shell.summary(), shell.warnings, files, seconds, formed=True)


def _shown_steps(job: Job) -> Progress:
    """A progress that prints each step: the residual of a solve, then the gap of a closing, or the value of a fit."""
    what = "distance" if job.fit is not None else "residual" if job.settings.close is None else "residual or gap"
    return lambda step, value: print(f"step {step}: {what} {value:.2e}", file=sys.stderr)


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="cmc",
        description="Form shells of constant mean curvature from job files.",
        epilog=_EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument(
        "jobs_files", nargs="+", metavar="job.toml", help="job files; a failing one does not stop the others"
    )
    parser.add_argument("-v", "--verbose", action="store_true", help="show every step of the solver on stderr")
    parser.add_argument("--version", action="version", version=PROGRAM)
    add_options(parser)
    return parser


if __name__ == "__main__":
    sys.exit(main())
