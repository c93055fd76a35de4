"""The command line, `cmc job.toml` or `python -m solver job.toml`: form the shells of job files without Blender."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from . import __version__
from .errors import CmcError, Progress
from .jobs.job import EXAMPLE, Job, load_job, run_job
from .notes import as_asked

OK, FAILED, BAD_JOB = 0, 1, 2

_EPILOG = f"""\
exit code: 0 done; 1 a shell is not as asked (it did not converge, a goal was missed, it has a gap, or its mean
curvature is off by more than half) or a file could not be written; 2 a job or its mesh is unusable

a job:

{EXAMPLE}"""


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command line and return the exit code; argparse itself exits with 2 on bad arguments."""
    arguments = _parser().parse_args(argv)
    return max(run(job, verbose=arguments.verbose, quiet=arguments.quiet) for job in arguments.jobs)


def run(job_file: str, *, verbose: bool = False, quiet: bool = False) -> int:
    """Run one job: results go to stdout, warnings and errors to stderr, a sentence each."""
    path = str(Path(job_file))
    try:
        job = load_job(path)
    except CmcError as error:
        return _complain(path, error, BAD_JOB)
    try:
        shell = run_job(job, progress=_shown_steps(job) if verbose else None)
    except CmcError as error:
        return _complain(path, error, FAILED)
    except KeyboardInterrupt:
        return _complain(path, "interrupted.", FAILED)
    for warning in shell.warnings:
        print(f"{path}: {warning}", file=sys.stderr)
    if not quiet:
        print(shell.summary())
        for name, file in job.files.items():
            print(f"{name} → {file}")
    return OK if as_asked(shell.warnings) else FAILED


def _complain(path: str, error: object, code: int) -> int:
    """Print an error after the name of the job, unless the message begins with it."""
    text = str(error)
    print(text if text.startswith(path) else f"{path}: {text}", file=sys.stderr)
    return code


def _shown_steps(job: Job) -> Progress:
    """A progress that prints each step: the residual of a solve, the value of a fit, the gap of a closing."""
    what = "distance" if job.fit is not None else "residual" if job.close is None else "gap"
    return lambda step, value: print(f"step {step}: {what} {value:.2e}", file=sys.stderr)


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="cmc",
        description="Form shells of constant mean curvature from job files.",
        epilog=_EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("jobs", nargs="+", metavar="job.toml", help="job files; a failing one does not stop the others")
    parser.add_argument("-v", "--verbose", action="store_true", help="show every step of the solver on stderr")
    parser.add_argument("-q", "--quiet", action="store_true", help="print errors and warnings only")
    parser.add_argument("--version", action="version", version=f"cmc-formfinding {__version__}")
    return parser


if __name__ == "__main__":
    sys.exit(main())
