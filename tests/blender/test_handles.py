"""Handles in the viewport: where they stand, and what a drag of the mouse makes of their numbers."""

from __future__ import annotations

import bpy
import numpy as np
import pytest
from numpy.testing import assert_allclose

from .overlay_scenes import arcs, disc
from .scenes import activate, add_group, boundary_edges, positions, quad_disc, quad_ring
from .solved_plans import solved


def handles():
    from cmc_formfinding.cmc_addon.drawing import handles

    return handles


def screens():
    from cmc_formfinding.cmc_addon.drawing import screen

    return screen


def gizmos():
    from cmc_formfinding.cmc_addon.drawing import handle_gizmos

    return handle_gizmos


def screen(eye=(0.0, -14.0, 9.0), target=(0.0, 0.0, 1.0), lens=1.2, flat=False):
    """A view of 1000 × 800 pixels from a place to another one, Z upwards; flat: a parallel projection."""
    eye, target = np.array(eye), np.array(target)
    back = (eye - target) / np.linalg.norm(eye - target)
    right = np.cross([0.0, 1e-9, 1.0], back)
    right /= np.linalg.norm(right)
    turn = np.stack([right, np.cross(back, right), back])
    view = np.eye(4)
    view[:3, :3], view[:3, 3] = turn, -turn @ eye
    projection = np.diag([lens, lens * 1000 / 800, -1.0, 0.0])
    projection[2, 3], projection[3, 2] = -0.2, -1.0
    if flat:
        projection = np.diag([0.1, 0.1 * 1000 / 800, -0.01, 1.0])
    return screens().Screen(projection @ view, 1000.0, 800.0)


VIEWS = [
    dict(), dict(eye=(12.0, 1.0, 3.0)), dict(eye=(0.0, 0.01, 15.0)), dict(eye=(-5.0, 9.0, -4.0)), dict(flat=True),
]


def test_a_pixel_of_the_screen_is_as_long_as_it_says():
    for view in VIEWS:
        shown, at = screen(**view), np.array([1.0, -2.0, 0.5])
        right = shown.matrix[0, :3] / np.linalg.norm(shown.matrix[0, :3])
        ends = shown.pixels(np.stack([at, at + shown.pixel(at) * right]))
        assert_allclose(np.linalg.norm(ends[1] - ends[0]), 1.0, rtol=1e-3)
    behind = screen().pixels(np.array([[0.0, -30.0, 9.0]]))
    assert np.isnan(behind).all() and np.isnan(screen().pixel(np.array([0.0, -30.0, 9.0])))


@pytest.mark.parametrize("kind, parameter", [("LEAN", "angle"), ("BINORMAL", "tilt")])
@pytest.mark.parametrize("degrees", [10.0, 35.0, 90.0, 120.0])
def test_a_lever_stands_in_the_tangent_plane(addon, kind, parameter, degrees):
    """0° upright, 90° flat over the plan; square to the prescribed normal, in the plane square to the rim."""
    plan = quad_disc()
    south, _ = arcs(plan, 225, 315, 360)
    add_group(plan, "South", south, kind, **{parameter: np.radians(degrees)})
    bpy.context.view_layer.update()
    (lever,) = gizmos().levers_of(bpy.context, plan)
    assert_allclose(lever.at, [0.0, -4.0 * np.cos(np.pi / 24), 0.0], atol=0.6)
    foot = lever.at / np.linalg.norm(lever.at)
    tip = (lever.tips(np.array([lever.angle]), 1.0) - lever.at)[0]
    assert_allclose(tip, np.cos(lever.angle) * np.array([0, 0, 1.0]) - np.sin(lever.angle) * foot, atol=1e-6)
    upright, level = lever.tips(np.radians([0.0, 90.0]), 2.0) - lever.at
    assert_allclose(upright, [0.0, 0.0, 2.0], atol=1e-6)
    assert_allclose(level, -2.0 * foot, atol=1e-6)


