"""The mesh of a result on the dual or the corner mesh of the shell.

It is a new mesh with the layers of the plan: numbers on vertices and corners (UVs, colours, weights) are interpolated,
those on faces are copied from the face below. Layers of edges are dropped.
"""

from __future__ import annotations

import bpy
import numpy as np
from numpy.typing import NDArray

from ...solver.shells.polygon_sheets import PolygonSheet
from .mesh_bridge import PlanMesh, build_polygons, copy_mesh, set_attribute
from .result_bridge import NOT_REFRESHED, active_layers, corners_of, gather, mesh_layers, set_active_layers

Int = NDArray[np.int32]

_SMOOTH = {"FLOAT", "FLOAT2", "FLOAT_VECTOR", "FLOAT_COLOR", "BYTE_COLOR"}
_COLOURS = {"FLOAT_COLOR", "BYTE_COLOR"}


def polygon_mesh(
    ob: bpy.types.Object,
    depsgraph: bpy.types.Depsgraph | None,
    plan: PlanMesh,
    triangles: Int,
    owners: Int,
    sheet: PolygonSheet,
) -> bpy.types.Mesh:
    """A new mesh with the polygons of `sheet`, shaded flat, its vertices not yet placed.

    triangles (T, 3) of the plan under the sheet; owners (T,): their polygons.
    """
    mesh = copy_mesh(ob, depsgraph)
    taken = mesh_layers(mesh, lambda name: name not in NOT_REFRESHED - {"material_index"} and name[0] != ".")
    active = active_layers(mesh)
    corner_vertices = np.concatenate(sheet.polygons)
    sizes = np.array([len(polygon) for polygon in sheet.polygons])
    build_polygons(mesh, len(sheet.points), corner_vertices, np.concatenate([[0], np.cumsum(sizes)]))
    faces = sheet.owners(triangles, owners)
    corners = corners_of(plan, np.repeat(owners, 3), triangles.ravel()).reshape(-1, 3)
    for name, kind, domain, values in taken:
        if domain == "FACE":
            set_attribute(mesh, name, kind, domain, gather(values, faces))
        elif kind in _SMOOTH and domain == "POINT":
            set_attribute(mesh, name, kind, domain, _within(kind, sheet.from_vertices(values)))
        elif kind in _SMOOTH and domain == "CORNER":
            at_vertices = sheet.from_corners(np.asarray(values)[corners], triangles)
            set_attribute(mesh, name, kind, domain, _within(kind, at_vertices)[corner_vertices])
    set_active_layers(mesh, active)
    mesh.cmc.groups.clear()
    mesh.cmc.active_index = 0
    mesh.shade_flat()
    return mesh


def _within(kind: str, values: NDArray) -> NDArray:
    """A vertex may lie a little outside its triangle, but a colour must stay within 0 and 1."""
    return values.clip(0.0, 1.0) if kind in _COLOURS else values


def row_weights(sheet: PolygonSheet, weights: list[dict[int, float]], vertex_count: int) -> list[dict[int, float]]:
    """The plan's vertex weights (a dictionary for each vertex group) on the vertices of a sheet."""
    table = np.zeros((vertex_count, len(weights)))
    member = np.zeros_like(table)
    for group, given in enumerate(weights):
        table[list(given), group] = list(given.values())
        member[list(given), group] = 1.0
    interpolated, inside = sheet.from_vertices(table).clip(0.0, 1.0), sheet.from_vertices(member) > 0.5
    return [
        {int(row): float(interpolated[row, group]) for row in np.flatnonzero(inside[:, group])}
        for group in range(len(weights))
    ]
