"""Background tasks that start by themselves, as those of Live.

A task runs in a thread; a tick of Blender's timer looks after it and writes its result.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import bpy

from . import worker

TICK = 0.01
"""Seconds between two ticks while there is something to look after."""


class BackgroundTask:
    """A task under way; it gives way to the solves that the user starts."""

    def __init__(self, task: Any) -> None:
        self.task = task
        self._steps = worker.steps(task.work, task.tolerance, wait=0.0, gives_way=True)

    def look(self) -> tuple[bool, Any]:
        """Whether the task has ended, and its result: None if it has given way. Raises the errors of the work."""
        try:
            while next(self._steps) is not None:
                pass
        except StopIteration as end:
            return True, end.value
        return False, None

    def drop(self) -> None:
        """Cancel the task."""
        self._steps.close()


def may_start() -> bool:
    """Whether no other work runs."""
    return worker.Running.stop is None


def wake(tick: Callable[[], float | None]) -> None:
    """Call tick from the timer until it returns None. Without a window there is no timer."""
    if not bpy.app.background and not bpy.app.timers.is_registered(tick):
        bpy.app.timers.register(tick, first_interval=0.0)


def rest(tick: Callable[[], float | None]) -> None:
    """Stop calling tick."""
    if bpy.app.timers.is_registered(tick):
        bpy.app.timers.unregister(tick)
