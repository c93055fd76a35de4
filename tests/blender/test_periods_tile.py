"""Repeat by Gaps: copies along the gap, one mesh or instances; counts; refusals."""

from __future__ import annotations

import json
from types import SimpleNamespace

import bpy
import numpy as np
import pytest
from numpy.testing import assert_allclose

from .scenes import activate, positions, quad_disc, snapshot, values
from .sidebar import draw, text_of
from .solved_modules import completion_report, farthest, is_oriented, matrices
from .test_periods import FINISHED, court, report, seams, uv_corners


@pytest.fixture
def plan():
    made = court()
    assert bpy.ops.cmc.solve() == FINISHED
    return made


def period(plan) -> np.ndarray:
    return np.array(report(plan)["holes"][0]["period"])


def test_three_periods_as_one_mesh(plan):
    shell, step = positions(plan.cmc.f_plus), period(plan)
    assert bpy.ops.cmc.tile_periods(tile_repeat=(3, 1, 1)) == FINISHED
    whole, p = plan.cmc.completed, positions(plan.cmc.completed)
    for k in range(3):
        assert min(farthest(shell + s * k * step, p) for s in (1, -1)) < 1e-4
    count, seam = len(shell), len(shell) - len(plan.data.vertices)
    assert len(p) == 3 * count - 2 * seam, "each vertex of a cut is welded to its neighbour's"
    assert is_oriented(whole.data)
    done = completion_report(plan)
    assert done["copies"] == 3 and done["relative_gap"] < 1e-9, "the seam joins by itself"
    assert plan.cmc.f_plus.hide_viewport and not whole.hide_viewport
    assert tuple(plan.cmc.tile_repeat) == (3, 1, 1) and plan.cmc.tile_as == "MESH"


def test_copies_are_reported_and_the_gap_is_no_warning(plan, addon):
    hand = hand_for(addon.cmc_addon.operators.periods)
    assert hand.execute(bpy.context) == FINISHED
    ((kind, text),) = hand.reports
    assert kind == {"INFO"} and "3 copies" in text and "does not close" not in text


def hand_for(operators):
    """Stands for the operator that Blender makes."""
    operator = operators.CMC_OT_tile_periods

    class Made(operators.ShellOperator):
        bl_label, read_task = operator.bl_label, operator.read_task
        tile_as, tile_repeat = "MESH", (3, 1, 1)
        properties = SimpleNamespace(is_property_set=lambda name: False)

        def __init__(self):
            self.reports = []

        def report(self, kind, text):
            self.reports.append((kind, text))

    return Made()


def test_the_gap_of_the_module_is_no_error_of_the_copies(plan):
    assert bpy.ops.cmc.tile_periods() == FINISHED
    record = draw("CMC_PT_results")
    assert text_of(record).startswith("Done. The shell is repeated.") and not record.operators
    assert "gap" not in " ".join(record.texts).lower() and "open by" not in " ".join(record.texts)


def test_layers_go_over_the_cuts():
    plan = court()
    plan.data.attributes.new("source", "INT", "POINT").data.foreach_set("value", np.arange(len(plan.data.vertices)))
    assert bpy.ops.cmc.tile_periods(tile_repeat=(2, 1, 1)) == FINISHED
    whole = plan.cmc.completed.data
    assert uv_corners(whole) == uv_corners(plan.data)
    assert seams(whole) == seams(plan.data)
    normals = np.array(values(whole.attributes["cmc_normal"]))
    for polygon in whole.polygons:
        assert normals[list(polygon.vertices)].sum(axis=0) @ np.array(polygon.normal) > 0


