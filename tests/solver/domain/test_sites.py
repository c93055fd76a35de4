"""The graph of sites: the same identities with normals at vertices and at faces."""

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from solver import ConditionError, Domain, conditions, shapes, solve_cmc
from solver.domain.sites import SITES, SiteGraph
from solver.gauss import sphere

SHAPES = {
    "disc": lambda: shapes.disc(300),
    "annulus": lambda: shapes.annulus(0.4, 1.0, 300),
    "torus": lambda: shapes.torus(1.0, 1.3, 8),
    "sphere": lambda: shapes.sphere(200),
}


@pytest.fixture(params=SHAPES)
def domain(request):
    return SHAPES[request.param]().domain


@pytest.mark.parametrize("sites", SITES)
def test_a_gradient_closes_around_every_cell_inside(domain, sites):
    """Differences of a function on the sites sum to zero along the links that surround a cell: cells and sides fit."""
    graph = SiteGraph.of(domain, sites)
    values = np.random.default_rng(0).normal(size=graph.count)
    i, j = graph.links.T
    difference = values[j] - values[i]
    around = np.zeros(graph.cell_count)
    left, right = graph.cells.T
    np.add.at(around, left, difference)  # a link has its left cell on the left: it runs counter-clockwise around it
    np.subtract.at(around, right[right >= 0], difference[right >= 0])
    inside = np.ones(graph.cell_count, dtype=bool)
    if not graph.at_vertices:
        inside[domain.boundary_vertices] = False
    assert_allclose(around[inside], 0, rtol=0, atol=1e-12)


@pytest.mark.parametrize("sites", SITES)
def test_weights_of_links_and_cells_are_each_others_inverse(domain, sites):
    primal, dual = SiteGraph.of(domain, "vertices"), SiteGraph.of(domain, "faces")
    assert_allclose(primal.weights[dual.edges] * dual.weights, 1, rtol=1e-12, atol=0)
    w = 0.5 / np.tan(dual.angles).prod(axis=1) * np.tan(dual.angles).sum(axis=1)
    assert_allclose(w, primal.weights[dual.edges], rtol=1e-9, atol=0)


@pytest.mark.parametrize("sites", SITES)
def test_areas_and_laplacians(domain, sites):
    graph = SiteGraph.of(domain, sites)
    assert_allclose(graph.areas.sum(), domain.area, rtol=1e-12, atol=0)
    L = graph.laplacian(graph.weights)
    u = np.random.default_rng(1).normal(size=graph.count)
    i, j = graph.links.T
    assert_allclose(u @ (L @ u), np.sum(graph.weights * (u[i] - u[j]) ** 2), rtol=1e-10, atol=0)
    assert_allclose(L @ np.ones(graph.count), 0, rtol=0, atol=1e-9)


def test_links_of_faces_cross_the_edges_inside(domain):
    graph = SiteGraph.of(domain, "faces")
    assert len(graph.links) == len(domain.interior_edges)
    assert_array_equal(np.sort(graph.cells, axis=1), np.sort(domain.edges[graph.edges], axis=1))


def test_completed_forms_close_around_every_site_of_the_boundary():
    domain = shapes.annulus(0.4, 1.0, 300).domain
    graph = SiteGraph.of(domain, "faces")
    form = np.random.default_rng(2).normal(size=(len(graph.links), 2))
    whole = graph.completed(form)
    assert_array_equal(whole[graph.edges], form)
    sums = graph.sums(form)
    behind = domain.edge_faces[domain.boundary_edges, 0]
    np.add.at(sums, behind, whole[domain.boundary_edges])
    assert_allclose(sums[graph.rim], 0, rtol=0, atol=1e-12)


def test_the_degree_of_the_identity_is_one_on_faces_too():
    shape = shapes.sphere(500)
    points = shape.positions
    normals = sphere.normalize(points[shape.domain.faces].mean(axis=1))
    graph = SiteGraph.of(shape.domain, "faces")
    assert_allclose(sphere.degree(normals, graph.triangles), 1, rtol=0, atol=1e-12)
    assert_allclose(sphere.degree(normals * [1, 1, -1], graph.triangles), -1, rtol=0, atol=1e-12)


def test_the_rings_of_faces_follow_the_boundary():
    domain = shapes.annulus(0.4, 1.0, 300).domain
    graph = SiteGraph.of(domain, "faces")
    assert [len(np.unique(ring)) for ring in graph.rings] == [len(ring) for ring in graph.rings]
    assert_array_equal(np.sort(np.concatenate(graph.rings)), graph.rim)
    assert len(graph.rings) == 2


def test_a_rectangle_has_no_weight_across_its_diagonal_and_a_dual_one_that_is_finite():
    domain = Domain.from_positions([[0, 0], [3, 0], [3, 1], [0, 1]], [[0, 1, 2], [0, 2, 3]])
    graph = SiteGraph.of(domain, "faces")
    assert graph.weights.shape == (1,) and 1e3 < graph.weights[0] < np.inf


def test_unknown_sites_are_refused():
    with pytest.raises(ConditionError, match="vertices, faces"):
        SiteGraph.of(shapes.disc(60).domain, "edges")


@pytest.mark.parametrize("sites", SITES)
def test_tau_leads_from_the_right_cell_to_the_left_one(sites):
    shape = shapes.disc(150)
    conormals = conditions.twisted(shape.domain, shape.positions, shape.domain.boundary_edges, 1)
    surface = solve_cmc(shape.domain, conormals, sites=sites, tolerance=1e-11)
    graph, conjugate = surface.graph, surface.conjugate
    inside = (graph.cells >= 0).all(axis=1)
    left, right = conjugate.g[graph.cells[inside].T]
    i, j = surface.harmonic.normals[graph.links[inside].T]
    star = graph.weights[inside, None]  # of the cotangent energy, or the dual one
    assert_allclose(left - right, star * np.cross(i, j), rtol=0, atol=1e-9)
