"""The rim in the overlay: the normals that the conditions prescribe, also in edit mode and with modifiers."""

from __future__ import annotations

import bpy
import numpy as np
import pytest
from numpy.testing import assert_allclose

from .overlay_scenes import arcs, disc, matrix_of, sides_of, square
from .scenes import add_group, boundary_edges, quad_disc, quad_ring


@pytest.fixture
def rim(addon):
    """The rim of a plan now; world directions, positions relative to the origin of the plan."""

    def look(plan):
        bpy.context.view_layer.update()
        return addon.cmc_addon.drawing.overlay.seen_plan_of(bpy.context, plan).rim

    return look


# --- what the conditions prescribe ----------------------------------------------------------

def test_on_a_disc_normals_point_outwards(rim):
    (walk,) = rim(disc()).walks
    assert walk.closed and walk.uid == 1 and len(walk.points) == 25
    assert_allclose(walk.normals, walk.points / 4.0, atol=1e-6)
    assert_allclose(walk.length, 24 * 8 * np.sin(np.pi / 24), rtol=1e-6)


@pytest.mark.parametrize("tilt", [-0.5, 0.3, np.pi / 2])
def test_a_tilt_turns_them_upwards(rim, tilt):
    (walk,) = rim(disc(tilt=tilt)).walks
    radial = walk.points / 4.0
    assert_allclose(walk.normals, np.cos(tilt) * radial + np.sin(tilt) * np.array([0, 0, 1]), atol=1e-6)


@pytest.mark.parametrize(
    "kind, parameters",
    [("PLANE", {"normal": (1, 2, 2)}), ("TWISTED", {"m": 2.0}), ("GAUSS_MAP", {}), ("MIRROR", {"normal": (0, 0, 1)})],
)
@pytest.mark.parametrize("blend", [0.0, 3.0])
@pytest.mark.parametrize("transform", ["plain", "stretched", "mirrored"])
def test_they_are_those_of_the_whole_plan(addon, rim, kind, parameters, blend, transform):
    plan = quad_disc(rise=1.0)
    plan.matrix_world = matrix_of(transform)
    first, second, third = arcs(plan, 0, 90, 200, 330)
    add_group(plan, "a", first, kind, **parameters)
    add_group(plan, "b", second, "BINORMAL", tilt=0.4)
    add_group(plan, "c", third, "BINORMAL", tilt=0.8)
    plan.cmc.blend = blend
    seen = rim(plan)
    found = np.concatenate([np.hstack([w.points, w.normals])[:-1] for w in seen.walks])
    points, normals, mirrors = whole(addon, plan)
    assert len(points) + len(mirrors) == len(found) == 24
    for point, normal in zip([*points, *mirrors], [*normals, *np.full_like(mirrors, np.nan)], strict=True):
        (at,) = np.flatnonzero(np.linalg.norm(found[:, :3] - point, axis=1) < 1e-4)
        assert_allclose(found[at, 3:], normal, atol=1e-5)
    assert {w.uid for w in seen.walks} == {0, 1, 2, 3}


def whole(addon, plan):
    """Points, normals and points on mirrors, from the conditions of the whole plan."""
    from cmc_formfinding.cmc_addon.background import plan_cache
    from cmc_formfinding.cmc_addon.tasks import solve
    from cmc_formfinding.solver.domain.sites import SiteGraph
    from cmc_formfinding.solver.gauss.admissible import resolved
    from cmc_formfinding.solver.shells.plan_conditions import plan_conditions

    bpy.context.view_layer.update()
    task = solve.SolveTask.read(bpy.context, plan, solve.settings_of(plan.cmc))
    prepared = plan_cache.prepare(task.mesh)
    domain = prepared.solver.domain
    settings = solve.solver_settings(task.settings)
    conditions = plan_conditions(task.plan(prepared), settings, domain)
    held = resolved(conditions, SiteGraph.of(domain, "vertices"))
    points = task.mesh.positions - np.array(plan.matrix_world.translation)
    return points[held.fixed], held.data, points[held.mirrors.sites]


def test_a_plan_with_lengths_of_its_own_turns_by_them(addon, rim):
    bpy.ops.mesh.primitive_circle_add(vertices=24, radius=3, fill_type="NGON")
    bpy.ops.cmc.mesh_plan(edge_length=0.8)
    plan = bpy.context.object
    add_group(plan, "all", boundary_edges(plan.data), "TWISTED", m=1.0)
    drawn = rim(plan).walks[0].normals
    ends = np.array([[plan.data.vertices[v].co for v in edge.vertices] for edge in plan.data.edges])
    lengths = np.linalg.norm((ends[:, 1] - ends[:, 0]) * [1.0, 2.0, 1.0], axis=1)
    plan.data.attributes.new("cmc_length", "FLOAT", "EDGE").data.foreach_set("value", lengths)
    plan.data.update()
    (walk,) = rim(plan).walks
    points, normals, _ = whole(addon, plan)
    order = [np.linalg.norm(points - point, axis=1).argmin() for point in walk.points]
    assert_allclose(walk.normals, normals[order], atol=1e-6)
    assert np.abs(walk.normals - drawn).max() > 0.1


def test_around_a_court_they_point_into_it(rim):
    plan = quad_ring()
    walks = rim(add_group(plan, "all", boundary_edges(plan.data), "BINORMAL") and plan).walks
    assert len(walks) == 2
    for walk in walks:
        centre = walk.points[:-1].mean(axis=0)
        outwards = np.einsum("ij,ij->i", walk.normals, walk.points - centre)
        assert (outwards > 0).all() or (outwards < 0).all()
    assert sum((np.einsum("ij,ij->i", w.normals, w.points - w.points[:-1].mean(axis=0)) < 0).all() for w in walks) == 1


