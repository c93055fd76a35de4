"""What was worked out for the viewport, kept until something that it came from has changed.

A redraw compares keys and draws what is there. Blender announces changes of geometry to the dependency graph; each
object and mesh has a count of them here, which is a part of the keys. What is quick to work out is worked out at once;
what is slow waits until the changes pause, and is then drawn by a redraw of its own, so that dragging stays smooth.
"""

from __future__ import annotations

import time
from collections import Counter, OrderedDict
from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeVar

import bpy
from bpy.app.handlers import persistent

T = TypeVar("T")

# Seconds: what took less is done again at once, as long as it fills no larger part of the time than this; what took
# more waits for a pause of at least so long.
_QUICK, _PART, _PAUSE = 0.02, 0.3, 0.15
_KEPT = 24

_changes: Counter[int] = Counter()
_kept: OrderedDict[object, _Entry] = OrderedDict()


@dataclass
class _Entry:
    """A value with what it was made from, when and in how many seconds; what is wanted now, and since when."""

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


def version(*blocks: bpy.types.ID) -> tuple[tuple[int, int], ...]:
    """Changes with the geometry of objects and meshes."""
    return tuple((block.session_uid, _changes[block.session_uid]) for block in blocks)


def forget() -> None:
    """Drop everything."""
    _kept.clear()
    _changes.clear()


def _redraw_soon() -> None:
    if not bpy.app.timers.is_registered(redraw):
        bpy.app.timers.register(redraw, first_interval=_PAUSE)


def redraw() -> None:
    """Redraw every 3D viewport."""
    for window in bpy.context.window_manager.windows:
        for area in window.screen.areas:
            if area.type == "VIEW_3D":
                area.tag_redraw()


@persistent
def _on_change(_scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph) -> None:
    for update in depsgraph.updates:
        if update.is_updated_geometry and isinstance(update.id, (bpy.types.Object, bpy.types.Mesh)):
            _changes[update.id.original.session_uid] += 1


@persistent
def _on_other_data(*_: object) -> None:
    _kept.clear()


_HANDLERS = (
    ("depsgraph_update_post", _on_change),
    ("frame_change_post", _on_change),
    ("undo_post", _on_other_data),
    ("redo_post", _on_other_data),
    ("load_post", _on_other_data),
)


def register() -> None:
    for name, handler in _HANDLERS:
        getattr(bpy.app.handlers, name).append(handler)


def unregister() -> None:
    for name, handler in _HANDLERS:
        if handler in getattr(bpy.app.handlers, name):
            getattr(bpy.app.handlers, name).remove(handler)
    if bpy.app.timers.is_registered(redraw):
        bpy.app.timers.unregister(redraw)
    forget()
