"""A moved solver, for the same faces with other edge lengths: the results of a new one, with reused factors."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.sparse as sp
from numpy.testing import assert_allclose

from solver import CmcSolver, Domain, conditions, shapes
from solver.linalg import Patience, ReusedFactor, factorize

SITES = [("vertices", "cotan"), ("faces", "mobius"), ("faces_and_rim", "mobius")]


def lifted(shape) -> np.ndarray:
    return np.column_stack([shape.positions, np.zeros(len(shape.positions))])


def lengths_of(domain: Domain, points: np.ndarray) -> np.ndarray:
    return np.linalg.norm(points[domain.edges[:, 1]] - points[domain.edges[:, 0]], axis=1)


def bumped(points: np.ndarray, amount: float) -> np.ndarray:
    """Points moved sideways around one of them, as with proportional editing."""
    weight = np.exp(-np.sum((points - [0.5, 0.1, 0.0]) ** 2, axis=1) / 0.05)
    return points + amount * weight[:, None] * [0.6, 0.8, 0.3]


def solved(solver: CmcSolver, points: np.ndarray, tilt: float = 0.4):
    conds = conditions.binormal(solver.domain, points, solver.domain.boundary_edges, tilt)
    return solver.solve(conds, tolerance=1e-9)


@pytest.mark.parametrize(("sites", "energy"), SITES)
@pytest.mark.parametrize("delaunay", [False, True])
def test_a_moved_solver_gives_what_a_new_one_gives(sites, energy, delaunay):
    shape = shapes.disc(150)
    points = lifted(shape)
    rng = np.random.default_rng(0)
    points[:, :2] += 0.01 * rng.uniform(-1, 1, (len(points), 2))
    choice = {"sites": sites, "energy": energy, "delaunay": delaunay}
    solver = CmcSolver(Domain.from_positions(points, shape.domain.faces), **choice)
    solved(solver, points)
    for amount in (0.02, 0.1):
        there = bumped(points, amount)
        solver = solver.moved(lengths_of(solver.domain, there))
        expected = solved(CmcSolver(Domain.from_positions(there, shape.domain.faces), **choice), there)
        result = solved(solver, there)
        assert result.status is expected.status
        for name in ("f_plus", "f_minus"):
            assert_allclose(getattr(result, name), getattr(expected, name), rtol=0, atol=2e-7)


def test_with_holes_trees_and_cuts_serve_again():
    shape = shapes.annulus(0.4, 1.0, 300)
    points = lifted(shape)
    solver = CmcSolver(shape.domain)
    solved(solver, points)
    there = bumped(points, 0.08)
    moved = solver.moved(lengths_of(shape.domain, there))
    assert moved.conjugation.homology is solver.conjugation.homology
    expected = solved(CmcSolver(Domain.from_positions(there, shape.domain.faces)), there)
    result = solved(moved, there)
    assert expected.is_open and result.is_open
    assert_allclose(result.f_plus, expected.f_plus, rtol=0, atol=2e-7)


def test_topology_is_kept_and_geometry_is_not():
    shape = shapes.disc(200)
    domain = shape.domain
    for name in ("boundary_loops", "twins", "fan_starts", "interior_edges", "corner_cotans", "face_areas", "laplacian"):
        getattr(domain, name)
    twice = domain.with_lengths(2.0 * domain.edge_lengths)
    assert twice.twins is domain.twins and twice.boundary_edges is domain.boundary_edges
    assert_allclose(twice.area, 4.0 * domain.area, rtol=1e-12, atol=0)
    assert_allclose(twice.corner_cotans, domain.corner_cotans, rtol=1e-9, atol=1e-12)


def test_a_factor_serves_until_the_domain_is_another():
    """Little moved: no new factor. Much moved: a new one, at once or the next time."""
    shape = shapes.disc(400)
    points = lifted(shape)
    solver = CmcSolver(shape.domain)
    solved(solver, points)
    (first,) = [one.rough for one in solver.harmonic._factors.values()]
    near = solver.moved(lengths_of(shape.domain, bumped(points, 0.01)))
    solved(near, bumped(points, 0.01))
    assert [one.rough for one in near.harmonic._factors.values()] == [first]
    stretched = points * [3.0, 1.0, 1.0]
    far = near.moved(lengths_of(shape.domain, stretched))
    solved(far, stretched)
    again = far.moved(lengths_of(shape.domain, stretched))
    solved(again, stretched)
    assert all(one.rough is not first for one in again.harmonic._factors.values())


def test_solving_with_the_factor_of_a_nearby_matrix():
    """Exact whatever the factor; where it is of no use the matrix itself is factored."""
    rng = np.random.default_rng(1)
    A = sp.csr_array(sp.diags_array(rng.uniform(1, 2, 50)) + sp.eye_array(50, k=1) * 0.1 + sp.eye_array(50, k=-1) * 0.1)
    b = rng.normal(size=(50, 3))
    near = ReusedFactor(A, factorize(sp.csr_array(A + 0.1 * sp.diags_array(rng.uniform(0, 1, 50)))))
    assert_allclose(A @ near.solve(b), b, rtol=0, atol=1e-9)
    assert near.iterations is not None and 0 < near.iterations < 12
    assert_allclose(near.solve(b[:, 0]), near.solve(b)[:, 0], rtol=0, atol=1e-9)
    assert_allclose(near.solve(np.zeros(50)), 0.0, rtol=0, atol=0)
    scale = sp.diags_array(np.geomspace(1e-6, 1e6, 50))
    useless = factorize(sp.csr_array(scale))
    far = ReusedFactor(A, useless)
    assert_allclose(A @ far.solve(b), b, rtol=0, atol=1e-9)
    assert far.factor is not useless


def test_a_window_gets_the_factor_that_does_not_block(monkeypatch):
    pytest.importorskip("cholespy")
    A = sp.csr_array(2.0 * sp.eye_array(20))
    assert type(factorize(A)).__name__ == "_Cholespy"
    monkeypatch.setattr(Patience, "largest", 20)
    assert type(factorize(A)).__name__ == "_SuperLU"


def test_the_boundary_gives_the_area_of_all_faces():
    from solver.gauss.frames import area_vectors, whole_area

    for shape in (shapes.disc(200), shapes.annulus(0.4, 1.0, 200)):
        points = bumped(lifted(shape), 0.2) @ np.array([[0.8, 0.6, 0.0], [0.0, 0.8, 0.6], [0.6, 0.0, 0.8]])
        expected = area_vectors(points, shape.domain.faces).sum(axis=0)
        assert_allclose(whole_area(shape.domain, points), expected, rtol=0, atol=1e-12)
