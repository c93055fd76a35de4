"""Links between a plan and its results: names, collections, duplicates, deletions, visibility."""

from __future__ import annotations

import bpy

# isort: split
import numpy as np
import pytest
from numpy.testing import assert_allclose

from .result_plans import solve, tilted
from .scenes import activate, positions, quad_disc


def test_names_and_collection():
    plan = tilted(quad_disc("Hall"))
    solve(plan, want_twin=True, want_g=True, want_gauss=True)
    collection = bpy.data.collections["CMC Hall"]
    names = {"Hall f+", "Hall f-", "Hall g", "Hall Gauss image"}
    assert {ob.name for ob in collection.objects} == names
    assert {ob.data.name for ob in collection.objects} == names
    assert plan.name not in collection.objects
    assert collection.name in bpy.context.scene.collection.children
    assert bpy.context.view_layer.objects.active == plan


def test_only_what_is_wanted():
    plan = tilted(quad_disc())
    solve(plan)
    assert {ob.name for ob in bpy.data.objects} == {"Disc", "Disc f+"}
    solve(plan, sheet="F_MINUS")
    assert {ob.name for ob in bpy.data.objects if not ob.hide_viewport} == {"Disc", "Disc f-"}


def test_unwanted_results_are_hidden_and_come_back():
    plan = quad_disc()
    solve(plan, want_g=True)
    g = plan.cmc.g
    solve(plan, want_g=False, size="HEIGHT", height=1.0)
    assert (g.hide_viewport, g.hide_render) == (True, True)
    hidden = positions(g)
    solve(plan, want_g=True)
    assert (g.hide_viewport, g.hide_render) == (False, False)
    assert_allclose(positions(g), hidden, rtol=0, atol=1e-6)  # it was kept up to date


def test_a_result_hidden_by_the_user_stays_hidden():
    plan = quad_disc()
    solve(plan).hide_viewport = True
    assert solve(plan).hide_viewport


def test_renaming_breaks_nothing():
    plan = quad_disc()
    result = solve(plan)
    plan.name, result.name, bpy.data.collections["CMC Disc"].name = "Market", "Roof", "Shells"
    result.data.name = "Skin"
    assert solve(plan, size="HEIGHT", height=2.0) == result
    assert (result.name, result.data.name) == ("Roof", "Skin")
    assert {ob.name for ob in bpy.data.objects} == {"Market", "Roof"}
    assert [c.name for c in bpy.data.collections] == ["Shells"]
    assert np.ptp(positions(result)[:, 2]) == pytest.approx(2.0, rel=1e-5)


def duplicate(*objects) -> list:
    bpy.ops.object.select_all(action="DESELECT")
    for ob in objects:
        ob.select_set(True)
    activate(objects[0])
    bpy.ops.object.duplicate()
    return list(bpy.context.selected_objects)


def test_a_duplicated_plan_gets_its_own_results():
    plan = quad_disc()
    result = solve(plan)
    (copy,) = duplicate(plan)
    assert copy.cmc.f_plus == result  # Blender copies the link
    before = positions(result)
    own = solve(copy, size="HEIGHT", height=1.0)
    assert own != result
    assert own.cmc.source == copy
    assert copy.cmc.collection != plan.cmc.collection
    assert_allclose(positions(result), before, rtol=0, atol=0)
    assert solve(plan) == result
    assert {ob.name for ob in bpy.data.objects} == {"Disc", "Disc f+", "Disc.001", "Disc.001 f+"}


def test_a_linked_duplicate_of_a_plan_too():
    """Its mesh and so its groups are shared, its settings and results are its own."""
    plan = quad_disc()
    result = solve(plan)
    bpy.ops.object.select_all(action="DESELECT")
    plan.select_set(True)
    bpy.ops.object.duplicate(linked=True)
    (copy,) = bpy.context.selected_objects
    copy.location.x = 20.0
    own = solve(copy)
    assert own != result
    assert_allclose(positions(own), positions(result) + [20.0, 0.0, 0.0], rtol=0, atol=1e-4)


