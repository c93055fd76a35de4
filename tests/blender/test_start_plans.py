"""Ordinary plans of Add > Mesh > CMC: Add and Solve with nothing set in between."""

from __future__ import annotations

import json

import bpy
import numpy as np
import pytest

FINISHED = {"FINISHED"}
SHAPES = ["RECTANGLE", "ROUND", "L_SHAPE", "COURT"]


def report(plan) -> dict:
    return json.loads(plan.cmc.report)


@pytest.mark.parametrize("shape", SHAPES)
def test_solve_needs_nothing_else(shape):
    assert bpy.ops.cmc.add_plan(shape=shape) == FINISHED
    plan = bpy.context.object
    assert plan.select_get() and not plan.data.cmc.groups and plan.cmc.default_kind == "LINE"
    assert bpy.ops.cmc.solve() == FINISHED
    reported = report(plan)
    shown = reported["sheets"][reported["sheet"]]
    assert reported["converged"] and not reported["is_open"] and shown["overhang"]["area_share"] < 0.01
    assert not shown["intersections"]["count"] and {note["code"] for note in reported["warnings"]} <= {"point"}
    assert shown["outline"]["max"] < 1e-3 * shown["span"]
    assert 0.05 * shown["span"] < shown["rise"] < 0.35 * shown["span"]


def test_the_round_plan_has_a_cap_of_a_sphere_on_its_outline():
    """Of height 0.35 over the radius 5."""
    bpy.ops.cmc.add_plan(shape="ROUND", columns=32)
    bpy.ops.cmc.solve()
    reported = report(bpy.context.object)
    shown = reported["sheets"][reported["sheet"]]
    np.testing.assert_allclose(shown["rise"], 0.35 * 5.0, rtol=0.03)
    np.testing.assert_allclose(reported["mean_curvature"] * 5.0, 2 * 0.35 / (1 + 0.35**2), rtol=0.03)


@pytest.mark.parametrize("shape", SHAPES)
def test_sizes_are_metres(shape):
    bpy.ops.cmc.add_plan(shape=shape, columns=16, size=5.0)
    assert abs(max(bpy.context.object.dimensions) - 5.0) < 0.02


@pytest.mark.parametrize(("operator", "given"), [
    ("add_module", {"slenderness": np.nan}), ("add_module", {"size": np.nan}), ("add_bubble", {"slenderness": np.nan}),
    ("add_plan", {"width": np.nan}),
])
def test_a_script_that_gives_no_number(operator, given):
    with pytest.raises(RuntimeError, match=r"Error: (Slenderness|Size|Width) is not a number"):
        getattr(bpy.ops.cmc, operator)(**({"bubble": "RING"} if operator == "add_bubble" else {}), **given)
    assert not bpy.data.objects and not bpy.data.meshes


def test_mesh_plan_makes_it_finer_in_place():
    bpy.ops.cmc.add_plan(columns=16)
    plan = bpy.context.object
    before = len(plan.data.polygons)
    assert plan.name == "Rectangle"
    assert bpy.ops.cmc.mesh_plan(edge_length=0.3) == FINISHED
    assert bpy.context.object == plan and len(plan.data.polygons) > 2 * before


def test_they_come_first_in_the_menu():
    from cmc_formfinding.cmc_addon.operators import add_plan

    bpy.ops.cmc.add_plan()
    assert bpy.context.object.name == "Rectangle"
    assert bpy.types.CMC_MT_add.draw._draw_funcs[0] == add_plan.first_in_add_menu
