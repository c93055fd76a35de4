"""Results of Approximate Surface: objects, settings, undo, and cancelling."""

from __future__ import annotations

import json
import threading

import bpy

# isort: split
import numpy as np
import pytest
from numpy.testing import assert_allclose

from .approximate_scenes import CANCELLED, FINISHED, approximated, cap, hand_for, report, wavy
from .scenes import activate, positions, snapshot, values

# --- results are results ---


@pytest.fixture
def plan():
    return cap()

def test_layers_and_materials_are_the_plans(plan):
    steel = bpy.data.materials.new("Steel")
    plan.data.materials.append(steel)
    layer = plan.data.uv_layers.new(name="Drawing")
    layer.uv.foreach_set("vector", np.random.default_rng(1).random(2 * len(plan.data.loops)).astype(np.float32))
    plan.vertex_groups.new(name="Held").add([1, 2], 0.5, "REPLACE")
    approximated(plan)
    result = plan.cmc.nearest
    assert result.name == "Cap nearest CMC"
    assert result.cmc.source == plan and result.users_collection[0].name == f"CMC {plan.name}"
    assert values(result.data.attributes["Drawing"]) == values(plan.data.attributes["Drawing"])
    assert result.data.materials[0] == steel
    assert [group.name for group in result.vertex_groups] == ["Held"]
    assert [tuple(p.vertices) for p in result.data.polygons] == [tuple(p.vertices) for p in plan.data.polygons]
    normals = np.array(values(result.data.attributes["cmc_normal"]))
    assert_allclose(np.linalg.norm(normals, axis=1), 1.0, rtol=0, atol=1e-6)
    assert json.loads(result["cmc_report"])["met"] and result["cmc_mean_curvature"] > 0


def test_the_next_one_writes_into_the_same_object(plan):
    approximated(plan)
    result, mesh = plan.cmc.nearest, plan.cmc.nearest.data
    gold = bpy.data.materials.new("Gold")
    mesh.materials.append(gold)
    result.name, result.location.x = "Mine", 20.0
    for vertex in plan.data.vertices:
        vertex.co.x *= 1.2
    before = positions(result)
    activate(result)  # the plan is what counts
    assert bpy.ops.cmc.approximate_surface() == FINISHED
    assert plan.cmc.nearest == result and result.data == mesh
    assert result.name == "Mine" and result.location.x == 20.0 and mesh.materials[0] == gold
    assert np.abs(positions(result) - before).max() > 0.1
    assert len([ob for ob in bpy.data.objects if ob.cmc.role != "NONE"]) == 1


def test_solve_and_approximate_surface_leave_each_other_alone(plan):
    nearest = approximated(plan)
    assert bpy.ops.cmc.solve() == FINISHED
    shell = positions(plan.cmc.f_plus)
    assert_allclose(positions(plan.cmc.nearest), nearest, rtol=0, atol=0)
    assert not plan.cmc.nearest.hide_viewport
    approximated(plan, smoothness=0.1)
    assert_allclose(positions(plan.cmc.f_plus), shell, rtol=0, atol=0)
    assert not plan.cmc.f_plus.hide_viewport
    assert plan.cmc.f_plus.users_collection == plan.cmc.nearest.users_collection


def test_in_edit_mode(plan):
    bpy.ops.object.mode_set(mode="EDIT")
    approximated(plan)
    assert plan.mode == "EDIT"


def test_settings_are_the_objects_unless_given(plan):
    other = cap("Other")
    approximated(plan, match="POSITION", near=50.0)
    assert (plan.cmc.match, plan.cmc.near, other.cmc.match) == ("POSITION", 50.0, "TANGENT_PLANES")


def test_every_setting_is_an_operator_property(addon):
    names = addon.cmc_addon.properties.approximate_settings.APPROXIMATE_SETTINGS
    assert set(names) <= {p.identifier for p in bpy.ops.cmc.approximate_surface.get_rna_type().properties}
    assert set(names) <= set(bpy.types.Object.bl_rna.properties["cmc"].fixed_type.properties.keys())