def test_plan_and_results_duplicated_together():
    plan = quad_disc()
    result = solve(plan)
    copies = duplicate(plan, result)
    copy = next(ob for ob in copies if ob.cmc.role == "NONE")
    own = next(ob for ob in copies if ob.cmc.role == "F_PLUS")
    before = positions(result)
    assert solve(copy, size="HEIGHT", height=1.0) == own
    assert np.ptp(positions(own)[:, 2]) == pytest.approx(1.0, rel=1e-5)
    assert_allclose(positions(result), before, rtol=0, atol=0)


def test_a_duplicated_result_is_a_copy():
    plan = quad_disc()
    result = solve(plan)
    (copy,) = duplicate(result)
    before = positions(copy)
    activate(copy)
    bpy.ops.cmc.solve(size="HEIGHT", height=1.0)
    assert_allclose(positions(copy), before, rtol=0, atol=0)
    assert np.ptp(positions(result)[:, 2]) == pytest.approx(1.0, rel=1e-5)
    assert len(bpy.data.objects) == 3


@pytest.mark.parametrize("how", ["operator", "data", "unlinked"])
def test_a_deleted_result_is_made_again(how):
    plan = quad_disc()
    result = solve(plan)
    mesh = result.data
    if how == "operator":
        bpy.ops.object.select_all(action="DESELECT")
        result.select_set(True)
        bpy.ops.object.delete()
    elif how == "data":
        bpy.data.objects.remove(result)
        bpy.data.meshes.remove(mesh)
    else:
        bpy.data.collections["CMC Disc"].objects.unlink(result)
    again = solve(plan)
    assert again.users_scene
    assert [ob.name for ob in bpy.data.objects] == ["Disc", "Disc f+"]
    assert [mesh.name for mesh in bpy.data.meshes] == ["Disc", "Disc f+"]


def test_a_deleted_plan_leaves_its_result():
    plan = quad_disc()
    result = solve(plan)
    before = positions(result)
    bpy.data.objects.remove(plan)
    assert_allclose(positions(result), before, rtol=0, atol=0)
    activate(result)
    with pytest.raises(RuntimeError, match="plan has been deleted"):
        bpy.ops.cmc.solve()


def test_a_deleted_collection_is_made_again():
    plan = tilted(quad_disc())
    result = solve(plan)
    bpy.context.scene.collection.objects.link(result)
    bpy.data.collections.remove(bpy.data.collections["CMC Disc"])
    solve(plan, want_twin=True)
    assert plan.cmc.f_plus == result
    assert [c.name for c in result.users_collection] == ["Scene Collection"]
    assert [c.name for c in plan.cmc.f_minus.users_collection] == ["CMC Disc"]


def test_a_result_moved_to_another_collection_stays_there():
    plan = quad_disc()
    result = solve(plan)
    roofs = bpy.data.collections.new("Roofs")
    bpy.context.scene.collection.children.link(roofs)
    roofs.objects.link(result)
    plan.cmc.collection.objects.unlink(result)
    assert solve(plan) == result
    assert result.users_collection == (roofs,)


def test_a_degenerate_twin_is_not_made():
    plan = quad_disc(rings=12, columns=48)
    solve(plan, want_twin=True)
    assert plan.cmc.f_minus is None
    assert [ob.name for ob in bpy.data.objects] == ["Disc", "Disc f+"]


def test_a_twin_that_has_become_a_point_is_deleted():
    plan = tilted(quad_disc(rings=12, columns=48), first=16)
    solve(plan, want_twin=True)
    assert plan.cmc.f_minus is not None
    plan.data.cmc.groups[0].tilt = 0.0
    solve(plan)
    assert plan.cmc.f_minus is None
    assert [ob.name for ob in bpy.data.objects] == ["Disc", "Disc f+"]
    assert [mesh.name for mesh in bpy.data.meshes] == ["Disc", "Disc f+"]
