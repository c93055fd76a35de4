"""Self-intersections against exact arithmetic, and on surfaces that are known to cross themselves."""

from __future__ import annotations

from itertools import combinations
from time import process_time

import numpy as np
import pytest
from numpy.testing import assert_array_equal

from solver.errors import MeshError
from solver.measure import self_intersections
from solver.measure.aabb_tree import overlapping_boxes
from tests.solver.sampled_surfaces import NODOID, UNDULOID, grid, sample

FLAT = [(0, 0, 0), (4, 0, 0), (0, 4, 0)]


def crossing(*triangles):
    """Whether the pair of triangles, without a common vertex, intersects."""
    points = np.array(triangles, dtype=float).reshape(-1, 3)
    return len(self_intersections(points, np.arange(len(points)).reshape(-1, 3))) > 0


def volume(a, b, c, d):
    """Six times the signed volume, in Python's integers: exact."""
    u, v, w = ([int(q[k]) - int(p[k]) for k in range(3)] for p, q in ((a, b), (a, c), (a, d)))
    return u[0] * (v[1] * w[2] - v[2] * w[1]) - u[1] * (v[0] * w[2] - v[2] * w[0]) + u[2] * (v[0] * w[1] - v[1] * w[0])


def exactly_through(p, q, face):
    if volume(*face, p) * volume(*face, q) >= 0:
        return False
    signs = {volume(p, q, face[k], face[(k + 1) % 3]) > 0 for k in range(3)}
    return len(signs) == 1


def exactly_crossing(a, b):
    return any(
        exactly_through(first[k], first[(k + 1) % 3], second) for first, second in ((a, b), (b, a)) for k in range(3)
    )


@pytest.mark.parametrize("room", [2_000, 6_000])
def test_agrees_with_exact_arithmetic(room):
    random = np.random.default_rng(room)
    corners = random.integers(0, room, size=(120, 1, 3)) + random.integers(-1000, 1000, size=(120, 3, 3))
    faces = np.arange(360).reshape(120, 3)
    expected = [(i, j) for i, j in combinations(range(120), 2) if exactly_crossing(corners[i], corners[j])]
    assert len(expected) > 20
    assert_array_equal(self_intersections(corners.reshape(-1, 3), faces), expected)


def test_agrees_with_exact_arithmetic_where_faces_share_a_vertex():
    random = np.random.default_rng(1)
    points = random.integers(-1000, 1000, size=(81, 3))
    points[0] = (30, 20, 10)
    faces = np.column_stack([np.zeros(40, int), 1 + np.arange(80).reshape(40, 2)])
    faces = np.array([np.roll(face, shift) for face, shift in zip(faces, random.integers(0, 3, 40), strict=True)])

    def pierced(i, j):
        (p, q), (r, s) = ([points[v] for v in faces[f] if v] for f in (i, j))
        return exactly_through(p, q, points[faces[j]]) or exactly_through(r, s, points[faces[i]])

    expected = [(i, j) for i, j in combinations(range(40), 2) if pierced(i, j)]
    assert len(expected) > 20
    assert_array_equal(self_intersections(points, faces), expected)


@pytest.mark.parametrize(
    ("other", "expected"),
    [
        ([(1, 1, -1), (1, 1, 1), (2, 2, 1)], True),  # through the middle
        ([(1, 1, 0), (1, 1, 1), (2, 2, 1)], False),  # a corner on the face
        ([(4, 0, 0), (5, 0, 1), (5, 1, 1)], False),  # a corner on a corner
        ([(0, 0, 0), (4, 0, 0), (0, 0, 4)], False),  # along an edge, without sharing its vertices
        ([(4, 4, 0), (4, 0, 0), (0, 4, 0)], False),  # in one plane, along an edge
        ([(1, 1, 0), (2, 1, 0), (1, 2, 0)], True),  # in one plane, one within the other
        ([(0, 0, 0), (4, 0, 0), (0, 4, 0)], True),  # the same triangle
        ([(0, 4, 0), (4, 0, 0), (0, 0, 0)], True),  # the same, other way round
        ([(3, 3, 0), (5, 3, 0), (3, 5, 0)], False),  # in one plane, apart though the boxes overlap
        ([(0, 0, 1e-3), (4, 0, 1e-3), (0, 4, 1e-3)], False),  # parallel and near
        ([(1, 1, -1e-3), (1, 1, 1e-3), (1.001, 1, 1e-3)], True),  # a small one through a large one
    ],
)
@pytest.mark.parametrize("shift", [0.0, 1000.0])
def test_pairs(other, expected, shift):
    first, second = np.array(FLAT) + shift, np.array(other) + shift
    assert crossing(first, second) is expected
    assert crossing(second[[1, 2, 0]], first[[2, 1, 0]]) is expected


