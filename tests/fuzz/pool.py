"""Worker processes, each restarted when a case ends it."""

from __future__ import annotations

import json
import os
import queue
import re
import select
import signal
import subprocess
import sys
import tempfile
import threading
from collections.abc import Iterable, Iterator
from pathlib import Path

from .judge import Outcome
from .worker import SECONDS

ROOT = Path(__file__).resolve().parents[2]
# Real time for a second of a processor that others use, too; a case that waits for something takes no time of its own.
_SHARED = 10.0


class Worker:
    """One process; `run` gives it a case and waits for the outcome."""

    def __init__(self) -> None:
        self.log = tempfile.TemporaryFile()  # noqa: SIM115  open as long as the process
        environment = os.environ | {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1", "PYTHONHASHSEED": "0"}
        self.process = subprocess.Popen(
            [sys.executable, "-m", "tests.fuzz.worker"],
            cwd=ROOT,
            env=environment,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=self.log,
            bufsize=0,
        )

    def run(self, case: str) -> Outcome:
        assert self.process.stdin is not None and self.process.stdout is not None
        try:
            self.process.stdin.write(f"{case}\n".encode())
            ready = select.select([self.process.stdout], [], [], _SHARED * SECONDS)[0]
            line = self.process.stdout.readline() if ready else b""
        except BrokenPipeError:
            line = b""
        return Outcome(**json.loads(line)) if line else self._end_of(case)

    def _end_of(self, case: str) -> Outcome:
        self.process.kill()
        code = self.process.wait()
        kind = "over time" if code in (-signal.SIGXCPU, -signal.SIGKILL) else "crash"
        self.log.seek(0)
        stack = re.findall(r'File ".*/solver/(.*)", line (\d+) in (\w+)', self.log.read().decode(errors="replace"))
        where = " ← ".join(f"{file}:{line} {name}" for file, line, name in stack[:3])
        return Outcome(case, kind, f"exit {code} ({where})", float(SECONDS))

    @property
    def is_alive(self) -> bool:
        return self.process.poll() is None

    def close(self) -> None:
        self.process.kill()
        self.process.wait()
        for stream in (self.process.stdin, self.process.stdout, self.log):
            if stream is not None:
                stream.close()


def run_all(cases: Iterable[str], workers: int) -> Iterator[Outcome]:
    """The outcomes, as they come."""
    waiting: queue.Queue[str] = queue.Queue()
    for case in cases:
        waiting.put(case)
    count, done = waiting.qsize(), queue.Queue()

    def work() -> None:
        worker = None
        try:
            while True:
                case = waiting.get_nowait()
                if worker is None or not worker.is_alive:
                    worker = _renewed(worker)
                done.put(worker.run(case))
        except queue.Empty:
            pass
        finally:
            if worker is not None:
                worker.close()

    for _ in range(workers):
        threading.Thread(target=work, daemon=True).start()
    for _ in range(count):
        yield done.get()


def _renewed(worker: Worker | None) -> Worker:
    if worker is not None:
        worker.close()
    return Worker()
