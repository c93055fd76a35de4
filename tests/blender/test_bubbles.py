"""Add > Mesh > CMC: Wente's cylinder and torus and the honeycomb ring, solved and completed as added."""

from __future__ import annotations

import json

import bpy

# isort: split
import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.spatial import KDTree

from .scenes import activate, boundary_edges, positions, snapshot
from .sidebar import draw


def add(bubble: str, **settings):
    assert bpy.ops.cmc.add_bubble(bubble=bubble, **settings) == {"FINISHED"}
    return bpy.context.object


def solved(plan, **settings) -> dict:
    activate(plan)
    assert bpy.ops.cmc.solve(**settings) == {"FINISHED"}
    reported = json.loads(plan.cmc.report)
    assert reported["converged"] and not reported["is_open"]
    return reported


def completed(plan) -> dict:
    activate(plan)
    assert bpy.ops.cmc.complete() == {"FINISHED"}
    return json.loads(plan.cmc.complete_report)


def doubled(ob) -> float:
    """The share of vertices that coincide with another one, as on a surface that crosses itself."""
    at = positions(ob)
    return float((KDTree(at).query(at, k=2)[0][:, 1] < 1e-3).mean())


def euler(mesh) -> int:
    return len(mesh.vertices) - len(mesh.edges) + len(mesh.polygons)


@pytest.mark.parametrize(("angle", "columns", "copies"), [(120.0, 12, 24), (90.0, 20, 16)])
def test_a_wente_cylinder_is_completed_to_a_torus(addon, angle, columns, copies):
    plan = add("WENTE", angle=np.radians(angle), columns=columns)
    assert [group.name for group in plan.data.cmc.groups] == ["Mirror", "Free", "Bottom", "Top"]
    solved(plan)
    reported, torus = completed(plan), plan.cmc.completed
    assert reported["copies"] == copies and reported["is_closed"] and reported["relative_gap"] < 2e-3
    assert euler(torus.data) == 0 and not len(boundary_edges(torus.data))
    assert_allclose(max(torus.dimensions), 8.0, rtol=0.15, atol=0)
    assert doubled(torus) < 0.1  # no copy lies on another one


def test_where_the_torus_never_closes_there_is_a_cylinder(addon):
    plan = add("WENTE", angle=2.0, columns=12)
    assert {group.name: group.across for group in plan.data.cmc.groups}["Bottom"] == "OFF"
    solved(plan)
    reported = completed(plan)
    assert reported["copies"] == 4 and not reported["lattice"]
    assert euler(plan.cmc.completed.data) == 0 and len(boundary_edges(plan.cmc.completed.data))


@pytest.mark.parametrize("height", [0.8, 1.25])
def test_at_another_height_there_is_a_strip_of_bubbles(addon, height):
    """Figure 13: a row of bubbles of any length."""
    plan = add("WENTE", height=height)
    assert tuple(plan.cmc.complete_repeat) == (3, 1, 1)
    solved(plan)
    reported = completed(plan)
    assert reported["copies"] == 12 and len(reported["lattice"]) == 1
    assert_allclose(reported["lattice"][0][:2], 0, rtol=0, atol=1e-5)


def test_the_whole_torus_is_a_saddle_that_is_found(addon):
    plan = add("TORUS", columns=8)
    assert euler(plan.data) == 0 and not len(boundary_edges(plan.data))
    drawn = positions(plan)
    assert_allclose(np.ptp(drawn[:, :2], axis=0), 8.0, rtol=0.01, atol=0)
    reported = solved(plan)
    assert reported["index"] == 11 and abs(reported["degree"]) < 1e-6 and reported["gap"] < 1e-5
    assert_allclose(reported["sheets"]["f+"]["span"], 8.0, rtol=1e-5, atol=0)
    shell = plan.cmc.f_plus
    assert doubled(shell) < 0.1
    assert euler(shell.data) == 0 and not len(boundary_edges(shell.data))
    centre = positions(shell).mean(axis=0)
    assert_allclose(centre, 0, rtol=0, atol=0.2)


def test_the_drawn_torus_is_conformal_to_the_flat_one(addon):
    """Own lengths and drawn ones differ by one factor at each place, where the flat one is a rectangle."""
    plan = add("TORUS", angle=np.radians(90.0), columns=14)
    edges = np.array([edge.vertices[:] for edge in plan.data.edges])
    points = positions(plan)
    drawn = np.linalg.norm(points[edges[:, 0]] - points[edges[:, 1]], axis=1)
    own = np.array([item.value for item in plan.data.attributes["cmc_length"].data])
    ratio = drawn / own
    reach = np.linalg.norm(points[edges].mean(axis=1)[:, :2], axis=1)
    assert np.std(ratio / reach) < 0.04 * np.mean(ratio / reach)


