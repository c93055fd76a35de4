"""Fit to Outline: height parameters, targets, standing and hanging."""

from __future__ import annotations

import bpy

# isort: split
import numpy as np
import pytest
from numpy.testing import assert_allclose

from .design_scenes import FEET, empties, fitted, nearest, off_line, raised_loop, report, rim_of, small_disc
from .outlines import mesh_plan, ngon
from .scenes import positions, quad_disc, values

# --- the height_parameters ---


@pytest.mark.parametrize("rise", [0.15, 0.5, 1.0])
def test_rise_keeps_the_outline(rise):
    """From flat to hemisphere over a circle: the cap of that height, its rim on the circle."""
    plan = small_disc()
    points = fitted(plan, fit_rise=rise)
    rim = rim_of(plan)
    assert off_line(points[rim], positions(plan)[rim]).max() < 0.01 * 8.0
    assert_allclose(points[:, 2].max(), 4.0 * rise, rtol=0, atol=4e-3)
    height = points[:, 2].max()
    ball = (16.0 + height**2) / (2 * height)
    assert_allclose(np.linalg.norm(points - [0, 0, height - ball], axis=1), ball, rtol=0.025, atol=0)
    assert plan.cmc.fit_rise == pytest.approx(rise)


def test_rise_keeps_an_oblong_outline_wherever_it_lies():
    plan = quad_disc(rings=5, columns=32)
    plan.location, plan.rotation_euler, plan.scale = (120.0, 30.0, 2.0), (0.0, 0.0, 0.7), (1.6, 1.0, 1.0)
    drawn = positions(plan)
    for rise in (0.3, 0.8):
        points = fitted(plan, fit_rise=rise)
        rim = rim_of(plan)
        assert off_line(points[rim], drawn[rim]).max() < 0.01 * 12.8
        extent = np.ptp(drawn[:, :2], axis=0).min()
        assert_allclose(points[:, 2].max() - 2.0, 0.5 * rise * extent, rtol=5e-3, atol=0)
    assert tuple(plan.cmc.fit.location) == pytest.approx((120.0, 30.0, 2.0))


def test_convex_corners_stay_sharp_and_in_place():
    """Of an L only the corner that points inwards is rounded; the shell stands on the other five as drawn."""
    drawn = [(0.0, 0.0), (8.0, 0.0), (8.0, 4.0), (4.0, 4.0), (4.0, 8.0), (0.0, 8.0)]
    ngon(drawn)
    plan = mesh_plan(edge_length=0.5, corners="RE_ENTRANT")
    points = fitted(plan, fit_rise=0.35)
    for k, corner in enumerate(drawn):
        away = np.linalg.norm(points - [*corner, 0.0], axis=1).min()
        assert away > 0.2 if k == 3 else away < 1e-5, corner
    assert off_line(points[rim_of(plan)], positions(plan)[rim_of(plan)]).max() < 0.01


def test_height():
    plan = small_disc()
    plan.location.z = 3.0
    points = fitted(plan, height_parameter="HEIGHT", fit_height=1.5)
    assert points[:, 2].max() - 3.0 == pytest.approx(1.5, rel=2e-3)


def test_volume():
    plan = small_disc()
    points = fitted(plan, height_parameter="VOLUME", fit_volume=40.0)
    x, y = points[:, 0], points[:, 1]
    found = 0.0
    for polygon in plan.cmc.fit.data.polygons:
        corner = list(polygon.vertices)
        for k in range(1, len(corner) - 1):
            t = [corner[0], corner[k], corner[k + 1]]
            area = 0.5 * ((x[t[1]] - x[t[0]]) * (y[t[2]] - y[t[0]]) - (x[t[2]] - x[t[0]]) * (y[t[1]] - y[t[0]]))
            found += area * points[t, 2].mean()
    assert found == pytest.approx(40.0, rel=0.01)


def test_mean_curvature():
    plan = small_disc()
    points = fitted(plan, height_parameter="MEAN_CURVATURE", fit_mean_curvature=0.2)
    assert report(plan)["mean_curvature"] == pytest.approx(0.2)
    assert points[:, 2].max() == pytest.approx(2.0, rel=0.02)
    curvature = np.array(values(plan.cmc.fit.data.attributes["cmc_mean_curvature"]))
    assert np.median(curvature) == pytest.approx(0.2, rel=0.02)


# --- what is fitted to ---


def test_a_curve_that_rises_and_falls():
    curve, line = raised_loop()
    plan = small_disc()
    points = fitted(plan, curve="Curve", fit_rise=0.5)
    assert (plan.cmc.fit_to, plan.cmc.fit_curve) == ("CURVE", curve)
    assert off_line(points[rim_of(plan)], line).max() < 0.01 * 8.0
    assert_allclose(fitted(plan), points, rtol=0, atol=1e-5)  # what was shown is kept


def test_a_curve_object():
    bpy.ops.curve.primitive_bezier_circle_add(radius=3.0, location=(10.0, 0.0, 1.0))
    circle = bpy.context.object
    plan = small_disc()
    points = fitted(plan, curve=circle.name, fit_rise=0.5)
    rim = points[rim_of(plan)] - [10.0, 0.0, 1.0]
    assert_allclose(np.linalg.norm(rim[:, :2], axis=1), 3.0, rtol=0.01, atol=0)
    assert_allclose(rim[:, 2], 0.0, rtol=0, atol=0.03)


