"""Changes of geometry announced by Blender's dependency graph; caches that depend on them are then out of date.

The sidebar and the viewport are redrawn at every movement of the mouse, so what they show is computed once a change,
not once a redraw. A cache either has `version` in its keys, or is `watched` and emptied. Undo, redo and another file
empty both kinds: their numbers of objects and meshes may mean others.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import MutableMapping
from typing import TypeVar

import bpy
from bpy.app.handlers import persistent

from ..properties.registration import registration

Cache = TypeVar("Cache", bound=MutableMapping)

_changes: Counter[int] = Counter()
_caches: list[MutableMapping] = []
_emptied_by_geometry: list[MutableMapping] = []


def version(*blocks: bpy.types.ID) -> tuple[tuple[int, int], ...]:
    """Changes with the geometry of objects and meshes."""
    return tuple((block.session_uid, _changes[block.session_uid]) for block in blocks)


def watched(cache: Cache, *, geometry: bool = True) -> Cache:
    """The cache, which undo, redo and another file will empty; with `geometry`, every change of a mesh will, too."""
    _caches.append(cache)
    if geometry:
        _emptied_by_geometry.append(cache)
    return cache


@persistent
def _on_change(_scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph) -> None:
    changed = [update.id for update in depsgraph.updates if update.is_updated_geometry]
    for block in changed:
        if isinstance(block, (bpy.types.Object, bpy.types.Mesh)):
            _changes[block.original.session_uid] += 1
    if changed:
        _empty(_emptied_by_geometry)


@persistent
def _on_other_data(*_: object) -> None:
    _empty(_caches)


def _empty(caches: list[MutableMapping]) -> None:
    for cache in caches:
        cache.clear()


register, _unlisten = registration(
    handlers={
        "depsgraph_update_post": _on_change,
        "frame_change_post": _on_change,
        "undo_post": _on_other_data,
        "redo_post": _on_other_data,
        "load_post": _on_other_data,
    }
)


def unregister() -> None:
    _unlisten()
    _empty(_caches)
    _changes.clear()
