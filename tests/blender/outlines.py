"""Outlines of every kind to draw a plan in, and measures of the meshed plan."""

from __future__ import annotations

import bpy
import numpy as np

SQUARE = [(0.0, 0.0), (8.0, 0.0), (8.0, 6.0), (0.0, 6.0)]
HOLE = [(3.0, 2.0), (5.0, 2.0), (5.0, 4.0), (3.0, 4.0)]


def wire(*loops, z=0.0, name="Hall") -> bpy.types.Object:
    """An object of edges only."""
    points, edges = [], []
    for loop in loops:
        first, count = len(points), len(loop)
        points += [(x, y, z) for x, y in loop]
        edges += [(first + k, first + (k + 1) % count) for k in range(count)]
    return added(name, points, edges, [])


def ngon(loop, z=0.0, name="Hall") -> bpy.types.Object:
    return added(name, [(x, y, z) for x, y in loop], [], [range(len(loop))])


def added(name, points, edges, faces) -> bpy.types.Object:
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(points, edges, [list(face) for face in faces])
    repair_selection(mesh)
    return linked(bpy.data.objects.new(name, mesh))


def repair_selection(mesh) -> None:
    """Blender 5.0 crashes on setting the selection of edges it has calculated."""
    from cmc_formfinding.cmc_addon.bridges import edge_bridge

    edge_bridge.repair_selection(mesh)


def curve(*splines, kind="POLY", cyclic=True, dimensions="2D") -> bpy.types.Object:
    """A curve object with a spline through each list of points; Bezier handles are automatic."""
    data = bpy.data.curves.new("Hall", "CURVE")
    data.dimensions = dimensions
    for loop in splines:
        spline = data.splines.new(kind)
        points = spline.bezier_points if kind == "BEZIER" else spline.points
        points.add(len(loop) - 1)
        for point, (x, y) in zip(points, loop, strict=True):
            if kind == "BEZIER":
                point.co = (x, y, 0)
                point.handle_left_type = point.handle_right_type = "AUTO"
            else:
                point.co = (x, y, 0, 1)
        spline.use_cyclic_u = cyclic
        if kind == "NURBS":
            spline.order_u = 4
    return linked(bpy.data.objects.new("Hall", data))


def linked(ob) -> bpy.types.Object:
    bpy.context.collection.objects.link(ob)
    for other in bpy.context.view_layer.objects:
        other.select_set(False)
    activate(ob)
    bpy.context.view_layer.update()
    return ob


def activate(ob) -> None:
    ob.select_set(True)
    bpy.context.view_layer.objects.active = ob


def mesh_plan(**settings) -> bpy.types.Object:
    assert bpy.ops.cmc.mesh_plan(**settings) == {"FINISHED"}
    return bpy.context.object


def points(ob) -> np.ndarray:
    """Vertices in world coordinates."""
    matrix = np.array(ob.matrix_world)
    return np.array([v.co for v in ob.data.vertices]) @ matrix[:3, :3].T + matrix[:3, 3]


def corners(ob) -> np.ndarray:
    return points(ob)[[list(face.vertices) for face in ob.data.polygons]]


def normals(ob) -> np.ndarray:
    """World normals of the faces, as long as twice the area."""
    a, b, c = corners(ob).transpose(1, 0, 2)
    return np.cross(b - a, c - a)


def area(ob) -> float:
    return 0.5 * float(np.linalg.norm(normals(ob), axis=1).sum())
