"""Add > Mesh > CMC: plans of modules that are solved and completed without another setting."""

from __future__ import annotations

import json

import bpy
import numpy as np
import pytest
from numpy.testing import assert_allclose

from .scenes import positions, snapshot, values
from .solved_modules import COPIES, FINISHED, completion_report, is_oriented, module, solved


@pytest.mark.parametrize("name", COPIES)
def test_solve_and_complete_need_nothing_else(name):
    """Corner angles of the plan are those of the surface: the copies go around each corner once."""
    plan = solved(name)
    report = json.loads(plan.cmc.report)
    assert report["converged"] and report["sheets"]["f+"]["intersections"]["count"] == 0
    assert {plane["name"] for plane in report["planes"]} == {group.name for group in plan.data.cmc.groups}
    assert max(plane["relative"] for plane in report["planes"]) < 0.02
    assert bpy.ops.cmc.complete() == FINISHED
    whole = plan.cmc.completed
    units = int(np.prod(list(plan.cmc.complete_repeat)))
    assert units > 1 and completion_report(plan)["copies"] == COPIES[name] * units
    assert len(whole.data.polygons) == completion_report(plan)["copies"] * len(plan.data.polygons)
    assert is_oriented(whole.data) and completion_report(plan)["relative_gap"] < 2e-3
    assert whole.name == f"{plan.name} completed" and whole.users_collection[0] == plan.cmc.collection
    assert plan.cmc.f_plus.hide_viewport and not whole.hide_viewport


@pytest.mark.parametrize("name", COPIES)
def test_every_edge_of_a_preset_is_in_a_group_and_the_plan_faces_up(name):
    bpy.context.scene.cursor.location = (3.0, 4.0, 5.0)
    plan = module(name, size=8.0)
    mesh = plan.data
    uids = {group.uid for group in mesh.cmc.groups}
    rim = np.bincount([loop.edge_index for loop in mesh.loops], minlength=len(mesh.edges)) == 1
    groups = np.array(values(mesh.attributes["cmc_group"]))
    assert set(groups[rim]) == uids and set(groups[~rim]) == {0}
    assert min(polygon.normal.z for polygon in mesh.polygons) > 0.999
    assert_allclose(np.ptp(positions(plan), axis=0).max(), 8.0, rtol=1e-6)
    assert plan.matrix_world.translation[:] == (3.0, 4.0, 5.0) and "Plan" in mesh.uv_layers
    assert bpy.context.selected_objects == [plan]


def test_a_slender_unduloid_has_the_necks_it_should():
    """Radii 1 ∓ √(1 + c) at H = ½."""
    plan = solved("UNDULOID", slenderness=0.5, edges=24)
    report = json.loads(plan.cmc.report)
    scale = 0.5 / report["mean_curvature"]
    points = positions(plan.cmc.f_plus)
    offsets = {plane["name"]: plane for plane in report["planes"]}
    around = np.hypot(points[:, 1] + offsets["Axis"]["offset"], points[:, 2] + offsets["Floor"]["offset"]) / scale
    assert_allclose([around.min(), around.max()], [0.5, 1.5], atol=0.01)


def test_the_menu_offers_every_preset():
    drawn = []

    class Layout:
        operator_context = "INVOKE_DEFAULT"

        def operator(self, name, text):
            drawn.append(text)
            return type("Properties", (), {})()

        def separator(self):
            drawn.append("---")

    from cmc_formfinding.cmc_addon.panels.symmetry_panel import CMC_MT_add

    CMC_MT_add.draw(type("Menu", (), {"layout": Layout()})(), bpy.context)
    assert drawn[:5] == ["Rectangle", "Round", "L-Shaped", "Court", "---"], "plans that need nothing else come first"
    assert drawn[5:10] == ["Nodoid", "Unduloid", "Mirror Quadrilateral", "Honeycomb Module", "Column Capital"]


def test_presets_are_undone_and_refused_in_edit_mode():
    before = snapshot()
    bpy.ops.ed.undo_push(message="before")
    bpy.ops.cmc.add_module("EXEC_DEFAULT", True, module="CAPITAL", edges=8)
    bpy.ops.ed.undo()
    assert snapshot() == before
    module("CAPITAL")
    bpy.ops.object.mode_set(mode="EDIT")
    with pytest.raises(RuntimeError, match="Leave edit mode"):
        bpy.ops.cmc.add_module(module="CAPITAL")


@pytest.mark.parametrize("slenderness", [0.0, 1.0])
@pytest.mark.parametrize("name", COPIES)
def test_the_stockiest_and_the_slenderest_work(name, slenderness):
    plan = solved(name, slenderness=slenderness, edges=14)
    assert json.loads(plan.cmc.report)["converged"]
    assert bpy.ops.cmc.complete(complete_repeat=(1, 1, 1)) == FINISHED
    assert completion_report(plan)["copies"] == COPIES[name] and completion_report(plan)["relative_gap"] < 2e-3
