"""Ctrl-C in the command lines: one sentence and exit code 130, whenever it comes."""

from __future__ import annotations

import os
import signal
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

SENTENCE = "Interrupted; what was finished is written, nothing is half written."


def _leave_quietly() -> None:
    """While a command imports numpy and scipy, end it at Ctrl-C: there is nothing to clean up yet."""
    if _is_command() and threading.current_thread() is threading.main_thread():
        signal.signal(signal.SIGINT, _leave)


@contextmanager
def interruptible() -> Iterator[None]:
    """Let Ctrl-C raise `KeyboardInterrupt` in the block; Blender without a window has a handler of its own."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, signal.SIG_DFL if before is None else before)


def _leave(*_: object) -> None:
    os.write(2, b"cmc: Interrupted.\n")
    os._exit(130)


def _is_command() -> bool:
    """Whether this package is run as `python -m solver` or as the command `cmc`."""
    started = sys.orig_argv
    as_module = "-m" in started and started[started.index("-m") + 1 :][:1] == [__package__]
    return as_module or Path(sys.argv[0] if sys.argv else "").stem == "cmc"


_leave_quietly()
