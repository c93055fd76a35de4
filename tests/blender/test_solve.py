"""Solve and Flip: the shell over plans of every kind, its size and its place."""

from __future__ import annotations

import json

import bpy

# isort: split
import numpy as np
import pytest
from numpy.testing import assert_allclose

from .scenes import add_group, boundary_edges, mesh_object, positions, quad_disc, quad_ring, values
from .solved_plans import FINISHED, extent, solved


@pytest.mark.parametrize("mode", ["OBJECT", "EDIT"])
def test_a_disc_becomes_a_hemisphere(mode):
    """Outward conormals: f+ is the hemisphere over the disc, with its normals and its curvature 1/R."""
    plan = quad_disc(rings=12, columns=48)
    bpy.ops.object.mode_set(mode=mode)
    points = solved(plan)
    assert plan.mode == mode
    assert_allclose(np.linalg.norm(points, axis=1), 4.0, rtol=0, atol=0.03)
    assert_allclose(points[:, 2].min(), 0.0, rtol=0, atol=1e-6)
    mesh = plan.cmc.f_plus.data
    normals = np.array(values(mesh.attributes["cmc_normal"]))
    assert_allclose(np.linalg.norm(normals, axis=1), 1.0, rtol=0, atol=1e-6)
    assert_allclose(normals, points / 4.0, rtol=0, atol=0.02)
    curvature = np.array(values(mesh.attributes["cmc_mean_curvature"]))
    assert_allclose(np.median(curvature), 0.25, rtol=0.01, atol=0)
    outward = np.array([polygon.normal for polygon in mesh.polygons])
    centres = np.array([polygon.center for polygon in mesh.polygons])
    assert (np.einsum("ij,ij->i", outward, centres) > 0).all()
    assert all(polygon.use_smooth for polygon in mesh.polygons)


def test_polygons_of_any_kind():
    """Triangles, quads and hexagons in one plan; every one of them is a polygon of the result."""
    n = 6
    points = [(x - n / 2, y - n / 2, 0.0) for y in range(n + 1) for x in range(n + 1)]
    faces = []
    for y in range(n):
        for x in range(0, n, 2):
            a = y * (n + 1) + x
            b = a + n + 1
            if y % 3 == 0:
                faces.append((a, a + 1, a + 2, b + 2, b + 1, b))
            elif y % 3 == 1:
                faces += [(a, a + 1, b + 1, b), (a + 1, a + 2, b + 2, b + 1)]
            else:
                faces += [(a, a + 1, b + 1), (a, b + 1, b), (a + 1, a + 2, b + 2, b + 1)]
    plan = mesh_object("Any", points, faces)
    shell = solved(plan)
    drawn = [tuple(p.vertices) for p in plan.data.polygons]
    assert [tuple(p.vertices) for p in plan.cmc.f_plus.data.polygons] == drawn
    inside = np.setdiff1d(np.arange(49), np.unique([plan.data.edges[e].vertices for e in boundary_edges(
        plan.data)]))
    assert (shell[inside, 2] > 0.1).all()
    assert shell[:, 2].max() > 0.1 * n


def test_transforms_are_respected():
    """A rotated and unevenly scaled object gives what its own points in world space give."""
    plan = quad_disc("Moved", rings=6)
    plan.location, plan.rotation_euler, plan.scale = (5.0, 3.0, 2.0), (0.0, 0.0, 0.7), (2.0, 1.0, 1.0)
    bpy.context.view_layer.update()
    baked = mesh_object("Baked", positions(plan), [tuple(p.vertices) for p in plan.data.polygons])
    assert_allclose(solved(plan), solved(baked), rtol=0, atol=1e-4)
    assert tuple(plan.cmc.f_plus.location) == pytest.approx((5.0, 3.0, 2.0))
    assert tuple(plan.cmc.f_plus.scale) == (1.0, 1.0, 1.0)


def test_a_mirrored_plan_stands_up_too():
    plan = quad_disc(rings=6)
    expected = solved(plan)
    plan.scale = (-1.0, 1.0, 1.0)
    points = solved(plan)
    assert_allclose(points[:, 2], expected[:, 2], rtol=0, atol=1e-5)
    mesh = plan.cmc.f_plus.data
    assert all(p.normal.dot(p.center) > 0 for p in mesh.polygons)


def test_far_from_the_origin():
    plan = quad_disc(rings=6)
    expected = solved(plan)
    plan.location = (1000.0, -2000.0, 50.0)
    assert_allclose(solved(plan) - [1000.0, -2000.0, 50.0], expected, rtol=0, atol=2e-3)


def test_modifiers_if_chosen():
    """The result then has the modified plan's polygons, and is that of the plan with the modifier applied."""
    plan = quad_disc(columns=16)
    plan.modifiers.new("Subdivision", "SUBSURF").levels = 1
    assert len(solved(plan)) == 81
    points = solved(plan, apply_modifiers=True)
    assert not plan.cmc.f_plus.modifiers
    bpy.ops.object.modifier_apply(modifier="Subdivision")
    assert_allclose(solved(plan, apply_modifiers=False), points, rtol=0, atol=1e-5)


# --- size and place ------------------------------------------------------------------------

SIZES = {
    "span": ({"size": "SPAN", "span": 20.0}, lambda p, ob: extent(p)[:2].max(), 20.0, 0.01),
    "height": ({"size": "HEIGHT", "height": 3.0}, lambda p, ob: extent(p)[2], 3.0, 1e-5),
    "radius": ({"size": "RADIUS", "radius": 7.0}, lambda p, ob: 1 / report(ob)["target"], 7.0, 1e-6),
    "H": ({"size": "MEAN_CURVATURE", "mean_curvature": 0.5}, lambda p, ob: report(ob)["target"], 0.5, 1e-6),
}


