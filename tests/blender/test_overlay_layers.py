"""The layers of the overlay: arrows, lines, planes, cuts and gaps, with exact shape, number and place."""

from __future__ import annotations

import json

import bpy
import numpy as np
import pytest
from numpy.testing import assert_allclose

from .overlay_scenes import arcs, disc, frame, layers, matrix_of, only, sides_of, square
from .scenes import activate, add_group, boundary_edges, positions, quad_disc, quad_ring


def test_arrows_stand_on_the_rim_and_point_outwards(addon):
    plan = disc()
    only("show_normals")
    shafts, heads = layers(frame(addon))
    assert (shafts.kind, heads.kind) == ("LINES", "TRIS")
    lines = shafts.points.reshape(-1, 2, 3)
    assert len(lines) == 24
    radial = lines[:, 0] / 4.0
    assert_allclose(np.linalg.norm(radial, axis=1), 1.0, rtol=1e-6)
    along = lines[:, 1] - lines[:, 0]
    assert_allclose(along, np.linalg.norm(along, axis=1)[:, None] * radial, atol=1e-6)
    tips = np.linalg.norm(heads.points, axis=1).max()
    bpy.context.scene.cmc.arrow_scale = 2.0
    assert_allclose(np.linalg.norm(layers(frame(addon), "TRIS")[0].points, axis=1).max() - 4, 2 * (tips - 4), rtol=1e-5)
    assert_allclose(shafts.colour[:3], addon.cmc_addon.drawing.palette.colour_of(1))
    assert plan == bpy.context.object


def test_parts_are_placed_by_the_object(addon):
    plan = disc()
    plan.matrix_world = matrix_of("mirrored")
    only("show_groups")
    (part,) = frame(addon)
    drawn = part.layers[0].points @ np.array(part.matrix)[:3, :3].T + np.array(part.matrix)[:3, 3]
    world = np.array([plan.matrix_world @ v.co for v in plan.data.vertices])
    assert len(drawn) == 48
    for point in drawn:
        assert np.linalg.norm(world - point, axis=1).min() < 1e-5


@pytest.mark.parametrize("columns, count", [(24, 64), (400, 64), (400, 10)])
def test_there_are_no_more_arrows_than_the_setting(addon, columns, count):
    plan = quad_disc(rings=2, columns=columns)
    add_group(plan, "rim", boundary_edges(plan.data), "BINORMAL")
    only("show_normals")
    bpy.context.scene.cmc.arrow_count = count
    lines = layers(frame(addon), "LINES")[0].points.reshape(-1, 2, 3)
    assert len(lines) == min(columns, count)
    turn = np.sort(np.arctan2(lines[:, 0, 1], lines[:, 0, 0]))
    assert_allclose(np.diff(turn), 2 * np.pi / len(turn), rtol=2e-4)
    along = lines[:, 1] - lines[:, 0]
    assert_allclose(np.cross(along, lines[:, 0])[:, 2], 0.0, atol=1e-4)


def test_edges_in_no_group_are_dashed_and_grey(addon):
    plan = quad_disc()
    first, _ = arcs(plan, 0, 90, 180)
    add_group(plan, "a", first, "BINORMAL")
    only("show_ungrouped")
    (layer,) = layers(frame(addon))
    assert len(set(layer.colour[:3])) == 1
    length = np.linalg.norm(np.diff(layer.points.reshape(-1, 2, 3), axis=1), axis=2).sum()
    rest = 18 * 8 * np.sin(np.pi / 24)
    assert_allclose(length, 0.55 * rest, rtol=0.02)
    angle = np.degrees(np.arctan2(layer.points[:, 1], layer.points[:, 0])) % 360
    assert angle[angle > 1e-3].min() > 89


def test_in_edit_mode_lines_let_the_selection_through(addon):
    disc()
    only("show_groups")
    (before,) = layers(frame(addon))
    bpy.ops.object.mode_set(mode="EDIT")
    (after,) = layers(frame(addon))
    assert before.colour[3] == 1.0 and before.edged
    assert after.colour[3] < 0.6 and after.width > before.width and not after.edged
    bpy.ops.object.mode_set(mode="OBJECT")


def test_tangent_planes_are_square_to_the_normals(addon):
    disc(tilt=0.4)
    only("show_tangents")
    fill = layers(frame(addon), "TRIS")[0].points.reshape(-1, 3, 3)
    assert len(fill) == 2 * 24
    assert bpy.context.scene.cmc.bl_rna.properties["show_tangents"].default is False
    normals = np.cross(fill[:, 1] - fill[:, 0], fill[:, 2] - fill[:, 0])
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    centre = 0.5 * (fill[::2, 0] + fill[::2, 2])
    radial = centre / np.linalg.norm(centre, axis=1)[:, None]
    expected = np.cos(0.4) * radial + np.sin(0.4) * np.array([0, 0, 1])
    assert_allclose(np.abs(np.einsum("ij,ij->i", normals[::2], expected)), 1.0, atol=1e-5)


