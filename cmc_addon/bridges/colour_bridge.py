"""Measures of results and their colours, as attributes of meshes.

The colours are the vertex attribute `CMC`, made active so that Solid shading shows it by *Attribute*; the mesh
remembers which one was active before. Missing curvatures, on a result of an older version or while a shell is dragged,
are measured from the mesh.
"""

from __future__ import annotations

from collections.abc import Mapping

import bpy
import numpy as np
from numpy.typing import NDArray

from ...solver.measure import vertex_gauss_curvature, vertex_mean_curvature, vertex_principal_curvatures
from ..properties.attributes import ATTRIBUTES
from .mesh_bridge import NORMAL_ATTRIBUTE, read, remove_attribute, set_attribute

Array = NDArray[np.float64]

COLOUR_ATTRIBUTE = "CMC"
_BEFORE = "cmc_colour_before"
_DIRECTION = ATTRIBUTES["direction"]


def put_measures(mesh: bpy.types.Mesh, measures: Mapping[str, NDArray]) -> None:
    """Write measures, attribute -> values (n,) or (n, 3), and remove all others, which belong to a former shell."""
    for name in ATTRIBUTES.values():
        if name not in measures:
            remove_attribute(mesh, name)
    for name, values in measures.items():
        set_attribute(mesh, name, "FLOAT_VECTOR" if values.ndim == 2 else "FLOAT", "POINT", values)


def has_measure(mesh: bpy.types.Mesh, name: str) -> bool:
    attribute = mesh.attributes.get(name)
    return attribute is not None and attribute.domain == "POINT" and len(attribute.data) == len(mesh.vertices)


def measure(mesh: bpy.types.Mesh, name: str, target: float = 1.0) -> Array | None:
    """A measure (n,) or (n, 3) by the name of its attribute, stored or measured now; None if neither is possible.

    target: see `surface_of`. Deviation is nan where it has no reference.
    """
    if has_measure(mesh, name):
        values = read(mesh, name, len(mesh.vertices), np.float32, 3 if name == _DIRECTION else 1).astype(np.float64)
        return np.where(values < 0.0, np.nan, values) if name == ATTRIBUTES["deviation"] else values
    ways = {
        ATTRIBUTES["mean_curvature"]: vertex_mean_curvature,
        ATTRIBUTES["gauss_curvature"]: vertex_gauss_curvature,
        _DIRECTION: lambda *surface: vertex_principal_curvatures(*surface).direction1,
    }
    if name not in ways or not has_measure(mesh, NORMAL_ATTRIBUTE) or not len(mesh.polygons):
        return None
    return ways[name](*surface_of(mesh, target))


def put_measure(mesh: bpy.types.Mesh, name: str, target: float = 1.0) -> None:
    """Measure and store a measure that is missing; target: see `surface_of`."""
    if not has_measure(mesh, name):
        values = measure(mesh, name, target)
        if values is not None:
            set_attribute(mesh, name, "FLOAT_VECTOR" if values.ndim == 2 else "FLOAT", "POINT", values)


def surface_of(mesh: bpy.types.Mesh, target: float = 1.0) -> tuple[Array, NDArray[np.int32], Array]:
    """Points (n, 3), triangles (F, 3) and normals (n, 3) of a result, the normals oriented so that H has the sign of
    its `target`; as they are where that is 0."""
    count = len(mesh.vertices)
    points = read(mesh, "position", count, np.float32, 3).astype(np.float64)
    normals = read(mesh, NORMAL_ATTRIBUTE, count, np.float32, 3).astype(np.float64)
    mesh.calc_loop_triangles()
    triangles = np.empty(3 * len(mesh.loop_triangles), dtype=np.int32)
    mesh.loop_triangles.foreach_get("vertices", triangles)
    triangles = triangles.reshape(-1, 3)
    H = vertex_mean_curvature(points, triangles, normals)
    return points, triangles, -normals if target * np.nanmedian(H) < 0.0 else normals


def points_of(mesh: bpy.types.Mesh) -> NDArray[np.float32]:
    """Points (n, 3) of a result."""
    return read(mesh, "position", len(mesh.vertices), np.float32, 3)


def points_and_directions(mesh: bpy.types.Mesh) -> tuple[Array, Array, Array] | None:
    """Points, normals and directions of the larger curvature (n, 3) of a result; None if it has no normals."""
    if mesh.is_editmode or not has_measure(mesh, NORMAL_ATTRIBUTE):
        return None
    directions = measure(mesh, _DIRECTION)
    if directions is None:
        return None
    points, normals = (read(mesh, name, len(mesh.vertices), np.float32, 3) for name in ("position", NORMAL_ATTRIBUTE))
    return points.astype(np.float64), normals.astype(np.float64), directions


def paint(mesh: bpy.types.Mesh, colours: NDArray[np.float32]) -> None:
    """Give the vertices linear colours (n, 4) and make these the active colours."""
    set_attribute(mesh, COLOUR_ATTRIBUTE, "FLOAT_COLOR", "POINT", colours)
    active = mesh.color_attributes.active_color_name
    if active != COLOUR_ATTRIBUTE or _BEFORE not in mesh:
        mesh[_BEFORE] = active if active and active != COLOUR_ATTRIBUTE else ""
        mesh.color_attributes.active_color_name = COLOUR_ATTRIBUTE
    mesh.update_tag()


def unpaint(mesh: bpy.types.Mesh) -> None:
    """Remove the colours and restore the former active colours."""
    if COLOUR_ATTRIBUTE not in mesh.attributes:
        return
    before, was_active = mesh.get(_BEFORE, ""), mesh.color_attributes.active_color_name == COLOUR_ATTRIBUTE
    remove_attribute(mesh, COLOUR_ATTRIBUTE)
    if was_active and before in mesh.color_attributes:
        mesh.color_attributes.active_color_name = before
    if _BEFORE in mesh:
        del mesh[_BEFORE]
    mesh.update_tag()


def is_painted(mesh: bpy.types.Mesh) -> bool:
    return COLOUR_ATTRIBUTE in mesh.attributes
