"""Blender meshes to arrays and back.

Positions and topology are read and written through the attributes that store them ("position", ".edge_verts",
".corner_vert", …), at a hundredth of the cost of `vertices` and `loops`. In edit mode these attributes are empty: the
edit mesh is flushed and a copy is read, so that mode and selection stay.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cached_property

import bmesh
import bpy
import numpy as np
from numpy.typing import NDArray

from ...solver.errors import MeshError, plural
from ...solver.shells.plan import Plan
from ...solver.shells.plan_metric import side_lengths
from .edge_bridge import group_values, is_boundary, mend_selection

Int = NDArray[np.int32]

NORMAL_ATTRIBUTE = "cmc_normal"
CORNER_ATTRIBUTE = "cmc_flipped_corner"
"""Integers on the vertices of a plan; other than 0 they flip the normal at a corner between two mirrors."""
LENGTH_ATTRIBUTE = "cmc_length"
"""Numbers on the edges of a plan: its own lengths in place of the drawn ones."""
START_ATTRIBUTE = "cmc_start"
"""Vectors on the vertices of a plan: its start map, normals in the world."""


@dataclass(frozen=True, eq=False)
class PlanMesh:
    """A mesh as the solver sees it, in Blender's numbering.

    positions (V, 3) in world coordinates; corners (C,): vertex of each polygon corner; corner_edges (C,): edge from it
    to the next; starts (P + 1,): first corner of each polygon; edges (E, 2); groups (E,): uid of the boundary group, 0
    for none; selected (E,). mirrored: the scale of the object turns the mesh inside out, so polygons are walked
    backwards. flipped_corners: see `CORNER_ATTRIBUTE`. lengths (E,) and initial (V, 3): see `LENGTH_ATTRIBUTE` and
    `START_ATTRIBUTE`, None without the attribute.
    """

    positions: NDArray[np.float64]
    corners: Int
    starts: Int
    edges: Int
    corner_edges: Int
    groups: Int
    selected: NDArray[np.bool_]
    mirrored: bool
    flipped_corners: tuple[int, ...] = ()
    lengths: NDArray[np.float32] | None = None
    initial: NDArray[np.float32] | None = None

    @cached_property
    def boundary(self) -> NDArray[np.bool_]:
        """(E,) edges with exactly one face."""
        return np.bincount(self.corner_edges, minlength=len(self.edges)) == 1

    def polygons(self) -> list[Int]:
        """Vertices of each polygon, counter-clockwise in world space."""
        polygons = np.split(self.corners, self.starts[1:-1]) if len(self.starts) > 1 else []
        return [polygon[::-1] for polygon in polygons] if self.mirrored else polygons

    def as_plan(self, triangles: Int) -> Plan:
        """The plan without its groups, on triangles (T, 3). Raises `MeshError` on lengths that do not fit them."""
        initial = None if self.initial is None else self.initial.astype(np.float64)
        plan = Plan(self.positions, triangles, initial=initial)
        if self.lengths is not None:
            plan.lengths = side_lengths(triangles, self.edges, self.lengths)
        return plan


def read_plan(ob: bpy.types.Object, depsgraph: bpy.types.Depsgraph | None = None) -> PlanMesh:
    """The mesh of an object, in any mode; with a depsgraph, modifiers applied.

    Raises `MeshError` for an object without a mesh or without faces, and for coordinates that are not finite.
    """
    if ob.type != "MESH":
        raise MeshError(f"'{ob.name}' is not a mesh; select a plan, or make one with Mesh Plan.")
    with readable_mesh(ob, depsgraph) as mesh:
        plan = plan_arrays(mesh, np.array(ob.matrix_world, dtype=np.float64))
    _check(ob, plan, depsgraph)
    return plan


@contextmanager
def readable_mesh(
    ob: bpy.types.Object, depsgraph: bpy.types.Depsgraph | None = None
) -> Iterator[bpy.types.Mesh]:
    """A mesh with attribute data: the object's own or, if that has none, a copy that is removed at the end."""
    if depsgraph is None and not ob.data.is_editmode:
        yield ob.data
        return
    copy = copy_mesh(ob, depsgraph)
    try:
        yield copy
    finally:
        bpy.data.meshes.remove(copy)


def points_and_rim(mesh: bpy.types.Mesh) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """The vertices (V, 3) and those on the boundary (b, 3) in the object; without a copy in edit mode, for panels."""
    if mesh.is_editmode:
        vertices = bmesh.from_edit_mesh(mesh).verts
        points = np.array([vertex.co for vertex in vertices], dtype=np.float64).reshape(-1, 3)
        return points, points[[vertex.is_boundary for vertex in vertices]]
    points = read(mesh, "position", len(mesh.vertices), np.float32, 3).astype(np.float64)
    ends = read(mesh, ".edge_verts", len(mesh.edges), np.int32, 2)
    return points, points[np.unique(ends[is_boundary(mesh)])]


