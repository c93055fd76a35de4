"""Geographic coordinates: outlines, curves, plans, fits and imports far from the origin give what they give near it."""

from __future__ import annotations

import bpy
import numpy as np
import pytest

from .scenes import activate, link, mesh_object

FINISHED = {"FINISHED"}
HALL = np.array([(0, 0, 0), (18, 0, 0), (18, 12, 0), (0, 12, 0)], dtype=float)
PLACES = {"UTM": (500000, 5400000, 420), "LV95": (2683000, 1247000, 0)}


def points(ob) -> np.ndarray:
    """Vertices in the world, in double precision."""
    bpy.context.view_layer.update()
    matrix = np.array(ob.matrix_world, dtype=np.float64)
    return np.array([v.co for v in ob.data.vertices], dtype=np.float64) @ matrix[:3, :3].T + matrix[:3, 3]


def outline(place) -> bpy.types.Object:
    return mesh_object("Hall", HALL + place, [(0, 1, 2, 3)])


def drawn_curve(place) -> bpy.types.Object:
    curve = bpy.data.curves.new("Hall", "CURVE")
    curve.dimensions = "3D"
    spline = curve.splines.new("POLY")
    spline.points.add(3)
    for point, co in zip(spline.points, HALL + place, strict=True):
        point.co = (*co, 1.0)
    spline.use_cyclic_u = True
    return link(bpy.data.objects.new("Hall", curve))


def area(plan) -> float:
    a, b, c = points(plan)[[list(p.vertices) for p in plan.data.polygons]].transpose(1, 0, 2)
    return 0.5 * np.cross(b - a, c - a)[:, 2].sum()


@pytest.mark.parametrize("draw", [outline, drawn_curve])
def test_plan_and_shell_are_the_same_everywhere(draw) -> None:
    found = []
    for place in ((0, 0, 0), *PLACES.values()):
        draw(place)
        assert bpy.ops.cmc.mesh_plan(edge_length=1.2) == FINISHED
        plan = bpy.context.object
        np.testing.assert_allclose(plan.location, np.array(place) + (9, 6, 0), atol=0.5, err_msg="origin in its middle")
        assert bpy.ops.cmc.solve(intersections=False) == FINISHED
        found.append([points(ob) - place for ob in (plan, plan.cmc.f_plus)])
    for plan, shell in found[1:]:
        np.testing.assert_allclose(plan, found[0][0], atol=1e-5)
        np.testing.assert_allclose(shell, found[0][1], atol=1e-4)


def test_the_usual_plan_in_utm() -> None:
    outline(PLACES["UTM"])
    assert bpy.ops.cmc.mesh_plan(corners="ALL") == FINISHED
    plan = bpy.context.object
    plan.cmc.default_kind = "BINORMAL"
    assert area(plan) == pytest.approx(213.12, abs=0.01)
    assert bpy.ops.cmc.solve(intersections=False) == FINISHED
    width, _, rise = np.ptp(points(plan.cmc.f_plus), axis=0)
    assert (width, rise) == pytest.approx((17.4346, 12.4825), rel=1e-4)


@pytest.mark.parametrize("place", PLACES.values(), ids=PLACES)
def test_results_of_a_plan_that_is_far_from_its_own_origin(place) -> None:
    """A plan with integer coordinates, which single precision holds, and its origin at 0."""
    u, v = np.meshgrid(np.arange(13), np.arange(9))
    grid = np.column_stack([u.ravel(), v.ravel(), 0 * u.ravel()])
    faces = [(r * 13 + c, r * 13 + c + 1, r * 13 + c + 14, r * 13 + c + 13) for r in range(8) for c in range(12)]
    shells = []
    for at in ((0, 0, 0), place):
        plan = mesh_object("Grid", grid + np.array(at), faces)
        activate(plan)
        assert bpy.ops.cmc.solve() == FINISHED
        shells.append(points(plan.cmc.f_plus) - at)
    np.testing.assert_allclose(shells[1], shells[0], atol=1e-4)


def test_an_origin_that_is_near_stays(addon) -> None:
    near_origin = addon.cmc_addon.bridges.mesh_bridge.near_origin
    box = np.array([(0.0, 0, 0), (18, 12, 0)])
    for base in ((0, 0, 0), (100, -200, 3)):
        assert near_origin(np.array(base, dtype=float), box).tolist() == list(base)
    far = box + PLACES["UTM"]
    origin = near_origin(np.zeros(3), far)
    assert (np.float32(origin) == origin).all() and np.abs(far - origin).max() < 64 * 18
    moved = far + np.random.default_rng(0).uniform(-1, 1, far.shape)
    assert (near_origin(np.zeros(3), moved) == origin).all(), "small changes leave it where it is"


def test_an_imported_plan_keeps_its_digits(addon, tmp_path) -> None:
    from cmc_formfinding.solver.io.mesh_files import read_mesh

    text = "v 500000.125 5400000.25 420\nv 500018.125 5400000.25 420\nv 500018.125 5400012.375 420\nf 1 2 3\n"
    (tmp_path / "site.obj").write_text(text)
    data = read_mesh(tmp_path / "site.obj")
    plan = addon.cmc_addon.bridges.import_bridge.import_plan(bpy.context, "Site", data, [])
    np.testing.assert_allclose(points(plan), data.positions, atol=1e-4, rtol=0)
