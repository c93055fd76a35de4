"""Results of both designs: objects, settings, undo, and cancelling."""

from __future__ import annotations

import json
import threading
from types import SimpleNamespace

import bpy

# isort: split
import numpy as np
import pytest
from numpy.testing import assert_allclose

from .design_scenes import (
    CANCELLED,
    FINISHED,
    approximated,
    cap,
    fitted,
    hand_for,
    raised_loop,
    report,
    rim_of,
    small_disc,
    wavy,
)
from .scenes import activate, positions, snapshot, values

# --- results are results ---

OPERATORS = {"nearest": (cap, approximated, "Cap nearest CMC"), "fit": (small_disc, fitted, "Disc fit")}


@pytest.fixture(params=OPERATORS)
def design(request):
    """The link to the result, the plan, the call, the name of the result."""
    build, call, name = OPERATORS[request.param]
    operator = bpy.ops.cmc.approximate_surface if request.param == "nearest" else bpy.ops.cmc.fit_outline
    return SimpleNamespace(link=request.param, plan=build(), call=call, name=name, operator=operator)


def test_layers_and_materials_are_the_plans(design):
    plan = design.plan
    steel = bpy.data.materials.new("Steel")
    plan.data.materials.append(steel)
    layer = plan.data.uv_layers.new(name="Drawing")
    layer.uv.foreach_set("vector", np.random.default_rng(1).random(2 * len(plan.data.loops)).astype(np.float32))
    plan.vertex_groups.new(name="Held").add([1, 2], 0.5, "REPLACE")
    design.call(plan)
    result = getattr(plan.cmc, design.link)
    assert result.name == design.name
    assert result.cmc.source == plan and result.users_collection[0].name == f"CMC {plan.name}"
    assert values(result.data.attributes["Drawing"]) == values(plan.data.attributes["Drawing"])
    assert result.data.materials[0] == steel
    assert [group.name for group in result.vertex_groups] == ["Held"]
    assert [tuple(p.vertices) for p in result.data.polygons] == [tuple(p.vertices) for p in plan.data.polygons]
    normals = np.array(values(result.data.attributes["cmc_normal"]))
    assert_allclose(np.linalg.norm(normals, axis=1), 1.0, rtol=0, atol=1e-6)
    assert json.loads(result["cmc_report"])["met"] and result["cmc_mean_curvature"] > 0


def test_the_next_one_writes_into_the_same_object(design):
    plan = design.plan
    design.call(plan)
    result, mesh = getattr(plan.cmc, design.link), getattr(plan.cmc, design.link).data
    gold = bpy.data.materials.new("Gold")
    mesh.materials.append(gold)
    result.name, result.location.x = "Mine", 20.0
    for vertex in plan.data.vertices:
        vertex.co.x *= 1.2
    before = positions(result)
    activate(result)  # the plan is what counts
    assert design.operator() == FINISHED
    assert getattr(plan.cmc, design.link) == result and result.data == mesh
    assert result.name == "Mine" and result.location.x == 20.0 and mesh.materials[0] == gold
    assert np.abs(positions(result) - before).max() > 0.1
    assert len([ob for ob in bpy.data.objects if ob.cmc.role != "NONE"]) == 1


def test_solve_and_design_leave_each_other_alone():
    plan = small_disc()
    fit = fitted(plan)
    assert bpy.ops.cmc.solve() == FINISHED
    shell = positions(plan.cmc.f_plus)
    assert_allclose(positions(plan.cmc.fit), fit, rtol=0, atol=0)
    assert not plan.cmc.fit.hide_viewport
    fitted(plan, fit_rise=0.2)
    assert_allclose(positions(plan.cmc.f_plus), shell, rtol=0, atol=0)
    assert bpy.data.objects["Disc f+"].users_collection == plan.cmc.fit.users_collection


def test_in_edit_mode(design):
    bpy.ops.object.mode_set(mode="EDIT")
    design.call(design.plan)
    assert design.plan.mode == "EDIT"


def test_settings_are_the_objects_unless_given():
    plan, other = small_disc("One"), small_disc("Other")
    fitted(plan, height_parameter="HEIGHT", fit_height=1.0)
    assert (plan.cmc.height_parameter, plan.cmc.fit_height, other.cmc.height_parameter) == ("HEIGHT", 1.0, "RISE")
    assert fitted(plan)[:, 2].max() == pytest.approx(1.0, rel=5e-3)


def test_every_setting_is_an_operator_property(addon):
    settings = addon.cmc_addon.properties.design_settings
    for operator, names in (
        (bpy.ops.cmc.approximate_surface, settings.APPROXIMATE_SETTINGS),
        (bpy.ops.cmc.fit_outline, (*settings.FIT_SETTINGS, *settings.POINTERS)),
    ):
        assert set(names) <= {p.identifier for p in operator.get_rna_type().properties}
        stored = bpy.types.Object.bl_rna.properties["cmc"].fixed_type.properties.keys()
        assert {settings.POINTERS.get(name, name) for name in names} <= set(stored)


def test_undo_and_redo(design):
    name = design.plan.name
    bpy.ops.ed.undo_push(message="before")
    assert design.operator("EXEC_DEFAULT", True) == FINISHED
    assert design.name in bpy.data.objects
    bpy.ops.ed.undo()
    assert [ob.name for ob in bpy.data.objects] == [name]
    assert getattr(bpy.data.objects[name].cmc, design.link) is None
    bpy.ops.ed.redo()
    assert getattr(bpy.data.objects[name].cmc, design.link) == bpy.data.objects[design.name]


# --- ending early ---


