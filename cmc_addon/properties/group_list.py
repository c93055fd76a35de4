"""The boundary groups of a mesh: unique names, and uids that are never reused."""

from __future__ import annotations

import re

import bpy

from ...solver.errors import ConditionError


def uids(mesh: bpy.types.Mesh) -> frozenset[int]:
    """The uids of all groups of the mesh: the valid values of the edge attribute."""
    return frozenset(group.uid for group in mesh.cmc.groups)


def active(mesh: bpy.types.Mesh):
    """The active group, or None."""
    groups, index = mesh.cmc.groups, mesh.cmc.active_index
    return groups[index] if 0 <= index < len(groups) else None


def find(mesh: bpy.types.Mesh, name: str = ""):
    """The group of that name, or with "" the active one. Raises `ConditionError`, which lists the names."""
    group = mesh.cmc.groups.get(name) if name else active(mesh)
    if group is None:
        names = ", ".join(repr(other.name) for other in mesh.cmc.groups) or "none"
        wanted = f"No boundary group is called {name!r}" if name else "No boundary group is active"
        raise ConditionError(f"{wanted}; the groups of this mesh are: {names}.")
    return group


def add(mesh: bpy.types.Mesh, name: str):
    """A new group at the end of the list, made active; a name already taken gets a number."""
    cmc = mesh.cmc
    free = free_name(name or "Group", {group.name for group in cmc.groups})
    group = cmc.groups.add()
    group.name = free
    group.uid = cmc.next_uid
    cmc.next_uid += 1
    cmc.active_index = len(cmc.groups) - 1
    return group


def remove(mesh: bpy.types.Mesh, uid: int) -> None:
    """Remove the group from the list; the active group stays active where possible."""
    cmc = mesh.cmc
    index = next(k for k, group in enumerate(cmc.groups) if group.uid == uid)
    cmc.groups.remove(index)
    if cmc.active_index > index or cmc.active_index >= len(cmc.groups):
        cmc.active_index = max(0, cmc.active_index - 1)


def free_name(name: str, taken: set[str]) -> str:
    """`name`, or the first free one of name.001, name.002, …, as Blender numbers."""
    base, number = re.fullmatch(r"(.*?)(?:\.(\d+))?", name, re.DOTALL).groups()
    count = int(number or 0)
    while name in taken:
        count += 1
        name = f"{base}.{count:03d}"
    return name
