"""Intrinsic Delaunay triangulations: every edge is Delaunay, the metric stays, with libigl and without."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from scipy.spatial import Delaunay

from solver import Domain, MeshError
from solver.domain import delaunay
from solver.domain.delaunay import intrinsic_delaunay
from solver.domain.flips import Flips
from solver.surface import averaging
from tests.solver import tiny_domains
from tests.solver.thin_domains import DOMAINS, FLAT, opposite_angles, stretched, stretched_faces


@pytest.fixture(params=DOMAINS)
def domain(request) -> Domain:
    return DOMAINS[request.param]()


@pytest.fixture(params=["libigl", "our flips"])
def way(request) -> None:
    if request.param == "our flips":
        request.getfixturevalue("without_libigl")
    assert (delaunay._libigl() is None) == (request.param == "our flips")


def cone_angles(domain: Domain) -> np.ndarray:
    return np.bincount(domain.faces.ravel(), domain.corner_angles.ravel())


def test_there_is_something_to_do(domain):
    assert domain.cotan_weights[domain.interior_edges].min() < -0.1


@pytest.mark.usefixtures("way")
def test_every_interior_edge_is_delaunay(domain):
    new = intrinsic_delaunay(domain).domain
    assert opposite_angles(new).max() <= np.pi + 1e-10
    assert new.cotan_weights[new.interior_edges].min() >= -1e-12


@pytest.mark.usefixtures("way")
def test_the_metric_stays(domain):
    """Area, the angles around each vertex, the boundary; and how many vertices, faces, handles and loops."""
    new = intrinsic_delaunay(domain).domain
    assert_allclose(new.area, domain.area, rtol=1e-9, atol=0)
    assert_allclose(cone_angles(new), cone_angles(domain), rtol=0, atol=1e-7)
    assert (new.vertex_count, len(new.faces), new.genus) == (domain.vertex_count, len(domain.faces), domain.genus)
    assert len(new.boundary_loops) == len(domain.boundary_loops)
    for mine, theirs in zip(new.boundary_loops, domain.boundary_loops, strict=True):
        assert_array_equal(mine, theirs)


@pytest.mark.usefixtures("way")
def test_boundary_edges_are_followed(domain):
    new, edges = intrinsic_delaunay(domain).domain, intrinsic_delaunay(domain).edges
    rim = domain.boundary_edges
    assert_array_equal(new.edges[edges[rim]], domain.edges[rim])
    assert_array_equal(new.edge_lengths[edges[rim]], domain.edge_lengths[rim])
    assert_array_equal(np.sort(edges[rim]), new.boundary_edges)
    assert (edges[domain.interior_edges] == -1).all() and len(edges) == len(domain.edges)


@pytest.mark.usefixtures("way")
def test_a_delaunay_domain_stays_the_same(domain):
    once = intrinsic_delaunay(domain)
    twice = intrinsic_delaunay(once.domain)
    assert_array_equal(twice.domain.faces, once.domain.faces)
    assert_array_equal(twice.domain.edge_lengths, once.domain.edge_lengths)
    rim = once.domain.boundary_edges
    assert_array_equal(twice.edges[rim], rim)


@pytest.mark.usefixtures("way")
def test_the_energy_falls(domain):
    """Of all triangulations of the vertices the Delaunay one has the least Dirichlet energy (Rippa)."""
    new = intrinsic_delaunay(domain).domain
    values = np.random.default_rng(5).normal(size=(domain.vertex_count, 4))
    before = np.einsum("vi,vi->i", values, domain.laplacian @ values)
    after = np.einsum("vi,vi->i", values, new.laplacian @ values)
    assert (after <= before * (1 + 1e-9)).all()


@pytest.mark.parametrize("name", FLAT)
def test_triangles_of_the_plane_stay_triangles_of_the_plane(name):
    """Where the plan is convex, edges are straight, and linear functions harmonic."""
    points, faces = FLAT[name]()
    new = intrinsic_delaunay(Domain.from_positions(points, faces)).domain
    a, b, c = (points[new.faces[:, k]] for k in range(3))
    twice = (b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]
    assert_allclose(new.face_areas, 0.5 * twice, rtol=1e-4, atol=0)  # lengths do not tell a needle better
    lengths = np.linalg.norm(points[new.edges[:, 1]] - points[new.edges[:, 0]], axis=1)
    assert_allclose(new.edge_lengths, lengths, rtol=1e-9, atol=0)
    inside = np.setdiff1d(np.arange(len(points)), new.boundary_vertices)
    scale = np.abs(new.laplacian).max() * np.abs(points).max()
    assert_allclose((new.laplacian @ points)[inside], 0, rtol=0, atol=1e-10 * scale)


def test_is_the_delaunay_triangulation_of_the_plane():
    """Inside of a ring of many vertices the points have one Delaunay triangulation, whatever they start from."""
    random = np.random.default_rng(2)
    angle = 2 * np.pi * np.arange(60) / 60
    points = np.concatenate([np.column_stack([np.cos(angle), np.sin(angle)]), 0.85 * (random.random((80, 2)) - 0.5)])
    points[60:, 1] *= 0.5
    start = stretched_faces(points, 30.0)
    best = np.unique(np.sort(Delaunay(points).simplices, axis=1), axis=0)
    new = intrinsic_delaunay(Domain.from_positions(points, start)).domain
    inner = lambda faces: {tuple(face) for face in np.sort(faces, axis=1).tolist() if max(face) >= 60}  # noqa: E731
    assert inner(start) != inner(best)
    assert inner(new.faces) == inner(best)


@pytest.mark.parametrize("vertices", [1, 9])
def test_a_lattice_has_its_shortest_vectors_for_edges(vertices):
    """(1, 0), (5.3, 1) generate the same lattice as (1, 0), (0.3, 1)."""
    n = round(vertices**0.5)
    new = intrinsic_delaunay(tiny_domains.small_torus(n, n, (1.0, 0.0), (5.3, 1.0))).domain
    lengths = np.sort(new.edge_lengths).reshape(3, -1)
    assert_allclose(lengths, np.repeat([[1.0], [1.09**0.5], [1.49**0.5]], vertices, axis=1), rtol=1e-12, atol=0)


def test_an_edge_may_join_a_vertex_to_itself():
    """Around a tube whose vertices are further apart along it than around it."""
    u, v = (0.4, 1.0), (1.8, 2.0)
    domain = tiny_domains.helix(12, u, v)
    new = intrinsic_delaunay(domain).domain
    closed = new.edges[:, 0] == new.edges[:, 1]
    assert not (domain.edges[:, 0] == domain.edges[:, 1]).any()
    assert_allclose(new.edge_lengths[closed], 1.0, rtol=1e-12, atol=0)  # v - 2 u, the circumference
    assert closed.sum() >= 6
    # height along the tube is linear, and so harmonic: an edge from a vertex to itself weighs nothing
    height = tiny_domains.helix_height(12, u, v)
    inside = np.setdiff1d(np.arange(12), new.boundary_vertices)
    assert_allclose((new.laplacian @ height)[inside], 0, rtol=0, atol=1e-12)
    assert_allclose(new.laplacian.sum(axis=1), 0, rtol=0, atol=1e-12)


@pytest.mark.parametrize("shear", [2, 3, 5])
@pytest.mark.parametrize("height", [0.1, 0.31, 0.7])
def test_squares_are_not_flipped_back_and_forth(shear, height):
    """Sheared rectangles come to stand upright in `shear` rounds; which diagonal they have then is left at that."""
    domain = tiny_domains.small_torus(3, 3, (0.7, 0.0), (shear * 0.7, height))
    assert len(Flips(domain).history) // 3 == 9 * shear


def test_both_ways_agree(domain, request):
    """On the Laplacian, which does not depend on diagonals between four vertices on a circle, and the boundary."""
    theirs = intrinsic_delaunay(domain)
    request.getfixturevalue("without_libigl")
    ours = intrinsic_delaunay(domain)
    scale = np.abs(theirs.domain.laplacian).max()
    assert_allclose(ours.domain.laplacian.toarray(), theirs.domain.laplacian.toarray(), rtol=0, atol=1e-7 * scale)
    rim = domain.boundary_edges
    assert_array_equal(ours.domain.edges[ours.edges[rim]], theirs.domain.edges[theirs.edges[rim]])
    assert (ours.flips is None) == (theirs.flips is None)


def test_needles_that_rounding_makes_flat_are_reported():
    """Ten million times as long as they are wide: some survive, for others the error names the vertices."""
    reported = 0
    for seed in range(60):
        try:
            domain = Domain.from_positions(*stretched(1e7, 60, seed))
        except MeshError:
            continue
        try:
            assert len(Flips(domain).domain().faces) == len(domain.faces)
        except MeshError as error:
            assert "so thin that rounding makes them flat" in str(error) and "solve without" in str(error)
            assert len(error.vertices) == 3 and set(error.vertices) <= set(range(60))
            reported += 1
    assert reported > 0


def cone() -> Domain:
    """One triangle, two of whose sides are glued: a cone whose rim is one edge from a vertex to itself."""
    return Domain.from_edge_lengths([[0, 1, 1]], [[1.0, 1.3, 1.3]], face_edges=[[0, 1, 1]])


def test_a_face_may_lie_on_both_sides_of_an_edge():
    domain = cone()
    assert (domain.euler_characteristic, len(domain.boundary_loops), domain.genus) == (1, 1, 0)
    assert intrinsic_delaunay(domain).domain is domain
    assert_array_equal(domain.boundary_loop_edges, [[0]])
    weight = 1 / np.tan(np.arccos(0.5 / 1.3))  # both angles opposite the glued side are at the base
    assert_allclose(domain.cotan_weights[1], weight, rtol=1e-12, atol=0)
    assert_allclose(domain.laplacian.toarray(), weight * np.array([[1, -1], [-1, 1]]), rtol=1e-12, atol=0)


def test_the_conjugate_of_a_cone_has_no_load():
    """Its two half-edges carry opposite products, which cancel."""
    N = np.array([[0.0, 0.0, 1.0], [0.6, 0.0, 0.8]])
    assert_allclose(averaging._galerkin_load(cone(), N), 0, rtol=0, atol=1e-15)
