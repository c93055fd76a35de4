"""Ctrl-C in the command lines: one sentence and exit code 130, whenever it comes."""

from __future__ import annotations

import importlib
import os
import signal
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from itertools import pairwise
from pathlib import Path
from types import ModuleType

SENTENCE = "Interrupted; what was finished is written, nothing is half written."


def _leave_quietly() -> None:
    """While a command imports numpy and scipy, end it at Ctrl-C: there is nothing to clean up yet."""
    if _is_command() and threading.current_thread() is threading.main_thread():
        signal.signal(signal.SIGINT, _leave)


class Pressed:
    """Whether Ctrl-C was pressed in a block of `interruptible`."""

    yes = False


def check() -> None:
    """Raise the `KeyboardInterrupt` that others have swallowed, as Blender's operators do."""
    if Pressed.yes:
        raise KeyboardInterrupt


@contextmanager
def interruptible(at_once: bool = True) -> Iterator[None]:
    """Let Ctrl-C raise `KeyboardInterrupt` in the block; Blender without a window has a handler of its own.

    at_once: or only where `check` is called, and at the second time: in Blender's own operators and handlers it would
    be a traceback.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    Pressed.yes = False
    before = signal.signal(signal.SIGINT, _press if at_once else _note)
    try:
        yield
        check()
    finally:
        Pressed.yes = False
        signal.signal(signal.SIGINT, signal.SIG_DFL if before is None else before)


def _press(*_: object) -> None:
    Pressed.yes = True
    raise KeyboardInterrupt


def _note(*_: object) -> None:
    if Pressed.yes:
        raise KeyboardInterrupt
    Pressed.yes = True


@contextmanager
def waiting() -> Iterator[None]:
    """A wait for input, which Ctrl-C ends at once."""
    check()
    with _handled_by(_press):
        yield


@contextmanager
def undisturbed() -> Iterator[None]:
    """Let Ctrl-C wait until the block has ended: a compiled module that is being imported ends the process at once."""
    came: list[object] = []
    with _handled_by(lambda *_: came.append(True)):
        yield
    if came:
        signal.raise_signal(signal.SIGINT)


def compiled(name: str) -> ModuleType:
    """Import a module that is written in C++. Raises `ImportError`."""
    with undisturbed():
        return importlib.import_module(name)


@contextmanager
def _handled_by(handler: Callable[..., None]) -> Iterator[None]:
    before = signal.getsignal(signal.SIGINT)
    if before is None or threading.current_thread() is not threading.main_thread():
        yield
        return
    signal.signal(signal.SIGINT, handler)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)


def _leave(*_: object) -> None:
    os.write(2, b"cmc: Interrupted.\n")
    os._exit(130)


def _is_command() -> bool:
    """Whether this package is run as `python -m solver`, as the command `cmc` or as `blender --command cmc`."""
    if any(pair in (("--command", "cmc"), ("-c", "cmc")) for pair in pairwise(sys.argv)):
        return True
    started = sys.orig_argv
    as_module = "-m" in started and started[started.index("-m") + 1 :][:1] == [__package__]
    return as_module or Path(sys.argv[0] if sys.argv else "").stem == "cmc"


_leave_quietly()
