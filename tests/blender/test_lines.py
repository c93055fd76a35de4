"""Shells on lines in Blender: kinds of groups, curves, sizes, colours, live updates, refusals."""

from __future__ import annotations

import json

import bpy
import numpy as np
import pytest
from numpy.testing import assert_allclose

from .scenes import activate, add_group, boundary_edges, link, mesh_object, positions, quad_disc, quad_ring, snapshot
from .solved_plans import solved


@pytest.fixture
def disc():
    """A round plan of radius 4, on its line all around."""
    plan = quad_disc(rings=8, columns=48)
    plan.cmc.default_kind = "LINE"
    return plan


def report(plan) -> dict:
    return json.loads(plan.cmc.report)


def circle(name: str, radius: float, height: float) -> bpy.types.Object:
    """A closed curve."""
    data = bpy.data.curves.new(name, "CURVE")
    data.dimensions = "3D"
    spline = data.splines.new("POLY")
    angles = np.linspace(0, 2 * np.pi, 72, endpoint=False)
    spline.points.add(len(angles) - 1)
    for point, t in zip(spline.points, angles.tolist(), strict=True):
        point.co = (radius * np.cos(t), radius * np.sin(t), height, 1.0)
    spline.use_cyclic_u = True
    return link(bpy.data.objects.new(name, data))


@pytest.mark.parametrize(
    "size, height",
    [
        ({}, 0.35 * 4.0),
        ({"size": "RISE", "rise": -0.5}, -2.0),
        ({"size": "HEIGHT", "height": 1.0}, 1.0),
        ({"size": "MEAN_CURVATURE", "mean_curvature": 0.0}, 0.0),
        ({"size": "MEAN_CURVATURE", "mean_curvature": -0.2}, -2.0),
        ({"size": "VOLUME", "volume": 54.45}, 2.0),
        ({"flip": True}, -0.35 * 4.0),
    ],
)
def test_the_rim_is_on_the_line_whatever_the_size(disc, size, height):
    """Caps over a circle of radius 4: with a height of 2 the radius is 5 and the volume π 2 (48 + 4) / 6 = 54.45."""
    points = solved(disc, **size)
    z = points[:, 2]
    assert_allclose(z[np.abs(z).argmax()], height, rtol=0.02, atol=1e-6)
    rim = np.unique([v for e in boundary_edges(disc.data) for v in disc.data.edges[e].vertices])
    assert_allclose(points[rim, 2], 0.0, atol=1e-6)
    assert_allclose(np.linalg.norm(points[rim, :2], axis=1), 4.0, rtol=1e-6)
    assert report(disc)["converged"]


def test_uv_layers_stay(disc):
    layer = disc.data.uv_layers.new(name="Mine")
    layer.uv.foreach_set("vector", np.random.default_rng(1).random(2 * len(disc.data.loops)).astype(np.float32))
    solved(disc)
    shell = disc.cmc.f_plus.data
    own, its = (np.empty(2 * len(mesh.loops), np.float32) for mesh in (disc.data, shell))
    disc.data.uv_layers["Mine"].uv.foreach_get("vector", own)
    shell.uv_layers["Mine"].uv.foreach_get("vector", its)
    assert_allclose(own, its)


def test_a_plan_adapted_to_corners_has_a_layer_of_its_own():
    """In it the shell is conformal, in the drawn coordinates it is not quite."""
    from cmc_formfinding.solver.domain.domain import Domain
    from cmc_formfinding.solver.measure.distortion import conformal_distortion

    count, cells = 13, range(12)
    points = [(0.5 * i, 0.35 * j + 0.08 * i * j / 12, 0.0) for j in range(count) for i in range(count)]
    faces = [(k, k + 1, k + count + 1, k + count) for k in (j * count + i for j in cells for i in cells)]
    plan = mesh_object("Quad", points, faces)
    plan.data.uv_layers.new(name="Mine")
    plan.cmc.default_kind = "LINE"
    solved(plan)
    mesh = plan.cmc.f_plus.data
    assert mesh.uv_layers.active.name == "Mine"
    mesh.calc_loop_triangles()
    layer = np.empty(2 * len(mesh.loops), np.float32)
    mesh.uv_layers["cmc_plan"].uv.foreach_get("vector", layer)
    flat = np.zeros((len(mesh.vertices), 3))
    flat[[loop.vertex_index for loop in mesh.loops], :2] = layer.reshape(-1, 2)
    triangles = np.array([t.vertices[:] for t in mesh.loop_triangles])
    shell = positions(plan.cmc.f_plus)
    drawn = positions(plan)
    bent, plain = (Domain.from_positions(points, triangles) for points in (flat, drawn))
    assert conformal_distortion(bent, shell, triangles).mean() < 1.02
    assert conformal_distortion(plain, shell, triangles).mean() > 1.02
    disc = quad_disc()
    disc.cmc.default_kind = "LINE"
    solved(disc)
    assert "cmc_plan" not in disc.cmc.f_plus.data.uv_layers