def near_origin(base: NDArray, points: NDArray) -> NDArray[np.float64]:
    """An origin (3,) for a mesh of points (n, 3) in the world, so near that single precision is enough.

    It is `base` itself if the points are near that, else it is shifted by whole steps of 32 to 64 of their extents, so
    that small changes of the points leave it where it is. Single precision holds it exactly.
    """
    low, high = points.min(axis=0), points.max(axis=0)
    step = 2.0 ** np.ceil(np.log2(32.0 * (float((high - low).max()) or 1.0)))
    shift = step * np.round(((low + high) / 2 - base) / step)
    return np.asarray(base + shift, dtype=np.float32).astype(np.float64)


def copy_mesh(ob: bpy.types.Object, depsgraph: bpy.types.Depsgraph | None = None) -> bpy.types.Mesh:
    """A new mesh data-block with all layers: of the object's mesh or, with a depsgraph, modifiers applied."""
    if ob.data.is_editmode:
        ob.update_from_editmode()
    if depsgraph is None:
        return ob.data.copy()
    evaluated = ob.evaluated_get(depsgraph)
    return bpy.data.meshes.new_from_object(evaluated, preserve_all_data_layers=True, depsgraph=depsgraph)


def plan_arrays(mesh: bpy.types.Mesh, matrix: NDArray[np.float64]) -> PlanMesh:
    """The arrays of a mesh that is not in edit mode, placed by `matrix` (4, 4)."""
    local = read(mesh, "position", len(mesh.vertices), np.float32, 3)
    starts = np.empty(len(mesh.polygons) + 1, dtype=np.int32)
    starts[-1] = len(mesh.loops)
    mesh.polygons.foreach_get("loop_start", starts[:-1])
    edge_count = len(mesh.edges)
    return PlanMesh(
        positions=local @ matrix[:3, :3].T + matrix[:3, 3],
        corners=read(mesh, ".corner_vert", len(mesh.loops), np.int32),
        starts=starts,
        edges=read(mesh, ".edge_verts", edge_count, np.int32, 2),
        corner_edges=read(mesh, ".corner_edge", len(mesh.loops), np.int32),
        groups=group_values(mesh),
        selected=_selected(mesh),
        mirrored=bool(np.linalg.det(matrix[:3, :3]) < 0),
        flipped_corners=_flipped_corners(mesh),
        lengths=_own(mesh, LENGTH_ATTRIBUTE, "EDGE", "FLOAT"),
        initial=_own(mesh, START_ATTRIBUTE, "POINT", "FLOAT_VECTOR"),
    )


def _own(mesh: bpy.types.Mesh, name: str, domain: str, kind: str) -> NDArray[np.float32] | None:
    """An optional attribute of a plan. Raises `MeshError` if its type or domain is wrong."""
    attribute = mesh.attributes.get(name)
    if attribute is None:
        return None
    if (attribute.domain, attribute.data_type) != (domain, kind):
        what = {"EDGE": "a Float on its edges", "POINT": "a Vector on its vertices"}[domain]
        raise MeshError(f"The attribute '{name}' of a plan must be {what}; convert it (Attributes), or remove it.")
    values = np.asarray(attribute_values(attribute))
    return values[:, 0] if kind == "FLOAT" else values


def _flipped_corners(mesh: bpy.types.Mesh) -> tuple[int, ...]:
    attribute = mesh.attributes.get(CORNER_ATTRIBUTE)
    if attribute is None or (attribute.domain, attribute.data_type) != ("POINT", "INT"):
        return ()
    return tuple(np.flatnonzero(read(mesh, CORNER_ATTRIBUTE, len(mesh.vertices), np.int32)).tolist())


def _selected(mesh: bpy.types.Mesh) -> NDArray[np.bool_]:
    """Selected edges; the slow way if ".select_edge" has the wrong type, as Blender 5.0 makes it."""
    attribute = mesh.attributes.get(".select_edge")
    if attribute is None or attribute.data_type == "BOOLEAN":
        return read(mesh, ".select_edge", len(mesh.edges), np.bool_)
    selected = np.empty(len(mesh.edges), dtype=np.bool_)
    mesh.edges.foreach_get("select", selected)
    return selected


def _check(ob: bpy.types.Object, plan: PlanMesh, depsgraph: bpy.types.Depsgraph | None) -> None:
    name = ob.name
    if len(plan.starts) == 1:
        seen = " tick Apply Modifiers if these make them," if depsgraph is None and ob.modifiers else ""
        raise MeshError(f"'{name}' has no faces;{seen} fill its outline (F), or use Mesh Plan.")
    bad = np.flatnonzero(~np.isfinite(plan.positions).all(axis=1))
    if bad.size:
        raise MeshError(
            f"Coordinates of {plural('vertex', bad)} of '{name}' are not finite numbers; move or delete "
            + ("it." if bad.size == 1 else "them."),
            vertices=bad,
        )


