"""Blender meshes to arrays and back: every mode, every layer, cut surfaces, numbers in messages."""

from __future__ import annotations

import bpy

# isort: split
import bmesh
import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from .scenes import add_group, boundary_edges, mesh_object, positions, quad_disc, quad_ring, snapshot, values


@pytest.fixture
def bridge(addon):
    return addon.cmc_addon.bridges.mesh_bridge


@pytest.fixture
def results(addon):
    return addon.cmc_addon.bridges.result_bridge


def test_reads_what_blender_has(bridge):
    ob = quad_disc()
    add_group(ob, "Rim", boundary_edges(ob.data)[3:7], "PLANE")
    plan = bridge.read_plan(ob)
    assert_allclose(plan.positions, [v.co for v in ob.data.vertices], rtol=0, atol=0)
    assert_array_equal(plan.edges, [tuple(e.vertices) for e in ob.data.edges])
    assert [p.tolist() for p in plan.polygons()] == [list(p.vertices) for p in ob.data.polygons]
    assert_array_equal(np.flatnonzero(plan.boundary), boundary_edges(ob.data))
    assert_array_equal(np.flatnonzero(plan.groups), boundary_edges(ob.data)[3:7])
    assert plan.positions.dtype == np.float64
    assert not plan.mirrored


def test_reads_world_coordinates(bridge):
    ob = quad_disc(rise=1.0)
    ob.location, ob.rotation_euler, ob.scale = (3.0, -2.0, 1.0), (0.2, 0.3, 0.4), (2.0, 1.0, 0.5)
    expected = positions(ob)
    assert_allclose(bridge.read_plan(ob).positions, expected, rtol=0, atol=1e-6)


def test_a_mirrored_object_is_walked_backwards(bridge):
    ob = quad_disc()
    ob.scale = (-1.0, 1.0, 1.0)
    bpy.context.view_layer.update()
    plan = bridge.read_plan(ob)
    a, b, c = (plan.positions[[polygon[k] for polygon in plan.polygons()]] for k in range(3))
    assert plan.mirrored
    assert (np.cross(b - a, c - b)[:, 2] > 0).all()


def test_edit_mode_is_read_as_it_is_now(bridge):
    ob = quad_disc()
    bpy.ops.object.mode_set(mode="EDIT")
    bm = bmesh.from_edit_mesh(ob.data)
    bm.verts.ensure_lookup_table()
    bm.edges.ensure_lookup_table()
    bm.verts[0].co.z = 2.5
    for edge in bm.edges:
        edge.select = edge.index == 4
    before = snapshot()
    plan = bridge.read_plan(ob)
    assert plan.positions[0, 2] == 2.5
    assert_array_equal(np.flatnonzero(plan.selected), [4])
    assert ob.mode == "EDIT"
    assert snapshot() == before


@pytest.mark.parametrize("mode", ["OBJECT", "EDIT"])
def test_modifiers_are_optional(bridge, mode):
    ob = quad_disc()
    rim = boundary_edges(ob.data)
    add_group(ob, "Rim", rim, "PLANE")
    ob.modifiers.new("Subdivision", "SUBSURF").levels = 1
    bpy.ops.object.mode_set(mode=mode)
    before = snapshot()
    plain = bridge.read_plan(ob)
    plan = bridge.read_plan(ob, bpy.context.evaluated_depsgraph_get())
    assert len(plain.positions) == 121
    assert len(plan.positions) == 121 + 120 + len(plain.edges)
    assert plan.groups.sum() == 2 * len(rim)
    assert_array_equal(plan.groups != 0, plan.boundary)
    assert snapshot() == before


ATTRIBUTES = {
    "FLOAT": (0.5, 1.0, -2.0),
    "INT": (1, 2, -3),
    "INT8": (1, 2, -3),
    "BOOLEAN": (True, False, True),
    "FLOAT_VECTOR": ((1.0, 2.0, 3.0), (0.5, 0.25, 0.125), (-1.0, 0.0, 1.0)),
    "FLOAT2": ((1.0, 2.0), (0.5, 0.25), (-1.0, 0.0)),
    "FLOAT_COLOR": ((1.0, 0.5, 0.25, 1.0), (0.0, 0.0, 0.0, 0.5), (1.0, 1.0, 1.0, 1.0)),
    "BYTE_COLOR": ((1.0, 0.2, 0.4, 1.0), (0.0, 0.0, 0.0, 0.6), (1.0, 1.0, 1.0, 1.0)),
    "QUATERNION": ((1.0, 0.0, 0.0, 0.0), (0.0, 1.0, 0.0, 0.0), (0.0, 0.0, 1.0, 0.0)),
    "INT32_2D": ((1, 2), (3, 4), (5, 6)),
    "INT16_2D": ((1, 2), (3, 4), (5, 6)),
    "STRING": (b"one", b"two", b""),
}