def test_a_soap_film_has_no_twin_and_a_gauss_image_of_radius_one():
    raised = quad_disc(rise=0.0, rings=6, columns=36)
    for vertex in raised.data.vertices:
        vertex.co.z = 0.1 * (vertex.co.x**2 - vertex.co.y**2)
    raised.cmc.default_kind = "LINE"
    raised.cmc.want_twin = raised.cmc.want_gauss = True
    solved(raised)
    assert report(raised)["mean_curvature"] == 0.0
    assert raised.cmc.f_minus is None
    image = positions(raised.cmc.gauss)
    centre = image - np.array(raised.cmc.gauss.location)
    assert np.ptp(image, axis=0).max() < 2.0 and np.ptp(np.linalg.norm(centre, axis=1)) < 2.0


def test_colours_of_a_soap_film_and_of_a_hanging_shell(disc):
    disc.cmc.colour_by = "MEAN_CURVATURE"
    for H in (0.0, -0.2, 0.2):
        solved(disc, size="MEAN_CURVATURE", mean_curvature=H)
        low, high, centre, has_centre, *_ = disc.cmc.f_plus.cmc.colour_range
        assert has_centre and low < high and centre == pytest.approx(H)
        values = np.empty(len(disc.cmc.f_plus.data.vertices), np.float32)
        disc.cmc.f_plus.data.attributes["cmc_mean_curvature"].data.foreach_get("value", values)
        assert np.median(values) == pytest.approx(H, abs=0.01)


def test_a_side_leans_over_its_line():
    plan = quad_disc(rings=6, columns=36)
    plan.cmc.default_kind = "LINE"
    ends = [plan.data.edges[e].vertices for e in boundary_edges(plan.data)]
    east = [max(plan.data.vertices[v].co.x for v in pair) > 2.5 for pair in ends]
    edges = [e for e, chosen in zip(boundary_edges(plan.data), east, strict=True) if chosen]
    add_group(plan, "Street", edges, "LEAN", angle=np.radians(70))
    points = solved(plan, size="RISE", rise=0.4)
    over = np.unique([v for e in edges for v in plan.data.edges[e].vertices])
    assert_allclose(np.linalg.norm(points[over, :2], axis=1), 4.0, rtol=1e-3)
    assert points[over, 2].max() > 0.1


def test_a_ring_between_the_drawn_line_and_a_chosen_curve():
    plan = quad_ring(rings=6, columns=48, inner=2.0, outer=4.0)
    plan.cmc.default_kind = "LINE"
    ends = {e: plan.data.vertices[plan.data.edges[e].vertices[0]].co for e in boundary_edges(plan.data)}
    inner = [e for e, place in ends.items() if place.xy.length < 3.0]
    add_group(plan, "Court", inner, "LINE", curve=circle("Ring", 2.4, 1.5))
    activate(plan)
    points = solved(plan, size="MEAN_CURVATURE", mean_curvature=0.0)
    court = np.unique([v for e in inner for v in plan.data.edges[e].vertices])
    assert_allclose(points[court, 2], 1.5, atol=1e-5)
    assert_allclose(np.linalg.norm(points[court, :2], axis=1), 2.4, rtol=2e-3)
    assert report(plan)["made"]["conditions"][0]["curve"] == "chosen"


