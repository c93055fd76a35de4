"""What a run says: blocks and sentences for people, lines of JSON for machines, a log file."""

from __future__ import annotations

import json
import os
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from datetime import UTC, datetime
from pathlib import Path
from typing import TextIO

from .outcomes import Outcome

LOG = "cmc.log"


@dataclass
class Console:
    """Shows outcomes. total: the number of inputs, each of which may turn out to have several plans.

    A reader that leaves (`| head`) ends the text, not the work.
    """

    total: int
    json: bool = False
    quiet: bool = False
    log: Path | None = None
    folder: Path = field(default_factory=Path)
    out: TextIO | None = None
    done: int = 0
    code: int = 0
    _started: float = field(default_factory=time.monotonic)
    _worked: int = 0
    _known: set[str] = field(default_factory=set)
    _owners: dict[str, str] = field(default_factory=dict)

    def show(self, outcome: Outcome) -> None:
        if outcome.input not in self._known:
            self._known.add(outcome.input)
            self.total += outcome.of - 1
        self.done += 1
        self._worked += not outcome.skipped
        self.code = max(self.code, outcome.code)
        self._log(outcome)
        if self.json:
            self.say(json.dumps(outcome.to_dict(), ensure_ascii=False, allow_nan=False))
        elif outcome.skipped:
            rest = "; its shell is not as asked, see its report." if outcome.code else "."
            self._block(f"{outcome.where}: done before, skipped{rest}")
        elif outcome.formed:
            files = [f"{name} → {file}" for name, file in outcome.files.items()]
            self._block("\n".join([f"{outcome.where}:", outcome.message, *files]))
        if not outcome.formed and not outcome.skipped:
            self.complain(outcome.where, outcome.message)
        for warning in outcome.warnings:
            self.complain(outcome.where, warning)
        self._check_owners(outcome)
        if self.total > 1 and not self.quiet:
            self.complain("", f"{self.done} of {self.total}{self._left()}")

    def say(self, text: str) -> None:
        fault = _print(text, self.out or sys.stdout)
        if fault:
            self.code = max(self.code, 1)
            self.complain("", f"The output cannot be written: {fault}.")

    def complain(self, where: str, text: str) -> None:
        """A sentence on stderr, after the place it is about, unless it begins with it."""
        _print(text if not where or text.startswith(where) else f"{where}: {text}", sys.stderr)

    def _block(self, text: str) -> None:
        if not self.quiet:
            self.say(text)

    def _check_owners(self, outcome: Outcome) -> None:
        """Two plans that write one file: the second has replaced the first one's."""
        for file in outcome.files.values():
            owner = self._owners.setdefault(os.path.normcase(os.path.abspath(file)), outcome.where)
            if owner != outcome.where:
                self.code = max(self.code, 1)
                self.complain(outcome.where, f"{file} was written by {owner}, too, in this run; give one another name.")

    def _left(self) -> str:
        """The time that the rest takes at the pace so far."""
        rest = self.total - self.done
        if not rest or not self._worked:
            return ""
        seconds = round((time.monotonic() - self._started) / self._worked * rest)
        hours, minutes = divmod(seconds // 60, 60)
        clock = f"{hours}:{minutes:02}:{seconds % 60:02}" if hours else f"{minutes}:{seconds % 60:02}"
        return f", {clock} left"

    def _log(self, outcome: Outcome) -> None:
        """Every outcome goes to the log that was asked for; an unexpected error to a log in any case."""
        if self.log is None and not outcome.details:
            return
        file = self.log or self.folder / LOG
        how = "skipped" if outcome.skipped else f"exit code {outcome.code}, {outcome.seconds:.2f} s"
        head = f"{datetime.now(UTC):%Y-%m-%dT%H:%M:%SZ} {outcome.where}: {how}"
        lines = [head, *outcome.message.splitlines(), *outcome.warnings, *outcome.details.splitlines()]
        text = "\n    ".join(lines) + "\n"
        for place in (file, Path(tempfile.gettempdir()) / LOG):
            try:
                place.parent.mkdir(parents=True, exist_ok=True)
                with open(place, "a", encoding="utf-8", errors="replace") as stream:
                    stream.write(text)
            except OSError as error:
                self.code = max(self.code, 1)
                self.complain(str(place), f"the log cannot be written: {error.strerror or error}.")
            else:
                if outcome.details:
                    self.complain(outcome.where, f"the traceback is in {place}.")
                return


def _print(text: str, stream: TextIO) -> str:
    """What went wrong, as on a full disk; then the stream is silent from here on."""
    try:
        print(text, file=stream, flush=True)
    except UnicodeEncodeError:  # a console of another alphabet
        print(text.encode("ascii", "backslashreplace").decode(), file=stream, flush=True)
    except BrokenPipeError:
        silence(stream)
    except OSError as error:
        silence(stream)
        return error.strerror or str(error)
    return ""


def silence(stream: TextIO) -> None:
    """Whoever read the stream has left: what follows goes nowhere, also what Python flushes at its end."""
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, stream.fileno())
    os.close(nowhere)


@contextmanager
def own_stdout() -> Iterator[TextIO | None]:
    """A stdout of our own; what others print meanwhile, such as Blender itself, goes to stderr. None within a test."""
    if sys.stdout is not sys.__stdout__ or sys.__stdout__ is None:
        yield None
        return
    sys.stdout.flush()
    number = sys.stdout.fileno()
    kept = os.dup(number)
    os.dup2(2, number)
    try:
        with os.fdopen(kept, "w", encoding="utf-8", closefd=False) as stream:
            yield stream
    except BrokenPipeError:
        pass
    finally:
        sys.stdout.flush()
        os.dup2(kept, number)
        os.close(kept)
