"""Plans laid anew: outlines that close, and a triangle in space whose plan is too unlike it."""

from __future__ import annotations

import numpy as np
from numpy.testing import assert_allclose

from solver import shapes, span_outline
from solver.spanning.layout import flat_layout
from solver.spanning.relay import closed_outline, rolled_out, under_lines
from tests.solver.exact_surfaces import disc
from tests.solver.spanned_plans import distortion


def test_an_outline_closes_with_its_lengths():
    random = np.random.default_rng(1)
    lengths = random.uniform(0.5, 1.5, 40)
    turns = 2 * np.pi / 40 + 0.1 * random.normal(size=40)
    turns[[0, 13, 27]] += 0.8
    points = closed_outline(turns, lengths)
    edges = np.roll(points, -1, axis=0) - points
    assert_allclose(np.linalg.norm(edges, axis=1), lengths, rtol=0, atol=1e-6)
    made = np.angle(np.exp(1j * np.diff(np.unwrap(np.arctan2(edges[:, 1], edges[:, 0])))))
    assert np.abs(made - turns[1:]).max() < 0.25  # what is bent away, on every edge


def test_a_flat_surface_rolls_out_to_itself():
    domain, points = disc(200)
    stretched = np.column_stack([1.3 * points[:, 0], points[:, 1], 0 * points[:, 0]])
    laid = rolled_out(domain, points, stretched)
    assert laid is not None
    rim = domain.boundary_edges
    i, j = domain.edges[rim].T
    assert_allclose(laid.edge_lengths[rim], np.linalg.norm(stretched[j] - stretched[i], axis=1), rtol=1e-6)
    assert flat_layout(laid, stretched)[0] is laid
    assert under_lines(domain, stretched * [1, 1, 0]) is not None
    assert under_lines(domain, stretched * [-1, 1, 0]) is None


def test_a_steep_line_over_a_narrow_plan():
    """Two corners of a triangle far above its third: the plan has other angles and lengths than the surface."""
    outline = np.array([[0.0, 0.0], [1.0, -0.15], [1.0, 0.15]])
    plan = shapes.polygon(outline, max_edge=0.035, corner_radius=0.05)
    x, y = plan.positions.T
    line = np.column_stack([x, y, 1.5 * x * (1 + y)])
    span = span_outline(plan, line)
    assert span.ok, span.message
    assert distortion(span) < 5e-3
