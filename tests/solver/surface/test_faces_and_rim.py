"""Normals on faces and on the edges of the rim: conditions hold where they are prescribed, at second order."""

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from solver import (
    Domain,
    HarmonicSolver,
    Status,
    conditions,
    conformal_distortion,
    mean_curvature_of,
    shapes,
    solve_cmc,
)
from solver.domain.sites import SiteGraph
from solver.gauss import sphere
from tests.solver.exact_surfaces import disc, hemisphere, rates

SITES = "faces_and_rim"


def grid(columns, rows, skew=0.0):
    """Square quads, each split along a diagonal; the triangles at two corners have two sides on the boundary."""
    x, y = np.meshgrid(np.arange(columns + 1.0), np.arange(rows + 1.0))
    points = np.column_stack([x.ravel() + skew * y.ravel(), y.ravel()])
    a = (np.arange(rows)[:, None] * (columns + 1) + np.arange(columns)).ravel()
    b, c, d = a + 1, a + columns + 2, a + columns + 1
    return Domain.from_positions(points, np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])), points


def test_edges_of_the_rim_have_sites_of_their_own():
    shape = shapes.disc(200)
    domain = shape.domain
    rim, count = domain.boundary_edges, len(domain.faces)
    graph = SiteGraph.of(domain, SITES)
    assert graph.count == count + len(rim) and len(graph.links) == len(domain.edges)
    assert_array_equal(graph.rim, np.arange(count, graph.count))
    outwards = shape.positions[domain.edges[rim]].mean(axis=1)[:, :2]
    found = HarmonicSolver(domain, sites=SITES).solve(conditions.binormal(domain, shape.positions, rim, 0.3))
    expected = np.cos(0.3) * outwards / np.linalg.norm(outwards, axis=1)[:, None]
    assert_allclose(found.normals[count:, :2], expected, rtol=0, atol=1e-12)
    assert found.normals.shape == (graph.count, 3)


def test_one_by_one_or_along_edges():
    domain = shapes.disc(200).domain
    edges = domain.boundary_edges
    both = conditions.fixed(domain, edges[:5], [1, 0, 0]) + conditions.fixed(domain, edges[4:], [0, 1, 0])
    found = HarmonicSolver(domain, sites=SITES).solve(both)
    on_rim = found.normals[len(domain.faces) :]
    assert_allclose(on_rim[4], np.sqrt([0.5, 0.5, 0]), rtol=0, atol=1e-12)
    assert_allclose(on_rim[[0, 9]], [[1, 0, 0], [0, 1, 0]], rtol=0, atol=1e-12)


@pytest.mark.parametrize("energy", ["dual_cotan", "mobius"])
@pytest.mark.parametrize("jitter", [0.0, 0.2])
def test_the_hemisphere_at_second_order(energy, jitter):
    energies, misses = [], []
    for n in (500, 2000, 8000):
        domain, points = disc(n, jitter=jitter)
        rim = conditions.binormal(domain, points, domain.boundary_edges)
        surface = solve_cmc(domain, rim, sites=SITES, energy=energy, delaunay=True, tolerance=1e-9)
        energies.append(abs(surface.harmonic.energy - 2 * np.pi))
        misses.append(np.sqrt(np.mean((surface.normals - hemisphere(points)) ** 2)))
        exact = hemisphere(points)
        assert np.abs(surface.g - (surface.g - exact).mean(axis=0) - exact).max() < 60 / n
    assert rates(misses).min() > 1.7
    assert energies[-1] < 5e-3 and (jitter or rates(energies).min() > 1.7)


