"""Repeat by Symmetry: one welded mesh at the shell, the choice of copies, and the interplay with Solve."""

from __future__ import annotations

import json

import bpy
import numpy as np
import pytest
from mathutils.bvhtree import BVHTree
from numpy.testing import assert_allclose

from .scenes import activate, add_group, mesh_object, positions, snapshot, values
from .solved_modules import FINISHED, completion_report, faces_of, farthest, is_oriented, module, solved

# --- one mesh ----------------------------------------------------------------------------------


def test_the_mesh_lies_where_the_shell_is_and_repeats_it():
    plan = solved("HONEYCOMB")
    shell = positions(plan.cmc.f_plus)
    assert bpy.ops.cmc.complete(complete_repeat=(1, 1, 1)) == FINISHED
    whole = positions(plan.cmc.completed)
    assert farthest(shell, whole) < 1e-5
    planes = {plane["name"]: plane for plane in json.loads(plan.cmc.report)["planes"]}
    for name in ("Axis", "Floor", "Bisector", "End"):
        normal, offset = np.array(planes[name]["normal"]), planes[name]["offset"]
        assert (np.abs(whole @ normal - offset) < 1e-5).any()
    below = whole * [1, 1, -1] + [0, 0, -2 * planes["Floor"]["offset"]]
    assert farthest(below, whole) < 1e-4


def test_a_patch_of_honeycomb_goes_through_itself_nowhere():
    """By Blender's own test: no two triangles overlap that have no vertex in common."""
    plan = solved("HONEYCOMB", edges=14)
    assert bpy.ops.cmc.complete() == FINISHED
    mesh = plan.cmc.completed.data
    faces = faces_of(mesh)
    tree = BVHTree.FromPolygons([v.co for v in mesh.vertices], faces)
    pairs = [(a, b) for a, b in tree.overlap(tree) if a < b and not set(faces[a]) & set(faces[b])]
    assert len(faces) > 30_000 and pairs == []


def test_layers_materials_and_weights_are_on_every_copy():
    plan = module("CAPITAL")
    mesh = plan.data
    for k, name in enumerate(("Stone", "Glass")):
        mesh.materials.append(bpy.data.materials.new(name))
        mesh.polygons[-1 - k].material_index = k
    mesh.attributes.new("age", "INT", "FACE").data.foreach_set("value", np.arange(len(mesh.polygons)))
    mesh.attributes.new("warmth", "FLOAT", "POINT").data.foreach_set("value", np.arange(len(mesh.vertices)))
    plan.vertex_groups.new(name="Held").add([3], 0.5, "REPLACE")
    assert bpy.ops.cmc.complete(complete_repeat=(1, 1, 1)) == FINISHED
    whole, count = plan.cmc.completed.data, len(mesh.polygons)
    ages = np.array(values(whole.attributes["age"]))
    assert_allclose(ages.reshape(4, count), np.tile(np.arange(count), (4, 1)))
    assert values(whole.attributes["cmc_copy"]) == np.repeat(np.arange(4), count).tolist()
    assert [slot.material.name for slot in plan.cmc.completed.material_slots] == ["Stone", "Glass"]
    assert [polygon.material_index for polygon in whole.polygons][:count] == [p.material_index for p in mesh.polygons]
    warmth, drawn = (np.array(values(m.attributes["Plan"])) for m in (whole, mesh))
    assert_allclose(np.sort(warmth.reshape(4, -1, 2), axis=1), np.tile(np.sort(drawn, axis=0), (4, 1, 1)), atol=1e-6)
    sources = np.array(values(whole.attributes["warmth"])).astype(int)
    for face, drawn_face in zip(faces_of(whole)[count:], faces_of(mesh) * 3, strict=False):
        assert sorted(sources[list(face)]) == sorted(drawn_face)
    held = [v.index for v in whole.vertices if any(g.weight == 0.5 for g in v.groups)]
    assert set(sources[held]) == {3}
    assert len(values(whole.attributes["cmc_normal"])) == len(whole.vertices)
    H = json.loads(plan.cmc.report)["mean_curvature"]
    assert_allclose(np.median(values(whole.attributes["cmc_mean_curvature"])), H, rtol=0.1)


def test_quads_stay_quads():
    """A quarter of an unduloid as a grid of quads, cut along any diagonal."""
    columns, rows, length = 14, 6, 3.4
    x, y = np.meshgrid(np.linspace(0.0, length, columns + 1), np.linspace(0.0, 1.0, rows + 1))
    points = np.column_stack([x.ravel(), y.ravel(), np.zeros(x.size)])
    first = (np.arange(rows)[:, None] * (columns + 1) + np.arange(columns)).ravel()
    quads = np.column_stack([first, first + 1, first + columns + 2, first + columns + 1])
    plan = mesh_object("Grid", points, quads.tolist())
    walls = {"Axis": (0, -1, 0), "Floor": (0, 0, -1), "Start": (-1, 0, 0), "End": (1, 0, 0)}
    ends = np.array([[points[v] for v in edge.vertices] for edge in plan.data.edges])
    inside = {"Axis": ends[:, :, 1] < 1e-6, "Floor": ends[:, :, 1] > 1 - 1e-6,
              "Start": ends[:, :, 0] < 1e-6, "End": ends[:, :, 0] > length - 1e-6}  # fmt: skip
    for name, normal in walls.items():
        add_group(plan, name, np.flatnonzero(inside[name].all(axis=1)), "MIRROR", normal=normal)
    assert bpy.ops.cmc.complete() == FINISHED
    whole = plan.cmc.completed.data
    assert completion_report(plan)["copies"] == 8 and len(whole.polygons) == 8 * len(quads)
    assert {len(polygon.vertices) for polygon in whole.polygons} == {4} and is_oriented(whole)
    assert len(whole.vertices) == (2 * columns + 1) * 4 * rows


