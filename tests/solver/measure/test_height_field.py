"""A mesh that is a graph over a plane is recognised; one that is not never passes for one."""

from __future__ import annotations

import numpy as np
import pytest

from solver.catalogue import shapes
from solver.measure import self_intersections
from solver.measure.height_field import is_graph
from solver.measure.intersections import _search
from tests.solver.sampled_surfaces import grid

TURN = np.linalg.qr(np.random.default_rng(9).normal(size=(3, 3)))[0]


def raised(positions, height=0.3):
    z = height * np.sin(3 * positions[:, 0]) * np.cos(2 * positions[:, 1])
    return np.column_stack([positions[:, :2], z])


def ribbon(angle, rise=0.0, n=120, inner=1.0, outer=1.5):
    """A band that goes `angle` around the vertical, climbing by `rise`: counter-clockwise seen from above."""
    parameters, faces = grid(4, n, 1.0, 1.0, 0.2)
    t, r = angle * parameters[:, 1], inner + (outer - inner) * parameters[:, 0]
    return np.column_stack([r * np.cos(t), r * np.sin(t), rise * parameters[:, 1]]), faces


@pytest.mark.parametrize("shape", [shapes.disc(300), shapes.annulus(1.0, 2.0, 300), shapes.strip(2.0, 1.0, 12)])
@pytest.mark.parametrize("turn", [np.eye(3), TURN])
@pytest.mark.parametrize("mirror", [1, -1])
def test_graphs(shape, turn, mirror):
    points, faces = raised(shape.positions) @ turn + 1000.0, shape.domain.faces[:, ::mirror]
    assert is_graph(points, faces)
    assert len(_search(points, faces, lambda: True)) == 0


def test_a_band_that_overlaps_itself_seen_from_above_is_none():
    assert is_graph(*ribbon(6.0))
    assert not is_graph(*ribbon(7.0))
    assert not is_graph(*ribbon(7.0, rise=3.0))
    assert len(self_intersections(*ribbon(6.0))) == 0
    assert len(self_intersections(*ribbon(7.0, rise=3.0))) == 0
    assert len(self_intersections(*ribbon(7.0))) > 0


def test_a_spiral_ramp_with_simple_curves_that_wind_twice_is_none():
    """Two storeys over one plan, one within the other's outline: simple, disjoint curves, covered twice."""
    shape = shapes.disc(100)
    upper = np.column_stack([0.5 * shape.positions, np.full(len(shape.positions), 1.0)])
    lower = np.column_stack([shape.positions, np.zeros(len(shape.positions))])
    faces = np.vstack([shape.domain.faces, shape.domain.faces + len(lower)])
    assert not is_graph(np.vstack([lower, upper]), faces)
    beside = upper + (3.0, 0.0, 0.0)
    assert is_graph(np.vstack([lower, beside]), faces)


def test_what_is_steep_closed_folded_or_not_a_surface_is_none():
    points, faces = grid(6, 6, 1.0, 1.0)
    flat = np.column_stack([points, np.zeros(len(points))])
    assert is_graph(flat, faces)
    folded = flat.copy()
    folded[:, 0] = np.abs(folded[:, 0] - 0.6)
    assert not is_graph(folded, faces)
    assert not is_graph(flat, np.vstack([faces, faces[:1]]))
    assert not is_graph(np.full_like(flat, np.nan), faces)
    assert not is_graph(np.zeros_like(flat), faces)
    sphere = shapes.sphere(200)
    assert not is_graph(sphere.positions, sphere.domain.faces)
    pinched = np.vstack([flat, flat + (1.0, 1.0, 0.0)])
    both = np.vstack([faces, faces + len(flat)])
    both[both == len(flat)] = len(flat) - 1
    assert not is_graph(pinched, both)


def test_the_quick_answer_is_that_of_the_search():
    random = np.random.default_rng(11)
    points, faces = grid(10, 10, 1.0, 1.0)
    known = 0
    for strength in np.linspace(0.0, 0.25, 60):
        moved = np.column_stack([points, np.zeros(len(points))]) + strength * random.normal(size=(len(points), 3))
        if is_graph(moved, faces):
            known += 1
            assert len(_search(moved, faces, lambda: True)) == 0
    assert 0 < known < 60