def test_levers_of_plans_that_look_down_or_are_moved_and_turned(addon):
    """The lever points upwards where the overlay's normals say so, whatever the faces do."""
    plan = disc("BINORMAL", tilt=0.3)
    plan.location = (3.0, 2.0, 1.0)
    plan.rotation_euler = (0.0, 0.0, 1.0)
    bpy.context.view_layer.update()
    (lever,) = gizmos().levers_of(bpy.context, plan)
    assert_allclose(np.linalg.norm((lever.at - [3.0, 2.0, 1.0])[:2]), 4.0 * np.cos(np.pi / 24), rtol=1e-6)
    assert lever.at[1] < 2.0 - 3.9 and abs(lever.at[0] - 3.0) < 0.6, "a whole loop has its lever in front"
    assert lever.along[2] == pytest.approx(np.cos(0.3))
    plan.data.flip_normals()
    bpy.context.view_layer.update()
    (turned,) = gizmos().levers_of(bpy.context, plan)
    assert_allclose(np.cross(turned.along, turned.normal)[2], 0.0, atol=1e-6)
    assert turned.along[2] == pytest.approx(-np.cos(0.3)), "a plan that looks down has its shell below"


@pytest.mark.parametrize("rise", [0.4, -0.4])
@pytest.mark.parametrize("degrees", [60.0, 120.0])
def test_the_shell_leaves_the_wall_along_the_lever(addon, rise, degrees):
    """Standing and hanging: the solver's normals point up in both, and the angle is the same."""
    plan = quad_disc(rings=16, columns=96)
    south, _ = arcs(plan, 225, 315, 360)
    add_group(plan, "South", south, "LEAN", angle=np.radians(degrees))
    plan.cmc.default_kind = "LINE"
    bpy.context.view_layer.update()
    (lever,) = gizmos().levers_of(bpy.context, plan)
    points = solved(plan, size="RISE", rise=rise)
    rim = min({v for e in south for v in plan.data.edges[e].vertices}, key=lambda v: abs(points[v, 0]))
    away = points - points[rim]
    inside = [v for v in range(len(away)) if 0.15 < away[v, 1] < 0.45 and abs(away[v, 0]) < 0.08]
    inward = away[inside[0]] / np.linalg.norm(away[inside[0]])
    (tip,) = lever.tips(np.array([lever.angle]), 1.0) - lever.at
    assert np.degrees(np.arccos(inward @ tip)) < 3.0, "of which half is the curvature of the shell"


@pytest.mark.parametrize("view", VIEWS)
@pytest.mark.parametrize("degrees", [12.0, 50.0, 95.0, 140.0])
def test_the_tip_stays_under_the_mouse(addon, view, degrees):
    """Dragged to where the tip is at an angle, in small steps, the lever has that angle."""
    plan = quad_disc()
    south, _ = arcs(plan, 225, 315, 360)
    add_group(plan, "South", south, "LEAN", angle=np.radians(45))
    (lever,) = gizmos().levers_of(bpy.context, plan)
    shown, angle = screen(**view), lever.angle
    for part in np.linspace(0.0, 1.0, 25)[1:]:
        wanted = (1 - part) * lever.angle + part * np.radians(degrees)
        mouse = shown.pixels(lever.tips(np.array([wanted]), 1.5))[0]
        angle = handles().turned(lever, shown, 1.5, angle, mouse)
    place = shown.pixels(lever.tips(np.array([angle]), 1.5))[0]
    assert np.linalg.norm(place - mouse) < 0.2, "pixels"
    if view.get("eye", (0, 0, 0))[2] != 15.0:  # from above the tip turns back where it lies flat
        assert_allclose(np.degrees(angle), degrees, atol=0.5)