def test_the_ring_is_solved_where_it_was_drawn_and_tiled(addon):
    plan = add("RING")
    assert [group.kind for group in plan.data.cmc.groups] == ["MIRROR"] * 6 and euler(plan.data) == -6
    reported = solved(plan)
    assert reported["index"] in (12, 13)  # one mode is nearly null on this mesh
    apart = np.linalg.norm(positions(plan.cmc.f_plus) - positions(plan), axis=1)
    assert_allclose(apart, 0.15 * 0.5 * plan.cmc.radius, rtol=0.01, atol=0)  # drawn a little inside itself
    assert not [note for note in reported["warnings"] if note["code"] == "crossing"]
    tiled = completed(plan)
    assert tiled["copies"] == 9 and len(tiled["lattice"]) == 2 and tiled["relative_gap"] < 1e-5
    assert euler(plan.cmc.completed.data) == -54


@pytest.mark.parametrize("bubble", ["TORUS", "RING"])
def test_the_default_mesh_has_the_mean_curvature_within_a_few_percent(bubble):
    H = solved(add(bubble))["sheets"]["f+"]["mean_curvature"]
    assert 0.0 < H["relative_l2"] < 0.05


def test_newton_runs_away_from_a_saddle(addon):
    """A minimiser fails with a message, and the scene stays."""
    plan = add("TORUS", columns=8)
    activate(plan)
    before = snapshot()
    with pytest.raises(RuntimeError, match="choose the method Nearest critical"):
        bpy.ops.cmc.solve(method="NEWTON")
    assert snapshot() == before


def test_a_torus_that_does_not_close_on_faces_is_cut_open(addon):
    """The height is that at which the map on vertices closes; on faces the surface is cut open, with a gap."""
    plan = add("TORUS", columns=8)
    activate(plan)
    assert bpy.ops.cmc.solve(sites="FACES") == {"FINISHED"}
    reported = json.loads(plan.cmc.report)
    assert reported["is_open"] and reported["gap"] > 0.0
    assert len(boundary_edges(plan.cmc.f_plus.data))


def test_an_approximation_of_a_closed_plan_is_refused(addon):
    plan = add("TORUS", columns=8)
    activate(plan)
    before = snapshot()
    with pytest.raises(RuntimeError, match="no rim"):
        bpy.ops.cmc.approximate_surface()
    assert snapshot() == before


def test_modes_do_not_count_what_only_moves_along(addon):
    """Three rotations and two translations of the torus, in single precision, are no unstable modes."""
    plan = add("TORUS", columns=8)
    reported = solved(plan)
    assert (reported["index"], reported["nullity"]) == (11, 5)


def test_what_cannot_be_added_is_said(addon):
    for settings, words in (
        ({"bubble": "TORUS", "angle": 2.0}, "never closes; choose an angle"),
        ({"bubble": "WENTE", "angle": 0.3, "columns": 8}, "columns or more"),
    ):
        before = snapshot()
        with pytest.raises(RuntimeError, match=words):
            bpy.ops.cmc.add_bubble(**settings)
        assert snapshot() == before


def test_bubbles_are_in_the_menu(addon):
    from types import SimpleNamespace

    from cmc_formfinding.cmc_addon.operators.add_bubble import BUBBLES, in_add_menu

    from .sidebar import Layout

    layout = Layout()
    in_add_menu(SimpleNamespace(layout=layout), bpy.context)
    assert layout.record.operators == ["cmc.add_bubble"] * len(BUBBLES)


def test_adding_is_one_step_of_undo_and_adjusts(addon):
    bpy.ops.ed.undo_push(message="before")
    bpy.ops.cmc.add_bubble("EXEC_DEFAULT", True, bubble="WENTE")
    assert bpy.context.object.name == "Wente Cylinder"
    bpy.ops.ed.undo()
    assert not bpy.data.objects


def test_bubbles_are_seen_in_panels(addon):
    for bubble in ("WENTE", "TORUS", "RING"):
        plan = add(bubble, columns={"WENTE": 8, "TORUS": 8, "RING": 3}[bubble])
        solved(plan)
        activate(plan)
        panel = draw()
        assert "Degree" in panel.texts
        bpy.data.objects.remove(plan)
