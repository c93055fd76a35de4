"""The energy as a problem on spheres: derivatives, line search, degree, exponential map."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from scipy.optimize import brentq

from solver import HarmonicSolver, shapes
from solver.gauss import sphere
from solver.gauss.admissible import resolved
from solver.gauss.energies import ENERGIES
from solver.gauss.newton import line_search, longest
from solver.gauss.problem import EnergyProblem
from tests.solver.exact_surfaces import disc
from tests.solver.rim_conditions import rim

KINDS_AND_ENERGIES = [(sites, name) for name, energy in ENERGIES.items() for sites in energy.sites]


@pytest.mark.parametrize(("sites", "name"), KINDS_AND_ENERGIES)
def test_gradient_and_hessian_against_finite_differences(sites, name):
    """E along exp_N: its first derivative is <PG, d>, its second <d, Hd>."""
    domain, points = disc(200)
    solver = HarmonicSolver(domain, sites=sites, energy=name)
    held = resolved(rim(domain, points, 0.2), solver.graph)
    fixed, data = held.fixed, held.data
    problem = EnergyProblem(solver.graph, solver.energy, solver.dirichlet(fixed))
    random = np.random.default_rng(5)
    spread = 0.3 * random.normal(size=(solver.graph.count, 3)) + [0.2, 0.1, 1.0]
    N = sphere.normalize(spread)
    N[fixed] = data
    d = problem.project(N, random.normal(size=N.shape))
    assert (d[fixed] == 0).all()
    here = problem.at(N)

    def energy(t):
        return problem.at(sphere.exp(N, t * d)).energy

    h = 1e-4
    slope = (energy(h) - energy(-h)) / (2 * h)
    curvature = (energy(h) - 2 * energy(0) + energy(-h)) / h**2
    assert_allclose(slope, sphere.inner(here.gradient, d), rtol=1e-6, atol=0)
    assert_allclose(curvature, sphere.inner(d, problem.hessian(here)(d)), rtol=1e-5, atol=0)
    there = problem.at(sphere.exp(N, 1e-3 * d))
    assert_allclose(problem.change(here, there), there.energy - here.energy, rtol=1e-6, atol=0)


@pytest.mark.parametrize(("sites", "name"), KINDS_AND_ENERGIES)
def test_the_sum_of_edge_energies_is_the_energy_reported(sites, name):
    shape = shapes.disc(400)
    domain, points = shape.domain, shape.positions
    solver = HarmonicSolver(domain, sites=sites, energy=name)
    result = solver.solve(rim(domain, points, 0.3))
    i, j = solver.graph.links.T
    c = np.einsum("ij,ij->i", result.normals[i], result.normals[j])
    assert_allclose(ENERGIES[name].value(c, solver.graph).sum(), result.energy, rtol=1e-10, atol=0)


def test_degree_counts_how_often_the_sphere_is_covered():
    shape = shapes.sphere(500)
    assert_allclose(sphere.degree(shape.positions, shape.domain.faces), 1, rtol=0, atol=1e-12)
    flipped = shape.positions * [1, 1, -1]
    assert_allclose(sphere.degree(flipped, shape.domain.faces), -1, rtol=0, atol=1e-12)


def test_exp_stays_on_the_sphere_and_keeps_lengths():
    random = np.random.default_rng(2)
    N = sphere.normalize(random.normal(size=(50, 3)))
    d = 0.4 * sphere.project(N, random.normal(size=(50, 3)))
    moved = sphere.exp(N, d)
    assert_allclose(np.linalg.norm(moved, axis=1), 1, rtol=0, atol=1e-14)
    arcs = np.arccos(np.clip(np.sum(N * moved, axis=1), -1, 1))
    assert_allclose(arcs, np.linalg.norm(d, axis=1), rtol=1e-6, atol=1e-8)
    assert_array_equal(sphere.exp(N, 0 * d), sphere.normalize(N))


def test_a_step_that_does_not_lower_the_energy_is_halved():
    """Armijo's rule: a full step to the far side of the valley, at equal height, is not taken."""
    domain, points = disc(300)
    condition = rim(domain, points, 0.3)
    solver = HarmonicSolver(domain)
    admissible = resolved(condition, solver.graph)
    problem = EnergyProblem(solver.graph, solver.energy, solver.dirichlet(admissible.fixed))
    tilted = np.random.default_rng(5).uniform(-0.05, 0.05, points.shape[:1] + (3,))
    point = problem.at(admissible.pin(sphere.normalize(solver.solve(condition).normals + tilted)))
    downhill = -problem.project(point.N, problem.dirichlet.precondition(point.tangent))

    def change(length):
        return problem.change(point, problem.at(sphere.exp(point.N, length * downhill)))

    across = brentq(change, 0.5, 4.0)
    slope = across * sphere.inner(point.tangent, downhill)
    assert longest(across * downhill) < 0.5 and abs(change(across)) < 1e-6 * abs(slope)
    step = line_search(problem, point, across * downhill, 0)
    assert step.length == 0.5
    assert problem.change(point, step.point) < 0.2 * slope