def test_a_lever_stays_within_what_a_wall_allows(addon):
    plan = quad_disc()
    south, _ = arcs(plan, 225, 315, 360)
    add_group(plan, "South", south, "LEAN", angle=np.radians(20))
    (lever,) = gizmos().levers_of(bpy.context, plan)
    shown, angle = screen(eye=(15.0, -3.0, 1.0)), lever.angle
    for degrees in np.linspace(20.0, -90.0, 12):
        mouse = shown.pixels(lever.tips(np.radians([degrees]), 1.5))[0]
        angle = handles().turned(lever, shown, 1.5, angle, mouse)
    assert np.degrees(angle) == pytest.approx(8.0)


@pytest.mark.parametrize("view", VIEWS)
@pytest.mark.parametrize("moved", [-2.0, 0.3, 3.0])
def test_the_crown_follows_the_mouse(view, moved):
    shown, at, up = screen(**view), np.array([0.5, 0.2, 1.0]), np.array([0.0, 0.0, 1.0])
    start = np.array([12.0, 7.0])
    places = shown.pixels(np.stack([at, at + moved * up]))
    found = handles().lifted(at, up, shown, start, start + places[1] - places[0])
    if view.get("eye", (0, 0, 0))[2] == 15.0:  # from above the height of the mouse counts
        assert handles().lifted(at, up, shown, start, start + [0.0, 10.0]) == pytest.approx(10 * shown.pixel(at))
    else:
        assert found == pytest.approx(moved, abs=0.02)


# --- the number of the size --------------------------------------------------------------------

def number_at(*args, **more):
    from cmc_formfinding.cmc_addon.drawing.crown import number_at

    return number_at(*args, **more)


def cap(height, radius=4.0):
    from cmc_formfinding.cmc_addon.drawing.crown import Crown

    return Crown(np.array([0.0, 0.0, height]), height, radius, True)


@pytest.mark.parametrize("height", [-1.0, 0.0, 0.4, 2.0])
@pytest.mark.parametrize("moved", [-1.5, 0.0, 1.0])
def test_the_numbers_of_caps_are_exact(height, moved):
    new = height + moved
    curvature, volume = (
        lambda h: 2 * h / (16 + h * h),
        lambda h: np.pi * h * (48 + h * h) / 6,
    )
    known = {
        "rise": (height / 4, new / 4), "height": (height, new),
        "mean_curvature": (curvature(height), curvature(new)), "volume": (volume(height), volume(new)),
    }
    for size, (now, wanted) in known.items():
        assert number_at(cap(height), size, now, moved) == (size, pytest.approx(wanted, abs=1e-12))
        assert number_at(cap(height), size, -now, moved, flip=True) == (size, pytest.approx(-wanted, abs=1e-12))
    assert number_at(cap(height), "match_plan", 0.0, moved) == ("rise", pytest.approx(new / 4))
    assert number_at(cap(height), "span", 18.0, moved) == ("rise", pytest.approx(new / 4))


def test_the_crown_is_inside_where_the_line_is_higher():
    """A sphere's cap under a rim with two high ends: the crown is the cap's, not the ends'."""
    from cmc_formfinding.cmc_addon.drawing.crown import crown_of

    turn = np.linspace(0, 2 * np.pi, 40, endpoint=False)
    rim = np.column_stack([4 * np.cos(turn), 4 * np.sin(turn), 3 * np.cos(2 * turn)])
    circle = np.column_stack([np.cos(turn), np.sin(turn), 0 * turn])
    inside = [r * circle + [0, 0, 1 - r * r / 16] for r in (0.0, 1.0, 2.0, 3.0)]
    outer = np.stack([rim, np.roll(rim, -1, axis=0)], axis=1)
    crown = crown_of(np.concatenate([rim, *inside]), rim, outer, True)
    assert_allclose(crown.at, [0.0, 0.0, 1.0], atol=1e-12)
    assert crown.height == pytest.approx(1.0) and crown.half == pytest.approx(4.0)
    free = crown_of(np.concatenate([rim, *inside]), rim, outer, False)
    assert free.at[2] == 3.0 and free.height == pytest.approx(6.0)
    assert crown_of(np.zeros((3, 3)), np.zeros((0, 3)), np.zeros((0, 2, 3)), True) is None


