"""Dual and corner meshes as results: their faces, the plan's layers on them, and the way back to the plan's faces."""

from __future__ import annotations

import bpy

# isort: split
import numpy as np
import pytest
from numpy.testing import assert_allclose

from .scenes import activate, add_group, boundary_edges, positions, quad_disc, quad_ring, values


def solve(plan, **settings):
    activate(plan)
    assert bpy.ops.cmc.solve(**settings) == {"FINISHED"}
    return plan.cmc.f_plus


def counts(plan) -> tuple[int, int, int]:
    """Vertices, edges and faces of the triangles that are solved on."""
    mesh = plan.data
    mesh.calc_loop_triangles()
    faces, boundary = len(mesh.loop_triangles), len(boundary_edges(mesh))
    return len(mesh.vertices), (3 * faces + boundary) // 2, faces


@pytest.fixture
def dressed():
    plan = quad_disc(rings=6)
    mesh = plan.data
    for name, factor in (("Plan", 1.0), ("Small", 0.1)):
        layer = mesh.uv_layers.new(name=name)
        for loop in mesh.loops:
            layer.data[loop.index].uv = factor * mesh.vertices[loop.vertex_index].co.xy
    mesh.attributes.new("x", "FLOAT", "POINT").data.foreach_set("value", [v.co.x for v in mesh.vertices])
    colour = mesh.color_attributes.new("Tint", "FLOAT_COLOR", "CORNER")
    colour.data.foreach_set("color", np.full(4 * len(mesh.loops), 0.5))
    for name in ("Glass", "Concrete"):
        mesh.materials.append(bpy.data.materials.new(name))
    for polygon in mesh.polygons:
        polygon.material_index = int(polygon.center.x > 0)
    group = plan.vertex_groups.new(name="Half")
    for vertex in mesh.vertices:
        if vertex.co.y >= 0:
            group.add([vertex.index], 0.75, "REPLACE")
    add_group(plan, "Tilted", boundary_edges(mesh)[:12], "BINORMAL", tilt=0.7)
    return plan


def manifold(mesh) -> None:
    """Every edge has one face or two that walk it in opposite directions; there are no loose parts."""
    walked = {}
    for polygon in mesh.polygons:
        corners = list(polygon.vertices)
        assert len(set(corners)) == len(corners) >= 3
        for a, b in zip(corners, corners[1:] + corners[:1], strict=True):
            assert (a, b) not in walked
            walked[a, b] = polygon.index
    assert {frozenset(e.vertices) for e in mesh.edges} == {frozenset(e) for e in walked}
    assert {v for edge in walked for v in edge} == set(range(len(mesh.vertices)))
    rim = [edge for edge in walked if edge[::-1] not in walked]
    assert len({a for a, _ in rim}) == len(rim) == len({b for _, b in rim})


FACES = ("DUAL", "CORNER")


@pytest.mark.parametrize("mirror", [False, True])
@pytest.mark.parametrize("sites", ["VERTICES", "FACES"])
@pytest.mark.parametrize("faces", FACES)
def test_counts_and_sides(dressed, faces, sites, mirror):
    """A face for each vertex, or for each face, edge and vertex; seen from outside they run counter-clockwise."""
    if mirror:
        dressed.scale.x = -1.0
    solve(dressed, combinatorics=faces, sites=sites, want_twin=True, want_g=True)
    V, E, F = counts(dressed)
    rim = len(boundary_edges(dressed.data))
    expected = {
        ("DUAL", "VERTICES"): V,
        ("DUAL", "FACES"): V,
        ("CORNER", "VERTICES"): V + E + F,
        # without the edges of the boundary; the disc's boundary vertices have three triangles or more, or two
        ("CORNER", "FACES"): V + E + F - rim - sum(n < 3 for n in triangles_at_the_rim(dressed)),
    }
    for role in ("f_plus", "f_minus", "g"):
        mesh = getattr(dressed.cmc, role).data
        assert len(mesh.polygons) == expected[faces, sites]
        manifold(mesh)
        assert not mesh.validate()
        assert not any(polygon.use_smooth for polygon in mesh.polygons)
        assert ("cmc_mean_curvature" in mesh.attributes) == (role != "g")
    mesh = dressed.cmc.f_plus.data
    normals = np.array(values(mesh.attributes["cmc_normal"]))
    assert_allclose(np.linalg.norm(normals, axis=1), 1.0, rtol=0, atol=1e-5)
    sides = np.array([polygon.normal.dot(normals[list(polygon.vertices)].mean(axis=0)) for polygon in mesh.polygons])
    areas = np.array([polygon.area for polygon in mesh.polygons])
    assert areas[sides < 0].sum() < 0.02 * areas.sum() and np.median(sides) > 0.9


