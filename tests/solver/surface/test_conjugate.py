"""The conjugate surface g: τ closes, three ways to g agree, boundary points, the fit."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

from solver import CmcSolver, shapes, solve_cmc
from solver.domain.sites import SiteGraph
from solver.gauss.dirichlet import Dirichlet
from solver.gauss.energies import ENERGIES
from solver.surface.conjugate import Conjugation, cross
from solver.surface.vertex_fit import fit_weights
from tests.solver.exact_surfaces import disc, rates
from tests.solver.rim_conditions import once_twisted
from tests.solver.surface_errors import centred, worst


def test_three_ways_to_the_conjugate_agree():
    """The sum of τ along a tree, the dual Poisson equation (both at circumcentres) and the P1 solve (at vertices)."""
    differences = []
    for n in (500, 2000):
        shape = shapes.disc(n)
        domain = shape.domain
        surface = solve_cmc(domain, once_twisted(domain, shape.positions), tolerance=1e-11)
        by_tree = centred(surface.conjugate.g)
        assert_allclose(dual_poisson(surface.graph, surface.normals), by_tree, rtol=0, atol=1e-8)
        faces, edges = fit_weights(domain, np.arange(domain.vertex_count))
        conjugate = surface.conjugate
        fitted = faces @ np.repeat(conjugate.g, 3, axis=0) + edges @ np.repeat(conjugate.boundary_points, 2, axis=0)
        differences.append(worst(fitted, surface.g))
    assert rates(differences)[0] > 1.5


def dual_poisson(graph: SiteGraph, N: np.ndarray) -> np.ndarray:
    """The conjugate of normals at vertices by the dual Poisson equation, (F, 3) centred at its mean.

    Σ w*_e (g_left - g_right) = Σ N_i × N_j around every face, w* = 1/w the dual cotangent weights, with the
    natural condition along the boundary (paper, Eq. 10 and Appendix C). For simply connected Delaunay domains. It
    agrees with the integral of tau as far as N is harmonic, and so checks it.
    """
    inside = graph.domain.interior_edges
    i, j = graph.links[inside].T
    faces = SiteGraph.of(graph.domain, "faces")
    anchor = np.zeros(1, dtype=np.int64)
    g = Dirichlet(faces, faces.weights, anchor).solve(faces.sums(cross(N[i], N[j])), np.zeros((1, 3)))
    return g - g.mean(axis=0)


def test_tau_closes_exactly_as_far_as_the_map_is_harmonic():
    domain, points = disc(800)
    solver = CmcSolver(domain)
    loose = solver.solve(once_twisted(domain, points), tolerance=1e-2, max_iterations=2)
    tight = solver.solve(once_twisted(domain, points), tolerance=1e-12)
    assert tight.conjugate.closure_error < 1e-12 < loose.conjugate.closure_error
    random = np.random.default_rng(0).normal(size=(domain.vertex_count, 3))
    N = random / np.linalg.norm(random, axis=1, keepdims=True)
    conjugate = Conjugation(SiteGraph.of(domain, "vertices")).conjugate(N, ENERGIES["cotan"])
    torques = np.linalg.norm(np.cross(N, domain.laplacian @ N), axis=1)
    inside = np.setdiff1d(np.arange(domain.vertex_count), domain.boundary_vertices)
    assert_allclose(conjugate.closure_error, torques[inside].max(), rtol=1e-10, atol=0)


def test_edges_of_the_conjugate_are_orthogonal_to_both_normals():
    domain, points = disc(300)
    surface = solve_cmc(domain, once_twisted(domain, points))
    for end in domain.edges.T:
        assert_allclose(np.einsum("ij,ij->i", surface.conjugate.tau, surface.normals[end]), 0, rtol=0, atol=1e-14)


def test_boundary_points_complete_the_dual_polygons():
    """Figure 7: the dual polygon of a boundary vertex runs through its faces and a point on each of its two edges."""
    domain, points = disc(300)
    surface = solve_cmc(domain, once_twisted(domain, points))
    conjugate = surface.conjugate
    faces = domain.edge_faces[domain.boundary_edges, 0]
    across = conjugate.g[faces] - conjugate.boundary_points
    assert_allclose(across, conjugate.tau[domain.boundary_edges], rtol=0, atol=1e-14)
    on_faces = solve_cmc(domain, once_twisted(domain, points), sites="faces", energy="dual_cotan").conjugate
    assert on_faces.boundary_points.shape == (0, 3), "with normals on faces g is at the vertices already"


@pytest.mark.parametrize("name", ["disc", "annulus"])
def test_linear_functions_are_reproduced_by_the_fit(name):
    if name == "disc":
        domain, points = disc(800)
    else:
        shape = shapes.annulus(0.4, 1.0, 800)
        domain, points = shape.domain, shape.positions
    values = lambda x: x @ np.array([[1.0, 2.0, 3.0], [0.5, -1.0, 2.0]]) + 1.0  # noqa: E731
    a, b, c = (points[domain.faces[:, k]] for k in range(3))
    ab, ac = b - a, c - a
    twice = 2 * (ab[:, 0] * ac[:, 1] - ab[:, 1] * ac[:, 0])
    squares = np.sum(ab**2, axis=1), np.sum(ac**2, axis=1)
    centre = a + np.column_stack(
        [
            (squares[0] * ac[:, 1] - squares[1] * ab[:, 1]) / twice,
            (squares[1] * ab[:, 0] - squares[0] * ac[:, 0]) / twice,
        ]
    )
    faces, edges = fit_weights(domain, np.arange(domain.vertex_count))
    midpoints = points[domain.edges[domain.boundary_edges]].mean(axis=1)
    fitted = faces @ np.repeat(values(centre), 3, axis=0) + edges @ np.repeat(values(midpoints), 2, axis=0)
    assert_allclose(fitted, values(points), rtol=0, atol=1e-11)
