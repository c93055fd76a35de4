"""What a plan is to be solved from, written to its mesh: edge lengths of its own, and a start.

One of the files that touch mesh data; `mesh_bridge` reads what is written here.
"""

from __future__ import annotations

import bpy
import numpy as np
from numpy.typing import NDArray

from ...solver.shells.plan import Plan
from .mesh_bridge import LENGTH_ATTRIBUTE, START_ATTRIBUTE, read, remove_attribute, set_attribute

Array = NDArray[np.floating]


def write_start(mesh: bpy.types.Mesh, plan: Plan) -> None:
    """Give a mesh, which has the triangles of a plan and is not in edit mode, the plan's own lengths and its start."""
    if plan.lengths is not None:
        triangles = np.asarray(plan.triangles, dtype=np.int64)
        sides = np.stack([np.roll(triangles, -1, axis=1), np.roll(triangles, 1, axis=1)], axis=2).reshape(-1, 2)
        write_lengths(mesh, sides, np.asarray(plan.lengths).ravel())
    if plan.initial is not None:
        write_normals(mesh, plan.initial)


def write_lengths(mesh: bpy.types.Mesh, pairs: NDArray[np.integer], lengths: Array) -> None:
    """Lengths (n,) of the edges that join the vertices of pairs (n, 2); pairs may repeat, and every edge is one."""
    ends = read(mesh, ".edge_verts", len(mesh.edges), np.int32, 2)
    count = len(mesh.vertices)
    keys, wanted = (np.sort(p.astype(np.int64), axis=1) @ [count, 1] for p in (np.asarray(pairs), ends))
    order = np.argsort(keys, kind="stable")
    found = np.asarray(lengths)[order[np.searchsorted(keys[order], wanted)]]
    set_attribute(mesh, LENGTH_ATTRIBUTE, "FLOAT", "EDGE", found)


def write_normals(mesh: bpy.types.Mesh, normals: Array) -> None:
    """The normals (V, 3), in the world, to start from."""
    set_attribute(mesh, START_ATTRIBUTE, "FLOAT_VECTOR", "POINT", np.asarray(normals))


def has_start(mesh: bpy.types.Mesh) -> bool:
    """Whether a mesh has a map to start from."""
    return START_ATTRIBUTE in mesh.attributes


def has_lengths(mesh: bpy.types.Mesh) -> bool:
    """Whether a mesh has edge lengths of its own."""
    return LENGTH_ATTRIBUTE in mesh.attributes


def clear_start(mesh: bpy.types.Mesh) -> None:
    """Take away both."""
    for name in (LENGTH_ATTRIBUTE, START_ATTRIBUTE):
        remove_attribute(mesh, name)