def triangles_at_the_rim(plan) -> list[int]:
    mesh = plan.data
    mesh.calc_loop_triangles()
    meeting = np.bincount([v for t in mesh.loop_triangles for v in t.vertices], minlength=len(mesh.vertices))
    return [int(meeting[v]) for v in {v for e in boundary_edges(mesh) for v in mesh.edges[e].vertices}]


@pytest.mark.parametrize("faces", FACES)
def test_what_the_plan_carries(dressed, faces):
    """UVs, numbers and weights between vertices are between theirs; materials are those of the face below."""
    result = solve(dressed, combinatorics=faces)
    mesh = result.data
    assert [layer.name for layer in mesh.uv_layers] == ["Plan", "Small"]
    assert mesh.uv_layers.active.name == dressed.data.uv_layers.active.name
    uv = np.array(values(mesh.attributes["Plan"]))
    assert_allclose(values(mesh.attributes["Small"]), 0.1 * uv, rtol=0, atol=1e-6)
    x = np.array(values(mesh.attributes["x"]))
    rows = np.array([loop.vertex_index for loop in mesh.loops])
    assert_allclose(uv[:, 0], x[rows], rtol=0, atol=1e-5)
    # the outline was drawn as a disc of radius 4, and the shell lies over it as a conformal image
    assert np.linalg.norm(uv, axis=1).max() < 4.01
    assert np.ptp(uv, axis=0).min() > 7.0
    assert [material.name for material in mesh.materials] == ["Glass", "Concrete"]
    for polygon in mesh.polygons:
        middle = uv[list(polygon.loop_indices)].mean(axis=0)
        if abs(middle[0]) > 0.8:
            assert polygon.material_index == int(middle[0] > 0)
    assert_allclose(values(mesh.attributes["Tint"]), 0.5, rtol=0, atol=1e-6)
    y = np.zeros(len(mesh.vertices))
    y[rows] = uv[:, 1]
    for vertex in mesh.vertices:
        weight = sum(g.weight for g in vertex.groups)
        if abs(y[vertex.index]) > 0.8:
            assert weight == pytest.approx(0.75 if y[vertex.index] > 0 else 0.0, abs=1e-6)
    assert not mesh.cmc.groups and "cmc_group" not in mesh.attributes


@pytest.mark.parametrize("delaunay", [False, True])
@pytest.mark.parametrize("faces", FACES)
def test_over_the_plan(dressed, faces, delaunay):
    """The vertices lie where the triangles' are: within half an edge of them, on either triangulation."""
    triangles = positions(solve(dressed))
    other = positions(solve(dressed, combinatorics=faces, delaunay=delaunay))
    distance = np.linalg.norm(other[:, None] - triangles, axis=2).min(axis=1)
    assert distance.max() < 1.0


