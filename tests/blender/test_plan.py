"""Mesh Plan: outlines of every kind in, a well-shaped plan in their place out."""

from __future__ import annotations

import math

import bpy
import numpy as np
import pytest
from mathutils import Euler, Matrix, Vector

from .outlines import HOLE, SQUARE, added, area, corners, curve, mesh_plan, ngon, normals, points, wire


def smallest_angle(ob) -> float:
    p = corners(ob)
    u, v = np.roll(p, -1, axis=1) - p, np.roll(p, 1, axis=1) - p
    cosines = (u * v).sum(2) / (np.linalg.norm(u, axis=2) * np.linalg.norm(v, axis=2))
    return math.degrees(np.arccos(cosines).min())


# --- outlines of every kind ----------------------------------------------------------------

def test_ngon() -> None:
    ob = ngon(SQUARE)
    plan = mesh_plan(corners="NONE")
    assert (plan.name, ob.name) == ("Hall Plan", "Hall")
    assert len(ob.data.polygons) == 1, "the drawn outline stays as it is"
    assert area(plan) == pytest.approx(48.0, rel=1e-6)
    assert (normals(plan)[:, 2] > 0).all()
    assert smallest_angle(plan) > 25
    ends = points(plan)[[list(edge.vertices) for edge in plan.data.edges]]
    lengths = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
    assert 0.1 < np.median(lengths) < 0.2 * 1.05, "a fortieth of 8 is 0.2"


def test_faces_with_a_hole() -> None:
    ring = [(0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)]
    added("Court", [(x, y, 0) for x, y in SQUARE + HOLE], [], ring)
    plan = mesh_plan(edge_length=0.5, corners="NONE")
    assert area(plan) == pytest.approx(48.0 - 4.0, rel=1e-6)
    assert not ((points(plan)[:, :2] > (3.01, 2.01)) & (points(plan)[:, :2] < (4.99, 3.99))).all(axis=1).any()


def test_edges_only_with_a_hole_drawn_first() -> None:
    wire(HOLE, SQUARE)
    plan = mesh_plan(edge_length=0.5, corners="NONE")
    assert area(plan) == pytest.approx(44.0, rel=1e-6)


def test_a_mesh_of_many_faces_and_stray_edges() -> None:
    bpy.ops.mesh.primitive_grid_add(x_subdivisions=5, y_subdivisions=3, size=4)
    plan = mesh_plan(edge_length=0.4, corners="NONE")
    assert area(plan) == pytest.approx(16.0, rel=1e-6)


@pytest.mark.parametrize("kind", ["POLY", "BEZIER", "NURBS"])
@pytest.mark.parametrize("clockwise", [False, True])
def test_curves(kind, clockwise) -> None:
    angles = np.linspace(0, 2 * np.pi, 24, endpoint=False) * (-1 if clockwise else 1)
    circles = [[(r * math.cos(t), r * math.sin(t)) for t in angles] for r in (5.0, 2.0)]
    ob = curve(*circles, kind=kind)
    plan = mesh_plan(edge_length=0.5)
    exact = math.pi * (25 - 4) * (0.975 if kind == "NURBS" else 1)  # a NURBS runs inside its polygon
    assert area(plan) == pytest.approx(exact, rel=0.03)
    assert (normals(plan)[:, 2] > 0).all()
    assert not ob.hide_get(), "a curve has no faces to fight with"


def test_a_filled_bevelled_curve_is_taken_by_its_line() -> None:
    ob = curve(SQUARE)
    ob.data.fill_mode = "BOTH"
    ob.data.extrude, ob.data.bevel_depth = 0.3, 0.1
    before = set(bpy.data.curves), set(bpy.data.meshes)
    plan = mesh_plan(edge_length=0.5, corners="NONE")
    assert area(plan) == pytest.approx(48.0, rel=1e-6)
    assert (set(bpy.data.curves), set(bpy.data.meshes) - {plan.data}) == before, "nothing is left behind"
    assert (ob.data.extrude, ob.data.bevel_depth, ob.data.fill_mode) == pytest.approx((0.3, 0.1, "BOTH"))


@pytest.mark.parametrize("build", [lambda: ngon(SQUARE), lambda: curve(SQUARE)], ids=["mesh", "curve"])
def test_from_edit_mode_and_undo(build) -> None:
    ob = build()
    name = ob.name
    bpy.ops.ed.undo_push(message="start")
    bpy.ops.object.mode_set("EXEC_DEFAULT", True, mode="EDIT")
    bpy.ops.cmc.mesh_plan("EXEC_DEFAULT", True, edge_length=1.0)
    assert bpy.context.mode == "OBJECT" and bpy.context.object.name == "Hall Plan"
    bpy.ops.ed.undo()
    assert "Hall Plan" not in bpy.data.objects
    assert bpy.context.object.name == name and not bpy.context.object.hide_get()
    bpy.ops.ed.redo()
    assert bpy.data.objects["Hall Plan"].cmc.outline == bpy.data.objects[name]
    assert bpy.data.objects[name].cmc.plan == bpy.data.objects["Hall Plan"]


# --- where it lies -------------------------------------------------------------------------

def test_heights_of_a_level_plan_are_kept() -> None:
    ngon(SQUARE, z=3.25)
    plan = mesh_plan(edge_length=0.5)
    assert (points(plan)[:, 2] == 3.25).all()


