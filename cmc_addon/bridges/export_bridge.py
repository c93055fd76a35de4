"""Joins result objects into one mesh in the world, as the solver's writers take it.

Objects that share a mesh, as instances do, are read once. Joining works on arrays alone, in any thread.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import bpy
import numpy as np
from numpy.typing import NDArray

from ...solver.io.obj import MeshData
from .mesh_bridge import NORMAL_ATTRIBUTE, read

Array = NDArray[np.float64]
Int = NDArray[np.int32]


@dataclass(frozen=True, eq=False)
class RawMesh:
    """A mesh in its own coordinates: points and normals (V, 3); corners (C,), starts (P,) of polygons, uvs (C, 2) or
    None, materials (P,) names. own: the normals are those of the surface, not means of faces."""

    points: Array
    normals: Array
    corners: Int
    starts: Int
    uvs: NDArray[np.float32] | None
    materials: list[str]
    own: bool


@dataclass(frozen=True, eq=False)
class Placed:
    """A mesh with the matrix (4, 4) of its object to the world."""

    name: str
    mesh: RawMesh
    matrix: Array

    @property
    def mirrored(self) -> bool:
        return bool(np.linalg.det(self.matrix[:3, :3]) < 0)

    def points(self) -> Array:
        return self.mesh.points @ self.matrix[:3, :3].T + self.matrix[:3, 3]

    def normals(self) -> Array:
        turned = self.mesh.normals @ np.linalg.inv(self.matrix[:3, :3])
        if self.mirrored and not self.mesh.own:
            turned = -turned  # the faces are walked the other way round
        return turned / np.maximum(np.linalg.norm(turned, axis=1, keepdims=True), 1e-30)

    def order(self) -> NDArray[np.int64]:
        """The order of the corners that walks the polygons counter-clockwise in the world."""
        count = len(self.mesh.corners)
        if not self.mirrored:
            return np.arange(count)
        ends = np.append(self.mesh.starts[1:], count)
        return np.repeat(self.mesh.starts + ends - 1, ends - self.mesh.starts) - np.arange(count)


def read_objects(objects: Sequence[bpy.types.Object], depsgraph: bpy.types.Depsgraph | None) -> list[Placed]:
    """Meshes of objects; with a depsgraph, modifiers applied."""
    known: dict[str, RawMesh] = {}
    placed = []
    for ob in objects:
        shown = depsgraph is not None and len(ob.modifiers) > 0
        key = ob.name if shown or any(slot.link == "OBJECT" for slot in ob.material_slots) else f"\0{ob.data.name}"
        if key not in known:
            known[key] = _read_object(ob, depsgraph if shown else None)
        placed.append(Placed(ob.name, known[key], np.array(ob.matrix_world, dtype=np.float64)))
    return placed


def _read_object(ob: bpy.types.Object, depsgraph: bpy.types.Depsgraph | None) -> RawMesh:
    shown = ob if depsgraph is None else ob.evaluated_get(depsgraph)
    if ob.data.is_editmode:
        ob.update_from_editmode()
    mesh = shown.to_mesh()
    try:
        return _raw(ob, mesh, own=depsgraph is None and NORMAL_ATTRIBUTE in mesh.attributes)
    finally:
        shown.to_mesh_clear()


def _raw(ob: bpy.types.Object, mesh: bpy.types.Mesh, own: bool) -> RawMesh:
    count, corner_count = len(mesh.vertices), len(mesh.loops)
    points, normals = np.empty((count, 3), dtype=np.float32), np.empty((count, 3), dtype=np.float32)
    mesh.vertices.foreach_get("co", points.reshape(-1))
    if own:
        normals = read(mesh, NORMAL_ATTRIBUTE, count, np.float32, 3)
    else:
        mesh.vertex_normals.foreach_get("vector", normals.reshape(-1))
    corners, starts = np.empty(corner_count, dtype=np.int32), np.empty(len(mesh.polygons), dtype=np.int32)
    mesh.loops.foreach_get("vertex_index", corners)
    mesh.polygons.foreach_get("loop_start", starts)
    uvs = None
    if mesh.uv_layers.active is not None:
        uvs = np.empty((corner_count, 2), dtype=np.float32)
        mesh.uv_layers.active.uv.foreach_get("vector", uvs.reshape(-1))
    return RawMesh(
        points.astype(np.float64), normals.astype(np.float64), corners, starts, uvs, _materials(ob, mesh), own
    )


def _materials(ob: bpy.types.Object, mesh: bpy.types.Mesh) -> list[str]:
    names = [slot.material.name if slot.material is not None else "" for slot in ob.material_slots]
    index = np.zeros(len(mesh.polygons), dtype=np.int32)
    mesh.polygons.foreach_get("material_index", index)
    return [names[i] if i < len(names) else "" for i in index.tolist()]


def joined(parts: Sequence[Placed]) -> tuple[MeshData, Array]:
    """All parts as one mesh in the world, and its normals (V, 3); in any thread."""
    vertices = np.cumsum([0] + [len(part.mesh.points) for part in parts])
    corners = np.cumsum([0] + [len(part.mesh.corners) for part in parts])
    orders = [part.order() for part in parts]
    rows = [part.mesh.corners[order] + first for part, order, first in zip(parts, orders, vertices, strict=False)]
    starts = np.concatenate([part.mesh.starts + first for part, first in zip(parts, corners, strict=False)])
    uvs, uv_corners = _uvs(parts, orders, starts)
    data = MeshData(
        np.concatenate([part.points() for part in parts]),
        _split(np.concatenate(rows), starts),
        uvs=uvs,
        uv_corners=uv_corners,
        objects=[part.name for part in parts for _ in range(len(part.mesh.starts))],
        groups=[""] * len(starts),
        materials=[name for part in parts for name in part.mesh.materials],
    )
    return data, np.concatenate([part.normals() for part in parts])


def _split(values: NDArray, starts: NDArray) -> list[NDArray]:
    return np.split(values, starts[1:]) if len(starts) else []


def _uvs(parts: Sequence[Placed], orders: list[NDArray], starts: NDArray) -> tuple[Array, list[NDArray]]:
    """Distinct UVs (T, 2), and the indices into them of every polygon's corners; empty where a mesh has no UVs."""
    if all(part.mesh.uvs is None for part in parts):
        return np.empty((0, 2)), []
    each = [
        np.full((len(order), 2), np.nan) if part.mesh.uvs is None else part.mesh.uvs[order]
        for part, order in zip(parts, orders, strict=True)
    ]
    uvs, rows = np.unique(np.concatenate(each), axis=0, return_inverse=True)
    none = np.isnan(uvs[:, 0])
    corners = _split(rows.reshape(-1).astype(np.int32), starts)
    if none.any():  # rows of nan come last
        corners = [c[:0] if none[c[0]] else c for c in corners]
    return uvs[~none].astype(np.float64), corners
