"""The radii of rounded corners: chosen in proportion to each loop and its edges, and said."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

from solver import shapes
from solver.meshing.mesher import mesh_plan
from solver.meshing.outline import signed_area
from solver.meshing.rounding import automatic_radii, rounded_sentence
from tests.solver.drawn_outlines import ellipse


def box(width, depth, at=(0.0, 0.0)) -> np.ndarray:
    return np.array([(0, 0), (width, 0), (width, depth), (0, depth)], dtype=float) + at


HALL, COURT = box(60, 40), box(5, 5, (27, 17))


def loop_area(mesh, loop) -> float:
    """Area inside a loop, whose vertices follow each other."""
    return abs(signed_area(mesh.positions[mesh.edges[mesh.loop == loop, 0]]))


def test_a_court_stays_a_court():
    """A tenth of the whole plan would make a circle of it: π 2.5² of 25."""
    mesh = mesh_plan(HALL, [COURT], max_edge=1.5, corner_radius=None)
    assert_allclose(mesh.rounded, [6.0] * 4 + [0.5] * 4, rtol=1e-6)
    assert loop_area(mesh, 1) == pytest.approx(25 - (4 - np.pi) * 0.5**2, rel=2e-3)


def test_at_least_half_of_each_edge_stays_straight():
    """The teeth of a comb are 2 wide, of a plan 40 wide."""
    comb = np.array([(0, 0), (40, 0), (40, 12), (38, 12), (38, 4), (2, 4), (2, 12), (0, 12)], dtype=float)
    radii = automatic_radii(comb)
    assert_allclose(radii, [3.0, 3.0, 0.5, 0.5, 2.0, 2.0, 0.5, 0.5])
    assert_allclose(mesh_plan(comb, max_edge=1.0, corner_radius=None).rounded, radii, rtol=1e-6)


def test_an_edge_may_be_drawn_in_pieces():
    pieces = np.array([(0, 0), (1, 0), (10, 0), (10, 10), (0, 10)], dtype=float)
    assert_allclose(automatic_radii(pieces), [1, 0, 1, 1, 1])


def test_a_sharp_tip_is_rounded_by_less():
    tip = np.array([(0, 0), (10, -1), (10, 1)], dtype=float)
    length, half = np.hypot(10, 1), 0.5 * (np.pi - 2 * np.arctan(0.1))
    assert automatic_radii(tip)[0] == pytest.approx(0.25 * length / np.tan(half))


def test_smooth_curves_have_no_corners():
    assert not automatic_radii(ellipse(60, 5, 3)).any()
    assert len(mesh_plan(ellipse(60, 5, 3), max_edge=0.8, corner_radius=None).rounded) == 0


@pytest.mark.parametrize("factor", [1e-6, 1.0, 1e6])
def test_radii_grow_with_the_plan(factor):
    mesh = mesh_plan(factor * HALL, [factor * COURT], max_edge=3.0 * factor, corner_radius=None)
    assert_allclose(mesh.rounded / factor, [6.0] * 4 + [0.5] * 4, rtol=1e-6)


def test_what_was_rounded_is_said():
    assert rounded_sentence(np.zeros(0)) is None
    assert rounded_sentence(np.array([0.8])) == "Rounded 1 corner by 0.8."
    assert rounded_sentence(np.full(4, 0.8)) == "Rounded 4 corners by 0.8."
    text = rounded_sentence(np.array([6.0] * 4 + [0.5] * 4))
    assert text == "Rounded 8 corners by 0.5 to 6."
    assert text.written(lambda length, power: f"{length:g} m") == "Rounded 8 corners by 0.5 m to 6 m."


def test_a_shape_notes_what_was_not_asked_for():
    assert shapes.polygon(HALL, max_edge=3.0).notes == ()
    assert shapes.polygon(HALL, max_edge=3.0, corner_radius=2.0).notes == ()
    (note,) = shapes.polygon(HALL, max_edge=3.0, corner_radius=None).notes
    assert note == "Rounded 4 corners by 6."
    (note,) = shapes.polygon(HALL, [COURT], max_edge=3.0, corner_radius=4.0).notes
    assert note.code == "rounded" and note == "Rounded 8 corners by 2.5 to 4."


L_SHAPE = np.array([(0, 0), (40, 0), (40, 20), (20, 20), (20, 40), (0, 40)], dtype=float)


@pytest.mark.parametrize("radius", [None, 2.0])
@pytest.mark.parametrize("way", [1, -1], ids=["counter-clockwise", "clockwise"])
def test_only_corners_that_point_into_the_plan_are_rounded(radius, way):
    """One of an L, and those of a court: its area grows by the four cut corners of the L's own sign."""
    court = box(10, 10, (5, 5))[::way]
    mesh = mesh_plan(L_SHAPE[::way], [court], max_edge=1.0, corner_radius=radius, corners="re-entrant")
    inner, of_court = (4.0, 1.0) if radius is None else (2.0, 2.0)
    assert_allclose(mesh.rounded, [inner] + [of_court] * 4, rtol=1e-6)
    assert loop_area(mesh, 0) == pytest.approx(1200 + (1 - np.pi / 4) * inner**2, rel=1e-4)
    assert loop_area(mesh, 1) == pytest.approx(100 - (4 - np.pi) * of_court**2, rel=2e-3)
    for corner in L_SHAPE[[0, 1, 2, 4, 5]]:
        assert np.linalg.norm(mesh.positions - corner, axis=1).min() < 1e-12


def test_an_arc_leaves_room_for_the_sharp_corners_beside_it():
    mesh = mesh_plan(L_SHAPE, max_edge=1.0, corner_radius=30.0, corners="re-entrant")
    assert_allclose(mesh.rounded, [20.0], rtol=1e-6)


def test_no_corner_is_rounded_whatever_the_radius():
    sharp = mesh_plan(L_SHAPE, max_edge=1.0)
    for radius in (None, 2.0):
        mesh = mesh_plan(L_SHAPE, max_edge=1.0, corner_radius=radius, corners="none")
        assert len(mesh.rounded) == 0
        assert_allclose(mesh.positions, sharp.positions)


def test_a_shape_passes_the_corners_on():
    shape = shapes.polygon(L_SHAPE, max_edge=2.0, corner_radius=None, corners="re-entrant")
    assert shape.notes == ("Rounded 1 corner by 4.",)
