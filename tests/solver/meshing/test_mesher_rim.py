"""The rim of a meshed plan: corners, arcs, segments, points to keep."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from solver.meshing.mesher import mesh_plan
from tests.solver.drawn_outlines import L_SHAPE, SQUARE, check, ellipse


def test_corners_stay_exactly_and_sides_are_divided_evenly():
    mesh = mesh_plan(L_SHAPE, max_edge=0.7)
    for corner in L_SHAPE:
        assert np.any(np.all(np.abs(mesh.positions - corner) < 1e-12, axis=1))
    length = np.linalg.norm(np.diff(mesh.positions[mesh.edges], axis=1)[:, 0], axis=1)
    for k in range(6):
        side = length[mesh.segment == k]
        assert_allclose(side, side[0], rtol=0.02)  # sides of 0.667 beside sides of 0.7
    assert_allclose(mesh.positions[0], L_SHAPE[0], atol=1e-12)


@pytest.mark.parametrize("clockwise", [False, True])
def test_edges_remember_the_segment_they_come_from(clockwise):
    outline = L_SHAPE[::-1] if clockwise else L_SHAPE
    hole = np.array([[1.0, 1.0], [3.0, 1.0], [3.0, 3.0], [1.0, 3.0]])
    mesh = mesh_plan(outline, [hole], max_edge=0.5)
    loops = [outline, hole]
    middle = mesh.positions[mesh.edges].mean(axis=1)
    for loop, segment, point in zip(mesh.loop, mesh.segment, middle, strict=True):
        a, b = loops[loop][segment], loops[loop][(segment + 1) % len(loops[loop])]
        along = (point - a) @ (b - a) / np.sum((b - a) ** 2)
        assert 0 < along < 1
        assert_allclose(a + along * (b - a), point, atol=1e-9)


def test_an_arc_is_divided_at_its_middle():
    mesh = mesh_plan(SQUARE, max_edge=0.5, corner_radius=2.0)
    check(mesh)
    middle = mesh.positions[mesh.edges].mean(axis=1)
    nearest = np.argmin([middle[:, 1], 10 - middle[:, 0], 10 - middle[:, 1], middle[:, 0]], axis=0)
    assert_array_equal(mesh.segment, nearest)
    centre = np.clip(mesh.positions[: len(mesh.edges)], 2, 8)
    assert_allclose(np.linalg.norm(mesh.positions[: len(mesh.edges)] - centre, axis=1), 2.0, atol=5e-4)
    assert_allclose(mesh.positions[0], 2 - np.sqrt(2) * np.ones(2), atol=1e-9)


def test_a_radius_too_large_makes_a_circle_of_a_square():
    mesh = mesh_plan(SQUARE, max_edge=0.5, corner_radius=1e6)
    assert_allclose(np.linalg.norm(mesh.positions[: len(mesh.edges)] - 5, axis=1), 5.0, atol=1e-3)


def test_a_smooth_curve_is_no_corner():
    plain = mesh_plan(ellipse(60, 5, 3), max_edge=0.8)
    rounded = mesh_plan(ellipse(60, 5, 3), max_edge=0.8, corner_radius=1.0)
    assert_array_equal(plain.positions, rounded.positions)


def test_where_a_curve_meets_a_chord_the_corner_is_rounded_smoothly():
    half = np.array([[np.cos(t), np.sin(t)] for t in np.linspace(0, np.pi, 80)]) * 5
    mesh = mesh_plan(half, max_edge=0.3, corner_radius=1.0)
    check(mesh)
    boundary = mesh.positions[: len(mesh.edges)]
    step = np.roll(boundary, -1, axis=0) - boundary
    before = np.roll(step, 1, axis=0)
    turn = np.arctan2(before[:, 0] * step[:, 1] - before[:, 1] * step[:, 0], np.sum(before * step, axis=1))
    assert np.degrees(np.abs(turn).max()) < 18
    assert_allclose(turn.sum(), 2 * np.pi, rtol=1e-12)


def test_a_column_in_the_way_of_an_arc_shrinks_it():
    column = ellipse(12, 0.2, 0.2, (0.6, 0.6))
    mesh = mesh_plan(SQUARE, [column], max_edge=1.0, corner_radius=4.0)
    check(mesh)
    assert mesh.positions[: len(mesh.edges)].sum(axis=1).min() < 0.8  # this arc passes outside the column
    assert np.linalg.norm(mesh.positions - [10, 10], axis=1).min() > 1.5  # the others are as asked


def test_points_to_keep_and_points_between_long_segments_stay_vertices():
    wall = np.array([[0, 0], [1.3, 0], [5, 0], [10, 0], [10, 6], [0, 6]], dtype=float)
    mesh = mesh_plan(wall, max_edge=1.8, keep=[[1]])
    for point in wall:
        assert np.any(np.all(np.abs(mesh.positions - point) < 1e-12, axis=1))
    assert set(mesh.segment) == set(range(6))