def test_plans_that_cannot_be_spanned_stay_as_they_are(disc):
    edges = boundary_edges(disc.data)[:10]
    group = add_group(disc, "Free", edges, "BINORMAL")
    before = snapshot()
    with pytest.raises(RuntimeError, match=r'but not "Free" \(leans, rim free\)'):
        bpy.ops.cmc.solve()
    assert snapshot() == before
    group.kind = "LINE"
    group.curve = circle("Line", 4.0, 0.5)
    activate(disc)
    with pytest.raises(RuntimeError, match="takes the place of a whole boundary loop"):
        bpy.ops.cmc.solve()
    with pytest.raises(RuntimeError, match='is not sized by "span"'):
        group.curve = None
        bpy.ops.cmc.solve(size="SPAN")


def test_live_follows_a_number_and_a_vertex_of_the_line(disc):
    """As by Solve, after any number of quick updates."""
    from cmc_formfinding.cmc_addon.live.update import FINAL, QUICK, FullTask, QuickTask, read

    context = bpy.context
    disc.cmc.size, disc.cmc.rise = "RISE", 0.3
    first = FullTask(read(context, disc), FINAL)
    memory = first.write(context, disc, first.work(lambda *_: True))
    for rise in (0.32, 0.36, 0.4):
        disc.cmc.rise = rise
        quick = QuickTask(read(context, disc), QUICK, memory)
        assert memory.serves(quick.reading)
        memory = quick.write(context, disc, quick.work(lambda *_: True))
        assert memory is not None
    followed = positions(disc.cmc.f_plus)
    assert_allclose(followed[:, 2].max(), 1.6, rtol=2e-3)
    for vertex in disc.data.vertices:
        vertex.co.z = 0.05 * vertex.co.x
    quick = QuickTask(read(context, disc), QUICK, memory)
    assert quick.write(context, disc, quick.work(lambda *_: True)) is not None
    followed = positions(disc.cmc.f_plus)
    assert_allclose(followed, solved(disc), atol=5e-3)


def test_the_overlay_shows_what_leans_and_leaves_lines_free(disc):
    from cmc_formfinding.cmc_addon.bridges.mesh_bridge import read_plan
    from cmc_formfinding.cmc_addon.drawing.overlay import group_states
    from cmc_formfinding.cmc_addon.drawing.rim import Drawn, Leaning, prescribed_rim

    group = add_group(disc, "Street", boundary_edges(disc.data)[:10], "LEAN", angle=np.radians(60))
    rim = prescribed_rim(
        Drawn.of(read_plan(disc), (group.uid,)), group_states(disc.data), Leaning(default_kind="line")
    )
    normals = {walk.uid: walk.middles for walk in rim.walks}
    assert_allclose(normals[group.uid][:, 2], np.sin(np.radians(60)), rtol=1e-6)
    assert np.isnan(normals[0]).all()


def test_a_job_with_lines_runs_in_blender(tmp_path):
    from cmc_formfinding.cmc_addon.headless import cli

    angle = 2 * np.pi * np.arange(90) / 90
    lines = [f"v {0.6 * x} {0.6 * y} 0.5" for x, y in zip(np.cos(angle), np.sin(angle), strict=True)]
    ring = " ".join(str(k + 1) for k in [*range(90), 0])
    (tmp_path / "upper.obj").write_text("\n".join([*lines, f"l {ring}\n"]))
    (tmp_path / "job.toml").write_text(
        '[shape]\nkind = "annulus"\ninner = 0.5\nouter = 1.0\nn = 500\n[default]\nkind = "line"\n'
        '[[conditions]]\nside = "inner"\nkind = "line"\ncurve = "upper.obj"\n[size]\ncurvature = 0\n'
        '[output]\nf_plus = "film.obj"\nreport = "film.json"\n'
    )
    assert cli.run([str(tmp_path / "job.toml"), "--output", str(tmp_path / "out")]) == 0
    reports = [json.loads(file.read_text()) for file in sorted((tmp_path / "out").rglob("report.json"))]
    assert [(found["mean_curvature"], found["converged"]) for found in reports] == [(0.0, True)]
