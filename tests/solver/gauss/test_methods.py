"""The minimisers: the same call, the same map, and a status."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from solver import Conditions, Domain, HarmonicSolver, Status, conditions, shapes
from solver.domain.sites import SITES, SiteGraph
from solver.gauss.energies import ENERGIES
from solver.gauss.gauss_seidel import colouring
from solver.gauss.initial_map import harmonic_start
from solver.gauss.methods import METHODS

TAME = [(sites, name) for name, energy in ENERGIES.items() for sites in energy.sites]


def tame(n=150):
    shape = shapes.disc(n)
    return shape.domain, conditions.binormal(shape.domain, shape.positions, shape.domain.boundary_edges, 0.3)


@pytest.mark.parametrize("method", [name for name in METHODS if name != "newton"])
@pytest.mark.parametrize(("sites", "energy"), TAME)
def test_all_methods_agree(sites, energy, method):
    domain, condition = tame()
    solver = HarmonicSolver(domain, sites=sites, energy=energy)
    reference = solver.solve(condition, tolerance=1e-11)
    other = solver.solve(condition, method=method, tolerance=1e-8)
    assert reference.status is other.status is Status.CONVERGED
    assert other.iterations > 0 and other.residual <= 1e-8
    assert_allclose(other.normals, reference.normals, rtol=0, atol=1e-6)
    assert_allclose(other.energy, reference.energy, rtol=1e-10, atol=0)


@pytest.mark.parametrize("method", METHODS)
def test_every_method_can_be_cancelled_and_limited(method):
    domain, condition = tame()
    calls = []

    def progress(iteration, residual):
        calls.append((iteration, residual))
        return iteration < 2

    cancelled = HarmonicSolver(domain).solve(condition, method=method, progress=progress)
    assert cancelled.status is Status.CANCELLED and cancelled.iterations == 2
    assert [iteration for iteration, _ in calls] == [0, 1, 2]
    limited = HarmonicSolver(domain).solve(condition, method=method, max_iterations=1)
    assert limited.status is Status.ITERATION_LIMIT and limited.iterations == 1


@pytest.mark.parametrize("method", ["newton", "flow", "gauss_seidel"])
@pytest.mark.parametrize(("sites", "energy"), [("vertices", "cotan"), ("faces", "mobius")])
def test_descents_descend(sites, energy, method):
    domain, condition = tame()
    result = HarmonicSolver(domain, sites=sites, energy=energy).solve(condition, method=method, max_iterations=40)
    energies = [line.energy for line in result.history]
    assert (np.diff(energies) <= 1e-12).all() and energies[0] > energies[-1] + 1e-3


def test_the_reference_finds_saddles_where_the_others_leave():
    """N_z = 0 is critical for outward normals on a disc, but no minimum; Newton's method on 4 S equations stays."""
    shape = shapes.disc(300)
    condition = conditions.binormal(shape.domain, shape.positions, shape.domain.boundary_edges)
    flat = np.column_stack([shape.positions[:, :2] + [0.013, 0.007], np.zeros(len(shape.positions))])
    solver = HarmonicSolver(shape.domain)
    saddle = solver.solve(condition, initial=flat, method="lagrange", tolerance=1e-9)
    assert np.abs(saddle.normals[:, 2]).max() < 1e-9
    dome = solver.solve(condition, tolerance=1e-9)
    assert saddle.energy > dome.energy + 1


@pytest.mark.parametrize("sites", SITES)
def test_colours_differ_along_links(sites):
    graph = SiteGraph.of(shapes.torus(1.0, 1.3, 7).domain, sites)
    colours = colouring(graph)
    i, j = graph.links.T
    assert (colours >= 0).all() and (colours[i] != colours[j]).all()
    assert colours.max() < 10