def test_instances_lie_where_the_mesh_does(plan):
    assert bpy.ops.cmc.tile_periods(tile_repeat=(3, 1, 1), tile_as="MESH") == FINISHED
    whole = positions(plan.cmc.completed)
    assert bpy.ops.cmc.tile_periods(tile_as="INSTANCES") == FINISHED
    assert plan.cmc.completed is None and len(plan.cmc.copies.objects) == 3
    shifts = matrices(plan)[:, :3, 3]
    steps = np.diff(shifts[np.argsort(np.linalg.norm(shifts - shifts[0], axis=1))], axis=0)
    assert_allclose(np.abs(steps), np.abs([period(plan)] * 2), atol=1e-5)
    points = np.concatenate([positions(ob) for ob in plan.cmc.copies.objects])
    assert farthest(whole, points) < 1e-4 and farthest(points, whole) < 1e-4
    assert bpy.ops.cmc.tile_periods(tile_as="MESH") == FINISHED and plan.cmc.copies is None


def test_counts_before_it_runs(plan, addon):
    counts = addon.cmc_addon.tasks.tile.tile_counts
    assert counts(plan, 1, (5, 9, 9)) == (5, 5 * len(plan.data.polygons)), "there is one hole"
    assert counts(plan, 2, (5, 3, 9))[0] == 15 and counts(plan, 5, (2, 2, 2))[0] == 8
    with pytest.raises(Exception, match="That makes 1000000 copies"):
        counts(plan, 2, (1000, 1000, 1))


def test_a_range_of_the_lattice_of_two_holes():
    made = two_courts()
    assert bpy.ops.cmc.solve(keep_closed=False) == FINISHED
    holes = report(made)["holes"]
    assert [hole["name"] for hole in holes] == ["hole 1", "hole 2"]
    assert bpy.ops.cmc.tile_periods(tile_repeat=(2, 3, 1), tile_as="INSTANCES") == FINISHED
    shifts = matrices(made)[:, :3, 3] - matrices(made)[0, :3, 3]
    numbers = np.linalg.lstsq(np.array([hole["period"] for hole in holes]).T, shifts.T, rcond=None)[0].T
    assert_allclose(numbers, np.round(numbers), atol=1e-4)
    assert {tuple(np.abs(row)) for row in np.round(numbers).astype(int)} == {(i, j) for i in range(2) for j in range(3)}


def two_courts():
    """Mesh Plan over an outline with two holes."""
    from .scenes import mesh_object

    boxes = [(0, 0, 14, 8), (3, 3, 5, 5), (9, 2.5, 12, 5)]
    loops = [[(a, b), (c, b), (c, d), (a, d)] for a, b, c, d in boxes]
    points = [(x, y, 0.0) for loop in loops for x, y in loop]
    edges = [(4 * k + j, 4 * k + (j + 1) % 4) for k in range(3) for j in range(4)]
    mesh_object("Two", points, [], edges=edges)
    assert bpy.ops.cmc.mesh_plan(edge_length=1.0, corner_radius=0.9) == FINISHED
    made = bpy.context.object
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.select_all(action="SELECT")
    bpy.ops.cmc.group_add(name="Rim", kind="BINORMAL", tilt=0.7, assign=True)
    bpy.ops.object.mode_set(mode="OBJECT")
    return made


def refused(message: str, **options) -> None:
    before = snapshot()
    with pytest.raises(RuntimeError, match=message):
        bpy.ops.cmc.tile_periods(**options)
    assert snapshot() == before


def test_a_shell_that_is_kept_closed_is_opened_and_tiled(plan):
    opened = positions(plan.cmc.f_plus)
    assert bpy.ops.cmc.solve(keep_closed=True) == FINISHED
    assert bpy.ops.cmc.tile_periods() == FINISHED
    assert not plan.cmc.keep_closed and completion_report(plan)["copies"] == 3
    assert_allclose(positions(plan.cmc.f_plus), opened, atol=1e-6)


def test_a_shell_that_closes_by_itself_is_not_tiled():
    quad_disc()
    bpy.context.object.data.cmc.groups.clear()
    refused("so it has no periods to repeat by")


def test_too_many(plan):
    made = two_courts()
    assert bpy.ops.cmc.solve() == FINISHED
    refused("That makes 250000 copies", tile_repeat=(500, 500, 1))
    activate(made)


