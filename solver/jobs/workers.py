"""Inputs shared out over processes: each is given one after the other and answers with a line of JSON for each plan.

A process that dies takes one input with it; the others go on. All end with the one that started them.
"""

from __future__ import annotations

import json
import os
import queue
import signal
import subprocess
import sys
import tempfile
import threading
from collections.abc import Callable, Generator, Iterable, Iterator, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any, TextIO

from ..interrupts import check, waiting
from ..notes import CODES, Note
from .outcomes import FAILED, Outcome, failed

WORKER = "--worker"
_END = {"end": True}
# Seconds in which an interrupted process may clean up.
_PATIENCE = 10.0
# Characters of what a process said last, for the log.
_LAST = 4000

RunOne = Callable[[str], Iterable[Outcome]]
Outcomes = Generator[Outcome, None, None]


def in_turn(inputs: Iterable[str], run_one: RunOne) -> Outcomes:
    """The outcomes of the inputs, one after the other; whatever goes wrong in one is its outcome."""
    for path in inputs:
        try:
            yield from run_one(path)
        except Exception as error:
            check()
            yield failed(path, error)
        check()


def in_processes(inputs: Sequence[str], count: int, command: Sequence[str], argv: Sequence[str]) -> Outcomes:
    """The same in `count` processes of a command line that answers to `--worker`; argv: its other arguments."""
    left: queue.SimpleQueue[str] = queue.SimpleQueue()
    for path in inputs:
        left.put(path)
    news: queue.SimpleQueue[Outcome | BaseException | None] = queue.SimpleQueue()
    crew = [_Worker(command, argv, left, news) for _ in range(min(count, len(inputs)))]
    for worker in crew:
        worker.thread.start()
    try:
        ended = 0
        while ended < len(crew):
            check()
            try:
                outcome = news.get(timeout=0.5)  # a wait without end would not notice Ctrl-C on Windows
            except queue.Empty:
                continue
            if isinstance(outcome, BaseException):
                raise outcome
            if outcome is None:
                ended += 1
            else:
                yield outcome
    finally:
        for worker in crew:
            worker.stopped = True
        for worker in crew:
            worker.end()


def serve(run_one: Callable[[list[str]], RunOne], out: TextIO) -> int:
    """Be such a process: the first line has the arguments, each further one an input. Ends with its stdin."""
    run: RunOne | None = None
    for line in _lines():
        if run is None:
            run = run_one(json.loads(line))
            continue
        for outcome in in_turn([json.loads(line)], run):
            data = outcome.to_dict() | {"of": outcome.of, "details": outcome.details}
            out.write(json.dumps(data) + "\n")
            out.flush()
        out.write(json.dumps(_END) + "\n")
        out.flush()
    return 0


def _lines() -> Iterator[str]:
    """The lines of stdin."""
    while True:
        with waiting():
            line = sys.stdin.readline()
        if not line:
            return
        yield line


class _Worker:
    """A process and the thread that feeds it."""

    def __init__(self, command: Sequence[str], argv: Sequence[str], left: queue.SimpleQueue, news) -> None:
        self.command, self.argv, self.left, self.news = command, argv, left, news
        self.process: subprocess.Popen[str] | None = None
        self.stopped = False
        self.noise = tempfile.TemporaryFile("w+", encoding="utf-8", errors="replace")  # noqa: SIM115  closed in end
        self.thread = threading.Thread(target=self._work, daemon=True)

    def _work(self) -> None:
        try:
            while not self.stopped:
                try:
                    path = self.left.get_nowait()
                except queue.Empty:
                    break
                for outcome in self._run(path):
                    self.news.put(outcome)
        except BaseException as error:
            if not self.stopped:
                self.news.put(error)
        self.news.put(None)

    def _run(self, path: str) -> Iterator[Outcome]:
        try:
            process = self.process or self._start()
            assert process.stdin is not None and process.stdout is not None
            process.stdin.write(json.dumps(path) + "\n")
            process.stdin.flush()
            for line in process.stdout:
                data = _answer(line)
                if data == _END:
                    return
                if data is not None:
                    yield _outcome(data)
        except BrokenPipeError:
            pass
        if not self.stopped:
            code = 0
            if self.process is not None:
                code, self.process = self.process.wait(), _closed(self.process)
            message = f"The process that worked on it ended without a word (exit code {code}); is the memory enough?"
            yield Outcome(path, code=FAILED, message=message, details=self._last_words() or message)

    def _start(self) -> subprocess.Popen[str]:
        apart: dict = {"start_new_session": True}
        if sys.platform == "win32":
            apart = {"creationflags": subprocess.CREATE_NEW_PROCESS_GROUP}
        # Ctrl-C reaches this process alone, which tells the others
        self.process = subprocess.Popen(
            self.command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=self.noise, encoding="utf-8",
            env=_environment(), **apart,
        )  # fmt: skip
        assert self.process.stdin is not None
        self.process.stdin.write(json.dumps(list(self.argv)) + "\n")
        return self.process

    def _last_words(self) -> str:
        self.noise.seek(0)
        return self.noise.read()[-_LAST:]

    def end(self) -> None:
        """Let an idle process go; interrupt a busy one."""
        if self.process is not None:
            if self.thread.is_alive():
                self.process.send_signal(signal.SIGINT if sys.platform != "win32" else signal.CTRL_BREAK_EVENT)
            elif self.process.stdin is not None:
                self.process.stdin.close()
            try:
                self.process.wait(_PATIENCE)
            except subprocess.TimeoutExpired:
                self.process.kill()
                self.process.wait()
            self.thread.join(_PATIENCE)
            self.process = _closed(self.process)
        self.noise.close()


def _closed(process: subprocess.Popen[str]) -> None:
    """Close the pipes of a process that has ended."""
    for pipe in (process.stdin, process.stdout):
        with suppress(OSError):
            if pipe is not None:
                pipe.close()


def _answer(line: str) -> dict | None:
    """A line of ours; None for what Blender says before the command begins."""
    try:
        data = json.loads(line)
    except ValueError:
        return None
    return data if isinstance(data, dict) and ("end" in data or "formed" in data) else None


def _outcome(data: dict) -> Outcome:
    notes = data.pop("warnings")
    known: list[Any] = [
        Note(note["code"], note["text"]) if isinstance(note, dict) and note["code"] in CODES else note for note in notes
    ]
    return Outcome(**data, warnings=known)


def _environment() -> dict[str, str]:
    """This process's, with the folder of this package; each process has a processor to itself."""
    package = sys.modules[__name__.partition(".")[0]]
    folders = [str(Path(folder).parent) for folder in getattr(package, "__path__", [])]
    paths = [*folders, *os.environ.get("PYTHONPATH", "").split(os.pathsep)]
    return {"OPENBLAS_NUM_THREADS": "1", **os.environ, "PYTHONPATH": os.pathsep.join(filter(None, paths))}
