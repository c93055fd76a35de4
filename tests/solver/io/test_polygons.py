"""Polygons into triangles: areas, orientation, numbering, and the messages about invalid polygons."""

from __future__ import annotations

import time

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from solver.errors import MeshError
from solver.io.polygons import triangulate_polygons

L_SHAPE = np.array([[0, 0], [4, 0], [4, 2], [2, 2], [2, 4], [0, 4.0]])


def areas(points: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    a, b, c = (points[triangles[:, k]] for k in range(3))
    ab, ac = b - a, c - a
    return 0.5 * (ab[:, 0] * ac[:, 1] - ab[:, 1] * ac[:, 0])


def test_mixed_polygons_keep_their_order():
    points = np.array([[0, 0], [1, 0], [2, 0], [0, 1], [1, 1], [2, 1], [3, 0.5]])
    triangles, index = triangulate_polygons(points, [[2, 6, 5], [0, 1, 4, 3], [1, 2, 5, 4]])
    assert_array_equal(index, [0, 1, 1, 2, 2])
    assert_array_equal(triangles[0], [2, 6, 5])
    assert set(triangles[1:3].ravel()) == {0, 1, 4, 3}
    assert_allclose(areas(points, triangles), 0.5)
    assert triangles.dtype == np.int32


def test_a_quad_is_cut_along_its_better_diagonal():
    kite = np.array([[0, 0], [3, -1], [6, 0], [3, 1.0]])
    triangles, _ = triangulate_polygons(kite, [[0, 1, 2, 3]])
    assert {frozenset(t) for t in triangles.tolist()} == {frozenset([1, 2, 3]), frozenset([3, 0, 1])}
    dart = np.array([[0, 0], [4, 0], [1, 1], [0, 4.0]])
    triangles, _ = triangulate_polygons(dart, [[0, 1, 2, 3]])
    assert {frozenset(t) for t in triangles.tolist()} == {frozenset([0, 1, 2]), frozenset([0, 2, 3])}


def test_a_quad_with_a_straight_corner():
    points = np.array([[0, 0], [1, 0], [2, 0], [1, 2.0]])
    triangles, _ = triangulate_polygons(points, [[0, 1, 2, 3]])
    assert_allclose(np.sort(areas(points, triangles)), [1, 1])


@pytest.mark.parametrize("first", range(6))
def test_an_l_shape(first):
    polygon = np.roll(np.arange(6), first)
    triangles, _ = triangulate_polygons(L_SHAPE, [polygon])
    assert len(triangles) == 4
    assert (areas(L_SHAPE, triangles) > 0).all()
    assert_allclose(areas(L_SHAPE, triangles).sum(), 12)


def test_clockwise_stays_clockwise_and_slopes_do_not_matter():
    points = np.column_stack([L_SHAPE, L_SHAPE @ [0.3, -0.2]])
    triangles, _ = triangulate_polygons(points, [[5, 4, 3, 2, 1, 0]])
    assert (areas(points[:, :2], triangles) < 0).all()
    assert_allclose(areas(points[:, :2], triangles).sum(), -12)


def test_a_comb_of_many_teeth_with_straight_corners():
    """Ears that stop being ears, corners of 180°, and an outline of 82 corners."""
    teeth = 20
    x = np.repeat(np.arange(2 * teeth), 2)[1:]
    y = np.where(np.arange(len(x)) % 4 < 2, 3.0, 1.0)
    points = np.vstack([np.column_stack([x[::-1], y[::-1]]), [[0, 0], [10, 0], [x.max(), 0]]])
    triangles, _ = triangulate_polygons(points, [np.arange(len(points))])
    signed = 0.5 * np.sum(points[:, 0] * np.roll(points[:, 1], -1) - np.roll(points[:, 0], -1) * points[:, 1])
    assert_allclose(areas(points, triangles).sum(), signed)
    assert (areas(points, triangles) > 0).all()


def test_a_regular_polygon_of_many_corners():
    t = 2 * np.pi * np.arange(150) / 150
    points = np.column_stack([np.cos(t), np.sin(t)]).astype(np.float32)
    triangles, _ = triangulate_polygons(points, [np.arange(150)])
    assert len(triangles) == 148
    assert (areas(points.astype(float), triangles) > 0).all()


@pytest.mark.parametrize("roughness", [0.0, 0.3])
def test_thousands_of_corners_take_seconds(roughness):
    """Time in proportion to the corners: comparing each ear with all corners takes 20 s here."""
    t = 2 * np.pi * np.arange(6000) / 6000
    radius = 1 + roughness * np.random.default_rng(0).random(len(t))
    points = radius[:, None] * np.column_stack([np.cos(t), np.sin(t)])
    start = time.process_time()
    triangles, _ = triangulate_polygons(points, [np.arange(len(points))])
    assert time.process_time() - start < 8.0
    assert len(triangles) == len(points) - 2 and (areas(points, triangles) > 0).all()


SQUARE = [[0, 0], [1, 0], [1, 1], [0, 1.0]]


SPIKE = [[0, 0], [1, 0], [1, 0.5], [3, 0.5], [2, 0.5], [1, 1], [0, 1]]
FLAT = [[0, 0], [1, 0], [2, 0], [3, 0.0]]
BOW = [[0, 0], [2, 2], [2, 0], [0, 1.0]]
WEDGE = [*SQUARE, [3, 0.5], [1, 0.5]]
HOLE = [*SQUARE[:3], [np.nan, 0]]


def test_a_thin_wedge_is_no_spike():
    assert len(triangulate_polygons(WEDGE, [[0, 1, 5, 4, 2, 3]])[0]) == 4


@pytest.mark.parametrize(
    ("points", "polygons", "message", "faces", "vertices"),
    [
        (WEDGE, [[0, 1, 2], [3, 5, 4, 5, 2]], "Polygon 1 passes through vertex 5 more than once", [1], [5]),
        (SPIKE, [range(7)], "Polygon 0 has a spike at vertex 3", [0], [3]),
        (FLAT, [[0, 1, 2]], r"Polygon 0 \(vertices 0, 1, 2\) has no area", [0], [0, 1, 2]),
        (BOW, [[0, 1, 2, 3]], r"polygon 0 .* crosses or touches itself", [0], [0, 1, 2, 3]),
        (SQUARE, [[0, 1, 2], [0, 3]], "Polygon 1 has fewer than three corners", [1], []),
        (SQUARE, [[0, 1, 7]], "Polygon 0 uses vertex 7, but there are 4 vertices", [0], [7]),
        (HOLE, [[0, 1, 2, 3]], "position of vertex 3 is not finite", [], [3]),
    ],
)
def test_messages_name_polygon_and_vertex(points, polygons, message, faces, vertices):
    with pytest.raises(MeshError, match=message) as caught:
        triangulate_polygons(points, polygons)
    assert list(caught.value.faces) == faces
    assert list(caught.value.vertices) == vertices


def test_an_outline_of_five_corners_that_crosses_itself():
    star = [[0, 0], [4, 0], [1, 3], [2, -2], [3, 3.0]]
    with pytest.raises(MeshError, match=r"polygon 0 .* crosses or touches itself"):
        triangulate_polygons(star, [[0, 1, 2, 3, 4]])
