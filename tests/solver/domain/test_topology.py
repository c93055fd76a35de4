"""Trees, homology and cuts: integrals of closed forms on domains with holes and handles."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from solver import shapes
from solver.domain.delaunay import intrinsic_delaunay
from solver.domain.topology import Homology
from solver.domain.trees import accumulate
from tests.solver import tiny_domains

SQUARE_WITH_HOLES = (
    [(0, 0), (4, 0), (4, 3), (0, 3)],
    [[(0.5, 0.5), (1.5, 0.5), (1.5, 1.5), (0.5, 1.5)], [(2.3, 1.2), (3.4, 1.2), (3.4, 2.4), (2.3, 2.4)]],
)
DOMAINS = {
    "disc": (lambda: shapes.disc(300).domain, 0),
    "annulus": (lambda: shapes.annulus(0.4, 1.0, 400).domain, 1),
    "cylinder": (lambda: shapes.cylinder(2 * np.pi, 2.0, 24).domain, 1),
    "two holes": (lambda: shapes.polygon(*SQUARE_WITH_HOLES, max_edge=0.2).domain, 2),
    "torus": (lambda: shapes.torus(3.0, 2.0, 16).domain, 2),
    "sphere": (lambda: shapes.sphere(200).domain, 0),
    # edges that join the same two vertices, or a vertex to itself; faces that have a vertex twice or three times
    "tube of loops": (lambda: intrinsic_delaunay(tiny_domains.helix(12, (0.4, 1.0), (1.8, 2.0))).domain, 1),
    "cylinder of one column": (lambda: tiny_domains.small_cylinder(1, (1.0, 0.0), (0.3, 1.0)), 1),
    "torus of loops": (lambda: intrinsic_delaunay(tiny_domains.seven_vertex_torus((1.0, 0.0), (2.03, 0.1))).domain, 2),
    "torus of one vertex": (lambda: tiny_domains.small_torus(1, 1, (1.0, 0.0), (0.3, 1.0)), 2),
}


@pytest.fixture(params=DOMAINS)
def case(request):
    make, generators = DOMAINS[request.param]
    return make(), generators


def closed_form(domain, homology, periods, seed=4):
    """A form with given periods: differences of random face values, plus the crossings."""
    random = np.random.default_rng(seed)
    values = random.normal(size=(len(domain.faces), 2))
    left, right = domain.edge_faces.T
    form = values[left] - np.where(right[:, None] >= 0, values[right], 0.0)
    return form + homology.crossings @ periods


def around_vertices(domain, form):
    """Sum of the increments met walking counter-clockwise around each vertex (V, d)."""
    sums = np.zeros((domain.vertex_count, form.shape[1]))
    np.add.at(sums, domain.edges[:, 0], form)
    np.subtract.at(sums, domain.edges[:, 1], form)
    return sums


def test_accumulate_follows_paths_to_the_root():
    parent = np.array([0, 0, 1, 2, 1, 5])
    steps = np.array([[9.0], [1.0], [2.0], [4.0], [8.0], [7.0]])
    assert_array_equal(accumulate(parent, steps)[:, 0], [0, 1, 3, 7, 9, 0])


def test_the_number_of_generators_is_the_first_betti_number(case):
    domain, generators = case
    homology = Homology.of(domain)
    assert len(homology.generators) == generators
    loops = len(domain.boundary_loops)
    assert generators == 2 * domain.genus + max(loops - 1, 0)


def test_the_tree_integrates_a_closed_form_up_to_its_periods(case):
    domain, generators = case
    homology = Homology.of(domain)
    periods = np.random.default_rng(1).normal(size=(generators, 2))
    form = closed_form(domain, homology, periods)
    inside = np.setdiff1d(np.arange(domain.vertex_count), domain.boundary_vertices)
    assert_allclose(around_vertices(domain, form)[inside], 0, rtol=0, atol=1e-12)
    values = homology.integrate(form)
    left, right = domain.edge_faces[domain.interior_edges].T
    jumps = form[domain.interior_edges] - (values[left] - values[right])
    assert_allclose(jumps, homology.crossings[domain.interior_edges] @ periods, rtol=0, atol=1e-11)
    assert_allclose(homology.periods(form, values), periods, rtol=0, atol=1e-11)


def test_the_tree_reaches_every_face(case):
    domain, _ = case
    tree = Homology.of(domain).tree
    depth = accumulate(tree.parent, np.ones((len(tree.parent), 1)))[:, 0]
    assert (tree.parent == np.arange(len(tree.parent))).sum() == 1
    assert (depth > 0).sum() == len(tree.parent) - 1


def test_cutting_makes_the_surface_simply_connected(case):
    domain, generators = case
    sheets = Homology.of(domain).sheets
    rows, faces = len(sheets.source), sheets.faces
    assert_array_equal(sheets.source[faces], domain.faces)
    assert_array_equal(sheets.source[: domain.vertex_count], np.arange(domain.vertex_count))
    edges = len(domain.edges) + len(Homology.of(domain).cut)  # those of the cut are there twice
    # a closed surface of genus 0 stays a sphere; everything else is cut to a disc
    assert rows - edges + len(faces) == (2 if not domain.boundary_loops and generators == 0 else 1)


def test_offsets_follow_the_crossings(case):
    """On the cut surface, rows of a vertex left and right of a cut edge differ by its crossing."""
    domain, _ = case
    homology = Homology.of(domain)
    sheets = homology.sheets
    rows = sheets.faces.ravel()
    after = lambda corner: corner - corner % 3 + (corner + 1) % 3  # noqa: E731
    for e in homology.cut:
        left, right = domain.half_edges[e]
        for a, b in ((after(left), after(after(right))), (after(after(left)), after(right))):
            assert domain.faces.ravel()[a] == domain.faces.ravel()[b]
            assert_array_equal(sheets.offsets[rows[b]] - sheets.offsets[rows[a]], homology.crossings[e])


def test_the_cut_of_an_annulus_joins_its_loops():
    domain = shapes.annulus(0.4, 1.0, 400).domain
    homology = Homology.of(domain)
    ends, counts = np.unique(domain.edges[homology.cut], return_counts=True)
    tips = ends[counts == 1]
    loops = [np.isin(tips, loop).sum() for loop in domain.boundary_loops]
    assert loops == [1, 1] and (counts <= 2).all()