def test_uv_corners_stay_with_their_vertices():
    """The plan's UVs are plan coordinates: at a corner they are those of the vertex it comes from."""
    plan = module("CAPITAL")
    place = positions(plan)[:, :2]
    plan.data.attributes.new("source", "INT", "POINT").data.foreach_set("value", np.arange(len(place)))
    assert bpy.ops.cmc.complete() == FINISHED
    whole = plan.cmc.completed.data
    sources = np.array(values(whole.attributes["source"]))
    vertices = [loop.vertex_index for loop in whole.loops]
    assert_allclose(values(whole.attributes["Plan"]), place[sources[vertices]], atol=1e-5)


def test_normals_look_out_of_the_faces():
    for name in ("HONEYCOMB", "NODOID"):
        plan = solved(name)
        assert bpy.ops.cmc.complete(complete_repeat=(1, 1, 1)) == FINISHED
        mesh = plan.cmc.completed.data
        told_normals = np.array(values(mesh.attributes["cmc_normal"]))
        for polygon in mesh.polygons:
            assert told_normals[list(polygon.vertices)].sum(axis=0) @ np.array(polygon.normal) > 0


@pytest.mark.parametrize("turned", ["flip", "scale", "rotation", "f-"])
def test_plans_that_are_turned_and_shells_that_hang(turned):
    plan = module("HONEYCOMB")
    plan.location = (2.0, -1.0, 0.5)
    if turned == "flip":
        plan.cmc.flip = True
    elif turned == "f-":
        plan.cmc.sheet = "F_MINUS"
    else:
        if turned == "scale":
            plan.scale = (-1.0, 1.0, 1.0)
        else:
            plan.rotation_euler.z = 0.5
        bpy.context.view_layer.update()
        turn = np.array(plan.matrix_world)[:3, :3]
        for group in plan.data.cmc.groups:
            group.normal = turn @ np.array(group.normal)
    assert bpy.ops.cmc.complete(complete_repeat=(1, 1, 1)) == FINISHED
    role = "f_minus" if turned == "f-" else "f_plus"
    shell, whole = getattr(plan.cmc, role), plan.cmc.completed
    assert farthest(positions(shell), positions(whole)) < 1e-4 and is_oriented(whole.data)
    told_normals = np.array(values(whole.data.attributes["cmc_normal"]))
    for polygon in whole.data.polygons:
        assert told_normals[list(polygon.vertices)].sum(axis=0) @ np.array(polygon.normal) > 0


# --- which copies ------------------------------------------------------------------------------


def test_a_number_a_box_or_units():
    plan = solved("CAPITAL")
    assert bpy.ops.cmc.complete(complete_count=7) == FINISHED
    assert completion_report(plan)["copies"] == 7 and plan.cmc.complete_extent == "COUNT"
    bpy.ops.mesh.primitive_cube_add(size=1.0)
    box = bpy.context.object
    whole = plan.cmc.f_plus
    low, high = positions(whole).min(axis=0), positions(whole).max(axis=0)
    box.location, box.scale = 0.5 * (low + high), 3.0 * (high - low)
    activate(plan)
    assert bpy.ops.cmc.complete(box=box.name) == FINISHED
    assert completion_report(plan)["copies"] == 9 and plan.cmc.complete_box == box and plan.cmc.complete_extent == "BOX"
    assert bpy.ops.cmc.complete() == FINISHED
    assert completion_report(plan)["copies"] == 9, "what was chosen is kept with the plan"
    assert bpy.ops.cmc.complete(complete_extent="UNIT") == FINISHED
    assert completion_report(plan)["copies"] == 36


