"""Result objects carry the plan's data and keep the user's: materials, modifiers, place."""

from __future__ import annotations

import json

import bpy

# isort: split
import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from .result_plans import solve, tilted
from .scenes import activate, add_group, boundary_edges, positions, quad_disc, quad_ring, values


@pytest.fixture
def dressed():
    """A plan of quads with two UV layers, two materials, a vertex group, a colour and other attributes."""
    plan = quad_disc(rings=10, columns=40)
    mesh = plan.data
    random = np.random.default_rng(3)
    corners = np.array([mesh.vertices[loop.vertex_index].co[:2] for loop in mesh.loops])
    mesh.uv_layers.new(name="Plan").data.foreach_set("uv", corners.astype(np.float32).ravel())
    mesh.uv_layers.new(name="Other").data.foreach_set(
        "uv", random.random(2 * len(mesh.loops)).astype(np.float32))
    color = mesh.color_attributes.new("Tint", "BYTE_COLOR", "CORNER")
    color.data.foreach_set("color_srgb", random.random(4 * len(mesh.loops)).astype(np.float32))
    mesh.attributes.new("heat", "FLOAT", "POINT").data.foreach_set(
        "value", random.random(len(mesh.vertices)).astype(np.float32))
    seam = mesh.attributes.new("seam", "BOOLEAN", "EDGE")
    seam.data.foreach_set("value", random.random(len(mesh.edges)) < 0.5)
    for name in ("Glass", "Concrete"):
        mesh.materials.append(bpy.data.materials.new(name))
    mesh.polygons.foreach_set("material_index", random.integers(0, 2, len(mesh.polygons)).astype(np.int32))
    group = plan.vertex_groups.new(name="Soft")
    for vertex in range(0, len(mesh.vertices), 3):
        group.add([vertex], (vertex % 5) / 5, "REPLACE")
    return tilted(plan)


LAYERS = ("Plan", "Other", "Tint", "heat", "seam", "material_index", "cmc_group")


def weights(ob) -> list:
    return [[(ob.vertex_groups[g.group].name, g.weight) for g in v.groups] for v in ob.data.vertices]


@pytest.mark.parametrize("again", [False, True])
def test_everything_of_the_plan_is_on_the_results(dressed, again):
    """Bit for bit, after the first solve and after an update in place."""
    solve(dressed, want_twin=True, want_g=True, want_gauss=True)
    if again:
        solve(dressed, size="HEIGHT", height=2.0)
    for role in ("f_plus", "f_minus", "g", "gauss"):
        result = getattr(dressed.cmc, role)
        drawn, mesh = dressed.data, result.data
        assert [tuple(p.vertices) for p in mesh.polygons] == [tuple(p.vertices) for p in drawn.polygons]
        assert [tuple(e.vertices) for e in mesh.edges] == [tuple(e.vertices) for e in drawn.edges]
        for name in LAYERS:
            one, other = mesh.attributes[name], drawn.attributes[name]
            assert (one.domain, one.data_type) == (other.domain, other.data_type)
            assert values(one) == values(other), name
        assert [layer.name for layer in mesh.uv_layers] == ["Plan", "Other"]
        assert mesh.uv_layers.active.name == drawn.uv_layers.active.name
        assert [slot.material.name for slot in result.material_slots] == ["Glass", "Concrete"]
        assert weights(result) == weights(dressed)
        assert not mesh.cmc.groups
    assert len(dressed.data.cmc.groups) == 1


def test_uv_of_the_plan_is_conformal_on_the_shell(dressed):
    """Q of the map from UV coordinates to f+, measured here, is the report's distortion."""
    result = solve(dressed)
    mesh = result.data
    mesh.calc_loop_triangles()
    points, uv = positions(result), [tuple(item.vector) for item in mesh.uv_layers["Plan"].uv]
    report = json.loads(result["cmc_report"])
    Q, areas = [], []
    for triangle in mesh.loop_triangles:
        p, q = points[list(triangle.vertices)], np.array([uv[c] for c in triangle.loops])
        jacobian = np.stack([p[1] - p[0], p[2] - p[0]], axis=1) @ np.linalg.inv(
            np.stack([q[1] - q[0], q[2] - q[0]], axis=1))
        one, other = np.linalg.svd(jacobian, compute_uv=False)
        Q.append(one / other)
        areas.append(0.5 * np.linalg.norm(np.cross(p[1] - p[0], p[2] - p[0])))
    mean = np.average(Q, weights=areas)
    assert mean == pytest.approx(report["sheets"]["f+"]["distortion"]["mean"], rel=0.02)
    assert mean < 1.2