@pytest.mark.parametrize("kind", ["MESH", "INSTANCES"])
def test_undo(plan, kind):
    bpy.ops.ed.undo_push(message="solved")
    before = snapshot()
    bpy.ops.cmc.tile_periods("EXEC_DEFAULT", True, tile_as=kind)
    assert snapshot() != before
    bpy.ops.ed.undo()
    assert snapshot() == before


# --- Add > Mesh > CMC --------------------------------------------------------------------------


def test_an_annulus_is_solved_and_closed():
    assert bpy.ops.cmc.add_plan(shape="ANNULUS", columns=40) == FINISHED
    plan = bpy.context.object
    assert {group.name for group in plan.data.cmc.groups} == {"Outer", "Inner"}
    assert bpy.ops.cmc.solve() == FINISHED
    assert report(plan)["closing"]["closed"] and report(plan)["closing"]["gap_before"] > 0.02
    place, drawn = positions(plan), np.array(values(plan.data.attributes["Plan"]))
    corners = [loop.vertex_index for loop in plan.data.loops]
    assert_allclose(drawn, place[corners][:, :2], atol=1e-5)


def test_a_cylinder_is_a_long_strip():
    """Its normals wind along both ends: a period along the axis; three copies are tiled without a gap."""
    assert bpy.ops.cmc.add_plan(shape="CYLINDER", columns=32) == FINISHED
    plan = bpy.context.object
    assert bpy.ops.cmc.solve() == FINISHED
    told_period = period(plan)
    assert np.linalg.norm(told_period) > 0.2 * report(plan)["sheets"]["f+"]["span"]
    assert bpy.ops.cmc.tile_periods(tile_repeat=(3, 1, 1)) == FINISHED
    assert completion_report(plan)["relative_gap"] < 1e-9 and completion_report(plan)["copies"] == 3
    points = positions(plan.cmc.completed)
    assert np.ptp(points, axis=0).max() > 2.0 * np.linalg.norm(told_period)


def test_uvs_of_a_cylinder_are_unrolled():
    """Every face has its own shape in the texture; the seam is where the ends of the strip meet."""
    assert bpy.ops.cmc.add_plan(shape="CYLINDER", columns=24, size=3.0) == FINISHED
    mesh = bpy.context.object.data
    uv = np.array(values(mesh.attributes["Plan"])).reshape(-1, 3, 2)
    place = positions(bpy.context.object)[[loop.vertex_index for loop in mesh.loops]].reshape(-1, 3, 3)
    for flat, solid in zip(uv, place, strict=True):
        sides = [np.linalg.norm(np.roll(p, 1, axis=0) - p, axis=1) for p in (flat, solid)]
        assert_allclose(sides[0], sides[1], rtol=0.02)
    marked = [edge for edge in mesh.edges if edge.use_seam]
    assert marked and all(abs(mesh.vertices[v].co.y) < 0.2 for edge in marked for v in edge.vertices)


def test_sizes_and_what_is_wrong():
    assert bpy.ops.cmc.add_plan(shape="ANNULUS", size=10.0, hole=0.5, offset=0.3) == FINISHED
    points = positions(bpy.context.object)
    assert_allclose(np.ptp(points[:, :2], axis=0), [10.0, 10.0], rtol=0.01)
    bpy.context.scene.cursor.location = (1.0, 2.0, 3.0)
    assert bpy.ops.cmc.add_plan(shape="CYLINDER") == FINISHED
    assert_allclose(bpy.context.object.location, (1.0, 2.0, 3.0))
    before = json.dumps(sorted(ob.name for ob in bpy.data.objects))
    bpy.ops.object.mode_set(mode="EDIT")
    with pytest.raises(RuntimeError, match="Leave edit mode"):
        bpy.ops.cmc.add_plan()
    bpy.ops.object.mode_set(mode="OBJECT")
    assert json.dumps(sorted(ob.name for ob in bpy.data.objects)) == before