def test_free_heights():
    """In plan the rim is on the outline; with its heights kept it is on it in space, too."""
    plan = quad_disc(rings=5, columns=32)
    plan.scale = (1.6, 1.0, 1.0)
    points = fitted(plan, free_heights=True, fit_rise=0.4)
    rim = rim_of(plan)
    drawn = positions(plan)[rim]
    assert off_line(points[rim] * [1, 1, 0], drawn).max() < 0.01 * 12.8


def test_selected_empties_are_anchors():
    plan = small_disc()
    for ob in empties(FEET):
        ob.select_set(True)
    points = fitted(plan, fit_to="ANCHORS", fit_rise=0.5)
    assert max(nearest(points, place) for place in FEET) < 0.01 * 8.0


def test_a_collection_of_anchors_with_weights():
    supports = bpy.data.collections.new("Supports")
    bpy.context.scene.collection.children.link(supports)
    off = empties([*FEET, (0.0, 0.0, 40.0)], supports)[-1]
    off.cmc.anchor_weight = 0.0
    plan = small_disc()
    points = fitted(plan, anchors="Supports")
    assert (plan.cmc.fit_to, plan.cmc.fit_anchors) == ("ANCHORS", supports)
    assert max(nearest(points, place) for place in FEET) < 0.01 * 8.0
    assert report(plan)["distances"]["anchors"] < 0.01 * 8.0, "one without weight does not count"


def test_a_missed_weak_anchor_is_reported():
    supports = bpy.data.collections.new("Supports")
    bpy.context.scene.collection.children.link(supports)
    weak = empties([(4.0, 0.0, 6.0), *FEET[1:]], supports)[0]
    weak.cmc.anchor_weight = 1e-4
    plan = small_disc()
    points = fitted(plan, anchors="Supports")
    off = nearest(points, (4.0, 0.0, 6.0))
    assert off > 1.0 and report(plan)["distances"]["anchors"] > off - 1e-3 and not report(plan)["met"]


def test_anchors_that_contradict_say_so():
    supports = bpy.data.collections.new("Supports")
    bpy.context.scene.collection.children.link(supports)
    low, high = empties([(4.0, 0.0, 0.0), (4.0, 0.0, 3.0)], supports)
    plan = small_disc()
    low.cmc.anchor_weight, high.cmc.anchor_weight = 1.0, 4.0
    points = fitted(plan, anchors="Supports")
    assert not report(plan)["met"] and "anchor is missed" in report(plan)["message"]
    assert nearest(points, (4.0, 0.0, 3.0)) < nearest(points, (4.0, 0.0, 0.0))


# --- which way up ---


def test_hanging_is_standing_in_a_mirror():
    plan = small_disc()
    plan.location.z = 2.0
    up = fitted(plan)
    down = fitted(plan, hanging=True)
    assert_allclose(down, up * [1, 1, -1] + [0, 0, 4.0], rtol=0, atol=1e-4)
    mesh = plan.cmc.fit.data
    curvature = np.array(values(mesh.attributes["cmc_mean_curvature"]))
    assert np.median(curvature) > 0
    normals, faces = np.array(values(mesh.attributes["cmc_normal"])), [p.normal for p in mesh.polygons]
    around = [normals[list(p.vertices)].mean(axis=0) for p in mesh.polygons]
    assert all(np.dot(a, n) > 0.9 for a, n in zip(around, faces, strict=True))


def test_faces_that_look_down_hang():
    plan = small_disc()
    up = fitted(plan)
    plan.data.flip_normals()
    points = fitted(plan)
    assert points[:, 2].min() == pytest.approx(-up[:, 2].max(), rel=1e-3)
    assert points[:, 2].max() < 0.05


def test_a_plan_on_a_wall():
    plan = small_disc()
    plan.rotation_euler = (np.pi / 2, 0.0, 0.0)  # its faces look along -y
    points = fitted(plan)
    assert -points[:, 1].min() == pytest.approx(2.0, rel=5e-3)
    assert abs(points[rim_of(plan), 1]).max() < 0.08


# --- bounds on the tilt --------------------------------------------------------------------


@pytest.mark.parametrize(("least", "met"), [(40.0, True), (60.0, False)])
def test_limits_of_the_tilt(least, met):
    """A cap of rise r leans by 90° - 2 atan r at its rim: of 0.4 by 46.4°."""
    plan = small_disc()
    points = fitted(plan, fit_rise=0.4, limit_tilt=True, tilt_min=np.radians(least), tilt_max=np.pi / 2)
    assert report(plan)["met"] == met
    assert (report(plan)["distances"]["tilt bounds"] < 0.01) == met
    if met:
        assert points[:, 2].max() == pytest.approx(1.6, rel=5e-3)
    assert plan.cmc.limit_tilt and plan.cmc.tilt_min == pytest.approx(np.radians(least))


def test_limits_that_are_not_on_do_not_count():
    plan = small_disc()
    points = fitted(plan, fit_rise=0.4, tilt_min=1.5, tilt_max=1.6)
    assert points[:, 2].max() == pytest.approx(1.6, rel=5e-3)
    assert "tilt bounds" not in report(plan)["distances"]


def test_limits_the_wrong_way_round():
    plan = small_disc()
    with pytest.raises(RuntimeError, match="Tilts lie between"):
        fitted(plan, limit_tilt=True, tilt_min=1.0, tilt_max=0.5)
    assert plan.cmc.fit is None
