"""The recipe of a plan: copies of its shell are made again with the next shell, or hidden and marked as behind."""

from __future__ import annotations

import json

import bpy
import pytest

from .live_driver import catch_up, settle
from .scenes import positions
from .sidebar import draw, text_of
from .solved_modules import FINISHED, farthest, solved


@pytest.fixture
def recipe(addon):
    return addon.cmc_addon.tasks.recipe


def repeated(plan):
    return plan.cmc.completed or plan.cmc.copies


@pytest.mark.parametrize("kind", ["MESH", "INSTANCES"])
def test_solve_makes_the_copies_again(kind):
    plan = solved("UNDULOID")
    assert bpy.ops.cmc.complete(complete_as=kind, complete_repeat=(2, 1, 1)) == FINISHED
    count = json.loads(plan.cmc.complete_report)["copies"]
    plan.scale = (2.0, 2.0, 2.0)
    assert bpy.ops.cmc.solve() == FINISHED
    assert plan.cmc.f_plus.hide_viewport and not repeated(plan).hide_viewport and not plan.cmc.behind
    assert json.loads(plan.cmc.complete_report)["copies"] == count
    if kind == "MESH":
        assert farthest(positions(plan.cmc.f_plus), positions(plan.cmc.completed)) < 1e-4, "of the new shell"


def test_many_faces_are_behind_until_they_are_updated(recipe, monkeypatch):
    plan = solved("UNDULOID")
    assert bpy.ops.cmc.complete() == FINISHED
    assert not bpy.ops.cmc.update_all.poll(), "nothing is out of date"
    monkeypatch.setattr(recipe, "_QUICK", 10)
    plan.scale = (2.0, 2.0, 2.0)
    assert bpy.ops.cmc.solve() == FINISHED
    assert recipe.is_behind(plan)
    assert not plan.cmc.f_plus.hide_viewport and plan.cmc.completed.hide_viewport and plan.cmc.completed.hide_render
    assert "older shell" in text_of(draw("CMC_PT_results"))
    assert bpy.ops.cmc.update_all() == FINISHED
    assert not recipe.is_behind(plan) and not plan.cmc.completed.hide_viewport
    assert farthest(positions(plan.cmc.f_plus), positions(plan.cmc.completed)) < 1e-4


def test_live_makes_them_again_at_rest(addon):
    live = addon.cmc_addon.live.live
    plan = solved("UNDULOID")
    assert bpy.ops.cmc.complete() == FINISHED
    plan.cmc.live = True
    settle(live)
    plan.location.x += 1.0
    catch_up(live)
    plan.data.vertices[0].co.z += 0.0
    settle(live)
    assert not plan.cmc.completed.hide_viewport and not plan.cmc.behind
    assert farthest(positions(plan.cmc.f_plus), positions(plan.cmc.completed)) < 1e-4


def test_where_they_cannot_be_made_the_shell_is(recipe, capfd):
    plan = solved("UNDULOID")
    assert bpy.ops.cmc.complete(complete_extent="COUNT", complete_count=4) == FINISHED
    for group in plan.data.cmc.groups:
        group.across = "OFF"
    assert bpy.ops.cmc.solve() == FINISHED
    assert "The shell was not repeated: " in capfd.readouterr().out
    assert not plan.cmc.f_plus.hide_viewport and recipe.is_behind(plan)


def test_copies_that_are_deleted_are_forgotten(recipe):
    plan = solved("UNDULOID")
    assert bpy.ops.cmc.complete() == FINISHED
    bpy.data.objects.remove(plan.cmc.completed)
    assert bpy.ops.cmc.solve() == FINISHED
    assert plan.cmc.completed is None and not plan.cmc.f_plus.hide_viewport and not recipe.is_behind(plan)
