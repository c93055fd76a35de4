"""Writes own edge lengths, a start map and seams to the mesh of a plan; `mesh_bridge` reads the first two."""

from __future__ import annotations

import bpy
import numpy as np
from numpy.typing import NDArray

from ...solver.shells.plan import Plan
from .mesh_bridge import LENGTH_ATTRIBUTE, START_ATTRIBUTE, read, remove_attribute, set_attribute

Array = NDArray[np.floating]


def write_start(mesh: bpy.types.Mesh, plan: Plan) -> None:
    """Write the lengths and the start map of a plan to a mesh of its triangles that is not in edit mode."""
    if plan.lengths is not None:
        triangles = np.asarray(plan.triangles, dtype=np.int64)
        sides = np.stack([np.roll(triangles, -1, axis=1), np.roll(triangles, 1, axis=1)], axis=2).reshape(-1, 2)
        write_lengths(mesh, sides, np.asarray(plan.lengths).ravel())
    if plan.initial is not None:
        write_normals(mesh, plan.initial)


def write_lengths(mesh: bpy.types.Mesh, pairs: NDArray[np.integer], lengths: Array) -> None:
    """Write lengths (n,) of edges, given as vertex pairs (n, 2) that include every edge; pairs may repeat."""
    ends = read(mesh, ".edge_verts", len(mesh.edges), np.int32, 2)
    count = len(mesh.vertices)
    keys, wanted = (np.sort(p.astype(np.int64), axis=1) @ [count, 1] for p in (np.asarray(pairs), ends))
    order = np.argsort(keys, kind="stable")
    values = np.asarray(lengths)[order[np.searchsorted(keys[order], wanted)]]
    set_attribute(mesh, LENGTH_ATTRIBUTE, "FLOAT", "EDGE", values)


def write_normals(mesh: bpy.types.Mesh, normals: Array) -> None:
    """Write the start map: normals (V, 3) in the world."""
    set_attribute(mesh, START_ATTRIBUTE, "FLOAT_VECTOR", "POINT", np.asarray(normals))


def has_start(mesh: bpy.types.Mesh) -> bool:
    """Whether a mesh has a start map."""
    return START_ATTRIBUTE in mesh.attributes


def has_lengths(mesh: bpy.types.Mesh) -> bool:
    """Whether a mesh has edge lengths of its own."""
    return LENGTH_ATTRIBUTE in mesh.attributes


def clear_start(mesh: bpy.types.Mesh) -> None:
    """Remove both."""
    for name in (LENGTH_ATTRIBUTE, START_ATTRIBUTE):
        remove_attribute(mesh, name)


def mark_seams(mesh: bpy.types.Mesh, pairs: NDArray[np.integer]) -> None:
    """Mark edges, given as vertex pairs (n, 2), as seams."""
    if not len(pairs):
        return
    wanted = set(map(tuple, np.sort(pairs, axis=1).tolist()))
    ends = np.sort(read(mesh, ".edge_verts", len(mesh.edges), np.int32, 2), axis=1)
    for edge, pair in zip(mesh.edges, map(tuple, ends.tolist()), strict=True):
        edge.use_seam = pair in wanted