def test_there_and_back(dressed):
    """One object throughout; the same faces again are written into the same mesh, with the user's materials."""
    result = solve(dressed)
    drawn = len(result.data.polygons)
    assert solve(dressed, combinatorics="DUAL") == result
    assert dressed.cmc.combinatorics == "DUAL"
    mesh, name = result.data, result.data.name
    mesh.polygons[3].material_index = 1 - mesh.polygons[3].material_index
    chosen = [polygon.material_index for polygon in mesh.polygons]
    before = positions(result)
    assert solve(dressed, size="HEIGHT", height=2.0) == result
    assert result.data == mesh
    assert [polygon.material_index for polygon in mesh.polygons] == chosen
    assert np.ptp(positions(result)[:, 2]) != pytest.approx(np.ptp(before[:, 2]))
    assert solve(dressed, combinatorics="PRIMAL") == result
    assert len(result.data.polygons) == drawn and result.data.name == name
    assert all(polygon.use_smooth for polygon in result.data.polygons)
    assert len(bpy.data.objects) == 2 and len(bpy.data.meshes) == 2


def test_undo_and_redo(dressed):
    solve(dressed)
    bpy.ops.ed.undo_push(message="before")
    activate(dressed)
    bpy.ops.cmc.solve("EXEC_DEFAULT", True, sites="FACES", energy="MOBIUS", combinatorics="CORNER")
    faces = len(bpy.data.objects["Disc f+"].data.polygons)
    for _ in range(2):
        bpy.ops.ed.undo()
        plan = bpy.data.objects["Disc"]
        assert (plan.cmc.sites, plan.cmc.energy, plan.cmc.combinatorics) == ("VERTICES", "COTAN", "PRIMAL")
        assert len(bpy.data.objects["Disc f+"].data.polygons) == len(plan.data.polygons) != faces
        bpy.ops.ed.redo()
        plan = bpy.data.objects["Disc"]
        assert (plan.cmc.sites, plan.cmc.energy, plan.cmc.combinatorics) == ("FACES", "MOBIUS", "CORNER")
        assert len(bpy.data.objects["Disc f+"].data.polygons) == faces


@pytest.mark.parametrize("sites", ["VERTICES", "FACES"])
@pytest.mark.parametrize("faces", FACES)
def test_a_surface_that_is_cut_open(faces, sites):
    """Every polygon is whole, and has its UVs; vertices along the cut are doubled."""
    plan = quad_ring(rings=6, columns=36)
    layer = plan.data.uv_layers.new(name="Plan")
    for loop in plan.data.loops:
        layer.data[loop.index].uv = plan.data.vertices[loop.vertex_index].co.xy
    inner = [e for e in boundary_edges(plan.data) if max(plan.data.edges[e].vertices) < 36]
    add_group(plan, "Inner", inner, "PLANE", normal=(0.6, 0.0, 0.8))
    mesh = solve(plan, sites=sites, combinatorics=faces).data
    assert "gap" in plan.cmc.message
    manifold(mesh)
    V, _, F = counts(plan)
    assert len(mesh.polygons) == V if faces == "DUAL" else len(mesh.polygons) > 2 * F
    uv = np.array(values(mesh.attributes["Plan"]))
    for polygon in mesh.polygons:
        assert np.ptp(uv[list(polygon.loop_indices)], axis=0).max() < 1.5


def test_twins_and_unwanted_results_have_the_same_faces(dressed):
    """A result that is not wanted now is still updated."""
    solve(dressed, want_g=True, want_gauss=True, combinatorics="DUAL")
    faces = len(dressed.cmc.g.data.polygons)
    assert len(dressed.cmc.gauss.data.polygons) == faces == len(dressed.data.vertices)
    solve(dressed, want_g=False, want_gauss=False, combinatorics="CORNER")
    assert dressed.cmc.g.hide_viewport
    assert len(dressed.cmc.g.data.polygons) == len(dressed.cmc.f_plus.data.polygons) > faces


def test_a_plan_as_its_modifiers_show_it():
    plan = quad_disc(columns=16)
    plan.modifiers.new("Subdivision", "SUBSURF").levels = 1
    mesh = solve(plan, apply_modifiers=True, combinatorics="DUAL").data
    bpy.ops.object.modifier_apply(modifier="Subdivision")
    assert len(mesh.polygons) == len(plan.data.vertices) > 200
    manifold(mesh)
