"""Splines and edges whose ends touch are one outline: lines of a DXF, a ring that repeats its first point."""

from __future__ import annotations

from itertools import pairwise

import bpy
import numpy as np
import pytest

from .scenes import add_group, boundary_edges, link, mesh_object

FINISHED = {"FINISHED"}
HALL = [(0, 0, 0), (18, 0, 0), (18, 12, 0), (0, 12, 0)]
SIDES = [[HALL[k], HALL[(k + 1) % 4]] for k in range(4)]


def curve(*splines, cyclic=False):
    data = bpy.data.curves.new("DXF", "CURVE")
    data.dimensions = "3D"
    for points in splines:
        spline = data.splines.new("POLY")
        spline.points.add(len(points) - 1)
        for point, co in zip(spline.points, points, strict=True):
            point.co = (*co, 1)
        spline.use_cyclic_u = cyclic
    return link(bpy.data.objects.new("DXF", data))


def as_mesh(*splines):
    points = [point for spline in splines for point in spline]
    starts = np.cumsum([0] + [len(spline) for spline in splines])
    edges = [(a + k, a + k + 1) for a, b in pairwise(starts) for k in range(b - a - 1)]
    return mesh_object("DXF", points, [], edges)


BUILDS = {
    "four lines": lambda: curve(*SIDES),
    "after Toggle Cyclic": lambda: curve(*SIDES, cyclic=True),
    "backwards": lambda: curve(SIDES[0], SIDES[1][::-1], SIDES[2], SIDES[3][::-1]),
    "a ring that repeats its first point": lambda: curve([*HALL, HALL[0]]),
    "a cyclic ring that repeats its first point": lambda: curve([*HALL, HALL[0]], cyclic=True),
    "a line and an arc": lambda: curve(HALL[:3], HALL[2:] + HALL[:1]),
    "edges": lambda: as_mesh(*SIDES),
    "a hole of lines": lambda: curve(*SIDES, [(5, 5, 0), (7, 5, 0), (7, 7, 0)], [(7, 7, 0), (5, 5, 0)]),
}


@pytest.mark.parametrize("build", BUILDS.values(), ids=BUILDS)
def test_touching_ends_are_joined(build):
    build()
    assert bpy.ops.cmc.mesh_plan(edge_length=1.0, corners="NONE") == FINISHED
    area = sum(face.area for face in bpy.context.object.data.polygons)
    assert area == pytest.approx(216.0 - (2.0 if build is BUILDS["a hole of lines"] else 0.0), rel=1e-4)


def test_the_usual_plan_of_four_lines():
    curve(*SIDES)
    assert bpy.ops.cmc.mesh_plan(corners="ALL") == FINISHED
    assert len(bpy.context.object.data.polygons) == 2474


def test_a_rim_on_lines_that_touch():
    bpy.ops.cmc.add_plan(columns=16)
    plan = bpy.context.object
    corners = [(x - 9, y - 6, 0) for x, y, _ in HALL]
    curve(*[[corners[k], corners[(k + 1) % 4]] for k in range(4)])
    bpy.context.view_layer.objects.active = plan
    add_group(plan, "Line", boundary_edges(plan.data), "LINE").curve = bpy.data.objects["DXF"]
    assert bpy.ops.cmc.solve() == FINISHED and plan.cmc.f_plus is not None


@pytest.mark.parametrize(("splines", "named"), [
    ([SIDES[0], SIDES[1], SIDES[2], [HALL[3], (0, 0.5, 0)]], "Splines 0, 3 of 'DXF' are open, and their ends do"),
    ([[*HALL, (0, 1, 0)]], "Spline 0 of 'DXF' is open, and"),
])
def test_ends_apart_are_named(splines, named):
    curve(*splines)
    with pytest.raises(RuntimeError, match=named):
        bpy.ops.cmc.mesh_plan()