def test_the_report(dressed):
    """On the result as JSON and as plain properties, on the plan for the panel."""
    result = solve(dressed)
    report = json.loads(result["cmc_report"])
    assert report["status"] == result["cmc_status"] == "converged"
    assert report["plan"] == "Disc"
    assert result["cmc_energy"] == pytest.approx(report["energy"])
    assert json.loads(dressed.cmc.report) == report
    target = report["sheets"]["f+"]["mean_curvature"]["target"]
    curvature = np.array(values(result.data.attributes["cmc_mean_curvature"]))
    assert np.median(curvature) == pytest.approx(target, rel=0.01)


def test_the_report_says_what_a_unit_is():
    """Lengths are Blender units; in a scene of millimetres one is a thousandth of a metre."""
    bpy.context.scene.unit_settings.scale_length = 0.001
    plan = quad_disc()
    assert json.loads(solve(plan, size="HEIGHT", height=2.0)["cmc_report"])["unit_scale"] == pytest.approx(0.001)
    assert np.ptp(positions(plan.cmc.f_plus)[:, 2]) == pytest.approx(2.0, rel=1e-5)


def test_curvature_of_both_sheets(dressed):
    """Each sheet carries its own, measured on it; f- is small here and coarsely meshed."""
    solve(dressed, want_twin=True)
    target = json.loads(dressed.cmc.report)["sheets"]["f+"]["mean_curvature"]["target"]
    found = [
        np.array(values(result.data.attributes["cmc_mean_curvature"]))
        for result in (dressed.cmc.f_plus, dressed.cmc.f_minus)
    ]
    assert np.median(found[0]) == pytest.approx(target, rel=0.01)
    assert 0.1 * target < np.median(found[1]) < 2.0 * target
    assert not np.allclose(*found, rtol=0.01, atol=0)


# --- what stays ----------------------------------------------------------------------------

def test_the_users_things_stay(dressed):
    """Materials, modifiers, shading, visibility, own layers and properties, the object and its mesh."""
    result = solve(dressed)
    mesh = result.data
    shell = bpy.data.materials.new("Shell")
    mesh.materials[0] = shell
    mesh.materials.append(bpy.data.materials.new("Edge"))
    mesh.polygons[5].material_index = 2
    mesh.polygons[6].use_smooth = False
    result.modifiers.new("Thickness", "SOLIDIFY").thickness = 0.2
    result["note"] = "mine"
    mesh.uv_layers.new(name="Bake")
    mesh.attributes.new("dirt", "FLOAT", "POINT").data.foreach_set(
        "value", np.arange(len(mesh.vertices), dtype=np.float32))
    result.vertex_groups.new(name="Edge").add([1, 2], 0.5, "REPLACE")
    solve(dressed, size="HEIGHT", height=2.0)
    assert dressed.cmc.f_plus == result
    assert result.data == mesh
    assert [m.name for m in mesh.materials] == ["Shell", "Concrete", "Edge"]
    assert mesh.polygons[5].material_index == 2
    assert not mesh.polygons[6].use_smooth
    assert mesh.polygons[7].use_smooth
    assert [m.name for m in result.modifiers] == ["Thickness"]
    assert result["note"] == "mine"
    assert "Bake" in mesh.uv_layers
    assert values(mesh.attributes["dirt"])[:3] == [0.0, 1.0, 2.0]
    assert [g.name for g in result.vertex_groups] == ["Soft", "Edge"]
    assert weights(result)[1] == [("Edge", 0.5)]


def test_what_the_plan_changes_is_refreshed(dressed):
    result = solve(dressed)
    dressed.data.uv_layers["Plan"].uv[0].vector = (7.0, 8.0)
    dressed.data.attributes["heat"].data[3].value = 9.0
    dressed.data.attributes.new("later", "INT", "FACE")
    dressed.vertex_groups["Soft"].add([0], 0.75, "REPLACE")
    dressed.vertex_groups["Soft"].remove([3])
    solve(dressed)
    assert tuple(result.data.uv_layers["Plan"].uv[0].vector) == (7.0, 8.0)
    assert result.data.attributes["heat"].data[3].value == 9.0
    assert "later" in result.data.attributes
    assert weights(result) == weights(dressed)