def test_cancelled_changes_nothing(addon, monkeypatch, design):
    session = addon.cmc_addon.background.worker
    design.call(design.plan)
    for vertex in design.plan.data.vertices:
        vertex.co.x *= 1.2
    activate(design.plan)
    plan_cache = addon.cmc_addon.background.plan_cache
    real = plan_cache.prepare

    def prepare(*args):
        session.cancel()
        return real(*args)

    monkeypatch.setattr(plan_cache, "prepare", prepare)
    before = snapshot()
    assert design.operator() == CANCELLED
    assert snapshot() == before
    assert session.Running.stop is None


@pytest.fixture
def hand(addon):
    design = addon.cmc_addon.operators.design
    return hand_for(design, design.CMC_OT_fit_outline)


def test_an_approximation_is_shown_too(addon, monkeypatch):
    surface = wavy()
    design, shown = addon.cmc_addon.operators.design, []
    monkeypatch.setattr(addon.cmc_addon.drawing.preview, "show", lambda *shape: shown.append(shape))
    hand, result = hand_for(design, design.CMC_OT_approximate_surface), {"RUNNING_MODAL"}
    while result == {"RUNNING_MODAL"}:
        result = hand.tick()
    assert result == FINISHED and len(shown) == 1
    assert_allclose(shown[0][0], positions(surface.cmc.nearest), rtol=0, atol=1.0)
    assert "on average" in hand.reports[-1][1]


def test_shapes_are_shown_while_it_runs(addon, hand, monkeypatch):
    plan = small_disc()
    plan.scale, plan.cmc.limit_tilt, plan.cmc.tilt_min = (1.6, 1.0, 1.0), True, 1.2
    preview = addon.cmc_addon.drawing.preview
    monkeypatch.setattr(addon.cmc_addon.tasks.fit_outline, "_FIRST_SLICE", 3)
    shown, progress = [], []
    real = preview.show
    monkeypatch.setattr(preview, "show", lambda *shape: (shown.append(shape), real(*shape)))
    result = {"RUNNING_MODAL"}
    while result == {"RUNNING_MODAL"}:
        result = hand.tick()
        progress.append(bpy.context.window_manager.cmc.progress)
    assert result == FINISHED
    assert len(shown) >= 1
    points, triangles = shown[-1]
    assert_allclose(points, positions(plan.cmc.fit), rtol=0, atol=0.5)
    assert preview.sides(triangles).shape == (len(points) + len(triangles) - 1, 2)  # Euler, for a disc
    assert progress == sorted(progress) and progress[-1] > 0
    assert preview.Preview.shape is None, "cleared at the end"


def test_escape_leaves_the_scene_as_it_was(addon, hand, monkeypatch):
    monkeypatch.setattr(addon.cmc_addon.tasks.fit_outline, "_FIRST_SLICE", 3)
    plan = small_disc()
    plan.scale, plan.cmc.limit_tilt, plan.cmc.tilt_min = (1.6, 1.0, 1.0), True, 1.2
    bpy.context.view_layer.update()
    before = snapshot()
    while addon.cmc_addon.drawing.preview.Preview.shape is None:
        assert hand.tick() == {"RUNNING_MODAL"}
    assert hand.tick("MOUSEMOVE") == {"PASS_THROUGH"}
    assert hand.tick("ESC", "PRESS") == CANCELLED
    assert snapshot() == before
    assert addon.cmc_addon.drawing.preview.Preview.shape is None
    assert addon.cmc_addon.background.worker.Running.stop is None
    thread: threading.Thread = addon.cmc_addon.background.worker.Running.thread
    thread.join(10.0)
    assert not thread.is_alive(), "a fit ends at its next step"


def test_a_plan_changed_meanwhile(hand):
    plan = small_disc()
    hand.tick()
    plan.data.vertices[0].co.z += 0.5
    result = {"RUNNING_MODAL"}
    while result == {"RUNNING_MODAL"}:
        result = hand.tick()
    assert result == CANCELLED and plan.cmc.fit is None
    assert "was changed while it was being solved" in hand.reports[-1][1]


def test_a_curve_deleted_meanwhile(hand):
    curve, _ = raised_loop()
    plan = small_disc()
    plan.cmc.fit_to, plan.cmc.fit_curve = "CURVE", curve
    hand.tick()
    bpy.data.objects.remove(curve)
    result = {"RUNNING_MODAL"}
    while result == {"RUNNING_MODAL"}:
        result = hand.tick()
    assert result == FINISHED and plan.cmc.fit_curve is None


def test_a_fitted_shell_carries_the_distance_of_its_rim_from_the_outline():
    """Elsewhere it is not known; an approximation has its distance from the surface at every vertex instead."""
    plan = small_disc()
    points = fitted(plan)
    deviation = np.array(values(plan.cmc.fit.data.attributes["cmc_deviation"]))
    rim = np.isin(np.arange(len(points)), rim_of(plan))
    assert (deviation[~rim] == -1.0).all() and (deviation[rim] >= 0.0).all()
    assert deviation.max() == pytest.approx(report(plan)["sheets"]["f+"]["outline"]["max"], rel=1e-4)
    surface = cap()
    approximated(surface)
    assert min(values(surface.cmc.nearest.data.attributes["cmc_deviation"])) >= 0.0


def test_a_fit_parks_the_shell_of_solve_and_an_approximation_does_not():
    """Both would be over one plan; an approximated surface is no plan."""
    plan, surface = small_disc(), cap()
    for ob, design in ((plan, fitted), (surface, approximated)):
        activate(ob)
        assert bpy.ops.cmc.solve() == FINISHED and not ob.cmc.f_plus.hide_viewport
        design(ob)
        shell, is_fit = ob.cmc.f_plus, design is fitted
        assert (shell.hide_viewport, shell.hide_render, shell.cmc.parked) == (is_fit,) * 3
