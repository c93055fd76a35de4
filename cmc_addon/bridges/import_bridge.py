"""Imports a plan from a mesh file or a job as an object, with its UVs, materials and boundary groups."""

from __future__ import annotations

from collections.abc import Sequence

import bpy
import numpy as np

from ...solver.io.obj import MeshData
from ...solver.shells.plan import Group
from ..properties import group_list
from .mesh_bridge import build_polygons, near_origin, set_attribute, set_positions
from .outline_bridge import write_boundary_groups

UV_LAYER = "UVMap"


def import_plan(context: bpy.types.Context, name: str, drawn: MeshData, groups: Sequence[Group]) -> bpy.types.Object:
    """A new object with this mesh and these boundary groups, linked to the scene and active.

    The mesh must have passed `triangulate_polygons`, and the edges of the groups must be edges of it.
    """
    mesh = bpy.data.meshes.new(name)
    origin = near_origin(np.zeros(3), drawn.positions)
    _write_polygons(mesh, drawn, origin)
    if drawn.uv_corners and all(len(rows) for rows in drawn.uv_corners):
        set_attribute(mesh, UV_LAYER, "FLOAT2", "CORNER", drawn.uvs[np.concatenate(drawn.uv_corners)])
    _write_materials(mesh, drawn.materials)
    _write_groups(context, mesh, groups)
    ob = bpy.data.objects.new(name, mesh)
    ob.location = origin
    context.scene.collection.objects.link(ob)
    context.view_layer.objects.active = ob
    context.view_layer.update()  # its matrix, which the next reader needs
    return ob


def _write_polygons(mesh: bpy.types.Mesh, drawn: MeshData, origin: np.ndarray) -> None:
    starts = np.cumsum([0] + [len(polygon) for polygon in drawn.polygons])
    build_polygons(mesh, len(drawn.positions), np.concatenate(drawn.polygons), starts)
    set_positions(mesh, drawn.positions - origin)


def _write_materials(mesh: bpy.types.Mesh, names: Sequence[str]) -> None:
    slots = {name: index for index, name in enumerate(dict.fromkeys(name for name in names if name))}
    for name in slots:
        mesh.materials.append(bpy.data.materials.get(name) or bpy.data.materials.new(name))
    if slots:
        indices = np.array([slots.get(name, 0) for name in names], dtype=np.int32)
        mesh.polygons.foreach_set("material_index", indices)


def _write_groups(context: bpy.types.Context, mesh: bpy.types.Mesh, groups: Sequence[Group]) -> None:
    uids = []
    for group in groups:
        made = group_list.add(mesh, group.name)
        made.kind = group.kind.upper()
        for name, value in group.parameters.items():
            setattr(made, name, value if name != "curve" else _line(context, group.name, np.asarray(value)))
        uids.append(np.full(len(group.edges), made.uid, dtype=np.int32))
    if uids:
        edges = np.concatenate([np.asarray(group.edges).reshape(-1, 2) for group in groups])
        write_boundary_groups(mesh, edges, np.concatenate(uids))


def _line(context: bpy.types.Context, name: str, points: np.ndarray) -> bpy.types.Object:
    """A closed line of points (m, 2|3) as an object in the scene."""
    if points.shape[1] == 2:
        points = np.column_stack([points, np.zeros(len(points))])
    mesh = bpy.data.meshes.new(f"{name} line")
    count, origin = len(points), near_origin(np.zeros(3), points)
    pairs = np.column_stack([np.arange(count), (np.arange(count) + 1) % count])
    mesh.vertices.add(count)
    mesh.edges.add(count)
    mesh.edges.foreach_set("vertices", pairs.astype(np.int32).ravel())
    set_positions(mesh, points - origin)
    ob = bpy.data.objects.new(mesh.name, mesh)
    ob.location = origin
    context.scene.collection.objects.link(ob)
    return ob