def test_a_rise_has_limits_and_h_a_largest_value():
    assert number_at(cap(1.0), "rise", 0.25, 100.0) == ("rise", 2.0)
    assert number_at(cap(1.0), "mean_curvature", 2 / 17, 100.0)[1] == pytest.approx(0.25)


def test_a_free_rim_grows_with_its_crown():
    from cmc_formfinding.cmc_addon.drawing.crown import Crown

    crown = Crown(np.array([0.0, 0.0, 2.0]), 2.0, 4.0, False)
    for size, now, wanted in [("span", 8.0, 12.0), ("height", 2.0, 3.0), ("radius", 5.0, 7.5), ("rise", 0.5, 0.75)]:
        assert number_at(crown, size, now, 1.0) == (size, pytest.approx(wanted))
    assert number_at(crown, "mean_curvature", 0.2, 2.0) == ("mean_curvature", pytest.approx(0.1))
    assert number_at(crown, "height", 2.0, -9.0)[1] == pytest.approx(0.1)
    assert number_at(crown, "match_plan", 0.0, 1.0) == ("rise", pytest.approx(0.75))


# --- in Blender ----------------------------------------------------------------------------------

@pytest.mark.parametrize("size", ["RISE", "HEIGHT", "VOLUME", "MEAN_CURVATURE"])
@pytest.mark.parametrize("flip", [False, True])
def test_dragging_the_crown_by_a_length_moves_it_by_that(addon, size, flip):
    """Over a circle the laws of caps are exact; the shell is that of the new number."""
    plan = quad_disc(rings=8, columns=48)
    plan.cmc.default_kind = "LINE"
    solved(plan, size="RISE", rise=0.4, flip=flip)
    bpy.context.view_layer.update()
    crown = gizmos().crown(bpy.context, plan)
    sign = -1.0 if flip else 1.0
    assert crown.height == pytest.approx(sign * 1.6, rel=1e-3)
    assert_allclose(crown.at[:2], 0.0, atol=0.3)
    numbers = {"RISE": 0.4, "HEIGHT": 1.6, "VOLUME": np.pi * 1.6 * (48 + 1.6**2) / 6, "MEAN_CURVATURE": 3.2 / 18.56}
    _, number = number_at(crown, size.lower(), numbers[size], sign * 0.8, flip=flip)
    name = "mean_curvature" if size == "MEAN_CURVATURE" else size.lower()
    heights = solved(plan, size=size, flip=flip, **{name: number})[:, 2]
    assert_allclose(sign * heights[np.abs(heights).argmax()], 2.4, rtol=0.02)


def test_a_flat_shell_has_its_crown_in_the_middle(addon):
    plan = quad_disc(rings=6, columns=36)
    plan.cmc.default_kind = "LINE"
    solved(plan, size="RISE", rise=0.0)
    crown = gizmos().crown(bpy.context, plan)
    assert crown.height == 0.0
    assert_allclose(crown.at, 0.0, atol=0.3)


def test_heights_are_over_the_outer_line(addon):
    """Around a court whose line is higher, as the solver measures them."""
    plan = quad_ring(rings=6, columns=48, inner=1.5, outer=4.0)
    for vertex in plan.data.vertices:
        radius = np.hypot(vertex.co.x - 0.8, vertex.co.y)
        vertex.co.z = 2.0 if abs(radius - 1.5) < 1e-3 else 1.0
    plan.location = (3.0, 2.0, 1.0)
    plan.cmc.default_kind = "LINE"
    points = solved(plan, size="RISE", rise=0.5)
    bpy.context.view_layer.update()
    crown = gizmos().crown(bpy.context, plan)
    assert crown.half == pytest.approx(4.0, rel=1e-6)
    assert crown.height == pytest.approx(crown.at[2] - 2.0, abs=1e-5)
    assert 1.0 < crown.height <= points[:, 2].max() - 2.0 + 1e-5


