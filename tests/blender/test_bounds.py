"""Bounds and dimensions are those of the mesh right after every operator that writes one."""

from __future__ import annotations

import bpy
import numpy as np
import pytest

from .scenes import activate, quad_ring

FINISHED = {"FINISHED"}


def check_bounds() -> None:
    """Every mesh object's cached box is that of its points, on the object and as evaluated."""
    bpy.context.view_layer.update()
    depsgraph = bpy.context.evaluated_depsgraph_get()
    for ob in [ob for ob in bpy.context.scene.objects if ob.type == "MESH"]:
        local = np.array([vertex.co for vertex in ob.data.vertices])
        for shown in (ob, ob.evaluated_get(depsgraph)):
            box = np.array(shown.bound_box)
            wanted = [local.min(0), local.max(0)]
            np.testing.assert_allclose([box.min(0), box.max(0)], wanted, atol=1e-6, err_msg=ob.name)
        np.testing.assert_allclose(ob.dimensions, np.ptp(local, axis=0) * np.abs(ob.scale), atol=1e-5, err_msg=ob.name)


def rectangle(**settings):
    assert bpy.ops.cmc.add_plan(columns=16) == FINISHED
    plan = bpy.context.object
    plan.cmc.default_kind = "BINORMAL"
    for name, value in settings.items():
        setattr(plan.cmc, name, value)
    return plan


@pytest.mark.parametrize("shape", ["RECTANGLE", "ROUND", "L_SHAPE", "COURT", "ANNULUS", "CYLINDER"])
def test_add_plan(shape):
    assert bpy.ops.cmc.add_plan(shape=shape, columns=24) == FINISHED
    check_bounds()


def test_add_module_solve_and_repeat():
    for made_as in ("MESH", "INSTANCES"):
        assert bpy.ops.cmc.add_module(module="HONEYCOMB", edges=6) == FINISHED
        check_bounds()
        assert bpy.ops.cmc.complete(complete_count=4, complete_as=made_as) == FINISHED
        check_bounds()


@pytest.mark.parametrize("combinatorics", ["PRIMAL", "DUAL"])
def test_solve_twice(combinatorics):
    plan = rectangle(combinatorics=combinatorics, want_g=True, want_f_minus=True)
    for span in (10.0, 40.0):
        plan.cmc.size, plan.cmc.span = "SPAN", span
        activate(plan)
        assert bpy.ops.cmc.solve() == FINISHED
        check_bounds()


def test_gauss_image_and_fits():
    plan = rectangle()
    assert bpy.ops.cmc.solve() == FINISHED
    assert bpy.ops.cmc.gauss_image() == FINISHED
    check_bounds()
    activate(plan)
    activate(plan.cmc.f_plus)
    plan.cmc.f_plus.cmc.role = "NONE"
    assert bpy.ops.cmc.approximate_surface() == FINISHED
    check_bounds()


def test_mesh_plan_twice():
    bpy.ops.mesh.primitive_plane_add(size=6.0)
    outline = bpy.context.object
    assert bpy.ops.cmc.mesh_plan() == FINISHED
    check_bounds()
    for vertex in outline.data.vertices:
        vertex.co.x *= 2.0
    activate(outline)
    assert bpy.ops.cmc.mesh_plan() == FINISHED
    check_bounds()
    assert bpy.context.object.dimensions.x == pytest.approx(12.0, rel=1e-5)


def test_shells_with_and_without_gaps():
    plan = quad_ring("Court", rings=5, columns=32)
    assert bpy.ops.cmc.solve(keep_closed=False) == FINISHED
    check_bounds()
    assert bpy.ops.cmc.solve(keep_closed=True) == FINISHED
    check_bounds()
    activate(plan)


def test_import(tmp_path, addon):
    from cmc_formfinding.solver.io.mesh_files import read_mesh

    rectangle()
    path = tmp_path / "plan.obj"
    assert bpy.ops.cmc.solve() == FINISHED
    assert bpy.ops.cmc.export(filepath=str(path), export_report=False) == FINISHED
    addon.cmc_addon.bridges.import_bridge.import_plan(bpy.context, "Read", read_mesh(path), [])
    check_bounds()
