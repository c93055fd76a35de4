"""Runs work in a thread that never touches Blender's data.

`steps` is the only way to run it, for a script that waits and for a window that keeps drawing.
"""

from __future__ import annotations

import math
import queue
import threading
import traceback
from collections.abc import Callable, Generator
from dataclasses import dataclass
from typing import TypeVar

import bpy

from ...solver.errors import CmcError, Progress, unexpected
from ...solver.linalg import Patience
from .plan_cache import forget

T = TypeVar("T")

# Unknowns whose factorisation by cholespy holds up a window for about a tenth of a second.
_PATIENT = 20_000


def register() -> None:
    """With a window, factor large matrices in a way that lets it keep drawing."""
    Patience.largest = math.inf if bpy.app.background else _PATIENT


def unregister() -> None:
    """Stop the running work and drop the kept results."""
    cancel()
    forget()
    Patience.largest = math.inf


@dataclass(frozen=True)
class Step:
    """A step of the work: `fraction` goes from 0 to 1 as the residual falls to the tolerance."""

    iteration: int
    residual: float
    fraction: float


class Running:
    """The running work, if any: `cmc.cancel` stops it, and so does the next work where it gives way. `thread` is
    the last one started; after being cancelled it may still be busy."""

    stop: threading.Event | None = None
    gives_way: bool = False
    thread: threading.Thread | None = None


def cancel() -> bool:
    """Stop waiting for the running work, which ends after its current step; False where none runs."""
    if Running.stop is None:
        return False
    Running.stop.set()
    return True


def steps(
    work: Callable[[Progress], T], tolerance: float, wait: float, gives_way: bool = False
) -> Generator[Step | None, None, T | None]:
    """Run `work(progress)` in a thread; yield each step, or None after `wait` seconds without one.

    Returns the result of the work, or None as soon as it is cancelled. Raises the errors of the work as `CmcError`, and
    the same while other work runs that does not give way. Closing the generator cancels. Nobody waits for a cancelled
    thread: it may be measuring, which has no steps to stop after. The next one starts when it has ended.
    """
    if Running.stop is not None:
        if not Running.gives_way:
            raise CmcError("A solve is running; wait for it, or cancel it (Esc) first.")
        Running.stop.set()
    stop = threading.Event()
    news: queue.SimpleQueue = queue.SimpleQueue()
    arguments = (work, stop, news, Running.thread)
    Running.stop, Running.gives_way = stop, gives_way
    Running.thread = threading.Thread(target=_run, args=arguments, name="cmc-solve", daemon=True)
    Running.thread.start()
    first = 0.0
    try:
        while not stop.is_set():
            try:
                kind, value = news.get(timeout=wait)
            except queue.Empty:
                yield None
                continue
            if kind == "done":
                return value
            if kind == "error":
                raise _in_a_sentence(value)
            iteration, residual = value
            first = first or residual
            yield Step(iteration, residual, _fraction(first, residual, tolerance))
        return None
    finally:
        if Running.stop is stop:
            Running.stop = None
        stop.set()


def _in_a_sentence(error: BaseException) -> BaseException:
    """An error that nobody expected as one to show; its traceback goes to the console."""
    if isinstance(error, CmcError) or not isinstance(error, Exception):
        return error
    if not isinstance(error, MemoryError):
        traceback.print_exception(error)
    return CmcError(unexpected(error, "please report it, with what the console says"))


def _run(
    work: Callable[[Progress], object],
    stop: threading.Event,
    news: queue.SimpleQueue,
    before: threading.Thread | None,
) -> None:
    def progress(iteration: int, residual: float) -> bool:
        if iteration >= 0:
            news.put(("step", (iteration, residual)))
        return not stop.is_set()

    try:
        if before is not None:
            before.join()  # the caches serve one thread at a time
        if not stop.is_set():
            news.put(("done", work(progress)))
    except BaseException as error:  # handed over whole: `steps` raises it in Blender's thread
        news.put(("error", error))


def _fraction(first: float, residual: float, tolerance: float) -> float:
    if not (first > tolerance and residual > 0 and math.isfinite(residual)):
        return 0.0
    return min(max(math.log(first / residual) / math.log(first / tolerance), 0.0), 1.0)
