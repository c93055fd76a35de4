"""Work that is done beside Blender without being asked for each time: what Follow and Live have in common.

An errand is one order, worked on in a thread; a tick of Blender's timer looks after it and writes what it brings.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import bpy

from . import worker

TICK = 0.01
"""Seconds between two ticks while there is something to look after."""


class Errand:
    """An order on its way; it gives way to the solves that the user starts."""

    def __init__(self, order: Any) -> None:
        self.order = order
        self._steps = worker.steps(order.work, order.settings.tolerance, wait=0.0, gives_way=True)

    def look(self) -> tuple[bool, Any]:
        """Whether it has ended, and what it brings: None where it has given way. Raises what the work raises."""
        try:
            while next(self._steps) is not None:
                pass
        except StopIteration as end:
            return True, end.value
        return False, None

    def drop(self) -> None:
        """Want it no more."""
        self._steps.close()


def may_start() -> bool:
    """Whether no other work is going on."""
    return worker.Running.stop is None


def wake(tick: Callable[[], float | None]) -> None:
    """See to it that a tick comes, and goes on coming until it returns None. Without a window there are no ticks."""
    if not bpy.app.background and not bpy.app.timers.is_registered(tick):
        bpy.app.timers.register(tick, first_interval=0.0)


def rest(tick: Callable[[], float | None]) -> None:
    """No more ticks."""
    if bpy.app.timers.is_registered(tick):
        bpy.app.timers.unregister(tick)