def report(plan) -> dict:
    import json

    found = json.loads(plan.cmc.f_plus["cmc_report"])
    return found["sheets"]["f+"]["mean_curvature"]


@pytest.mark.parametrize("name", SIZES)
def test_sizes(name):
    settings, measure, expected, tolerance = SIZES[name]
    plan = quad_disc(rings=8, columns=32)
    assert measure(solved(plan, **settings), plan) == pytest.approx(expected, rel=tolerance)


def test_ground():
    """With tilted boundary planes the lowest point is inside; it, or the rim, is on the plan's plane."""
    plan = quad_disc(rings=8, columns=32)
    plan.location.z = 1.5
    rim = boundary_edges(plan.data)
    add_group(plan, "Low", rim[: len(rim) // 2], "BINORMAL", tilt=-0.6)
    lowest = solved(plan, ground="LOWEST")
    assert lowest[:, 2].min() == pytest.approx(1.5, abs=1e-5)
    outline = np.unique([plan.data.edges[e].vertices for e in rim])
    rim_heights = solved(plan, ground="RIM")[outline, 2]
    assert rim_heights.mean() == pytest.approx(1.5, abs=0.02)
    assert rim_heights.min() < 1.5 - 0.1


def test_flip_hangs_and_stands():
    plan = quad_disc(rings=6)
    up = solved(plan)
    assert bpy.ops.cmc.flip() == FINISHED
    down = positions(plan.cmc.f_plus)
    assert plan.cmc.flip
    assert extent(down)[2] == pytest.approx(extent(up)[2], rel=1e-5)
    summit = np.argmax(up[:, 2])
    assert down[summit, 2] == pytest.approx(down[:, 2].min())
    bpy.ops.cmc.flip()
    assert_allclose(positions(plan.cmc.f_plus), up, rtol=0, atol=1e-5)


def test_the_sheet_that_is_shown():
    """With tilted planes f- is a surface as well: shown, it is placed over the plan, f+ by the same map."""
    plan = quad_disc(rings=8, columns=32)
    rim = boundary_edges(plan.data)
    add_group(plan, "Tilted", rim[: len(rim) // 2], "BINORMAL", tilt=0.7)
    solved(plan, sheet="F_MINUS", want_twin=True)
    minus = positions(plan.cmc.f_minus)
    assert minus[:, 2].min() == pytest.approx(0.0, abs=1e-5)
    assert not plan.cmc.f_plus.hide_viewport
    solved(plan, sheet="F_PLUS", want_twin=False)
    assert positions(plan.cmc.f_plus)[:, 2].min() == pytest.approx(0.0, abs=1e-5)
    assert plan.cmc.f_minus.hide_viewport


def test_g_and_the_gauss_image():
    plan = quad_disc(rings=8, columns=32)
    plus = solved(plan, want_g=True, want_gauss=True)
    gauss = positions(plan.cmc.gauss)
    normals = np.array(values(plan.cmc.f_plus.data.attributes["cmc_normal"]))
    radius = np.linalg.norm(gauss - gauss.mean(axis=0) * 0, axis=1)
    assert_allclose(gauss, radius[:, None] * normals, rtol=0, atol=1e-4)
    # f+ = g + N/(2H): the Gauss image is of radius 1/(2H)
    g = positions(plan.cmc.g)
    assert_allclose(plus - g, gauss, rtol=0, atol=1e-4)
    assert "cmc_mean_curvature" not in plan.cmc.g.data.attributes


# --- cuts and messages ---------------------------------------------------------------------

def test_a_ring_is_cut_open_and_says_so():
    """The surface over an eccentric ring does not close: more vertices, the same polygons, a warning."""
    plan = quad_ring(rings=6, columns=36)
    rim = boundary_edges(plan.data)
    inner = [e for e in rim if max(plan.data.edges[e].vertices) < 36]
    add_group(plan, "Inner", inner, "BINORMAL", tilt=0.8)
    solved(plan)
    mesh = plan.cmc.f_plus.data
    assert len(mesh.vertices) > len(plan.data.vertices)
    quads = [polygon for polygon in mesh.polygons if len(polygon.vertices) == 4]
    torn = len(plan.data.polygons) - len(quads)
    assert len(mesh.polygons) == len(plan.data.polygons) + torn
    assert torn < 0.05 * len(plan.data.polygons)
    assert "has a gap" in plan.cmc.message
    # cut, it hangs together: one boundary more would be one loop less
    assert len(plan.data.vertices) - len(plan.data.edges) + len(plan.data.polygons) == 0
    assert len(mesh.vertices) - len(mesh.edges) + len(mesh.polygons) == 1


def test_the_message_says_how_even_the_curvature_is(addon):
    """The measured error of the shown sheet; a coarser plan has a larger one."""
    errors = []
    for rings in (4, 8):
        plan = quad_disc(f"Disc {rings}", rings=rings, columns=8 * rings)
        edges = boundary_edges(plan.data)
        add_group(plan, "Half", edges[: len(edges) // 2], "BINORMAL", tilt=0.3)
        solved(plan)
        report = json.loads(plan.cmc.report)
        errors.append(report["sheets"]["f+"]["mean_curvature"]["relative_l2"])
        assert plan.cmc.message == report["message"] == f"Done. Curvature is even to {100 * errors[-1]:.2g} %."
    assert errors[1] < errors[0] < 1.0
