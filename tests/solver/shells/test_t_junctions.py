"""Plans whose parts touch without being joined, and T-junctions, are named with the way out."""

from __future__ import annotations

import numpy as np
import pytest

from solver.errors import MeshError
from solver.shells.plan import Plan, plan_domain


def grid(columns, rows, at=(0.0, 0.0), step=1.0):
    """Points (V, 3) and triangles (F, 3) of a grid of squares."""
    u, v = np.meshgrid(np.arange(columns + 1), np.arange(rows + 1))
    points = step * np.column_stack([u.ravel(), v.ravel(), 0 * u.ravel()]) + (*at, 0.0)
    a = (np.arange(rows)[:, None] * (columns + 1) + np.arange(columns)).ravel()
    n = columns + 1
    return points, np.concatenate([np.column_stack([a, a + 1, a + n + 1]), np.column_stack([a, a + n + 1, a + n])])


def joined(*parts):
    offsets = np.cumsum([0] + [len(points) for points, _ in parts])
    triangles = [faces + offset for (_, faces), offset in zip(parts, offsets, strict=False)]
    return np.concatenate([points for points, _ in parts]), np.concatenate(triangles)


def welded(points, triangles):
    unique, index = np.unique(points.round(9), axis=0, return_inverse=True)
    return unique, index.reshape(-1)[triangles]


@pytest.mark.parametrize("place", [0.0, 5e6])
def test_parts_that_coincide(place):
    points, triangles = joined(grid(6, 8), grid(6, 8, at=(6, 0)))
    with pytest.raises(MeshError, match=r"2 components that touch: .* merge them by distance") as caught:
        plan_domain(Plan(points + place, triangles))
    assert "delete" not in str(caught.value) and len(caught.value.vertices) == 18
    plan_domain(Plan(*welded(points, triangles)))


def test_parts_that_are_apart_are_told_as_before():
    with pytest.raises(MeshError, match="2 components"):
        plan_domain(Plan(*joined(grid(3, 3), grid(3, 3, at=(5, 0)))))


def test_a_row_of_large_squares_over_a_row_of_small_ones():
    both = joined(grid(8, 4), grid(4, 2, at=(0, 4), step=2.0))
    with pytest.raises(MeshError, match=r"Vertices .* lie inside an edge") as caught:
        plan_domain(Plan(*both))
    assert "T-junction" in str(caught.value)
    points, triangles = welded(*both)
    with pytest.raises(MeshError, match=r"lie inside an edge of the rim, .*T-junction") as caught:
        plan_domain(Plan(points, triangles))
    assert sorted(points[list(caught.value.vertices)].tolist()) == [[x, 4.0, 0.0] for x in (1.0, 3.0, 5.0, 7.0)]


def test_sound_plans_have_none():
    plan_domain(Plan(*grid(8, 4)))


def test_triangles_that_are_no_whole_numbers():
    points, triangles = grid(3, 3)
    with pytest.raises(MeshError, match="Faces must hold integers"):
        plan_domain(Plan(points, triangles + 0.5))