def test_between_mirrors_the_shell_faces_as_the_mark_says(rim):
    plan = square()
    for k, (normal, edges) in enumerate(zip([(0, -1, 0), (1, 0, 0)], sides_of(plan)[:2], strict=True)):
        add_group(plan, f"m{k}", edges, "MIRROR", normal=normal)
    seen = rim(plan)
    assert_allclose(seen.corners, [[2, -2, 0]], atol=1e-6)
    assert_allclose(seen.corner_normals, [[0, 0, 1]], atol=1e-6)
    mark = plan.data.attributes.new("cmc_flipped_corner", "INT", "POINT")
    corner = next(v.index for v in plan.data.vertices if v.co.x > 1.9 and v.co.y < -1.9)
    mark.data[corner].value = 1
    plan.data.update()
    assert_allclose(rim(plan).corner_normals, [[0, 0, -1]], atol=1e-6)


def test_the_side_a_plan_looks_to_is_that_of_the_whole(addon, rim):
    plan = square()
    below, right, above, _ = sides_of(plan)
    for name, normal, edges in (("m0", (0, 1, 0), below), ("m1", (1, 0, 0), right)):
        add_group(plan, name, edges, "MIRROR", normal=normal)
    add_group(plan, "rim", above, "BINORMAL")
    for vertex in plan.data.vertices:  # a mushroom: along the rim its faces look down
        if max(abs(vertex.co.x), abs(vertex.co.y)) < 1.9:
            vertex.co *= 4.0
            vertex.co.z = 1.0
    plan.data.update()
    seen = rim(plan)
    assert_allclose(seen.up, [0, 0, 16], atol=1e-5)
    points, normals, _ = whole(addon, plan)
    (at,) = np.flatnonzero(np.linalg.norm(points - [2, -2, 0], axis=1) < 1e-5)
    assert_allclose(normals[at], [0, 0, 1], atol=1e-6)
    assert_allclose(seen.corner_normals, [normals[at]], atol=1e-6)


# --- what makes no sense --------------------------------------------------------------------

def test_an_invalid_group_leaves_the_others(rim):
    plan = quad_disc()
    first, second = arcs(plan, 0, 90, 180)
    add_group(plan, "bad", first, "PLANE", normal=(0, 0, 0))
    add_group(plan, "good", second, "BINORMAL")
    walks = {walk.uid: walk for walk in rim(plan).walks}
    assert np.isnan(walks[1].normals[1:-1]).all() and np.isnan(walks[1].middles).all()
    assert np.isfinite(walks[2].normals[1:-1]).all()


def test_normals_that_cancel_are_left_out(rim):
    plan = quad_disc()
    first, second = arcs(plan, 0, 90, 180)
    add_group(plan, "a", first, "PLANE", normal=(0, 0, 1))
    add_group(plan, "b", second, "PLANE", normal=(0, 0, -1))
    walks = {walk.uid: walk for walk in rim(plan).walks}
    assert np.isnan(walks[1].normals[-1]).all() and np.isfinite(walks[1].normals[1:-1]).all()


# --- in edit mode and with modifiers ---------------------------------------------------------

@pytest.mark.parametrize("modified", [False, True])
@pytest.mark.parametrize("applied", [False, True])
def test_in_edit_mode_the_edited_mesh_is_drawn(addon, rim, modified, applied):
    plan = disc(tilt=0.3)
    plan.cmc.apply_modifiers = applied
    if modified:
        plan.modifiers.new("wide", "SIMPLE_DEFORM").deform_method = "TAPER"
        plan.modifiers["wide"].factor = 0.5
    stored = rim(plan)
    bpy.ops.object.mode_set(mode="EDIT")
    edited = rim(plan)
    for a, b in zip(stored.walks, edited.walks, strict=True):
        assert_allclose(a.points, b.points, atol=1e-5)
        assert_allclose(a.normals, b.normals, atol=1e-5)
    bpy.ops.mesh.select_all(action="SELECT")
    bpy.ops.transform.translate(value=(0, 0, 1.5))
    updates = []
    bpy.app.handlers.depsgraph_update_post.append(lambda _, graph: updates.extend(graph.updates))
    after = rim(plan)
    bpy.context.view_layer.update()
    assert len(updates) == 0, "to look must not change anything"
    bpy.app.handlers.depsgraph_update_post.pop()
    if not (modified and applied):
        assert_allclose(after.walks[0].points, edited.walks[0].points + [0, 0, 1.5], atol=1e-5)
    bpy.ops.object.mode_set(mode="OBJECT")


def test_modifiers_that_move_are_followed(addon, rim):
    plan = disc()
    plan.cmc.apply_modifiers = True
    bend = plan.modifiers.new("wide", "SIMPLE_DEFORM")
    bend.deform_method, bend.deform_axis, bend.factor = "STRETCH", "X", 0.0
    bend.keyframe_insert("factor", frame=1)
    bend.factor = 0.5
    bend.keyframe_insert("factor", frame=10)
    bpy.context.scene.frame_set(1)
    before = rim(plan).walks[0].points
    assert_allclose(np.linalg.norm(before, axis=1), 4.0, rtol=1e-5)
    bpy.context.scene.frame_set(10)
    assert rim(plan).walks[0].points[:, 0].max() > 4.2
