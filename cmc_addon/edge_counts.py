"""How many boundary edges a mesh has, and how many are in no group: counted once a change, not once a redraw.

The sidebar is redrawn at every movement of the mouse over it. Blender announces every change of geometry to
the dependency graph; from then on the old count is not used any more.
"""

from __future__ import annotations

import bpy
from bpy.app.handlers import persistent

from . import edge_bridge, group_list

_counts: dict[int, tuple[tuple, tuple[int, int]]] = {}


def boundary_counts(mesh: bpy.types.Mesh) -> tuple[int, int]:
    """Numbers of boundary edges in all, and of those in none of the mesh's groups."""
    uids = group_list.uids(mesh)
    key = (mesh.is_editmode, len(mesh.vertices), len(mesh.edges), len(mesh.polygons), uids)
    known = _counts.get(mesh.session_uid)
    if known is None or known[0] != key:
        known = (key, edge_bridge.count_boundary(mesh, uids))
        _counts[mesh.session_uid] = known
    return known[1]


@persistent
def _on_change(_scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph) -> None:
    if _counts and any(update.is_updated_geometry for update in depsgraph.updates):
        _counts.clear()


@persistent
def _on_other_data(*_: object) -> None:
    _counts.clear()


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
    _counts.clear()