def test_the_panel_knows_the_counts_before_it_runs():
    from cmc_formfinding.cmc_addon.tasks.complete import CompleteTask, counts

    plan = module("HONEYCOMB")
    assert counts(plan, CompleteTask.stored(plan)) is None
    assert bpy.ops.cmc.solve() == FINISHED
    assert counts(plan, CompleteTask.stored(plan)) == (216, False)
    plan.cmc.complete_extent, plan.cmc.complete_count = "COUNT", 19_000
    assert counts(plan, CompleteTask.stored(plan)) == (19_000, False)
    plan.cmc.complete_count = 50
    assert counts(plan, CompleteTask.stored(plan)) == (50, False)
    assert bpy.ops.cmc.complete() == FINISHED
    assert len(plan.cmc.completed.data.polygons) == 50 * len(plan.data.polygons)
    bpy.ops.mesh.primitive_cube_add(size=20.0)
    plan.cmc.complete_extent, plan.cmc.complete_box = "BOX", bpy.context.object
    activate(plan)
    inside, more = counts(plan, CompleteTask.stored(plan))
    assert bpy.ops.cmc.complete() == FINISHED
    assert not more and inside == completion_report(plan)["copies"] > 10
    plan.cmc.complete_box.scale = (20.0, 20.0, 20.0)
    bpy.context.view_layer.update()
    assert counts(plan, CompleteTask.stored(plan)) == (400, True)


def test_a_finite_group_has_no_more_copies_than_it_has():
    """A corner of three mirrors: eight, whatever number is set."""
    from cmc_formfinding.cmc_addon.tasks.complete import CompleteTask, counts

    plan = solved("UNDULOID")
    plan.data.cmc.groups["End"].across = "OFF"
    plan.cmc.complete_extent, plan.cmc.complete_count = "COUNT", 5000
    assert counts(plan, CompleteTask.stored(plan)) == (8, False)
    assert bpy.ops.cmc.complete() == FINISHED
    assert completion_report(plan)["copies"] == 8


def test_a_side_that_ends_the_shell():
    plan = solved("UNDULOID")
    plan.data.cmc.groups["End"].across = "OFF"
    plan.data.cmc.groups["Bisector"].across = "OFF"
    assert bpy.ops.cmc.complete() == FINISHED
    assert completion_report(plan)["copies"] == 4, "the tube ends after half a period"


# --- together with Solve -----------------------------------------------------------------------


def test_a_plan_that_was_changed_is_solved_first():
    plan = module("UNDULOID")
    assert bpy.ops.cmc.complete() == FINISHED
    first = positions(plan.cmc.completed)
    assert plan.cmc.f_plus is not None
    plan.cmc.size, plan.cmc.span = "SPAN", 12.0
    assert bpy.ops.cmc.complete() == FINISHED
    assert_allclose(json.loads(plan.cmc.report)["sheets"]["f+"]["span"], 12.0, rtol=1e-6)
    assert np.ptp(positions(plan.cmc.completed), axis=0)[0] > 1.5 * np.ptp(first, axis=0)[0]


def test_the_shell_that_is_shown_is_not_solved_again(monkeypatch):
    plan = solved("UNDULOID")
    from cmc_formfinding.solver.shells import form

    monkeypatch.setattr(form, "form", lambda *a, **k: pytest.fail("solved again"))
    assert bpy.ops.cmc.complete() == FINISHED
    activate(plan.cmc.completed)
    assert bpy.ops.cmc.complete() == FINISHED, "with the result active, too"


@pytest.mark.parametrize("kind", ["MESH", "INSTANCES"])
def test_undo(kind):
    plan = solved("UNDULOID")
    name = plan.name
    bpy.ops.ed.undo_push(message="solved")
    before = snapshot()
    bpy.ops.cmc.complete("EXEC_DEFAULT", True, complete_as=kind)
    assert snapshot() != before
    bpy.ops.ed.undo()
    assert snapshot() == before
    assert bpy.data.objects[name].cmc.completed is None


# --- what cannot be done -----------------------------------------------------------------------


def refused(message: str, **options) -> None:
    before = snapshot()
    with pytest.raises(RuntimeError, match=message):
        bpy.ops.cmc.complete(**options)
    assert snapshot() == before


def test_without_a_mirror_or_a_plane_nothing_repeats():
    plan = solved("UNDULOID")
    for group in plan.data.cmc.groups:
        group.across = "OFF"
    refused("There is no side to continue across")
    for group in plan.data.cmc.groups:
        group.kind = "BINORMAL"
    refused("There is no side to continue across")


def test_sides_that_contradict_each_other_are_named():
    plan = module("CAPITAL")
    for name, normal in (("Front", (0.0, -1.0, 0.0)), ("Right", (0.8, -0.6, 0.0))):
        plan.data.cmc.groups[name].normal = normal
    assert bpy.ops.cmc.solve() == FINISHED
    refused("'Front' and 'Right' meet at vertex .* copies never close up")


def test_boxes_that_hold_nothing():
    plan = solved("CAPITAL")
    refused("No object is chosen for the box", complete_extent="BOX")
    refused("There is no object 'Crate' for the box", box="Crate")
    far = bpy.data.objects.new("Far", bpy.data.meshes.new("Far"))
    far.data.from_pydata([(900, 900, 900), (901, 901, 901)], [], [])
    bpy.context.scene.collection.objects.link(far)
    refused("No copy has its centre in the box", box="Far")
    activate(plan)


def test_edit_mode_is_refused():
    solved("CAPITAL")
    bpy.ops.object.mode_set(mode="EDIT")
    with pytest.raises(RuntimeError, match="Leave edit mode"):
        bpy.ops.cmc.complete()
