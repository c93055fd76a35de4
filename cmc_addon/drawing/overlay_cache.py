"""Values computed for the viewport, kept until their sources change.

A redraw compares keys, which contain `version`s of the geometry, and draws what is there. What is quick is computed
again at once; what is slow waits for a pause in the changes and is then drawn by a redraw of its own, so that dragging
stays smooth.
"""

from __future__ import annotations

import time
from collections import OrderedDict
from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeVar

import bpy

from ..bridges.geometry_changes import watched
from .viewport import redraw

T = TypeVar("T")

# Seconds: what took less is done again at once, as long as it fills no larger part of the time than this; what took
# more waits for a pause of at least so long.
_QUICK, _PART, _PAUSE = 0.02, 0.3, 0.15
_KEPT = 24

_kept: OrderedDict[object, _Entry] = watched(OrderedDict(), geometry=False)


@dataclass
class _Entry:
    """A value with its key, its time and its seconds of work; the key wanted now, and since when."""

    value: object
    key: object
    done: float
    cost: float
    wanted: object = None
    since: float = 0.0

    def is_due(self, key: object, now: float) -> bool:
        if self.wanted != key:
            self.wanted, self.since = key, now
        if self.cost < _QUICK:
            return now - self.done >= self.cost / _PART
        return now - self.since >= max(_PAUSE, 2.0 * self.cost)


def kept(slot: object, key: object, make: Callable[[], T]) -> T:
    """The value of `make()`, made again when the key has changed: at once, or soon, with the last one until then."""
    entry, now = _kept.get(slot), time.perf_counter()
    if entry is not None:
        _kept.move_to_end(slot)
        if entry.key == key:
            return entry.value  # type: ignore[return-value]
        if not bpy.app.background and not entry.is_due(key, now):
            _redraw_soon()
            return entry.value  # type: ignore[return-value]
    value = make()
    done = time.perf_counter()
    _kept[slot] = _Entry(value, key, done, done - now)
    _kept.move_to_end(slot)
    while len(_kept) > _KEPT:
        _kept.popitem(last=False)
    return value


def forget() -> None:
    """Drop everything, the redraw that is due included."""
    if bpy.app.timers.is_registered(redraw):
        bpy.app.timers.unregister(redraw)
    _kept.clear()


def _redraw_soon() -> None:
    if not bpy.app.timers.is_registered(redraw):
        bpy.app.timers.register(redraw, first_interval=_PAUSE)