def test_a_mirror_has_ticks_in_its_plane_and_its_plane_stands_on_its_edges(addon):
    plan = square()
    add_group(plan, "wall", sides_of(plan)[1], "MIRROR", normal=(1, 0, 0))
    only("show_normals")
    ticks = next(layer for layer in layers(frame(addon), "LINES") if layer.colour[:3] == colour(addon, 1))
    lines = ticks.points.reshape(-1, 2, 3)
    assert_allclose(lines[..., 0], 2.0, atol=1e-6)
    assert_allclose(lines[:, 0, 1], lines[:, 1, 1], atol=1e-6)
    only("show_mirrors")
    fill = layers(frame(addon), "TRIS")[0].points
    assert_allclose(fill[:, 0], 2.0, atol=1e-6)
    assert fill[:, 1].min() < -2 and fill[:, 1].max() > 2 and fill[:, 2].max() > 1
    plan.data.cmc.groups[0].normal = (0, 0, 1)
    assert layers(frame(addon), "TRIS"), "a floor"
    plan.data.cmc.groups[0].normal = (0, 1, 0)
    assert not layers(frame(addon)), "square to its own edges: where it is, only the shell can tell"


def colour(addon, uid):
    return addon.cmc_addon.drawing.palette.colour_of(uid)


def test_after_a_solve_the_plane_is_where_the_shell_has_it(addon):
    plan = square(9)
    add_group(plan, "wall", sides_of(plan)[1], "MIRROR", normal=(1, 0, 0))
    bpy.ops.cmc.solve()
    only("show_mirrors")
    shell = plan.cmc.f_plus
    shell.location.z += 3.0
    (part,) = [part for part in frame(addon) if part.layers]
    assert part.matrix == shell.matrix_world
    fill = layers([part], "TRIS")[0].points
    offset = json.loads(plan.cmc.report)["planes"][0]["offset"]
    assert_allclose(fill[:, 0] + shell.cmc.placed_at[0], offset, atol=1e-5)
    heights = np.array([v.co.z for v in shell.data.vertices])
    assert fill[:, 2].min() <= heights.min() and fill[:, 2].max() >= heights.max()
    shell.hide_set(True)
    assert_allclose(layers(frame(addon), "TRIS")[0].points[:, 0], 2.0, atol=1e-6)
    shell.hide_set(False)
    plan.data.cmc.groups[0].normal = (1, 0.2, 0)
    assert not any(part.matrix == shell.matrix_world for part in frame(addon)), "the group was changed since"


# --- gaps and cuts --------------------------------------------------------------------------

def court():
    plan = quad_ring()
    add_group(plan, "all", boundary_edges(plan.data), "BINORMAL", tilt=0.6)
    bpy.ops.cmc.solve()
    assert plan.cmc.f_plus is not None and len(plan.cmc.f_plus.data.vertices) > len(plan.data.vertices)
    return plan


def test_the_cut_is_drawn_on_the_plan_and_on_both_sides_of_the_shell(addon):
    plan = court()
    only("show_cut")
    parts = [part for part in frame(addon) if part.layers]
    on_shell = next(part for part in parts if part.matrix == plan.cmc.f_plus.matrix_world and len(part.layers))
    on_plan = next(part for part in parts if part is not on_shell)
    ends = on_plan.layers[0].points.reshape(-1, 2, 3)
    assert 2 * len(ends) == len(on_shell.layers[0].points) // 2
    radii = np.linalg.norm(ends - np.array([0.4, 0, 0]), axis=2)
    assert np.ptp(radii) > 1.5, "from the court to the outer rim"
    rim_edges = {tuple(plan.data.edges[e].vertices) for e in boundary_edges(plan.data)}
    points = positions(plan)
    for end in ends:
        pair = sorted(np.linalg.norm(points - point, axis=1).argmin() for point in end)
        assert tuple(pair) not in rim_edges
    activate(plan.cmc.f_plus)
    assert len(layers(frame(addon))) == 2, "also with the shell active"
    plan.cmc.f_plus.hide_set(True)
    activate(plan)
    assert_allclose(layers(frame(addon))[0].points, on_plan.layers[0].points)
    assert len(layers(frame(addon))) == 1


def test_a_shell_that_closes_has_no_cut(addon):
    plan = disc(tilt=0.4)
    bpy.ops.cmc.solve()
    only("show_cut")
    assert not layers(frame(addon))
    assert "cmc_cut" not in plan.cmc.f_plus.data.attributes


