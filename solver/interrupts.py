"""Ctrl-C in the command lines: one sentence and exit code 130, whenever it comes."""

from __future__ import annotations

import importlib
import os
import signal
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from types import ModuleType

SENTENCE = "Interrupted; what was finished is written, nothing is half written."


def _leave_quietly() -> None:
    """While a command imports numpy and scipy, end it at Ctrl-C: there is nothing to clean up yet."""
    if _is_command() and threading.current_thread() is threading.main_thread():
        signal.signal(signal.SIGINT, _leave)


_asked = False


@contextmanager
def interruptible(at_once: bool = True) -> Iterator[None]:
    """Let Ctrl-C raise `KeyboardInterrupt` in the block; Blender without a window has a handler of its own.

    at_once: or only where the block calls `stop_if_asked`, and at a second Ctrl-C; Blender swallows exceptions in its
    handlers and operators.
    """
    global _asked
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = signal.signal(signal.SIGINT, signal.default_int_handler if at_once else _ask)
    try:
        stop_if_asked()  # it may have been before
        yield
    finally:
        _asked = False
        signal.signal(signal.SIGINT, signal.SIG_DFL if before is None else before)


def is_asked() -> bool:
    """Whether Ctrl-C asks to stop where `stop_if_asked` is called next."""
    return _asked


def stop_if_asked() -> None:
    """Raise `KeyboardInterrupt` where Ctrl-C has asked for it."""
    global _asked
    if _asked:
        _asked = False
        raise KeyboardInterrupt


def _ask(*_: object) -> None:
    global _asked
    if _asked:
        raise KeyboardInterrupt
    _asked = True


@contextmanager
def undisturbed() -> Iterator[None]:
    """Let Ctrl-C wait until the block has ended: a compiled module that is being imported ends the process at once."""
    handler = signal.getsignal(signal.SIGINT)
    if handler is None or threading.current_thread() is not threading.main_thread():
        yield
        return
    came: list[object] = []
    signal.signal(signal.SIGINT, lambda *_: came.append(True))
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, handler)
        if came:
            signal.raise_signal(signal.SIGINT)


def compiled(name: str) -> ModuleType:
    """Import a module that is written in C++. Raises `ImportError`."""
    with undisturbed():
        return importlib.import_module(name)


def _leave(*_: object) -> None:
    os.write(2, b"cmc: Interrupted.\n")
    os._exit(130)


def _is_command() -> bool:
    """Whether this package is run as `python -m solver` or as the command `cmc`."""
    started = sys.orig_argv
    as_module = "-m" in started and started[started.index("-m") + 1 :][:1] == [__package__]
    return as_module or Path(sys.argv[0] if sys.argv else "").stem == "cmc"


_leave_quietly()