def test_transforms_are_respected() -> None:
    ob = ngon(SQUARE)
    ob.location, ob.scale = (10, -5, 2), (2, 0.5, 7)
    ob.rotation_euler = (0, 0, math.radians(30))
    bpy.context.view_layer.update()
    plan = mesh_plan(edge_length=0.4, corners="NONE")
    assert tuple(plan.scale) == pytest.approx((1, 1, 1), abs=1e-6)
    middle = (points(plan).min(axis=0) + points(plan).max(axis=0)) / 2
    assert tuple(plan.location) == pytest.approx(tuple(middle), abs=1e-5), "the origin is in the middle"
    assert area(plan) == pytest.approx(16 * 3, rel=1e-5)
    drawn = [ob.matrix_world @ v.co for v in ob.data.vertices]
    nearest = [min((Vector(p) - q).length for p in points(plan)) for q in drawn]
    assert max(nearest) < 1e-5


def test_a_mirrored_outline_gives_faces_that_look_up() -> None:
    ob = ngon(SQUARE)
    ob.scale = (-1, 1, 1)
    bpy.context.view_layer.update()
    assert (normals(mesh_plan(edge_length=0.5))[:, 2] > 0).all()


@pytest.mark.parametrize("degrees", [20, 60, 90, 160])
def test_a_plan_in_any_plane(degrees) -> None:
    ob = ngon(SQUARE)
    ob.matrix_world = Matrix.LocRotScale((1, 2, 3), Euler((math.radians(degrees), 0, 0)), None)
    bpy.context.view_layer.update()
    plan = mesh_plan(edge_length=0.5, corners="NONE")
    assert area(plan) == pytest.approx(48.0, rel=1e-5)
    normal = np.array(ob.matrix_world.to_3x3() @ Vector((0, 0, 1)))
    assert np.abs((points(plan) - (1, 2, 3)) @ normal).max() < 1e-5
    assert (normals(plan)[:, 2] > -1e-6).all()


def test_an_outline_that_is_not_flat_is_flattened_and_said_so(capfd) -> None:
    added("Hall", [(0, 0, 0.2), (8, 0, -0.2), (8, 8, 0.2), (0, 8, -0.2)], [(0, 1), (1, 2), (2, 3), (3, 0)], [])
    plan = mesh_plan(edge_length=0.5)
    assert np.ptp(points(plan)[:, 2]) < 1e-5
    assert "leaves its plane by 20 cm" in capfd.readouterr().out


def test_uv_layer_holds_plan_coordinates() -> None:
    ob = ngon(SQUARE)
    ob.location = (100, 50, 4)
    bpy.context.view_layer.update()
    plan = mesh_plan(edge_length=0.5)
    assert plan.data.uv_layers.active.name == "Plan"
    uv = np.array([item.vector for item in plan.data.uv_layers["Plan"].uv])
    vertex = [loop.vertex_index for loop in plan.data.loops]
    assert uv == pytest.approx(points(plan)[vertex][:, :2] - (104, 53), abs=1e-4), "from the plan's middle"


# --- settings ------------------------------------------------------------------------------

def test_corners_are_rounded_by_default() -> None:
    ngon(SQUARE)
    plan = mesh_plan(edge_length=0.25)
    assert area(plan) == pytest.approx(48 - (4 - math.pi) * 0.8**2, rel=1e-3), "radius: a tenth of 8"
    bpy.context.view_layer.objects.active = plan
    mesh_plan(corner_radius=2.0)
    assert area(plan) == pytest.approx(48 - (4 - math.pi) * 2.0**2, rel=1e-3)


def test_a_court_stays_a_court_and_what_was_rounded_is_said(capfd) -> None:
    corners = [(0, 0, 0), (60, 0, 0), (60, 40, 0), (0, 40, 0), (27, 17, 0), (32, 17, 0), (32, 22, 0), (27, 22, 0)]
    added("Hall", corners, [(k, k - k % 4 + (k + 1) % 4) for k in range(8)], [])
    plan = mesh_plan(edge_length=1.5)
    assert area(plan) == pytest.approx(60 * 40 - (4 - math.pi) * 36 - 25 + (4 - math.pi) * 0.25, rel=1e-3)
    assert "Rounded 8 corners by 50 cm to 6 m." in capfd.readouterr().out
    bpy.context.scene.unit_settings.scale_length = 0.001
    mesh_plan(corner_radius=4.0)
    assert "Rounded 8 corners by 2.5 mm to 4 mm." in capfd.readouterr().out
    mesh_plan(corners="NONE")
    assert "Rounded" not in capfd.readouterr().out


def test_only_the_corners_of_a_court_are_rounded(capfd) -> None:
    wire(SQUARE, HOLE)
    plan = mesh_plan(edge_length=0.25, corners="RE_ENTRANT")
    assert area(plan) == pytest.approx(48 - 4 + (4 - math.pi) * 0.2**2, rel=1e-3)
    assert "Rounded 4 corners by 20 cm." in capfd.readouterr().out


def test_settings_are_remembered_by_the_scene() -> None:
    ngon(SQUARE)
    mesh_plan(edge_length=1.0, corners="NONE")
    first = len(bpy.context.object.data.polygons)
    mesh_plan()
    assert len(bpy.context.object.data.polygons) == first
    assert bpy.context.scene.cmc.edge_length == 1.0 and bpy.context.scene.cmc.corners == "NONE"