@pytest.mark.parametrize("kind", ATTRIBUTES)
def test_every_type_of_attribute(bridge, kind):
    """What is written comes back to the bit, also where Blender stores it otherwise (byte colours)."""
    ob = mesh_object("Triangle", [(0, 0, 0), (1, 0, 0), (0, 1, 0)], [(0, 1, 2)])
    data = list(ATTRIBUTES[kind]) if kind == "STRING" else np.array(ATTRIBUTES[kind])
    bridge.set_attribute(ob.data, "data", kind, "CORNER", data)
    attribute = ob.data.attributes["data"]
    assert (attribute.data_type, attribute.domain) == (kind, "CORNER")
    found = bridge.attribute_values(attribute)
    bridge.set_attribute(ob.data, "again", kind, "CORNER", found)
    assert repr(values(ob.data.attributes["again"])) == repr(values(ob.data.attributes["data"]))
    if kind == "STRING":
        assert found == data
    else:
        assert_allclose(np.squeeze(found), data, rtol=0, atol=1e-7)


def test_an_attribute_of_another_type_is_replaced(bridge):
    ob = mesh_object("Triangle", [(0, 0, 0), (1, 0, 0), (0, 1, 0)], [(0, 1, 2)])
    ob.data.attributes.new("data", "INT", "FACE")
    bridge.set_attribute(ob.data, "data", "FLOAT", "POINT", np.arange(3.0))
    assert [item.value for item in ob.data.attributes["data"].data] == [0.0, 1.0, 2.0]


def test_same_topology(bridge):
    a, b, c = quad_disc("A"), quad_disc("B", rise=2.0), quad_disc("C", columns=30)
    assert bridge.same_topology(a.data, b.data)
    assert not bridge.same_topology(a.data, c.data)
    b.data.polygons[30].flip()
    assert not bridge.same_topology(a.data, b.data)


# --- cut surfaces --------------------------------------------------------------------------

def cut_along(ob, bridge, results, plan_cache, doubled, faces_beyond):
    """The plan's mesh with vertices doubled for the triangles of some polygons."""
    plan = bridge.read_plan(ob)
    prepared = plan_cache.prepare(plan)
    rows = prepared.triangles.copy()
    new = {v: len(plan.positions) + k for k, v in enumerate(doubled)}
    for t in np.flatnonzero(np.isin(prepared.owners, faces_beyond)):
        rows[t] = [new.get(int(v), v) for v in rows[t]]
    source = np.concatenate([np.arange(len(plan.positions)), doubled]).astype(np.int32)
    return plan, results.find_cut(plan, prepared.triangles, prepared.owners, rows, source)


def dressed_ring(name="Ring"):
    """A ring with data in every place where a mesh has some."""
    ob = quad_ring(name)
    mesh = ob.data
    random = np.random.default_rng(5)
    for layer in ("Plan", "Second"):
        uv = mesh.uv_layers.new(name=layer)
        uv.data.foreach_set("uv", random.random(2 * len(mesh.loops)).astype(np.float32))
    mesh.uv_layers.active_index = 1
    color = mesh.color_attributes.new("Tint", "BYTE_COLOR", "CORNER")
    color.data.foreach_set("color_srgb", random.random(4 * len(mesh.loops)).astype(np.float32))
    kinds = [("heat", "FLOAT", "POINT", 1), ("wind", "FLOAT_VECTOR", "FACE", 3), ("load", "FLOAT", "EDGE", 1)]
    sizes = {"POINT": len(mesh.vertices), "FACE": len(mesh.polygons), "EDGE": len(mesh.edges)}
    for label, kind, domain, width in kinds:
        attribute = mesh.attributes.new(label, kind, domain)
        field = "vector" if width == 3 else "value"
        attribute.data.foreach_set(field, random.random(width * sizes[domain]).astype(np.float32))
    for label in ("Glass", "Concrete"):
        mesh.materials.append(bpy.data.materials.get(label) or bpy.data.materials.new(label))
    mesh.polygons.foreach_set("material_index", random.integers(0, 2, len(mesh.polygons)).astype(np.int32))
    group = ob.vertex_groups.new(name="Soft")
    for vertex in range(0, len(mesh.vertices), 3):
        group.add([vertex], (vertex % 5) / 5, "REPLACE")
    return ob