# --- one attribute -------------------------------------------------------------------------

_FIELDS = {
    "FLOAT": ("value", np.float32, 1),
    "INT": ("value", np.int32, 1),
    "INT8": ("value", np.int8, 1),
    "BOOLEAN": ("value", np.bool_, 1),
    "FLOAT_VECTOR": ("vector", np.float32, 3),
    "FLOAT2": ("vector", np.float32, 2),
    "FLOAT_COLOR": ("color", np.float32, 4),
    "BYTE_COLOR": ("color_srgb", np.float32, 4),
    "QUATERNION": ("value", np.float32, 4),
    "FLOAT4X4": ("value", np.float32, 16),
    "INT16_2D": ("value", np.int16, 2),
    "INT32_2D": ("value", np.int32, 2),
}
"""Type of an attribute -> field of its values, their type, and their number."""


def read(mesh: bpy.types.Mesh, name: str, count: int, dtype: type, width: int = 1) -> NDArray:
    """Values (count,) or (count, width) of an attribute; zeros if the mesh does not have it."""
    shape = (count,) if width == 1 else (count, width)
    attribute = mesh.attributes.get(name)
    if attribute is None:
        return np.zeros(shape, dtype=dtype)
    values = np.empty(shape, dtype=dtype)
    attribute.data.foreach_get(_FIELDS[attribute.data_type][0], values.reshape(-1))
    return values


def attribute_values(attribute: bpy.types.Attribute) -> NDArray | list[bytes]:
    """Values of any attribute; (n, width), or a list for strings."""
    if attribute.data_type == "STRING":
        return [item.value for item in attribute.data]
    field, dtype, width = _FIELDS[attribute.data_type]
    values = np.empty((len(attribute.data), width), dtype=dtype)
    attribute.data.foreach_get(field, values.reshape(-1))
    return values


def set_attribute(
    mesh: bpy.types.Mesh, name: str, kind: str, domain: str, values: NDArray | list[bytes]
) -> None:
    """Write an attribute of a mesh that is not in edit mode; an attribute of another type or domain is replaced."""
    attribute = mesh.attributes.get(name)
    if attribute is not None and (attribute.data_type, attribute.domain) != (kind, domain):
        mesh.attributes.remove(attribute)
        attribute = None
    if attribute is None:
        attribute = mesh.attributes.new(name, kind, domain)
    if kind == "STRING":
        for item, value in zip(attribute.data, values, strict=True):
            item.value = value
        return
    field, dtype, _ = _FIELDS[kind]
    attribute.data.foreach_set(field, np.ascontiguousarray(values, dtype=dtype).reshape(-1))
    if name == "position" and len(mesh.vertices):
        # Blender keeps its cached bounds when the attribute is written; writing one vertex as such drops them.
        mesh.vertices[0].co = values[0]


def set_positions(mesh: bpy.types.Mesh, positions: NDArray) -> None:
    """Write vertex positions (V, 3), and have Blender update normals and bounds."""
    set_attribute(mesh, "position", "FLOAT_VECTOR", "POINT", positions)
    mesh.update()


def build_polygons(
    mesh: bpy.types.Mesh, vertex_count: int, corners: NDArray[np.integer], starts: NDArray[np.integer]
) -> None:
    """Replace the geometry of a mesh by polygons: vertices of corners (C,), starts (P + 1,). Materials stay."""
    mesh.clear_geometry()
    mesh.vertices.add(vertex_count)
    mesh.loops.add(len(corners))
    mesh.polygons.add(len(starts) - 1)
    mesh.polygons.foreach_set("loop_start", np.asarray(starts[:-1], dtype=np.int32))
    mesh.loops.foreach_set("vertex_index", np.asarray(corners, dtype=np.int32))
    mesh.update(calc_edges=True)
    mend_selection(mesh)


def remove_attribute(mesh: bpy.types.Mesh, name: str) -> None:
    attribute = mesh.attributes.get(name)
    if attribute is not None:
        mesh.attributes.remove(attribute)


def same_topology(a: bpy.types.Mesh, b: bpy.types.Mesh) -> bool:
    """Whether two meshes (neither in edit mode) have the same polygons and edges, in the same order."""
    if any(len(getattr(a, k)) != len(getattr(b, k)) for k in ("vertices", "edges", "loops", "polygons")):
        return False
    one, other = (plan_arrays(mesh, np.eye(4)) for mesh in (a, b))
    return all(
        np.array_equal(getattr(one, name), getattr(other, name)) for name in ("starts", "corners", "edges")
    )
