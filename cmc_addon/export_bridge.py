"""From result objects to one mesh in the world, as the solver's writers take it."""

from __future__ import annotations

from collections.abc import Sequence

import bpy
import numpy as np
from numpy.typing import NDArray

from ..solver.files import MeshData
from .mesh_bridge import NORMAL_ATTRIBUTE, read

Array = NDArray[np.float64]


def read_part(ob: bpy.types.Object, depsgraph: bpy.types.Depsgraph | None) -> tuple[MeshData, Array]:
    """An object's mesh in the world, and its normals; with a depsgraph as its modifiers show it."""
    shown = ob if depsgraph is None else ob.evaluated_get(depsgraph)
    if ob.data.is_editmode:
        ob.update_from_editmode()
    mesh = shown.to_mesh()
    try:
        return _data(ob, mesh, own=depsgraph is None)
    finally:
        shown.to_mesh_clear()


def _data(ob: bpy.types.Object, mesh: bpy.types.Mesh, own: bool) -> tuple[MeshData, Array]:
    matrix = np.array(ob.matrix_world, dtype=np.float64)
    count, corner_count = len(mesh.vertices), len(mesh.loops)
    local = np.empty((count, 3), dtype=np.float32)
    mesh.vertices.foreach_get("co", local.reshape(-1))
    corners, starts = np.empty(corner_count, dtype=np.int32), np.empty(len(mesh.polygons), dtype=np.int32)
    mesh.loops.foreach_get("vertex_index", corners)
    mesh.polygons.foreach_get("loop_start", starts)
    uvs, rows = _uvs(mesh, corner_count)
    mirrored = np.linalg.det(matrix[:3, :3]) < 0

    def split(values: NDArray) -> list[NDArray]:
        parts = np.split(values, starts[1:]) if len(starts) else []
        return [part[::-1] for part in parts] if mirrored else parts

    data = MeshData(
        local @ matrix[:3, :3].T + matrix[:3, 3],
        split(corners),
        uvs=uvs,
        uv_corners=split(rows) if len(uvs) else [],
        objects=[ob.name] * len(starts),
        groups=[""] * len(starts),
        materials=_materials(ob, mesh),
    )
    return data, _normals(mesh, matrix, own)


def _uvs(mesh: bpy.types.Mesh, corner_count: int) -> tuple[Array, NDArray[np.int32]]:
    """UVs (T, 2), each once, and the row (C,) of each corner; both empty without a layer."""
    layer = mesh.uv_layers.active
    if layer is None:
        return np.empty((0, 2)), np.empty(0, dtype=np.int32)
    found = np.empty((corner_count, 2), dtype=np.float32)
    layer.uv.foreach_get("vector", found.reshape(-1))
    uvs, rows = np.unique(found, axis=0, return_inverse=True)
    return uvs.astype(np.float64), rows.reshape(-1).astype(np.int32)


def _materials(ob: bpy.types.Object, mesh: bpy.types.Mesh) -> list[str]:
    names = [slot.material.name if slot.material is not None else "" for slot in ob.material_slots]
    index = np.zeros(len(mesh.polygons), dtype=np.int32)
    mesh.polygons.foreach_get("material_index", index)
    return [names[i] if i < len(names) else "" for i in index.tolist()]


def _normals(mesh: bpy.types.Mesh, matrix: Array, own: bool) -> Array:
    """(V, 3) in the world: those of the surface, where the mesh is as it was made, else those of the faces around."""
    count = len(mesh.vertices)
    if own and NORMAL_ATTRIBUTE in mesh.attributes:
        local = read(mesh, NORMAL_ATTRIBUTE, count, np.float32, 3).astype(np.float64)
    else:
        local = np.empty((count, 3), dtype=np.float32)
        mesh.vertex_normals.foreach_get("vector", local.reshape(-1))
    turned = local @ np.linalg.inv(matrix[:3, :3])
    if np.linalg.det(matrix[:3, :3]) < 0 and not own:
        turned = -turned  # the faces are walked the other way round
    return turned / np.maximum(np.linalg.norm(turned, axis=1, keepdims=True), 1e-30)


def joined(parts: Sequence[MeshData]) -> MeshData:
    """Meshes as one."""
    if len(parts) == 1:
        return parts[0]
    vertices = np.cumsum([0] + [len(part.positions) for part in parts])
    rows = np.cumsum([0] + [len(part.uvs) for part in parts])
    textured = any(len(part.uvs) for part in parts)
    polygons, uv_corners = [], []
    for part, first, row in zip(parts, vertices.tolist(), rows.tolist(), strict=False):
        polygons += [polygon + first for polygon in part.polygons]
        none = [np.empty(0, dtype=np.int32)] * len(part.polygons)
        uv_corners += [corners + row for corners in part.uv_corners] or (none if textured else [])
    return MeshData(
        np.concatenate([part.positions for part in parts]),
        polygons,
        uvs=np.concatenate([part.uvs for part in parts]),
        uv_corners=uv_corners,
        objects=[name for part in parts for name in part.objects],
        groups=[name for part in parts for name in part.groups],
        materials=[name for part in parts for name in part.materials],
    )
