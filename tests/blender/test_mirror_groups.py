"""Mirrors as boundary groups: their planes, the corners between two of them, and what the panels show of both."""

from __future__ import annotations

import json

import bpy
import numpy as np
import pytest
from numpy.testing import assert_allclose

from .scenes import activate, positions
from .sidebar import draw, text_of
from .solved_modules import FINISHED, module, solved


def plane(which: str) -> np.ndarray:
    assert bpy.ops.cmc.group_plane(plane=which) == FINISHED
    mesh = bpy.context.object.data
    return np.array(mesh.cmc.groups[mesh.cmc.active_index].normal)


def corners(plan: bpy.types.Object) -> dict:
    from cmc_formfinding.cmc_addon.bridges import corner_bridge

    return {corner.vertex: corner for corner in corner_bridge.corners(plan.data)}


def normals(plan: bpy.types.Object) -> np.ndarray:
    return np.array([item.vector[:] for item in plan.cmc.f_plus.data.attributes["cmc_normal"].data])


def test_planes_by_axis_by_the_edges_and_turned_round():
    plan = module("HONEYCOMB")
    drawn = {group.name: np.array(group.normal) for group in plan.data.cmc.groups}
    for k, group in enumerate(plan.data.cmc.groups):
        plan.data.cmc.active_index = k
        assert_allclose(plane("X"), (1, 0, 0))
        assert_allclose(plane("FLIP"), (-1, 0, 0))
        assert_allclose(plane("Y"), (0, 1, 0))
        assert_allclose(plane("Z"), (0, 0, 1))
        assert_allclose(plane("EDGES"), drawn[group.name], atol=1e-6)


def test_the_plane_of_the_edges_is_that_of_the_world():
    plan = module("HONEYCOMB")
    plan.rotation_euler = (0.3, 0.4, 0.5)
    bpy.context.view_layer.update()
    turn = np.array(plan.matrix_world)[:3, :3]
    for mode in ("OBJECT", "EDIT"):
        bpy.ops.object.mode_set(mode=mode)
        plan.data.cmc.active_index = plan.data.cmc.groups.find("Bisector")
        assert_allclose(plane("EDGES"), turn @ [-np.sqrt(0.75), 0.5, 0], atol=1e-6)


def test_groups_without_a_plane_or_edges_are_refused():
    plan = module("HONEYCOMB")
    plan.data.cmc.groups[0].kind = "FREE"
    plan.data.cmc.active_index = 0
    with pytest.raises(RuntimeError, match="Group 'Axis' has no plane; make it a mirror"):
        bpy.ops.cmc.group_plane(plane="X")
    bpy.ops.cmc.group_add(name="Empty", kind="MIRROR")
    with pytest.raises(RuntimeError, match="Group 'Empty' has no edges on the boundary"):
        bpy.ops.cmc.group_plane(plane="EDGES")


@pytest.mark.parametrize("name", ["HONEYCOMB", "CAPITAL", "QUADRILATERAL"])
def test_corners_say_which_way_the_shell_faces(name):
    """In both modes, and as the solve then has it; at the inner corners of the capital, too."""
    plan = solved(name)
    mesh, N = plan.data, normals(plan)
    found = corners(plan)
    assert len(found) == len(mesh.cmc.groups)
    for vertex, corner in found.items():
        assert_allclose(N[vertex], corner.normal(mesh), atol=1e-6)
    bpy.ops.object.mode_set(mode="EDIT")
    assert corners(plan) == found


def test_a_corner_that_is_flipped_is_solved_so():
    plan = module("UNDULOID")
    mesh = plan.data
    names = {group.uid: group.name for group in mesh.cmc.groups}
    at = {frozenset(names[uid] for uid in corner.uids): vertex for vertex, corner in corners(plan).items()}
    vertex = at[frozenset(("End", "Floor"))]
    natural = corners(plan)[vertex].normal(mesh)
    assert bpy.ops.cmc.flip_corner(vertex=vertex) == FINISHED
    assert corners(plan)[vertex].flipped
    assert_allclose(corners(plan)[vertex].normal(mesh), -natural)
    bpy.ops.cmc.solve()
    assert_allclose(normals(plan)[vertex], -natural, atol=1e-6)
    bpy.ops.object.mode_set(mode="EDIT")
    assert corners(plan)[vertex].flipped
    assert bpy.ops.cmc.flip_corner(vertex=vertex) == FINISHED
    bpy.ops.object.mode_set(mode="OBJECT")
    assert not corners(plan)[vertex].flipped
    bpy.ops.cmc.solve()
    assert_allclose(normals(plan)[vertex], natural, atol=1e-6)


def test_mesh_plan_takes_mirrors_over():
    """Their normals, and where the completed shell is to end."""
    bpy.ops.mesh.primitive_plane_add(size=4.0)
    outline = bpy.context.object
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.select_all(action="SELECT")
    bpy.ops.cmc.group_add(name="Walls", kind="MIRROR", normal=(0.0, 1.0, 0.0), assign=True)
    outline.data.cmc.groups["Walls"].across = "OFF"
    bpy.ops.object.mode_set(mode="OBJECT")
    bpy.ops.cmc.mesh_plan(edge_length=0.5, corners="NONE")
    group = bpy.context.object.data.cmc.groups["Walls"]
    assert bpy.context.object != outline
    assert (group.kind, tuple(group.normal), group.across) == ("MIRROR", (0.0, 1.0, 0.0), "OFF")


def test_where_no_mirrors_meet_there_is_nothing_to_flip():
    plan = module("CAPITAL")
    inside = next(v.index for v in plan.data.vertices if v.index not in corners(plan))
    with pytest.raises(RuntimeError, match=f"No two mirrors meet at vertex {inside}; the corners"):
        bpy.ops.cmc.flip_corner(vertex=inside)


def test_the_panel_shows_the_plane_of_a_group_after_a_solve():
    plan = module("CAPITAL")
    plan.data.cmc.active_index = plan.data.cmc.groups.find("Right")
    before = draw("CMC_PT_boundary")
    assert "cmc.group_plane" in before.operators and "across" in before.props
    assert "Plane At" not in text_of(before)
    assert before.operators.count("cmc.flip_corner") == 2 and "At Back: faces +Z" in text_of(before)
    bpy.ops.cmc.solve()
    after = text_of(draw("CMC_PT_boundary"))
    assert "Plane At" in after and "Off Plane" in after
    report = json.loads(plan.cmc.report)
    right = next(plane for plane in report["planes"] if plane["name"] == "Right")
    rim = positions(plan.cmc.f_plus)[:, 0]
    assert_allclose(rim.max(), right["offset"], atol=1e-5)


def test_the_panel_of_symmetry_shows_counts_then_gaps():
    plan = module("UNDULOID")
    assert "Solve to see the number of copies" in text_of(draw("CMC_PT_symmetry"))
    bpy.ops.cmc.solve()
    assert f"24 Faces {24 * len(plan.data.polygons):,}" in text_of(draw("CMC_PT_symmetry"))
    bpy.ops.cmc.complete()
    assert "24 copies Seams" in text_of(draw("CMC_PT_symmetry"))
    activate(plan.cmc.completed)
    assert "24 copies Seams" in text_of(draw("CMC_PT_symmetry"))
    plan.cmc.complete_extent = "BOX"
    assert "No object is chosen for the box" in text_of(draw("CMC_PT_symmetry"))
    plan.cmc.complete_report = "not a report"
    draw("CMC_PT_symmetry")
    for group in plan.data.cmc.groups:
        group.kind = "BINORMAL"
    assert not draw("CMC_PT_symmetry").props
