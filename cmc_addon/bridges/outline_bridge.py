"""Reads outlines from meshes and curves, and writes the mesh of a plan into an object.

Reading changes nothing, in any mode. All coordinates are world coordinates.
"""

from __future__ import annotations

import bpy
import numpy as np
from mathutils import Matrix, Quaternion, Vector
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from ...solver.errors import MeshError, plural
from ...solver.meshing.mesher import PlanMesh
from ...solver.meshing.wires import Outline, Wire, chain, joined_ends, nearest
from .edge_bridge import group_values, has_faces, write_group_values
from .mesh_bridge import build_polygons, read, readable_mesh, remove_attribute, set_attribute, set_positions

UV_LAYER = "Plan"

WAY_OUT = "apply it, or convert the object (Object > Convert), to take what is seen"
"""For the modifiers of an outline, see `drawn_warnings`."""

_CURVE_STEPS = 48  # pieces of a curve between two control points; the mesher resamples them


def read_wire(ob: bpy.types.Object) -> Wire:
    """The edges of an outline: the boundary of the faces, all edges of a mesh without faces, or the splines of a curve.

    Raises `MeshError` for other objects, open splines, edges with three faces and faces without a boundary.
    """
    if ob.type == "MESH":
        with readable_mesh(ob) as mesh:
            return _mesh_wire(ob, mesh)
    if ob.type == "CURVE":
        return _curve_wire(ob)
    raise MeshError(f"'{ob.name}' is neither a mesh nor a curve; draw the outline of the plan as one of these.")


def closed_lines(ob: bpy.types.Object, where: str) -> list[NDArray[np.float64]]:
    """Points (m, 3) of each closed loop of an object, in the world and in order. where: it is chosen, for messages.

    Raises `CmcError` where it has been deleted or has no edges, and as `read_wire`.
    """
    if not ob.users_scene:
        raise MeshError(f"The curve '{ob.name}' has been deleted; choose another one {where}.")
    wire = joined_ends(read_wire(ob))
    if not len(wire.edges):
        raise MeshError(f"'{ob.name}' has no edges; draw a closed loop in it.")
    return [wire.points[loop] for loop, _ in chain(wire)]


def has_plan_layer(mesh: bpy.types.Mesh) -> bool:
    """Whether a mesh has the faces and the UV layer of a meshed plan."""
    return has_faces(mesh) and UV_LAYER in mesh.uv_layers


def write_plan(ob: bpy.types.Object, meshed: PlanMesh, outline: Outline, rotation: Quaternion) -> None:
    """Replace the mesh of a plan object in object mode and place the object; materials and names stay.

    The origin goes to the middle of the plan, so that its points keep their digits wherever it lies. The faces look
    along the normal of the outline's plane. The UV layer "Plan" holds plan coordinates in world units, measured from
    the origin.
    """
    mesh = ob.data
    triangles = meshed.triangles
    build_polygons(mesh, len(meshed.positions), triangles.ravel(), np.arange(0, triangles.size + 1, 3))
    for name in (".select_vert", ".select_edge", ".select_poly"):  # a new mesh is selected as a whole
        remove_attribute(mesh, name)
    points = outline.plane.raised(meshed.positions)
    matrix = Matrix.LocRotScale(Vector((points.min(axis=0) + points.max(axis=0)) / 2), rotation, None)
    middle = np.array(matrix.translation, dtype=np.float64)
    set_positions(mesh, (points - middle) @ np.array(matrix, dtype=np.float64)[:3, :3])
    flat = meshed.positions - outline.plane.flatten(middle)
    set_attribute(mesh, UV_LAYER, "FLOAT2", "CORNER", flat[triangles.ravel()])
    mesh.uv_layers.active = mesh.uv_layers[UV_LAYER]
    ob.matrix_world = matrix


def write_boundary_groups(mesh: bpy.types.Mesh, edges: NDArray, groups: NDArray) -> None:
    """Put boundary edges, as vertex pairs (B, 2), into groups (B,)."""
    ends = read(mesh, ".edge_verts", len(mesh.edges), np.int32, 2)
    keys, wanted = _keys(ends, len(mesh.vertices)), _keys(edges, len(mesh.vertices))
    order = np.argsort(keys)
    values = np.zeros(len(mesh.edges), dtype=np.int32)
    values[order[np.searchsorted(keys, wanted, sorter=order)]] = groups
    write_group_values(mesh, values)


def groups_nearby(ob: bpy.types.Object, points: NDArray[np.float64]) -> NDArray[np.int32]:
    """For each point (n, 3) in the world, the group of the nearest boundary edge of a mesh object."""
    with readable_mesh(ob) as mesh:
        if not len(mesh.edges):
            return np.zeros(len(points), dtype=np.int32)
        wire = _mesh_wire(ob, mesh)
    index = nearest(points, wire.points[wire.edges[:, 0]], wire.points[wire.edges[:, 1]])
    return wire.groups[index]


