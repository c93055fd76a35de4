"""Solve from groups and Solve from Selection: each boundary edge follows its own condition."""

from __future__ import annotations

import bpy

# isort: split
import numpy as np
import pytest
from numpy.testing import assert_allclose

from .scenes import activate, add_group, boundary_edges, positions, quad_disc, values
from .solved_plans import solved


def test_groups_of_every_kind():
    """Normals at the rim are what the groups say; boundary edges in no group are vertical."""
    plan = quad_disc(rings=8, columns=32)
    edges = {frozenset(e.vertices): e.index for e in plan.data.edges}
    rim = [edges[frozenset((225 + k, 225 + (k + 1) % 32))] for k in range(32)]
    add_group(plan, "Plane", rim[0:4], "PLANE", normal=(0.6, 0.0, 0.8))
    add_group(plan, "Tilt", rim[8:12], "BINORMAL", tilt=np.pi / 6)
    add_group(plan, "Free", rim[16:20], "FREE")
    solved(plan)
    normals = np.array(values(plan.cmc.f_plus.data.attributes["cmc_normal"]))[225:]
    assert_allclose(normals[1:4], [(0.6, 0.0, 0.8)] * 3, rtol=0, atol=1e-5)
    assert_allclose(normals[9:12, 2], 0.5, rtol=0, atol=1e-5)
    assert_allclose(normals[24:31, 2], 0.0, rtol=0, atol=1e-5)
    assert (np.abs(normals[17:20, 2]) > 1e-3).all()


def select(plan, edges) -> None:
    for edge in plan.data.edges:
        edge.select = edge.index in edges


@pytest.mark.parametrize("kind, parameters", [
    ("BINORMAL", {"tilt": 0.6}), ("PLANE", {"normal": (0.0, 0.6, 0.8)})])
def test_solve_from_selection(kind, parameters):
    """With nothing set up: the same as a group of the selected boundary edges."""
    plan, other = quad_disc("One", rings=6), quad_disc("Other", rings=6)
    rim = boundary_edges(plan.data)
    add_group(other, "Group", rim[:7], kind, **parameters)
    expected = solved(other)
    select(plan, {*rim[:7].tolist(), 0, 1, 2})  # of the selection only the boundary counts
    activate(plan)
    bpy.ops.cmc.solve_selection(kind=kind, **parameters)
    assert_allclose(positions(plan.cmc.f_plus), expected, rtol=0, atol=1e-6)
    assert not plan.data.cmc.groups


def test_solve_from_selection_in_edit_mode():
    import bmesh

    plan = quad_disc(rings=6)
    rim = boundary_edges(plan.data)
    select(plan, {*rim[:7].tolist()})
    bpy.ops.cmc.solve_selection(tilt=0.6)
    expected = positions(plan.cmc.f_plus)
    bpy.ops.object.mode_set(mode="EDIT")
    bm = bmesh.from_edit_mesh(plan.data)
    bm.edges.ensure_lookup_table()
    for edge in bm.edges:
        edge.select = edge.index in rim[:7]
    bpy.ops.cmc.solve_selection(tilt=0.6)
    assert_allclose(positions(plan.cmc.f_plus), expected, rtol=0, atol=1e-6)


def test_selection_goes_before_groups():
    """Edges that are in a group and selected follow the selection, the group's others the group."""
    plan, other = quad_disc("One", rings=6), quad_disc("Other", rings=6)
    rim = boundary_edges(plan.data)
    add_group(plan, "All", rim, "BINORMAL", tilt=0.3)
    add_group(other, "First", rim[:7], "BINORMAL", tilt=0.6)
    add_group(other, "Rest", rim[7:], "BINORMAL", tilt=0.3)
    select(plan, set(rim[:7].tolist()))
    activate(plan)
    bpy.ops.cmc.solve_selection(tilt=0.6)
    assert_allclose(positions(plan.cmc.f_plus), solved(other), rtol=0, atol=1e-6)


def test_angles_of_neighbouring_groups_blend_over_a_length():
    """With a blend the normals at the rim turn gradually; without one they jump between two groups."""
    plan = quad_disc(rings=8, columns=64)
    half = [e for e in boundary_edges(plan.data) if plan.data.edges[e].vertices[0] % 64 < 32]
    add_group(plan, "Half", half, "BINORMAL", tilt=0.8)
    steps = []
    for blend in (0.0, 8.0):
        solved(plan, blend=blend)
        normals = np.array(values(plan.cmc.f_plus.data.attributes["cmc_normal"]))[-64:]
        steps.append(np.abs(np.diff(np.append(normals[:, 2], normals[0, 2]))).max())
    assert steps[0] > 0.3 and steps[1] < 0.15
