"""Boundary, overhang, and the distance from a drawn outline."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from solver.catalogue import shapes
from solver.domain.domain import Domain
from solver.errors import MeshError
from solver.measure import boundary_sides, face_normals, leans, overhanging_faces
from solver.measure.outline import distance_to_segments, outline_segments
from tests.solver.sampled_surfaces import grid

SQUARE = np.array([(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)])


def test_boundary_sides_walk_with_the_surface_on_the_left():
    shape = shapes.disc(100)
    sides = boundary_sides(shape.domain)
    assert sorted(map(tuple, sides)) == sorted(map(tuple, shape.domain.edges[shape.domain.boundary_edges]))
    a, b = shape.positions[sides[:, 0]], shape.positions[sides[:, 1]]
    assert (a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0] > 0).all()


def test_seams_of_a_cut_surface_are_not_boundary():
    domain = shapes.cylinder(6.0, 2.0, 12).domain
    rows = np.arange(3 * len(domain.faces)).reshape(-1, 3)
    sides = boundary_sides(domain, rows)
    assert len(sides) == len(domain.boundary_edges) == 24
    back = domain.faces.ravel()[sides]
    assert sorted(map(tuple, back)) == sorted(map(tuple, domain.edges[domain.boundary_edges]))


def dome(height, n=32):
    """Part of the unit sphere above z = `height`, -1 < height < 1, with faces that look outwards."""
    points, faces = grid(4 * n, n, 2 * np.pi, 1.0)
    z = height + (0.999 - height) * points[:, 1]
    r = np.sqrt(1 - z**2)
    return np.stack([r * np.cos(points[:, 0]), r * np.sin(points[:, 0]), z], axis=1), faces


def test_face_normals_of_a_dome_look_outwards():
    points, faces = dome(0.2)
    middle = points[faces].mean(axis=1)
    assert (np.einsum("fc,fc->f", face_normals(points, faces), middle) > 0.9).all()


def test_a_hemisphere_does_not_overhang_and_more_of_a_sphere_does():
    assert len(overhanging_faces(*dome(0.0))) == 0
    points, faces = dome(-0.6)
    leaning = overhanging_faces(points, faces)
    assert 0 < len(leaning) < len(faces)
    assert np.degrees(leans(points, faces)[leaning].max()) == pytest.approx(np.degrees(np.arcsin(0.6)), abs=2.0)
    middle = points[faces].mean(axis=1)[:, 2]
    assert middle[leaning].max() < 0.05
    assert np.delete(middle, leaning).min() > -0.05


def test_overhang_does_not_depend_on_winding_flips_or_turns():
    points, faces = dome(-0.6)
    leaning = overhanging_faces(points, faces)
    assert_array_equal(overhanging_faces(points, faces[:, ::-1]), leaning)
    assert_array_equal(overhanging_faces(points * (1, 1, -1), faces), leaning)
    turned = points[:, [2, 0, 1]]
    assert_array_equal(overhanging_faces(turned, faces, up=(2.0, 0.0, 0.0)), leaning)


def test_vertical_walls_and_collapsed_faces_do_not_overhang():
    points, faces = grid(4, 4, 1.0, 1.0)
    wall = np.column_stack([points[:, 0], np.zeros(len(points)), points[:, 1]])
    assert len(overhanging_faces(wall, faces)) == 0
    assert len(overhanging_faces(np.zeros_like(wall), faces)) == 0


def test_distance_is_to_the_curve_and_not_to_its_points():
    starts, ends = SQUARE, np.roll(SQUARE, -1, axis=0)
    points = [(0.5, -0.25), (0.5, 0.4), (2.0, 2.0), (0.0, 0.7), (1.3, 0.5)]
    assert_allclose(distance_to_segments(points, starts, ends), [0.25, 0.4, np.sqrt(2), 0.0, 0.3], atol=1e-15)
    in_space = [(*p, 7.0) for p in points]
    assert_allclose(distance_to_segments(in_space, starts, ends), [0.25, 0.4, np.sqrt(2), 0.0, 0.3], atol=1e-15)


def test_distance_in_many_blocks_and_with_a_repeated_point():
    random = np.random.default_rng(4)
    t = np.linspace(0, 2 * np.pi, 3000, endpoint=False)
    circle = np.column_stack([np.cos(t), np.sin(t), 0 * t])
    circle[10] = circle[11]
    points = random.normal(size=(700, 3))
    exact = np.hypot(np.hypot(points[:, 0], points[:, 1]) - 1, points[:, 2])
    assert_allclose(distance_to_segments(points, circle, np.roll(circle, -1, axis=0)), exact, atol=1e-5)


def test_the_nearest_segment_may_be_far_from_its_middle_and_long():
    """Segments of all lengths, the longest a hundred times the mean, and points anywhere, against fine samples."""
    random = np.random.default_rng(7)
    starts, points = random.normal(size=(30, 2)), 3.0 * random.normal(size=(40, 2))
    ends = starts + 10.0 ** random.uniform(-3, 1, (30, 1)) * random.normal(size=(30, 2))
    ends[:2] = starts[:2] + [[300.0, 0.0], [0.0, 0.0]]
    t = np.linspace(0.0, 1.0, 5001)[:, None]
    lines = [start + t * (end - start) for start, end in zip(starts, ends, strict=True)]
    exact = np.array([min(np.linalg.norm(line - point, axis=1).min() for line in lines) for point in points])
    assert_allclose(distance_to_segments(points, starts, ends), exact, atol=4e-2)


def test_outlines_as_drawn_vertices_or_as_polylines():
    shape = shapes.annulus(1.0, 2.0, 200)
    starts, ends = outline_segments(shape.domain, shape.positions)
    assert len(starts) == len(shape.domain.boundary_edges)
    assert_allclose(np.linalg.norm(ends - starts, axis=1).sum(), 6 * np.pi, rtol=5e-3)
    starts, ends = outline_segments(shape.domain, [SQUARE, SQUARE[:3] + 5.0])
    assert_allclose(starts[4:], SQUARE[:3] + 5.0)
    assert_allclose(ends[[3, 6]], [SQUARE[0], SQUARE[0] + 5.0])


def test_errors_of_outlines():
    domain = shapes.disc(30).domain
    with pytest.raises(MeshError, match=f"each of the {domain.vertex_count} vertices"):
        outline_segments(domain, SQUARE)
    with pytest.raises(MeshError, match="at least two points"):
        outline_segments(domain, [SQUARE, SQUARE[:1]])
    with pytest.raises(MeshError, match="as many in every polyline"):
        outline_segments(domain, [SQUARE, np.zeros((3, 3))])
    tetrahedron = Domain.from_positions(
        np.vstack([np.zeros(3), np.eye(3)]), [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]
    )
    with pytest.raises(MeshError, match="has no boundary"):
        outline_segments(tetrahedron, np.zeros((4, 3)))
