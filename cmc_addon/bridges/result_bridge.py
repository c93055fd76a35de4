"""The mesh of a result: the plan's mesh with all its layers and new positions.

Along the cut of an open surface (a plan with holes whose surface does not close), vertices are doubled. The polygons
keep the data of their corners; data of vertices and edges go to both sides of the cut. A polygon that the cut crosses,
along a diagonal of its triangulation, becomes triangles.
"""

from __future__ import annotations

from dataclasses import dataclass

import bpy
import numpy as np
from numpy.typing import NDArray

from ...solver.shells.shell import sheet_polygons
from .mesh_bridge import (
    LENGTH_ATTRIBUTE,
    START_ATTRIBUTE,
    PlanMesh,
    attribute_values,
    build_polygons,
    copy_mesh,
    read,
    remove_attribute,
    same_topology,
    set_attribute,
)

Int = NDArray[np.int32]

# Layers that a result does not take from its plan: positions, shading, and the materials of faces, which on a result
# belong to the user. Blender's own layers (".corner_vert", ".select_edge", …) begin with a dot.
NOT_REFRESHED = {"position", "material_index", "sharp_face", "custom_normal"}

CUT_ATTRIBUTE = "cmc_cut"
"""On a cut result, true on the edges on both sides of the cut."""
SOURCE_ATTRIBUTE = "cmc_source"
"""On a cut result, the plan's vertex of each vertex."""


PLAN_LAYER = "cmc_plan"
"""UV layer of a result on lines whose plan was adapted to corners and holes: the coordinates of that plan, in which the
result is conformal. The drawn layers stay as they are."""


@dataclass(frozen=True, eq=False)
class Cut:
    """A cut mesh with doubled vertices, by the origins of its elements in the plan.

    vertices (n,), corners (C,) and faces (P,): the plan's vertex, corner and polygon of each; corner_vertices (C,): the
    cut vertex of each corner, among the n; starts (P + 1,).
    """

    vertices: Int
    corners: NDArray[np.integer]
    faces: Int
    corner_vertices: Int
    starts: Int


def find_cut(plan: PlanMesh, triangles: Int, owners: Int, cut_triangles: Int, source: Int) -> Cut | None:
    """The cut of a surface with triangles `cut_triangles` (T, 3) over the plan's `triangles` (T, 3), or None.

    owners (T,): the polygon of each triangle; source (n,): the plan's vertex of each cut vertex.
    """
    if np.array_equal(triangles, cut_triangles):
        return None
    pieces, faces = sheet_polygons(plan.polygons(), owners, triangles, cut_triangles)
    if plan.mirrored:  # polygons are walked as seen in the world; the mesh stores them reversed
        pieces = [piece[::-1] for piece in pieces]
    sizes = np.array([len(piece) for piece in pieces])
    corner_vertices = np.concatenate(pieces)
    return Cut(
        vertices=np.asarray(source, dtype=np.int32),
        corners=corners_of(plan, np.repeat(faces, sizes), source[corner_vertices]),
        faces=faces,
        corner_vertices=corner_vertices,
        starts=np.concatenate([[0], np.cumsum(sizes)]).astype(np.int32),
    )


def corners_of(plan: PlanMesh, polygons: NDArray[np.integer], vertices: NDArray[np.integer]) -> NDArray[np.int64]:
    """The corner of each polygon at the given vertex."""
    count = len(plan.positions)
    owner = np.repeat(np.arange(len(plan.starts) - 1), np.diff(plan.starts)).astype(np.int64)
    keys = owner * count + plan.corners
    order = np.argsort(keys)
    return order[np.searchsorted(keys[order], polygons.astype(np.int64) * count + vertices)]


def fresh_mesh(
    ob: bpy.types.Object, depsgraph: bpy.types.Depsgraph | None, plan: PlanMesh, cut: Cut | None
) -> bpy.types.Mesh:
    """A new mesh for a result, with the layers of the plan; smooth, without boundary groups and start map."""
    mesh = copy_mesh(ob, depsgraph)
    if cut is not None:
        _cut_open(mesh, plan, cut)
    if plan.mirrored:
        mesh.flip_normals()
    mesh.cmc.groups.clear()
    mesh.cmc.active_index = 0
    for name in ("custom_normal", LENGTH_ATTRIBUTE, START_ATTRIBUTE):
        remove_attribute(mesh, name)
    mesh.shade_smooth()
    return mesh


def put_plan_layer(mesh: bpy.types.Mesh, positions: NDArray[np.float64]) -> None:
    """Write the coordinates (V, 2) of an adapted plan into a UV layer of its own; the active layer stays."""
    active = active_layers(mesh)
    corners = read(mesh, ".corner_vert", len(mesh.loops), np.int32)
    set_attribute(mesh, PLAN_LAYER, "FLOAT2", "CORNER", positions[corners])
    set_active_layers(mesh, active)