def test_a_plan_with_other_polygons_gives_new_mesh_data(dressed):
    """The object stays, with its modifiers and materials; the mesh's name stays; nothing is left over."""
    result = solve(dressed)
    result.data.name = "Skin"
    result.data.materials[0] = bpy.data.materials.new("Shell")
    result.modifiers.new("Thickness", "SOLIDIFY")
    linked = bpy.data.objects.new("Twin", result.data)
    bpy.context.scene.collection.objects.link(linked)
    activate(dressed)
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.select_all(action="SELECT")
    bpy.ops.mesh.subdivide()
    bpy.ops.object.mode_set(mode="OBJECT")
    meshes = len(bpy.data.meshes)
    solve(dressed)
    assert dressed.cmc.f_plus == result
    assert len(result.data.polygons) == len(dressed.data.polygons)
    assert result.data.name == "Skin"
    assert [slot.material.name for slot in result.material_slots] == ["Shell", "Concrete"]
    assert [m.name for m in result.modifiers] == ["Thickness"]
    drawn = [polygon.material_index for polygon in dressed.data.polygons]
    assert [polygon.material_index for polygon in result.data.polygons] == drawn
    assert weights(result) == weights(dressed)
    assert linked.data == result.data
    assert len(bpy.data.meshes) == meshes


def test_materials_linked_to_the_object():
    plan = quad_disc()
    plan.data.materials.append(None)
    plan.material_slots[0].link = "OBJECT"
    plan.material_slots[0].material = bpy.data.materials.new("Own")
    slot = solve(plan).material_slots[0]
    assert (slot.link, slot.material.name) == ("OBJECT", "Own")


# --- place ---------------------------------------------------------------------------------

def test_the_users_transform_stays_and_the_plan_is_followed():
    plan = quad_disc()
    result = solve(plan)
    result.location.x += 15.0
    result.rotation_euler.z = 0.5
    aside = positions(result)
    solve(plan)
    assert_allclose(positions(result), aside, rtol=0, atol=1e-5)
    plan.location = (0.0, 3.0, 1.0)
    solve(plan)
    assert_allclose(positions(result), aside + [0.0, 3.0, 1.0], rtol=0, atol=1e-4)


def test_a_parented_result_is_left_to_its_parent():
    plan = quad_disc()
    result = solve(plan)
    parent = bpy.data.objects.new("Frame", None)
    bpy.context.scene.collection.objects.link(parent)
    result.parent = parent
    plan.location = (5.0, 0.0, 0.0)
    solve(plan)
    assert tuple(result.location) == (0.0, 0.0, 0.0)


# --- shape keys and cuts -------------------------------------------------------------------

def test_a_plan_with_shape_keys():
    """Solve takes its basis, or with modifiers applied the shown shape; the result has no keys."""
    plan = quad_disc()
    plan.shape_key_add(name="Basis")
    plan.shape_key_add(name="Wide").data[0].co.z = 1.0
    plan.data.shape_keys.key_blocks["Wide"].value = 1.0
    result = solve(plan)
    assert result.data.shape_keys is None
    assert positions(result)[:, 2].max() > 1.0
    solve(plan, apply_modifiers=True)
    assert plan.cmc.f_plus == result
    assert result.data.shape_keys is None


@pytest.mark.parametrize("mirror", [False, True])
def test_a_cut_surface_keeps_its_data(mirror):
    """Vertex weights, normals and curvature have a value on either side of the cut; UVs stay on corners."""
    plan = quad_ring(rings=6, columns=36)
    if mirror:
        plan.scale.x = -1.0
    mesh = plan.data
    uv = mesh.uv_layers.new(name="Plan")
    for loop in mesh.loops:
        uv.data[loop.index].uv = mesh.vertices[loop.vertex_index].co[:2]
    mesh.attributes.new("drawn", "INT", "POINT").data.foreach_set("value", np.arange(len(mesh.vertices)))
    group = plan.vertex_groups.new(name="Index")
    for vertex in mesh.vertices:
        group.add([vertex.index], vertex.index / len(mesh.vertices), "REPLACE")
    inner = [e for e in boundary_edges(mesh) if max(mesh.edges[e].vertices) < 36]
    add_group(plan, "Inner", inner, "BINORMAL", tilt=0.8)
    for _ in range(2):
        result = solve(plan)
        cut = result.data
        drawn = np.array(values(cut.attributes["drawn"]))
        assert len(drawn) > len(mesh.vertices)
        assert_array_equal(np.unique(drawn), np.arange(len(mesh.vertices)))
        found = [vertex.groups[0].weight for vertex in cut.vertices]
        assert_allclose(found, drawn / len(mesh.vertices), rtol=0, atol=1e-6)
        flat = np.array([v.co[:2] for v in mesh.vertices])
        for loop in cut.loops:
            assert_allclose(cut.uv_layers["Plan"].uv[loop.index].vector, flat[drawn[loop.vertex_index]])
        normals = np.array(values(cut.attributes["cmc_normal"]))
        assert_allclose(np.linalg.norm(normals, axis=1), 1.0, rtol=0, atol=1e-6)
        outward = np.array([n.vector for n in cut.vertex_normals])
        assert np.median(np.einsum("ij,ij->i", outward, normals)) > 0.9