def local_size(ob: bpy.types.Object) -> float:
    """Longest side of the object's bounding box, scale included; cheap enough for the panel."""
    return max(ob.dimensions)


# --- meshes --------------------------------------------------------------------------------

def _mesh_wire(ob: bpy.types.Object, mesh: bpy.types.Mesh) -> Wire:
    count = len(mesh.edges)
    edges = read(mesh, ".edge_verts", count, np.int32, 2)
    groups = group_values(mesh)
    if len(mesh.polygons):
        corner_edges = read(mesh, ".corner_edge", len(mesh.loops), np.int32)
        faces = np.bincount(corner_edges, minlength=count)
        bad = np.flatnonzero(faces > 2)
        if bad.size:
            raise MeshError(
                f"{plural('edge', bad).capitalize()} of '{ob.name}' {'has' if bad.size == 1 else 'have'} more than "
                "two faces; delete the extra faces.",
                edges=bad,
            )
        if not (faces == 1).any():
            raise MeshError(f"'{ob.name}' is closed and has no boundary; delete the faces beyond its rim.")
        edges, groups = edges[faces == 1], groups[faces == 1]
    local = read(mesh, "position", len(mesh.vertices), np.float32, 3)
    return Wire(f"'{ob.name}'", _in_world(ob, local), edges, groups)


def _keys(pairs: NDArray, count: int) -> NDArray[np.int64]:
    ends = np.sort(np.asarray(pairs, dtype=np.int64), axis=1)
    return ends[:, 0] * count + ends[:, 1]


def _in_world(ob: bpy.types.Object, local: NDArray) -> NDArray[np.float64]:
    matrix = np.array(ob.matrix_world, dtype=np.float64)
    return local @ matrix[:3, :3].T + matrix[:3, 3]


# --- curves --------------------------------------------------------------------------------

def _curve_wire(ob: bpy.types.Object) -> Wire:
    if ob.data.is_editmode:
        ob.update_from_editmode()
    splines = ob.data.splines
    if not len(splines):
        raise MeshError(f"The curve '{ob.name}' is empty; draw a closed spline in it.")
    local, edges = _sampled(ob.data)
    drawn = Wire(f"'{ob.name}'", _in_world(ob, local), edges, np.zeros(len(edges), np.int32), numbered=False)
    wire = joined_ends(drawn)
    still_open = _splines_of(drawn, wire.loose_ends())
    if still_open:
        raise MeshError(
            f"{plural('spline', still_open).capitalize()} of '{ob.name}' {'is' if len(still_open) == 1 else 'are'} "
            "open, and their ends do not touch; close with Toggle Cyclic (Alt C in edit mode), or snap the ends "
            "together."
        )
    return wire


def _splines_of(wire: Wire, points: NDArray[np.bool_]) -> list[int]:
    """The splines, as pieces of a sampled curve in their order, that some of its points (V,) are on."""
    count = len(wire.points)
    graph = coo_array((np.ones(len(wire.edges)), tuple(wire.edges.T)), shape=(count, count))
    _, first, piece = np.unique(connected_components(graph, directed=False)[1], return_index=True, return_inverse=True)
    return np.unique(np.argsort(np.argsort(first))[piece[points]]).tolist()


def _sampled(curve: bpy.types.Curve) -> tuple[NDArray[np.float64], NDArray[np.int32]]:
    """Fine polylines of all splines, evaluated by Blender on a copy of the curve without bevel and fill.

    The copy lies around its origin, since Blender evaluates in single precision.
    """
    bare = curve.copy()
    sampler = None
    try:
        bare.bevel_depth = bare.extrude = bare.offset = 0.0
        bare.bevel_object = bare.taper_object = None
        bare.bevel_mode = "ROUND"
        if bare.dimensions == "2D":
            bare.fill_mode = "NONE"
        bare.render_resolution_u = 0
        bare.resolution_u = _CURVE_STEPS
        for spline in bare.splines:
            spline.resolution_u = _CURVE_STEPS
        middle = _to_origin(bare)
        sampler = bpy.data.objects.new("outline", bare)
        mesh = sampler.to_mesh()
        points = read(mesh, "position", len(mesh.vertices), np.float32, 3)
        edges = read(mesh, ".edge_verts", len(mesh.edges), np.int32, 2)
        sampler.to_mesh_clear()
        return points + middle, edges
    finally:
        if sampler is not None:
            bpy.data.objects.remove(sampler)
        bpy.data.curves.remove(bare)


def _to_origin(curve: bpy.types.Curve) -> NDArray[np.float64]:
    """Move a curve by its first point, which is returned (3,)."""
    first = next((spline.bezier_points or spline.points)[0] for spline in curve.splines)
    middle = np.array(first.co[:3], dtype=np.float64)
    curve.transform(Matrix.Translation(Vector((-middle).tolist())), shape_keys=True)
    return middle
