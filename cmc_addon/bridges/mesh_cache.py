"""What is worked out from a mesh for the screen: once a change, not once a redraw.

The sidebar and the viewport are redrawn at every movement of the mouse. Blender announces every change of
geometry to the dependency graph; from then on nothing worked out before is used any more.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

import bpy
from bpy.app.handlers import persistent

from ..properties import group_list
from . import corner_bridge, edge_bridge

T = TypeVar("T")

_known: dict[tuple[int, str], tuple[tuple, object]] = {}


def boundary_counts(mesh: bpy.types.Mesh) -> tuple[int, int]:
    """Numbers of boundary edges in all, and of those in none of the mesh's groups."""
    return _cached(mesh, "counts", lambda: edge_bridge.count_boundary(mesh, group_list.uids(mesh)))


def mirror_corners(mesh: bpy.types.Mesh) -> list[corner_bridge.Corner]:
    """The corners between two mirrors."""
    kinds = ",".join(f"{group.uid}:{group.kind}" for group in mesh.cmc.groups)
    return _cached(mesh, f"corners {kinds}", lambda: corner_bridge.corners(mesh))


def _cached(mesh: bpy.types.Mesh, what: str, make: Callable[[], T]) -> T:
    sizes = len(mesh.vertices), len(mesh.edges), len(mesh.polygons)
    state = (mesh.is_editmode, sizes, group_list.uids(mesh))
    known = _known.get((mesh.session_uid, what))
    if known is None or known[0] != state:
        known = (state, make())
        _known[mesh.session_uid, what] = known
    return known[1]


@persistent
def _on_change(_scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph) -> None:
    if _known and any(update.is_updated_geometry for update in depsgraph.updates):
        _known.clear()


@persistent
def _on_other_data(*_: object) -> None:
    _known.clear()


_HANDLERS = (
    ("depsgraph_update_post", _on_change),
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
    _known.clear()
