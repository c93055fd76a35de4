"""Needles give the surface that a regular mesh gives (paper, Figure 19), more exactly on a Delaunay triangulation."""

from __future__ import annotations

import numpy as np
from numpy.testing import assert_allclose

from solver import Domain, Status, conditions, shapes, solve_cmc
from tests.solver import meshes
from tests.solver.surface_errors import distances, hausdorff

TILT = 0.3


def dome(points, faces, **options):
    """f+ (n, 3) over the disc with a rim that leans in, the middle of its area at the origin, and its faces."""
    domain = Domain.from_positions(points, faces)
    rim = conditions.binormal(domain, points, domain.boundary_edges, tilt=TILT)
    surface = solve_cmc(domain, rim, **options)
    assert surface.status is Status.CONVERGED
    a, b, c = (surface.f_plus[surface.faces[:, k]] for k in range(3))
    areas = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    return surface.f_plus - np.average((a + b + c) / 3, axis=0, weights=areas), surface.faces


def test_needles_give_the_same_surface():
    """Angles down to 1°, a third of the edges not Delaunay: 0.9 % of the diagonal away, 0.2 % with delaunay."""
    points, faces = meshes.needles(3000, 8.0)
    assert np.degrees(meshes.smallest_angle(points, faces).min()) < 2.0
    assert (Domain.from_positions(points, faces).cotan_weights < 0).mean() > 0.25
    plan = shapes.disc(8000)
    regular = dome(plan.positions, plan.domain.faces)
    diagonal = np.linalg.norm(np.ptp(regular[0], axis=0))
    as_it_is = hausdorff(*dome(points, faces), *regular) / diagonal
    delaunay = hausdorff(*dome(points, faces, delaunay=True), *regular) / diagonal
    assert as_it_is < 1e-2
    assert delaunay < 0.5 * as_it_is


def test_distances_to_a_mesh_are_exact():
    """From points around a cube of side 2: to faces, edges and corners."""
    corners = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], dtype=float)
    quads = np.array([[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]])
    faces = meshes.split(quads, np.random.default_rng(0))
    queries = np.random.default_rng(1).uniform(-3, 3, (500, 3))
    outside = np.linalg.norm(np.maximum(np.abs(queries) - 1.0, 0.0), axis=1)
    inside = 1.0 - np.abs(queries).max(axis=1)
    exact = np.where(outside > 0, outside, inside)
    assert_allclose(distances(queries, corners, faces, 0.1), exact, rtol=0, atol=1e-12)
