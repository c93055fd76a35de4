"""Approximate Surface: the nearest shell, its deviation, and the smoothness of its rim."""

from __future__ import annotations

import bpy

# isort: split
import numpy as np
import pytest
from numpy.testing import assert_allclose

from .approximate_scenes import approximated, cap, report, wavy
from .scenes import boundary_edges, positions, values
from .sidebar import draw


def test_a_sphere_is_its_own_nearest_surface():
    surface = cap()
    points = approximated(surface, smoothness=0.0)
    assert_allclose(points, positions(surface), rtol=0, atol=0.05)
    mesh = surface.cmc.nearest.data
    deviation = np.array(values(mesh.attributes["cmc_deviation"]))
    assert deviation.shape == (len(mesh.vertices),)
    assert deviation.max() < 0.05
    curvature = np.array(values(mesh.attributes["cmc_mean_curvature"]))
    assert np.median(curvature) == pytest.approx(0.2, rel=0.02)
    assert report(surface)["deviation"]["max"] == pytest.approx(deviation.max(), rel=1e-4)


def test_deviation_is_the_distance_to_the_original():
    """Not to its vertices, and in the world; the largest is red."""
    surface = wavy()
    points = approximated(surface)
    deviation = np.array(values(surface.cmc.nearest.data.attributes["cmc_deviation"]))
    dense = surface.data.copy()
    other = bpy.data.objects.new("Dense", dense)
    bpy.context.scene.collection.objects.link(other)
    other.location = surface.location
    other.modifiers.new("Fine", "SUBSURF").subdivision_type = "SIMPLE"
    other.modifiers["Fine"].levels = 4
    bpy.context.view_layer.update()
    fine = other.evaluated_get(bpy.context.evaluated_depsgraph_get()).to_mesh()
    samples = np.array([other.matrix_world @ v.co for v in fine.vertices])
    by_samples = np.array([np.linalg.norm(samples - p, axis=1).min() for p in points])
    # quads are bent: Blender's surface and ours, of triangles, differ by a little
    assert_allclose(deviation, by_samples, rtol=0, atol=0.04)
    assert 0.05 < deviation.max() < 0.6
    colours = np.array(values(surface.cmc.nearest.data.attributes["cmc_deviation_colour"]))
    red, blue = colours[deviation.argmax()], colours[deviation.argmin()]
    assert red[0] > 2 * red[2] and blue[2] > 2 * blue[0]
    assert surface.cmc.nearest.data.color_attributes.active_color_name == "cmc_deviation_colour"


def test_smoothness_calms_the_rim():
    surface = wavy()
    variation = []
    for smoothness in (0.0, 1e-2, 1.0):
        approximated(surface, smoothness=smoothness)
        mesh = surface.cmc.nearest.data
        normals = np.array(values(mesh.attributes["cmc_normal"]))
        ends = np.array([tuple(mesh.edges[e].vertices) for e in boundary_edges(mesh)])
        jumps = normals[ends[:, 0]] - normals[ends[:, 1]]
        variation.append((jumps**2).sum())
    assert variation[0] > variation[1] > variation[2]
    assert surface.cmc.smoothness == 1.0


def test_position_brings_it_nearer():
    """A weight that is not in use does not count."""
    surface = wavy()
    approximated(surface)
    by_planes = report(surface)
    approximated(surface, match="POSITION", near=300.0)
    by_position = report(surface)
    assert by_position["deviation"]["mean"] < 0.8 * by_planes["deviation"]["mean"]
    assert (surface.cmc.match, surface.cmc.near) == ("POSITION", 300.0)
    approximated(surface, match="TANGENT_PLANES")
    assert report(surface)["deviation"] == pytest.approx(by_planes["deviation"], rel=1e-3)


def test_a_saddle_has_a_minimal_surface_on_its_rim():
    """H = 0 in the report and on every vertex; the rim stays, and the mean curvature has a colour."""
    surface = cap()
    for vertex in surface.data.vertices:
        vertex.co.z = 0.06 * (vertex.co.x**2 - vertex.co.y**2)
    surface.cmc.colour_by = "MEAN_CURVATURE"
    points = approximated(surface)
    rim = np.unique([tuple(surface.data.edges[e].vertices) for e in boundary_edges(surface.data)])
    assert_allclose(points[rim, 2], positions(surface)[rim, 2], rtol=0, atol=0.01)
    assert report(surface)["met"] and report(surface)["mean_curvature"] == 0.0
    curvature = np.array(values(surface.cmc.nearest.data.attributes["cmc_mean_curvature"]))
    assert np.abs(curvature).max() < 0.02
    sizes, checks = draw("CMC_PT_results").texts, draw("CMC_PT_checks").texts
    assert sizes[sizes.index("H") + 1].startswith("0 ") and "Radius 1/H" not in sizes
    assert "1/m" in checks[checks.index("H Off By") + 1]