def _cut_open(mesh: bpy.types.Mesh, plan: PlanMesh, cut: Cut) -> None:
    """Rebuild the mesh with doubled vertices, and copy every layer from its origin."""
    layers = mesh_layers(mesh, lambda name: name != "position" and not name.startswith("."))
    active = active_layers(mesh)
    old_edges, count = read(mesh, ".edge_verts", len(mesh.edges), np.int32, 2), len(mesh.vertices)
    build_polygons(mesh, len(cut.vertices), cut.corner_vertices, cut.starts)
    new_edges = cut.vertices[read(mesh, ".edge_verts", len(mesh.edges), np.int32, 2)]
    origin = {
        "POINT": cut.vertices,
        "EDGE": _find_pairs(new_edges, old_edges, count),
        "FACE": cut.faces,
        "CORNER": cut.corners,
    }
    for name, kind, domain, values in layers:
        set_attribute(mesh, name, kind, domain, gather(values, origin[domain]))
    set_active_layers(mesh, active)
    inner = _find_pairs(new_edges, old_edges[plan.boundary], count) < 0
    once = np.bincount(read(mesh, ".corner_edge", len(mesh.loops), np.int32), minlength=len(mesh.edges)) == 1
    set_attribute(mesh, CUT_ATTRIBUTE, "BOOLEAN", "EDGE", once & inner)
    set_attribute(mesh, SOURCE_ATTRIBUTE, "INT", "POINT", cut.vertices)


def _find_pairs(pairs: Int, among: Int, count: int) -> NDArray[np.int64]:
    """Index of each vertex pair `among` others, or -1."""
    if not len(among):
        return np.full(len(pairs), -1)
    wanted, keys = (np.sort(p, axis=1).astype(np.int64) @ [count, 1] for p in (pairs, among))
    order = np.argsort(keys)
    slot = order[np.searchsorted(keys[order], wanted).clip(max=len(keys) - 1)]
    return np.where(keys[slot] == wanted, slot, -1)


def gather(values: NDArray | list[bytes], origin: NDArray) -> NDArray | list[bytes]:
    """values[origin], and zero where the origin is -1."""
    if isinstance(values, list):
        return [values[i] if i >= 0 else b"" for i in origin]
    gathered = values[origin]
    gathered[origin < 0] = 0
    return gathered


def mesh_layers(mesh: bpy.types.Mesh, wanted) -> list[tuple[str, str, str, NDArray | list[bytes]]]:
    """Name, type, domain and values of the attributes with a wanted name."""
    return [
        (attribute.name, attribute.data_type, attribute.domain, attribute_values(attribute))
        for attribute in mesh.attributes
        if wanted(attribute.name)
    ]


def active_layers(mesh: bpy.types.Mesh) -> dict[str, str | None]:
    uv, colors = mesh.uv_layers, mesh.color_attributes
    rendered = colors.render_color_index
    return {
        "uv": uv.active.name if uv.active else None,
        "render_uv": next((layer.name for layer in uv if layer.active_render), None),
        "color": colors.active_color_name or None,
        "render_color": colors[rendered].name if rendered >= 0 else None,
    }


def set_active_layers(mesh: bpy.types.Mesh, active: dict[str, str | None]) -> None:
    if active["uv"]:
        mesh.uv_layers.active = mesh.uv_layers[active["uv"]]
    if active["render_uv"]:
        mesh.uv_layers[active["render_uv"]].active_render = True
    if active["color"]:
        mesh.color_attributes.active_color_name = active["color"]
    if active["render_color"]:
        mesh.color_attributes.render_color_index = mesh.color_attributes.find(active["render_color"])


# --- into an existing result ---------------------------------------------------------------

def put_mesh(ob: bpy.types.Object, fresh: bpy.types.Mesh) -> None:
    """Update the mesh of a result from a fresh one, which is consumed.

    With the same polygons and edges, the layers of the plan are refreshed and all else stays. Otherwise the mesh is
    replaced, also under linked duplicates of the result; its name and its material slots stay.
    """
    old = ob.data
    if same_topology(old, fresh):
        refreshed = mesh_layers(fresh, lambda name: name not in NOT_REFRESHED and not name.startswith("."))
        for name, kind, domain, values in refreshed:
            set_attribute(old, name, kind, domain, values)
        bpy.data.meshes.remove(fresh)
        return
    _keep_materials(fresh, old)
    name = old.name
    old.user_remap(fresh)
    bpy.data.meshes.remove(old)
    fresh.name = name


def _keep_materials(fresh: bpy.types.Mesh, old: bpy.types.Mesh) -> None:
    """Give the fresh mesh the old slots, and the plan's slots beyond their number, which faces may use."""
    added = list(fresh.materials)[len(old.materials):]
    indices = read(fresh, "material_index", len(fresh.polygons), np.int32)
    fresh.materials.clear()
    for material in [*old.materials, *added]:
        fresh.materials.append(material)
    if indices.any():
        set_attribute(fresh, "material_index", "INT", "FACE", indices)


# --- vertex groups -------------------------------------------------------------------------

def vertex_weights(mesh: bpy.types.Mesh, group_count: int) -> list[dict[int, float]]:
    """For each vertex group, a dictionary from vertex to weight."""
    weights: list[dict[int, float]] = [{} for _ in range(group_count)]
    if group_count:
        for vertex in mesh.vertices:
            for element in vertex.groups:
                weights[element.group][vertex.index] = element.weight
    return weights


def put_weights(ob: bpy.types.Object, names: list[str], weights: list[dict[int, float]]) -> None:
    """Give an object vertex groups with these names and weights; other groups stay, unchanged ones are skipped."""
    if not names:
        return
    present = vertex_weights(ob.data, len(ob.vertex_groups))
    for name, wanted in zip(names, weights, strict=True):
        group = ob.vertex_groups.get(name) or ob.vertex_groups.new(name=name)
        has = present[group.index] if group.index < len(present) else {}
        if has == wanted:
            continue
        group.remove([vertex for vertex in has if vertex not in wanted])
        alike: dict[float, list[int]] = {}
        for vertex, weight in wanted.items():
            alike.setdefault(weight, []).append(vertex)
        for weight, vertices in alike.items():
            group.add(vertices, weight, "REPLACE")