def test_turned_flat_meshes_do_not_intersect():
    random = np.random.default_rng(8)
    points, faces = grid(20, 15, 7.0, 5.0, 0.25)
    turn = np.linalg.qr(random.normal(size=(3, 3)))[0]
    flat = np.column_stack([points, np.zeros(len(points))]) @ turn + (100.0, -40.0, 3.0)
    assert len(self_intersections(flat, faces)) == 0
    # The same with every face on vertices of its own: neighbours touch exactly, and do not intersect.
    assert len(self_intersections(flat[faces].reshape(-1, 3), np.arange(3 * len(faces)).reshape(-1, 3))) == 0


def test_an_embedded_surface_does_not_intersect():
    m = sample(UNDULOID, 60, 40, (2 * np.pi, 3.0), 0.2)
    assert len(self_intersections(m.points, m.faces)) == 0


def test_a_nodoid_of_several_periods_crosses_itself():
    m = sample(NODOID, 40, 80, (2 * np.pi, 12.0), 0.0)
    pairs = self_intersections(m.points, m.faces)
    assert len(pairs) >= 40
    # A surface of revolution crosses itself in circles: everywhere around, at few heights.
    t = m.centres[np.unique(pairs)][:, 0]
    assert np.diff(np.sort(t)).max() < 0.5


def test_the_search_ends_where_everything_crosses(monkeypatch):
    """Five hundred triangles about one line: each crosses every other."""
    turns = np.pi * np.arange(500) / 500
    x, y = np.cos(turns), np.sin(turns)
    corners = np.stack([[x, y, 0 * x], [-x, -y, 0 * x - 1], [-x, -y, 0 * x + 1]], axis=0).transpose(2, 0, 1)
    points, faces = corners.reshape(-1, 3), np.arange(1500).reshape(-1, 3)
    assert len(self_intersections(points, faces)) == 500 * 499 / 2
    monkeypatch.setattr("solver.measure.intersections._MOST", 1000)
    monkeypatch.setattr("solver.measure.aabb_tree._BLOCK", 64)
    assert 1000 < len(self_intersections(points, faces)) < 500 * 499 / 2


def test_a_figure_eight_crosses_along_one_line():
    parameters, faces = grid(64, 10, 1.0, 1.0)
    t, z = 2 * np.pi * 0.98 * parameters[:, 0] + 0.6, parameters[:, 1]
    points = np.column_stack([np.sin(t), np.sin(2 * t), z])
    pairs = self_intersections(points, faces)
    middle = points[faces].mean(axis=1)
    assert len(np.unique(pairs)) >= 20
    assert np.hypot(*middle[np.unique(pairs), :2].T).max() < 0.25
    assert (pairs[:, 0] < pairs[:, 1]).all()


def test_a_fold_over_the_far_edge_of_a_neighbour_is_found():
    points = np.array([(0, 0, 0), (2, -1, 0), (2, 1, 0), (1, 0, -1), (3, 0, 2), (-1, 1, 5), (-1, -1, 5)], dtype=float)
    assert_array_equal(self_intersections(points, [[0, 1, 2], [0, 3, 4]]), [[0, 1]])
    assert len(self_intersections(points, [[0, 1, 2], [0, 5, 6]])) == 0


def test_faces_without_area_or_position_intersect_nothing():
    points = np.array([*FLAT, (1, 1, -1), (1, 1, 1), (np.nan, 0, 0)], dtype=float)
    assert len(self_intersections(points, [[0, 1, 2], [3, 4, 4], [3, 4, 5], [3, 3, 3]])) == 0
    assert len(self_intersections(np.zeros((6, 3)), [[0, 1, 2], [3, 4, 5]])) == 0
    assert self_intersections(points, np.zeros((0, 3), int)).shape == (0, 2)
    assert self_intersections(points, [[0, 1, 2]]).shape == (0, 2)


def test_error_on_a_missing_vertex():
    with pytest.raises(MeshError, match="face 0 refer"):
        self_intersections(np.eye(3), [[0, 1, 3]])


def test_boxes_of_all_sizes_against_every_pair():
    random = np.random.default_rng(2)
    centres = random.uniform(0, 10, size=(301, 3))
    half = random.choice([0.01, 0.3, 3.0], size=(301, 1)) * random.uniform(0, 1, size=(301, 3))
    low, high = centres - half, centres + half
    touching = (low[:, None] <= high) & (low <= high[:, None])
    expected = np.argwhere(np.triu(touching.all(axis=2), k=1))
    found = np.sort(np.concatenate(list(overlapping_boxes(low, high))), axis=1)
    assert_array_equal(found[np.lexsort((found[:, 1], found[:, 0]))], expected)


def test_ten_thousand_faces_in_a_second():
    m = sample(UNDULOID, 100, 50, (2 * np.pi, 3.0), 0.2)
    start = process_time()
    self_intersections(m.points, m.faces)
    assert len(m.faces) == 10_000
    assert process_time() - start < 1.0  # 0.2 s on an idle core