@pytest.mark.parametrize("mirror", [False, True])
def test_cut_keeps_all_layers(addon, bridge, results, mirror):
    """Corners and faces keep their data one by one; vertices and edges give theirs to both sides."""
    ob = dressed_ring()
    if mirror:
        ob.scale.x = -1.0
        bpy.context.view_layer.update()
    plan_cache = addon.cmc_addon.background.plan_cache
    # the seam at angle 0: vertices 0, 24, 48, …; the faces before it (the last of every ring) go to new ones
    seam = np.arange(0, 144, 24)
    plan, cut = cut_along(ob, bridge, results, plan_cache, seam, np.arange(23, 120, 24))
    fresh = results.fresh_mesh(ob, None, plan, cut)
    old = ob.data
    assert len(fresh.vertices) == 150
    assert [p.material_index for p in fresh.polygons] == [p.material_index for p in old.polygons]
    assert [m.name for m in fresh.materials] == ["Glass", "Concrete"]
    assert [layer.name for layer in fresh.uv_layers] == ["Plan", "Second"]
    assert fresh.uv_layers.active.name == "Second"
    assert fresh.color_attributes.active_color_name == old.color_attributes.active_color_name
    for new_polygon, polygon in zip(fresh.polygons, old.polygons, strict=True):
        corners = dict(zip(polygon.vertices, polygon.loop_indices, strict=True))
        ends = [cut.vertices[v] for v in new_polygon.vertices]
        assert ends == (list(polygon.vertices) if not mirror else
                        [polygon.vertices[0], *reversed(polygon.vertices[1:])])
        for corner, vertex in zip(new_polygon.loop_indices, ends, strict=True):
            for name in ("Plan", "Second", "Tint"):
                one, other = fresh.attributes[name].data[corner], old.attributes[name].data[corners[vertex]]
                field = "vector" if name != "Tint" else "color_srgb"
                assert tuple(getattr(one, field)) == tuple(getattr(other, field))
    assert values(fresh.attributes["wind"]) == values(old.attributes["wind"])
    heat = np.array(values(old.attributes["heat"]))
    assert_array_equal(values(fresh.attributes["heat"]), heat[cut.vertices])
    load = {tuple(sorted(e.vertices)): old.attributes["load"].data[e.index].value for e in old.edges}
    for edge in fresh.edges:
        pair = tuple(sorted(int(cut.vertices[v]) for v in edge.vertices))
        assert fresh.attributes["load"].data[edge.index].value == load[pair]
    assert len(boundary_edges(fresh)) == len(boundary_edges(old)) + 2 * (len(seam) - 1)


def test_cut_through_a_polygon_makes_triangles(addon, bridge, results):
    """Where the cut follows the diagonal of a quad, the quad falls into triangles with its corners' data."""
    ob = dressed_ring()
    plan = bridge.read_plan(ob)
    prepared = addon.cmc_addon.background.plan_cache.prepare(plan)
    rows = prepared.triangles.copy()
    torn = 30
    mine = np.flatnonzero(prepared.owners == torn)
    common = np.intersect1d(rows[mine[0]], rows[mine[1]])
    rows[mine[1]][:] = 0
    rows[mine[1]] = [len(plan.positions) + int(np.searchsorted(common, v)) if v in common else v
                     for v in prepared.triangles[mine[1]]]
    source = np.concatenate([np.arange(len(plan.positions)), common]).astype(np.int32)
    cut = results.find_cut(plan, prepared.triangles, prepared.owners, rows, source)
    fresh = results.fresh_mesh(ob, None, plan, cut)
    assert len(fresh.polygons) == len(ob.data.polygons) + 1
    assert cut.faces.tolist() == sorted([*range(120), torn])
    for number, origin in enumerate(cut.faces):
        polygon, old = fresh.polygons[number], ob.data.polygons[origin]
        assert polygon.material_index == old.material_index
        assert len(polygon.vertices) == (3 if origin == torn else 4)
        uv = {v: tuple(ob.data.uv_layers[0].uv[c].vector) for v, c in zip(
            old.vertices, old.loop_indices, strict=True)}
        for vertex, corner in zip(polygon.vertices, polygon.loop_indices, strict=True):
            assert tuple(fresh.uv_layers[0].uv[corner].vector) == uv[cut.vertices[vertex]]


def test_no_cut_where_nothing_is_doubled(addon, bridge, results):
    ob = quad_disc()
    plan = bridge.read_plan(ob)
    prepared = addon.cmc_addon.background.plan_cache.prepare(plan)
    rows, source = prepared.triangles, np.arange(len(plan.positions))
    assert results.find_cut(plan, rows, prepared.owners, rows, source) is None


# --- numbers in messages -------------------------------------------------------------------

def test_messages_count_as_blender_does(addon, bridge):
    """Triangles become polygons (each once), edges Blender's edges, in the text and as attributes."""
    from cmc_formfinding.solver.errors import MeshError, plural

    ob = quad_disc()
    plan = bridge.read_plan(ob)
    prepared = addon.cmc_addon.background.plan_cache.prepare(plan)
    quads = np.flatnonzero(prepared.owners >= 30)[:30]
    error = MeshError(f"{plural('face', quads).capitalize()} have no area.", faces=quads)
    renumbered = addon.cmc_addon.bridges.numbering.in_plan_numbers(error, plan, prepared.triangles, prepared.owners)
    assert renumbered.faces == tuple(range(30, 45))
    assert str(renumbered) == "Faces 30, 31, 32, 33, 34, 35, 36, 37 and 7 more have no area."

    text = "Faces 24, 25 are wrong; see edge 0 (vertices 0, 1) and face 3."
    error = MeshError(text, faces=(24, 25), edges=(0,))
    renumbered = addon.cmc_addon.bridges.numbering.in_plan_numbers(error, plan, prepared.triangles, prepared.owners)
    edge = next(e.index for e in ob.data.edges if set(e.vertices) == {0, 1})
    assert str(renumbered) == f"Face 24 is wrong; see edge {edge} (vertices 0, 1) and face 3."
    assert renumbered.edges == (edge,)
    assert type(renumbered) is MeshError
