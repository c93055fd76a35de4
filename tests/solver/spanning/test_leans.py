"""Sides that lean over their line: the angle at the wall, mirrors as leans of 90°, and what cannot be."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

from solver import ConditionError, Shape, shapes, span_outline
from tests.solver.spanned_plans import distortion, inside_curvature

HALL = np.array([[0.0, 0.0], [18.0, 0.0], [18.0, 12.0], [0.0, 12.0]])


def hall(max_edge: float, corner_radius: float = 1.5) -> Shape:
    """A rectangle; sides "street", "back" along x and "left" without the rounded corners."""
    plan = shapes.polygon(HALL, max_edge=max_edge, corner_radius=corner_radius)
    ends = plan.positions[plan.domain.edges[plan.domain.boundary_edges]]
    for name, axis, place in (("street", 1, 0.0), ("back", 1, 12.0), ("left", 0, 0.0)):
        plan.sides[name] = plan.domain.boundary_edges[(np.abs(ends[:, :, axis] - place) < 1e-6).all(axis=1)]
    return plan


def angles(span, plan: Shape, side: str, away: float = 0.05) -> np.ndarray:
    """Degrees at which the surface meets the wall over a side, farther than `away` of the size from its ends."""
    pairs = plan.domain.edges[plan.sides[side]]
    way = plan.positions[pairs[:, 1]] - plan.positions[pairs[:, 0]]
    outward = np.column_stack([way[:, 1], -way[:, 0]]) / np.linalg.norm(way, axis=1)[:, None]
    count = np.zeros(plan.domain.vertex_count)
    normal = np.zeros((plan.domain.vertex_count, 2))
    for ends in pairs.T:
        np.add.at(count, ends, 1)
        np.add.at(normal, ends, outward)
    vertices = np.flatnonzero(count)
    normal = normal[vertices] / np.linalg.norm(normal[vertices], axis=1)[:, None]
    measured = np.degrees(np.arccos(np.einsum("ij,ij->i", span.normals[vertices, :2], normal)))
    far = np.ones(len(vertices), dtype=bool)
    for end in np.flatnonzero(count == 1):
        gap = np.linalg.norm(span.points[vertices, :2] - span.points[end, :2], axis=1)
        far &= gap > away * np.linalg.norm(np.ptp(plan.positions, axis=0))
    return measured[far]


@pytest.mark.parametrize(("angle", "H"), [(60, 0.0620), (85, 0.0420), (120, -0.0185)])
def test_one_side_leans(angle, H):
    plan = hall(0.6)
    span = span_outline(plan, plan.positions, rise=0.35, leans=[(plan.sides["street"], np.radians(angle))])
    assert span.ok, span.message
    found = angles(span, plan, "street")
    assert_allclose(np.median(found), angle, rtol=0, atol=0.6)
    assert np.abs(found - angle).max() < 1.5
    assert_allclose(span.mean_curvature, H, rtol=0.06)
    rim = np.unique(plan.domain.edges[plan.sides["street"]])
    assert np.abs(span.points[rim, 1]).max() < 1e-12  # over its line
    others = np.setdiff1d(plan.domain.boundary_vertices, rim)
    assert np.abs(span.points[others, 2]).max() < 1e-12


def test_the_angle_is_met_better_on_finer_meshes():
    off = []
    for max_edge in (0.75, 0.375):
        plan = hall(max_edge)
        span = span_outline(plan, plan.positions, rise=0.35, leans=[(plan.sides["street"], np.radians(35))])
        assert span.ok, span.message
        off.append(abs(np.median(angles(span, plan, "street")) - 35))
    assert off[1] < 0.5 * off[0] and off[1] < 0.6, off


def test_two_sides_lean_with_a_modulus():
    plan = hall(0.5)
    leans = [(plan.sides["street"], np.radians(60)), (plan.sides["back"], np.radians(70))]
    span = span_outline(plan, plan.positions, rise=0.35, leans=leans)
    assert span.ok, span.message
    for side, angle in (("street", 60), ("back", 70)):
        assert_allclose(np.median(angles(span, plan, side)), angle, rtol=0, atol=0.3)
    assert_allclose(span.mean_curvature, 0.0541, rtol=0.01)
    assert span.kept.descent.problem.motions.count == 1 and distortion(span) < 2e-4


def test_a_mirror_is_a_lean_of_ninety_and_half_is_half_of_the_whole():
    plan = hall(0.75, corner_radius=0.0)
    leans = span_outline(plan, plan.positions, rise=0.35, leans=[(plan.sides["side3"], 0.5 * np.pi)])
    mirrored = span_outline(plan, plan.positions, rise=0.35, mirrors=[(plan.sides["side3"], [1, 0, 0])])
    assert leans.ok and mirrored.ok
    assert_allclose(leans.points, mirrored.points, rtol=0, atol=1e-3)
    whole = shapes.polygon(HALL * [2, 1], max_edge=0.9)
    one = span_outline(whole, whole.positions, height=leans.points[:, 2].max())
    assert_allclose(one.mean_curvature, leans.mean_curvature, rtol=5e-3)
    assert_allclose(np.median(inside_curvature(leans)), leans.mean_curvature, rtol=0.01)


def test_adjacent_sides_lean_about_a_corner():
    plan = hall(1.0, corner_radius=0.0)
    leans = [(plan.sides["side0"], np.radians(60)), (plan.sides["side1"], np.radians(60))]
    span = span_outline(plan, plan.positions, rise=0.35, leans=leans)
    assert span.ok, span.message
    assert_allclose(np.median(angles(span, plan, "side0")), 60, rtol=0, atol=0.6)
    steep = [(edges, np.radians(40)) for edges, _ in leans]
    with pytest.raises(ConditionError, match="at least 45°"):
        span_outline(plan, plan.positions, rise=0.35, leans=steep)
    flat = [(edges, np.radians(150)) for edges, _ in leans]
    with pytest.raises(ConditionError, match=r"at most 135°.*steeper"):
        span_outline(plan, plan.positions, rise=0.35, leans=flat)


def test_a_courtyard_leans():
    circle = np.linspace(0, 2 * np.pi, 40, endpoint=False)
    hole = np.array([9, 6]) + 2.2 * np.column_stack([np.cos(circle), np.sin(circle)])
    plan = shapes.polygon(HALL, holes=[hole], max_edge=0.8, corner_radius=1.5)
    span = span_outline(plan, plan.positions, rise=0.5, leans=[(plan.sides["hole0"], np.radians(70))])
    assert span.ok, span.message
    assert_allclose(np.median(angles(span, plan, "hole0")), 70, rtol=0, atol=1.0)
    rim = np.unique(plan.domain.edges[plan.sides["hole0"]])
    assert np.abs(np.linalg.norm(span.points[rim, :2] - [9, 6], axis=1) - 2.2).max() < 0.02
    assert span.points[rim, 2].min() > 2.0


def test_what_cannot_lean():
    plan = hall(1.5)
    everywhere = [(plan.sides["outer"], 1.0)]
    with pytest.raises(ConditionError, match="Nothing holds the height"):
        span_outline(plan, plan.positions, leans=everywhere)
    with pytest.raises(ConditionError, match="out of range"):
        span_outline(plan, plan.positions, leans=[(plan.sides["street"], np.radians(4))])
    with pytest.raises(ConditionError, match=r"np\.radians"):
        span_outline(plan, plan.positions, leans=[(plan.sides["street"], 60)])
    with pytest.raises(ConditionError, match="more than the sides on lines can hold"):
        span_outline(plan, plan.positions, mean_curvature=0.13, leans=[(plan.sides["street"], np.radians(60))])


def hall_of_arcs(max_edge: float, radius: float) -> Shape:
    """The hall with its sides "street" and "left" to the middles of the arcs at their ends."""
    plan = shapes.polygon(HALL, max_edge=max_edge, corner_radius=radius)
    x, y = plan.positions[plan.domain.edges[plan.domain.boundary_edges]].mean(axis=1).T
    low, left = y - y.min(), x - x.min()
    plan.sides["street"] = plan.domain.boundary_edges[(low < left) & (low < radius) & (low < x.max() - x)]
    plan.sides["left"] = plan.domain.boundary_edges[(left < low) & (left < radius) & (left < y.max() - y)]
    return plan


@pytest.mark.parametrize(("radius", "angle", "noted"), [(0.5, 40, True), (0.5, 50, False), (1.5, 40, False)])
def test_steep_sides_about_a_corner_that_is_rounded_a_little(radius, angle, noted):
    """A surface exists, which goes the farther down the smaller the radius is."""
    plan = hall_of_arcs(0.9, radius)
    assert len(np.intersect1d(*(plan.domain.edges[plan.sides[name]] for name in ("street", "left")))) == 1
    span = span_outline(
        plan, plan.positions, rise=0.35, leans=[(plan.sides[name], np.radians(angle)) for name in ("street", "left")]
    )
    assert span.ok, span.message
    assert [note.code for note in span.asked.lines.notes] == (["steep-corner"] if noted else [])
    if noted:
        assert "goes far down" in span.asked.lines.notes[0]
        assert span.points[:, 2].min() < -6.0