def test_handles_are_shown_when_they_are_wanted(addon):
    plan = disc("BINORMAL", tilt=0.5)
    settings = bpy.context.scene.cmc
    assert gizmos().handled_plan(bpy.context) == plan
    assert len(gizmos().levers_of(bpy.context, plan)) == 1
    assert gizmos().crown(bpy.context, plan) is None, "there is no shell yet"
    solved(plan)
    shell = plan.cmc.f_plus
    activate(shell)
    assert gizmos().handled_plan(bpy.context) == plan
    crown = gizmos().crown(bpy.context, plan)
    assert crown.height == pytest.approx(np.ptp(positions(shell)[:, 2]), rel=1e-5)
    shell.hide_set(True)
    activate(plan)
    assert gizmos().crown(bpy.context, plan) is None
    plan.hide_set(True)
    assert not gizmos().levers_of(bpy.context, plan)
    plan.hide_set(False)
    bpy.ops.object.mode_set(mode="EDIT")
    assert gizmos().handled_plan(bpy.context) is None, "in edit mode vertices are dragged"
    bpy.ops.object.mode_set(mode="OBJECT")
    for name in ("show_handles", "show_all"):
        setattr(settings, name, False)
        assert gizmos().handled_plan(bpy.context) is None
        setattr(settings, name, True)
    plan.data.cmc.groups[0].kind = "LINE"
    assert not gizmos().levers_of(bpy.context, plan)


def test_a_group_in_many_places_has_levers_at_its_longest_sides(addon):
    plan = quad_disc(columns=48)
    pieces = arcs(plan, 0, 30, 60, 90, 120, 150, 180, 270, 300, 359)
    add_group(plan, "Sides", np.concatenate(pieces[::2]), "LEAN", angle=1.0)
    found = gizmos().levers_of(bpy.context, plan)
    assert len(found) == 3 and len({lever.uid for lever in found}) == 1
    edges = boundary_edges(plan.data)
    assert len(edges) == 48


def test_captions_of_sides_say_what_the_shell_does_there(addon):
    plan = quad_disc()
    plan.location.z = 2.0
    first, second, third = arcs(plan, 0, 90, 180, 270)
    add_group(plan, "Street", first, "LEAN", angle=np.radians(35))
    add_group(plan, "Garden", second, "MIRROR")
    add_group(plan, "Court", third, "BINORMAL", tilt=np.radians(12.5))
    plan.cmc.default_kind = "LINE"
    bpy.context.view_layer.update()
    sides = {side.text: side for side in gizmos().sides_of(bpy.context, plan)}
    assert set(sides) == {
        "Street: leans over its line, 35°", "Garden: mirror", "Court: leans, rim free, 12.5°",
        "Other edges: on the line",
    }
    assert_allclose(np.linalg.norm(sides["Garden: mirror"].points - [0, 0, 2], axis=1), 4.0, rtol=1e-6)
    shown, near = screen(), sides["Court: leans, rim free, 12.5°"].points
    ends = shown.pixels(near[2:4])
    place, (x, y) = ends.mean(axis=0), (ends[1] - ends[0]) / np.linalg.norm(ends[1] - ends[0])
    assert screens().distance(shown.pixels(near), place) < 1e-6
    assert screens().distance(shown.pixels(near), place + [5.0 * y, -5.0 * x]) == pytest.approx(5.0)
    assert screens().distance(np.full((3, 2), np.nan), place) == np.inf


def test_captions_are_in_the_units_of_the_scene(addon):
    units = bpy.context.scene.unit_settings
    units.system, units.scale_length = "METRIC", 1.0
    text = gizmos().size_text
    assert [text("rise", 0.351), text("height", 4.2), text("mean_curvature", -0.05)] == [
        "Rise 0.35", "Height 4.2 m", "H -0.05 1/m",
    ]
    assert text("volume", 12.0).startswith("Volume 12 m")
