"""Runs over several inputs, the same for both command lines: options, processes, Ctrl-C, exit codes."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Sequence
from pathlib import Path

from ..errors import CmcError, JobError
from ..interrupts import SENTENCE, interruptible
from .console import Console, own_stdout, silence
from .outcomes import INTERRUPTED, UNUSABLE
from .workers import WORKER, RunOne, in_processes, in_turn, serve

# How the names of files end into which no log belongs.
_NO_LOGS = (".toml", ".blend", ".obj", ".mtl", ".ply", ".stl", ".glb", ".npz", ".json")

Read = Callable[[argparse.Namespace], tuple[list[str], RunOne]]
"""From the arguments to the inputs and what runs one of them. Raises `CmcError` where they do not fit."""


def add_options(parser: argparse.ArgumentParser) -> None:
    """The options that both command lines have."""
    group = parser.add_argument_group("runs over several inputs")
    group.add_argument(
        "--resume", action="store_true",
        help="skip what an earlier run has finished: same input, settings and version, its report and files in place",
    )  # fmt: skip
    group.add_argument("--jobs", type=_count, default=1, metavar="N", help="work in N processes (default: 1)")
    group.add_argument("--json", action="store_true", help="one line of JSON for each plan on stdout, for machines")
    group.add_argument("--log", type=Path, metavar="FILE", help="add what happens to this file")
    group.add_argument("-q", "--quiet", action="store_true", help="print errors and warnings only")


def _count(text: str) -> int:
    if not text.isdecimal() or not 1 <= int(text) <= 256:
        raise argparse.ArgumentTypeError(f"it is a number of processes from 1 to 256, not {text!r}")
    return int(text)


def command_line(
    argv: Sequence[str], parser: argparse.ArgumentParser, read: Read, command: Sequence[str], at_once: bool = True
) -> int:
    """Run a command line and return its exit code.

    command: how to start another process of it. at_once: whether Ctrl-C raises anywhere, see `interruptible`.

    argparse exits by itself on help and on bad arguments.
    """
    try:
        with interruptible(at_once):
            if list(argv) == [WORKER]:
                with own_stdout() as out:
                    return serve(lambda given: read(parser.parse_args(given))[1], out or sys.stdout)
            arguments = parser.parse_args(list(argv))
            try:
                inputs, run_one = read(arguments)
                _check_log(arguments.log, inputs)
            except CmcError as error:
                print(f"{parser.prog.split()[-1]}: {error}", file=sys.stderr)
                return UNUSABLE
            return _run(arguments, list(argv), inputs, run_one, command)
    except KeyboardInterrupt:
        print(f"{parser.prog.split()[-1]}: {SENTENCE}", file=sys.stderr)
        return INTERRUPTED
    except SystemExit:
        _flush()
        raise


def _check_log(log: Path | None, inputs: Sequence[str]) -> None:
    """Raise `JobError` on a log that is a folder, an input, or a file of a kind that inputs and results have."""
    if log is None:
        return
    if log.is_dir():
        raise JobError(f"The log {log} is a folder; name a file in it.")
    if log.resolve() in [Path(each).resolve() for each in inputs] or log.suffix.lower() in _NO_LOGS:
        raise JobError(f"The log {log} would go into a file of another kind; choose another name, like log.txt.")


def _flush() -> None:
    """Here, where it can be noticed that the reader of the help has left."""
    try:
        sys.stdout.flush()
    except BrokenPipeError:
        silence(sys.stdout)


def _run(
    arguments: argparse.Namespace, argv: list[str], inputs: list[str], run_one: RunOne, command: Sequence[str]
) -> int:
    with own_stdout() as out:
        folder = getattr(arguments, "output", None) or Path()
        console = Console(len(inputs), arguments.json, arguments.quiet, arguments.log, folder, out)
        outcomes = (
            in_processes(inputs, arguments.jobs, command, argv)
            if arguments.jobs > 1 and len(inputs) > 1
            else in_turn(inputs, run_one)
        )
        try:
            for outcome in outcomes:
                console.show(outcome)
        finally:
            outcomes.close()
        return console.code