def test_undo_and_redo(plan):
    bpy.ops.ed.undo_push(message="before")
    assert bpy.ops.cmc.approximate_surface("EXEC_DEFAULT", True) == FINISHED
    assert "Cap nearest CMC" in bpy.data.objects
    bpy.ops.ed.undo()
    assert [ob.name for ob in bpy.data.objects] == ["Cap"] and bpy.data.objects["Cap"].cmc.nearest is None
    bpy.ops.ed.redo()
    assert bpy.data.objects["Cap"].cmc.nearest == bpy.data.objects["Cap nearest CMC"]


# --- ending early ---


def test_cancelled_changes_nothing(addon, monkeypatch, plan):
    session = addon.cmc_addon.background.worker
    approximated(plan)
    for vertex in plan.data.vertices:
        vertex.co.x *= 1.2
    activate(plan)
    plan_cache = addon.cmc_addon.background.plan_cache
    real = plan_cache.prepare

    def prepare(*args):
        session.cancel()
        return real(*args)

    monkeypatch.setattr(plan_cache, "prepare", prepare)
    before = snapshot()
    assert bpy.ops.cmc.approximate_surface() == CANCELLED
    assert snapshot() == before
    assert session.Running.stop is None


@pytest.fixture
def hand(addon, plan):
    activate(plan)
    return hand_for(addon.cmc_addon.operators.approximate)


def test_the_shape_is_shown_while_it_runs(addon, monkeypatch):
    surface, shown, progress = wavy(), [], []
    preview, hand = addon.cmc_addon.drawing.preview, hand_for(addon.cmc_addon.operators.approximate)
    monkeypatch.setattr(preview, "show", lambda *shape: shown.append(shape))
    result = {"RUNNING_MODAL"}
    while result == {"RUNNING_MODAL"}:
        result = hand.tick()
        progress.append(bpy.context.window_manager.cmc.progress)
    assert result == FINISHED and len(shown) == 1
    points, triangles = shown[0]
    assert_allclose(points, positions(surface.cmc.nearest), rtol=0, atol=1.0)
    assert preview.sides(triangles).shape == (len(points) + len(triangles) - 1, 2)  # Euler, for a disc
    assert progress == sorted(progress) and progress[-1] > 0 and "on average" in hand.reports[-1][1]


def test_escape_leaves_the_scene_as_it_was(addon):
    surface = wavy()
    activate(surface)
    preview, worker = addon.cmc_addon.drawing.preview.Preview, addon.cmc_addon.background.worker
    hand = hand_for(addon.cmc_addon.operators.approximate)
    bpy.context.view_layer.update()
    before = snapshot()
    while preview.shape is None:
        assert hand.tick() == {"RUNNING_MODAL"}
    assert hand.tick("MOUSEMOVE") == {"PASS_THROUGH"}
    assert hand.tick("ESC", "PRESS") == CANCELLED
    assert snapshot() == before and preview.shape is None and worker.Running.stop is None
    thread: threading.Thread = worker.Running.thread
    thread.join(10.0)
    assert not thread.is_alive(), "it ends at its next step"


def test_a_surface_changed_meanwhile(hand, plan):
    hand.tick()
    plan.data.vertices[0].co.z += 0.5
    result = {"RUNNING_MODAL"}
    while result == {"RUNNING_MODAL"}:
        result = hand.tick()
    assert result == CANCELLED and plan.cmc.nearest is None
    assert "was changed while it was being solved" in hand.reports[-1][1]


def test_every_vertex_has_its_distance_from_the_surface(plan):
    approximated(plan)
    deviation = np.array(values(plan.cmc.nearest.data.attributes["cmc_deviation"]))
    assert (deviation >= 0.0).all() and deviation.max() == pytest.approx(report(plan)["deviation"]["max"], rel=1e-4)