def test_the_gap_is_an_arrow_that_goes_with_the_shell(addon):
    plan = court()
    only("show_gaps")
    (part,) = [part for part in frame(addon) if part.layers]
    hole = json.loads(plan.cmc.report)["holes"][0]
    start = part.layers[0].points[0]
    assert_allclose(np.array(part.matrix) @ [*start, 1], [*hole["at"], 1], atol=1e-4)
    plan.cmc.f_plus.location.x += 2.0
    (moved,) = [part for part in frame(addon) if part.layers]
    assert_allclose(np.array(moved.matrix) @ [*start, 1] - [*hole["at"], 1], [2, 0, 0, 0], atol=1e-4)


# --- when it is drawn -----------------------------------------------------------------------

def test_hidden_objects_and_other_meshes_are_not_drawn(addon):
    plan = disc()
    assert frame(addon)
    plan.hide_set(True)
    assert not frame(addon)
    plan.hide_set(False)
    bpy.context.scene.cmc.show_all = False
    assert not frame(addon)
    bpy.context.scene.cmc.show_all = True
    other = bpy.data.scenes.new("other")
    with bpy.context.temp_override(scene=other, view_layer=other.view_layers[0]):
        assert not addon.cmc_addon.drawing.overlay.frame(bpy.context)
    quad_disc("just a mesh")
    assert not frame(addon)
    activate(None)
    assert not frame(addon)
    bpy.ops.object.camera_add()
    assert not frame(addon)


def test_a_line_that_holds_the_rim_has_a_bright_core(addon):
    """Of a group on its line, and of edges in no group where these are on theirs; not of a group on a chosen curve."""
    plan = quad_disc()
    first, second, third = arcs(plan, 0, 90, 180, 270)
    add_group(plan, "a", first, "LINE")
    group = add_group(plan, "b", second, "LINE")
    add_group(plan, "c", third, "BINORMAL")
    only("show_groups")
    cores = [layer for layer in layers(frame(addon)) if layer.colour[:3] == (1.0, 1.0, 1.0)]
    assert [len(core.points) for core in cores] == [2 * len(first), 2 * len(second)]
    curve = bpy.data.objects.new("Curve", circle_curve(5.0))
    bpy.context.scene.collection.objects.link(curve)
    curve.location.z = 3.0
    group.curve = curve
    parts = frame(addon)
    held = [part for part in parts if tuple(part.matrix.translation) == (0.0, 0.0, 3.0)]
    assert len(held) == 1 and len(held[0].layers) == 2
    assert_allclose(np.linalg.norm(held[0].layers[0].points[:, :2], axis=1), 5.0, rtol=1e-3)
    assert_allclose(held[0].layers[0].colour[:3], addon.cmc_addon.drawing.palette.colour_of(group.uid))
    cores = [layer for layer in layers(frame(addon)) if layer.colour[:3] == (1.0, 1.0, 1.0)]
    assert len(cores) == 2
    curve.hide_set(True)
    assert len(frame(addon)) == 1
    only("show_ungrouped")
    assert len(layers(frame(addon))) == 1
    plan.cmc.default_kind = "LINE"
    outer, core = layers(frame(addon))
    assert core.colour[:3] == (1.0, 1.0, 1.0) and core.width < outer.width
    count = 2 * (24 - len(first) - len(second) - len(third))
    assert len(outer.points) == len(core.points) == count
    bpy.ops.object.mode_set(mode="EDIT")
    (pale,) = layers(frame(addon))
    assert len(pale.points) == count and pale.colour[3] < 1.0, "without dashes and core, over the selection"


def test_an_upright_wall_stands_over_a_leaning_line(addon):
    plan = quad_disc()
    first, _ = arcs(plan, 0, 90, 180)
    add_group(plan, "a", first, "LEAN", angle=np.radians(50))
    only("show_groups")
    _, fill, edges = layers(frame(addon))
    assert (fill.kind, edges.kind, fill.hides) == ("TRIS", "LINES", True)
    assert_allclose(np.linalg.norm(fill.points[:, :2], axis=1), 4.0, rtol=1e-5)
    height = fill.points[:, 2].max()
    assert height > 0.3
    for layer in (fill, edges):
        assert_allclose(np.abs(layer.points[:, 2]), height)
    assert len(fill.points) == 6 * len(first)


def circle_curve(radius: float):
    data = bpy.data.curves.new("Circle", "CURVE")
    data.dimensions = "3D"
    spline = data.splines.new("POLY")
    angles = np.linspace(0, 2 * np.pi, 90, endpoint=False)
    spline.points.add(len(angles) - 1)
    for point, t in zip(spline.points, angles.tolist(), strict=True):
        point.co = (radius * np.cos(t), radius * np.sin(t), 0.0, 1.0)
    spline.use_cyclic_u = True
    return data