def test_nothing_fixed_needs_a_start_and_then_converges():
    """On a closed surface the identity of the sphere is harmonic (degree one), of energy 4π."""
    sphere = shapes.sphere(800)
    result = HarmonicSolver(sphere.domain).solve(Conditions(), initial=sphere.positions, tolerance=1e-5)
    assert result.status is Status.CONVERGED
    assert_allclose([result.degree, result.energy], [1, 4 * np.pi], rtol=0.01, atol=0)


@pytest.mark.parametrize(("sites", "energy"), [pair for pair in TAME if pair[0] != "vertices"])
def test_gauss_seidel_turns_the_halves_of_squares_as_one(sites, energy):
    """Tied by weights of 10⁴, they would take 10⁵ sweeps one by one."""
    x, y = (grid.ravel() for grid in np.meshgrid(np.arange(6.0), np.arange(5.0), indexing="ij"))
    corner = (5 * np.arange(5)[:, None] + np.arange(4)).ravel()
    faces = np.concatenate([corner[:, None] + [0, 5, 6], corner[:, None] + [0, 6, 1]])
    points = np.column_stack([x, y, np.zeros(30)])
    domain = Domain.from_positions(points, faces)
    condition = conditions.binormal(domain, points, domain.boundary_edges, 0.4)
    solver = HarmonicSolver(domain, sites=sites, energy=energy)
    reference = solver.solve(condition, tolerance=1e-9)
    result = solver.solve(condition, method="gauss_seidel", tolerance=1e-5, max_iterations=100)
    assert result.status is Status.CONVERGED
    assert_allclose(result.normals, reference.normals, rtol=0, atol=1e-6)


@pytest.mark.parametrize(("tolerance", "limit", "status", "most"), [
    (1e-6, 5000, Status.CONVERGED, 1000),
    (1e-6, 350, Status.ITERATION_LIMIT, 300),  # it would take about 600 sweeps
    (1e-15, 5000, Status.STALLED, 2500),  # rounding comes first
])  # fmt: skip
def test_sweeps_end_where_their_pace_does_not_reach_the_tolerance(tolerance, limit, status, most):
    disc = shapes.disc(600)
    condition = conditions.binormal(disc.domain, disc.positions, disc.domain.boundary_edges, 0.3)
    solver = HarmonicSolver(disc.domain)
    swept = solver.solve(condition, method="gauss_seidel", tolerance=tolerance, max_iterations=limit)
    assert swept.status is status
    assert (limit if status is Status.ITERATION_LIMIT else 0) - 100 < swept.iterations <= most


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("sites", SITES)
def test_units_do_not_matter_to_any_method(sites, method):
    """Nor where nothing is fixed, and an area has to be added to the Laplacian."""
    result = []
    for size in (1.0, 1000.0):
        shape = shapes.sphere(40)
        domain = Domain.from_positions(size * shape.positions, shape.domain.faces)
        solver = HarmonicSolver(domain, sites=sites)
        start = np.random.default_rng(0).normal(size=(solver.graph.count, 3)) + [0.0, 0.0, 4.0]
        result.append(solver.solve(Conditions(), start, method=method, max_iterations=8))
    assert result[0].iterations == result[1].iterations
    assert_allclose(result[0].normals, result[1].normals, rtol=0, atol=1e-6)


def test_the_reference_halves_steps_that_would_raise_the_residual():
    shape = shapes.disc(150)
    twice = conditions.twisted(shape.domain, shape.positions, shape.domain.boundary_edges, 2)
    solver = HarmonicSolver(shape.domain)
    fixed, data = twice.resolve()
    far = harmonic_start(solver.dirichlet(fixed), data, twice.up, +1)
    found = solver.solve(twice, far, method="lagrange", tolerance=1e-9)
    steps, residuals = ([getattr(line, name) for line in found.history] for name in ("step", "residual"))
    assert found.status is Status.CONVERGED
    assert 0.0 < steps[0] < 0.5 and steps[-2] == 1.0, "far away a part of the step, near the map all of it"
    assert np.log2(steps[0]) == round(np.log2(steps[0]))
    assert (np.diff(residuals) < 0.0).all()
