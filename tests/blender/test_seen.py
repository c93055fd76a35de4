"""What is seen is not what is planned: every modifier and shape key that a task leaves out is named in a warning."""

from __future__ import annotations

import json

import bpy
import numpy as np
import pytest

from .scenes import activate, add_group, boundary_edges, link, mesh_object

FINISHED = {"FINISHED"}
HALL = [(0, 0, 0), (18, 0, 0), (18, 12, 0), (0, 12, 0)]


def grid(name="Grid", columns=6, rows=8):
    points = [(x, y, 0) for y in range(rows + 1) for x in range(columns + 1)]
    step = columns + 1
    corners = [(r * step + c, r * step + c + 1) for r in range(rows) for c in range(columns)]
    return mesh_object(name, points, [(a, b, b + step, a + step) for a, b in corners])


def widen(ob):
    ob.shape_key_add(name="Basis")
    key = ob.shape_key_add(name="Wide")
    for point in key.data:
        point.co.x *= 2
    key.value = 1


def mirror(ob):
    ob.modifiers.new("M", "MIRROR")


def bevel(ob):
    modifier = ob.modifiers.new("B", "BEVEL")
    modifier.affect, modifier.width = "VERTICES", 3


def hook(ob):
    empty = bpy.data.objects.new("Empty", None)
    bpy.context.collection.objects.link(empty)
    modifier = ob.modifiers.new("Hook", "HOOK")
    modifier.object = empty
    modifier.vertex_indices_set(range(len(ob.data.vertices)))
    empty.location.x = 3.0


CHANGES = [(mirror, "modifier 'M'"), (bevel, "modifier 'B'"), (hook, "modifier 'Hook'"), (widen, "shape key 'Wide'")]


@pytest.mark.parametrize(("change", "named"), CHANGES)
def test_outlines(change, named, capfd):
    ob = mesh_object("Hall", HALL, [(0, 1, 2, 3)])
    assert bpy.ops.cmc.mesh_plan(edge_length=2.0) == FINISHED
    assert "taken as drawn" not in capfd.readouterr().out
    change(ob)
    activate(ob)
    assert bpy.ops.cmc.mesh_plan(edge_length=2.0) == FINISHED
    assert f"'Hall' was taken as drawn, without its {named}; apply it" in capfd.readouterr().out


def test_a_curve_with_a_modifier(capfd):
    data = bpy.data.curves.new("Curve", "CURVE")
    spline = data.splines.new("POLY")
    spline.points.add(3)
    for point, co in zip(spline.points, HALL, strict=True):
        point.co = (*co, 1)
    spline.use_cyclic_u = True
    curve = link(bpy.data.objects.new("Curve", data))
    curve.modifiers.new("Array", "ARRAY")
    assert bpy.ops.cmc.mesh_plan(edge_length=2.0) == FINISHED
    assert "without its modifier 'Array'" in capfd.readouterr().out
    plan = curve.cmc.plan
    activate(plan)
    add_group(plan, "Line", boundary_edges(plan.data), "LINE").curve = curve
    assert bpy.ops.cmc.solve() == FINISHED
    assert "'Curve' was taken as drawn, without its modifier 'Array'" in capfd.readouterr().out


@pytest.mark.parametrize(("change", "named"), [CHANGES[0], CHANGES[2], CHANGES[3]])
def test_plans(change, named, capfd):
    plan = grid()
    change(plan)
    text = f"'Grid' was taken as drawn, without its {named}; tick Apply Modifiers"
    activate(plan)
    assert bpy.ops.cmc.solve() == FINISHED
    assert text in capfd.readouterr().out
    assert any(text in warning["text"] for warning in json.loads(plan.cmc.report)["warnings"])
    activate(plan)
    assert bpy.ops.cmc.solve(apply_modifiers=True) == FINISHED
    assert "taken as drawn" not in capfd.readouterr().out


def test_surfaces_to_approximate(capfd):
    surface = grid("Surface")
    for vertex in surface.data.vertices:
        x, y, _ = vertex.co
        vertex.co.z = np.sqrt(400.0 - (x - 3) ** 2 - (y - 4) ** 2)
    surface.modifiers.new("Array", "ARRAY")
    assert bpy.ops.cmc.approximate_surface() == FINISHED
    assert "'Surface' was taken as drawn, without its modifier 'Array'" in capfd.readouterr().out


def test_what_changes_nothing_is_not_told(capfd):
    plan = grid()
    plan.modifiers.new("Normals", "WEIGHTED_NORMAL")
    plan.modifiers.new("Array", "ARRAY").show_viewport = False
    plan.shape_key_add(name="Basis")
    plan.shape_key_add(name="Same").value = 1.0
    assert bpy.ops.cmc.solve() == FINISHED
    assert "taken as drawn" not in capfd.readouterr().out


def test_geometry_nodes_may_make_the_faces():
    tree = bpy.data.node_groups.new("G", "GeometryNodeTree")
    tree.interface.new_socket("Geometry", in_out="OUTPUT", socket_type="NodeSocketGeometry")
    made, out = tree.nodes.new("GeometryNodeMeshGrid"), tree.nodes.new("NodeGroupOutput")
    for name, value in (("Size X", 12), ("Size Y", 8), ("Vertices X", 13), ("Vertices Y", 9)):
        made.inputs[name].default_value = value
    tree.links.new(made.outputs[0], out.inputs[0])
    plan = mesh_object("GN", [], [])
    plan.modifiers.new("GN", "NODES").node_group = tree
    bpy.context.view_layer.update()
    with pytest.raises(RuntimeError, match="'GN' has no faces; tick Apply Modifiers if these make them"):
        bpy.ops.cmc.solve()
    assert bpy.ops.cmc.solve(apply_modifiers=True) == FINISHED
    assert len(plan.cmc.f_plus.data.polygons) == 96


def test_points_that_blender_rounds_are_told(capfd):
    ob = mesh_object("Hall", np.array(HALL) + (2683000, 1247000, 0), [(0, 1, 2, 3)])
    assert bpy.ops.cmc.mesh_plan(edge_length=2.0) == FINISHED
    assert "'Hall' is drawn 2.7e+06 from its origin, where Blender keeps points to 0.25" in capfd.readouterr().out
    activate(ob.cmc.plan)
    assert bpy.ops.cmc.solve() == FINISHED
    assert "from its origin" not in capfd.readouterr().out
