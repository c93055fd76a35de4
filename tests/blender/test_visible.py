"""A result that cannot be seen is linked where the plan is, or a warning says where it is."""

from __future__ import annotations

import bpy
import pytest

from .scenes import activate, quad_disc

FINISHED = {"FINISHED"}


@pytest.fixture
def plan():
    return quad_disc()


def second_scene(plan) -> bpy.types.Scene:
    scene = bpy.data.scenes.new("Two")
    scene.collection.objects.link(plan)
    bpy.context.window.scene = scene
    activate(plan)
    return scene


def test_a_plan_in_a_second_scene(plan, capfd):
    bpy.ops.cmc.solve()
    first, shell = bpy.context.scene, plan.cmc.f_plus
    scene = second_scene(plan)
    assert bpy.ops.cmc.solve() == FINISHED
    assert shell.name in scene.objects and shell.name in first.objects and plan.cmc.f_plus == shell
    assert [c.name for c in bpy.data.collections] == [f"CMC {plan.name}"], "one collection, in both scenes"
    assert "cannot be seen" not in capfd.readouterr().out


def test_a_result_that_was_moved_out_of_the_collection(plan):
    bpy.ops.cmc.solve()
    shell, first = plan.cmc.f_plus, bpy.context.scene
    first.collection.objects.link(shell)
    bpy.data.collections.remove(plan.cmc.collection)
    scene = second_scene(plan)
    assert bpy.ops.cmc.solve() == FINISHED and plan.cmc.f_plus == shell and shell.name in scene.objects


@pytest.mark.parametrize("made_as", ["MESH", "INSTANCES"])
def test_copies_in_a_second_scene(made_as):
    bpy.ops.cmc.add_module(module="HONEYCOMB", edges=6)
    plan = bpy.context.object
    bpy.ops.cmc.complete(complete_count=4, complete_as=made_as)
    scene = second_scene(plan)
    assert bpy.ops.cmc.complete(complete_count=4, complete_as=made_as) == FINISHED
    shown = [ob for ob in scene.objects if ob.cmc.role == "COMPLETED"]
    assert len(shown) == (1 if made_as == "MESH" else 4) and all(ob.visible_get() for ob in shown)


def layer_of(plan) -> bpy.types.LayerCollection:
    return bpy.context.view_layer.layer_collection.children[plan.cmc.collection.name]


def exclude(plan):
    layer_of(plan).exclude = True


def close_eye(plan):
    layer_of(plan).hide_viewport = True


def disable(plan):
    plan.cmc.collection.hide_viewport = True


def hide(plan):
    plan.cmc.f_plus.hide_set(True)


@pytest.mark.parametrize(("how", "told"), [
    (exclude, "its collection 'CMC Disc' is excluded from 'ViewLayer'; tick it in the Outliner"),
    (close_eye, "its collection 'CMC Disc' is hidden; click its eye"),
    (disable, "its collection 'CMC Disc' is hidden; click its eye"),
    (hide, "it is hidden; click its eye in the Outliner, or press Alt H"),
])
def test_hidden_results_are_told(plan, capfd, how, told):
    bpy.ops.cmc.solve()
    assert "cannot be seen" not in capfd.readouterr().out
    how(plan)
    activate(plan)
    assert bpy.ops.cmc.solve() == FINISHED
    assert f"'Disc f+' is there and cannot be seen: {told}" in capfd.readouterr().out


def test_mesh_plan_in_a_second_scene():
    bpy.ops.mesh.primitive_plane_add(size=6.0)
    outline = bpy.context.object
    bpy.ops.cmc.mesh_plan(edge_length=1.0)
    scene = second_scene(outline)
    assert bpy.ops.cmc.mesh_plan(edge_length=1.0) == FINISHED
    assert outline.cmc.plan.name in scene.objects and outline.cmc.plan.visible_get()
