"""Undo of the list of groups in edit mode.

An undo step of edit mode holds only the edit mesh: undoing "Remove Boundary Group" would bring the edges back into a
group that is no longer in the list. So each change of the list in edit mode stamps the edit mesh with a number, which
undo restores, and after an undo or redo the list is restored to its state at that number. Kinds and angles keep their
last values, like any other property.

In object mode undo holds everything, and this file does nothing.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from itertools import count

import bpy
from bpy.app.handlers import persistent

from ..properties.group_settings import kind_parameters
from ..properties.registration import registration
from . import edge_bridge


@dataclass
class _History:
    """For one mesh: the uids in the list at each stamp, and the values of all groups ever in it."""

    lists: dict[int, tuple[int, ...]] = field(default_factory=dict)
    groups: dict[int, dict] = field(default_factory=dict)


_histories: dict[int, _History] = {}
_stamps = count(1)


def before(mesh: bpy.types.Mesh) -> None:
    """Note the list before an operator changes it."""
    if not mesh.is_editmode:
        _histories.pop(mesh.session_uid, None)
        return
    history = _histories.setdefault(mesh.session_uid, _History())
    _note(mesh, history, edge_bridge.read_stamp(mesh))


def after(mesh: bpy.types.Mesh) -> None:
    """Note the list if the operator changed it."""
    history = _histories.get(mesh.session_uid)
    if not mesh.is_editmode or history is None:
        return
    if history.lists[edge_bridge.read_stamp(mesh)] != _uids(mesh):
        stamp = next(_stamps)
        edge_bridge.write_stamp(mesh, stamp)
        _note(mesh, history, stamp)


def _note(mesh: bpy.types.Mesh, history: _History, stamp: int) -> None:
    history.lists[stamp] = _uids(mesh)
    history.groups.update({group.uid: _values(group) for group in mesh.cmc.groups})


def _uids(mesh: bpy.types.Mesh) -> tuple[int, ...]:
    return tuple(group.uid for group in mesh.cmc.groups)


def _values(group) -> dict:
    names = ("uid", "kind", *kind_parameters(group.kind), "across", "name")
    return {name: value if isinstance(value := getattr(group, name), (str, int, float)) else tuple(value)
            for name in names}


def _restore(mesh: bpy.types.Mesh, history: _History) -> None:
    """Restore the list of the stamp that undo brought back."""
    wanted = history.lists.get(edge_bridge.read_stamp(mesh))
    if wanted is None or wanted == _uids(mesh):
        return
    groups = mesh.cmc.groups
    history.groups.update({group.uid: _values(group) for group in groups})
    for index in reversed(range(len(groups))):
        if groups[index].uid not in wanted:
            groups.remove(index)
    for uid in wanted:
        if uid not in _uids(mesh):
            group = groups.add()
            for name, value in history.groups[uid].items():
                setattr(group, name, value)
    for place, uid in enumerate(wanted):
        groups.move(_uids(mesh).index(uid), place)
    mesh.cmc.active_index = max(0, min(mesh.cmc.active_index, len(groups) - 1))


@persistent
def _on_undo(*_: object) -> None:
    for mesh in bpy.data.meshes:
        history = _histories.get(mesh.session_uid)
        if history is not None and mesh.is_editmode:
            _restore(mesh, history)


@persistent
def _on_load(*_: object) -> None:
    _histories.clear()


register, _unlisten = registration(handlers={"undo_post": _on_undo, "redo_post": _on_undo, "load_post": _on_load})


def unregister() -> None:
    _unlisten()
    _histories.clear()