@pytest.mark.parametrize("energy", ["dual_cotan", "mobius"])
def test_mean_curvature_converges_at_irregular_rims(energy):
    l2, linf, distortion = [], [], []
    for n in (600, 2400, 9600):
        domain, points = disc(n, jitter=0.2)
        rim = conditions.twisted(domain, points, domain.boundary_edges, 1)
        surface = solve_cmc(domain, rim, sites=SITES, energy=energy, delaunay=True)
        miss = mean_curvature_of(surface.f_plus, surface.faces, surface.normals) - 0.5
        Q = conformal_distortion(domain, surface.f_plus)
        l2.append(np.sqrt(np.average(miss**2, weights=domain.face_areas)))
        linf.append(np.abs(miss).max())
        distortion.append(np.sqrt(np.average((0.5 * (Q + 1 / Q) - 1) ** 2, weights=domain.face_areas)))
    assert rates(l2).min() > 0.9 and rates(linf).mean() > 0.8 and rates(distortion).mean() > 1.8


def test_the_conjugate_closes_around_every_face_and_reaches_the_tips_of_ears():
    domain, points = grid(12, 9, skew=-0.3)
    behind = domain.edge_faces[domain.boundary_edges, 0]
    assert (np.bincount(behind) == 2).any()
    bowl = np.column_stack([points, -0.01 * ((points - 5) ** 2).sum(axis=1)])
    rim = conditions.gauss_map(domain, bowl, domain.boundary_edges)
    surface = solve_cmc(domain, rim, sites=SITES, energy="mobius", tolerance=1e-8)
    g, tau, N = surface.conjugate.g, surface.conjugate.tau, surface.harmonic.normals
    i, j = domain.edges.T
    assert_allclose(g[j] - g[i], tau, rtol=0, atol=1e-8)
    corners = g[domain.faces]
    area = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    assert_allclose(np.cross(area, N[: len(domain.faces)]), 0, rtol=0, atol=1e-8)
    Q = conformal_distortion(domain, surface.f_plus)  # the corners of the plan are not rounded
    assert Q.max() < 1.6 and np.quantile(Q, 0.9) < 1.1


def test_free_edges_take_the_normal_of_their_face():
    shape = shapes.strip(2.0, 1.0, 16)
    domain = shape.domain
    ends = conditions.fixed(domain, shape.sides["left"], [0, 0, 1])
    ends += conditions.fixed(domain, shape.sides["right"], [1, 0, 0])
    found = HarmonicSolver(domain, sites=SITES, energy="mobius").solve(ends, tolerance=1e-10)
    sides = np.concatenate([shape.sides["bottom"], shape.sides["top"]])
    own, behind = SiteGraph.of(domain, SITES).owners[sides], domain.edge_faces[sides, 0]
    assert_allclose(found.normals[own], found.normals[behind], rtol=0, atol=1e-8)
    assert_allclose(found.normals[:, 1], 0, rtol=0, atol=1e-8)


def test_the_degree_counts_the_whole_disc():
    shape = shapes.disc(2000)
    rim = conditions.binormal(shape.domain, shape.positions, shape.domain.boundary_edges)
    found = HarmonicSolver(shape.domain, sites=SITES, energy="mobius").solve(rim)
    assert_allclose(found.degree, 0.5, rtol=0, atol=1e-2)
    triangles = SiteGraph.of(shape.domain, SITES).triangles
    assert sphere.solid_angles(found.normals, triangles).min() > 0


@pytest.mark.parametrize("energy", ["dual_cotan", "mobius", "shell", "tan"])
@pytest.mark.parametrize("sites", ["faces", SITES])
def test_quads_behave(sites, energy):
    """Halves of squares lie on one circle and turn as one; at the corners two conditions meet in one square."""
    domain, points = grid(12, 9)
    rim = conditions.binormal(domain, points, domain.boundary_edges, 0.5)
    surface = solve_cmc(domain, rim, sites=sites, energy=energy)
    reference = solve_cmc(domain, rim)
    assert surface.status is Status.CONVERGED
    halves = surface.harmonic.normals[: len(domain.faces)].reshape(2, -1, 3)
    assert_allclose(halves[0], halves[1], rtol=0, atol=1e-3)
    assert 0.7 < np.ptp(surface.f_plus, axis=0).max() / np.ptp(reference.f_plus, axis=0).max() < 1.3
    assert len(np.unique(SiteGraph.of(domain, "faces").bodies)) == len(domain.faces) // 2
