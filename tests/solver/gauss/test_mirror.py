"""Minimisation with mirrors: derivatives within them, the same map as on the doubled graph."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from solver import Domain, HarmonicSolver, Status, conditions, shapes, solve_cmc
from solver.domain.sites import SITES
from solver.gauss import sphere
from solver.gauss.admissible import resolved
from solver.gauss.dirichlet import Dirichlet
from solver.gauss.energies import ENERGIES
from solver.gauss.methods import METHODS
from solver.gauss.newton import newton
from solver.gauss.problem import EnergyProblem
from tests.solver.mirror_images import doubled, doubled_graph, half_disc, jittered_strip, reflect
from tests.solver.mirror_sides import E_X, E_Y, E_Z, mirrors, quad_grid

SITES_AND_ENERGIES = [(sites, name) for name, energy in ENERGIES.items() for sites in energy.sites]


def half_dome(domain, points, arc, flat, tilt=0.2):
    plan = np.column_stack([points, np.zeros(len(points))])
    return conditions.binormal(domain, plan, arc, tilt=tilt) + conditions.mirror(domain, flat, -E_Y)


@pytest.mark.parametrize(("sites", "name"), SITES_AND_ENERGIES)
def test_gradient_and_hessian_against_finite_differences(sites, name):
    """E along exp_N in a direction that the mirrors allow: <PG, d> and <d, Hd>."""
    domain, points, arc, flat = half_disc(200)
    solver = HarmonicSolver(domain, sites=sites, energy=name)
    held = resolved(half_dome(domain, points, arc, flat), solver.graph)
    problem = EnergyProblem(solver.graph, solver.energy, solver.dirichlet(held.fixed), mirrors=held.mirrors)
    random = np.random.default_rng(5)
    N = held.pin(sphere.normalize(0.3 * random.normal(size=(solver.graph.count, 3)) + [0.2, 0.1, 1.0]))
    d = problem.project(N, random.normal(size=N.shape))
    assert len(held.mirrors.sites) > 5
    assert_allclose(N[held.mirrors.sites] @ E_Y, 0, rtol=0, atol=1e-15)
    assert_allclose(d[held.mirrors.sites] @ E_Y, 0, rtol=0, atol=1e-15)
    assert_allclose(sphere.dot(N, d), 0, rtol=0, atol=1e-14)
    here = problem.at(N)
    h = 1e-4
    there, back = (problem.at(sphere.exp(N, t * d)) for t in (h, -h))
    assert_allclose((there.energy - back.energy) / (2 * h), sphere.inner(here.tangent, d), rtol=1e-6, atol=0)
    curvature = (there.energy - 2 * here.energy + back.energy) / h**2
    assert_allclose(curvature, sphere.inner(d, problem.hessian(here)(d)), rtol=1e-5, atol=0)


@pytest.mark.parametrize(("sites", "name"), SITES_AND_ENERGIES)
def test_minimisation_is_that_on_the_doubled_graph(sites, name):
    """The graph and its image, glued at the sites on the mirror, all of them free there; from a start that has lost
    the symmetry."""
    domain, points, arc, flat = half_disc(130)
    solver = HarmonicSolver(domain, sites=sites, energy=name)
    condition = half_dome(domain, points, arc, flat)
    result = solver.solve(condition, tolerance=1e-10)
    held = result.admissible
    whole, image = doubled_graph(solver.graph, held.mirrors.sites)
    start = np.empty((whole.count, 3))
    start[image] = reflect(result.normals, E_Y)
    start[: solver.graph.count] = result.normals
    fixed = np.union1d(held.fixed, image[held.fixed])
    noise = 0.05 * np.random.default_rng(1).normal(size=start.shape)
    noise[fixed] = 0.0
    weights = np.abs(solver.energy.star(np.ones(len(whole.links)), whole))
    problem = EnergyProblem(whole, solver.energy, Dirichlet(whole, weights, fixed))
    twice = newton(problem, sphere.normalize(start + noise), tolerance=1e-10)
    assert twice.status is Status.CONVERGED
    assert_allclose(twice.N, start, rtol=0, atol=1e-7)
    assert_allclose(twice.history[-1].energy, 2 * result.energy, rtol=1e-12, atol=0)


def test_a_half_is_half_of_the_whole_disc():
    """With outward conormals: a tilted normal at the end of the mirror blends a little differently."""
    domain, points, arc, flat = half_disc(700)
    disc = shapes.disc(700)
    half = HarmonicSolver(domain).solve(half_dome(domain, points, arc, flat, tilt=0.0), tolerance=1e-10)
    rim = conditions.binormal(disc.domain, disc.positions, disc.domain.boundary_edges)
    whole = HarmonicSolver(disc.domain).solve(rim, tolerance=1e-10)
    places = {tuple(p): i for i, p in enumerate(np.round(disc.positions, 9))}
    same = [places[tuple(p)] for p in np.round(points, 9)]
    assert_allclose(half.normals, whole.normals[same], rtol=0, atol=1e-7)
    assert_allclose(half.energy, 0.5 * whole.energy, rtol=1e-10, atol=0)


@pytest.mark.parametrize("tilt", [0.3, -0.6])
def test_a_quarter_is_a_quarter_of_the_whole_plan(tilt):
    """Two mirrors that meet at the centre; with rims that lean out, too, where the way along them is the longer one."""
    shape, points = jittered_strip(2.0, 1.4, 9)
    right_top = np.concatenate([shape.sides["right"], shape.sides["top"]])
    quarter = conditions.binormal(shape.domain, points, right_top, tilt=tilt) + mirrors(shape, left=-E_X, bottom=-E_Y)
    result = HarmonicSolver(shape.domain).solve(quarter, tolerance=1e-10)
    assert_array_equal(result.admissible.corners, [0])
    assert_allclose(result.admissible.corner_normals, [E_Z], rtol=0, atol=1e-15)
    vertices, faces = doubled(*doubled(points, shape.domain.faces, 0), 1)
    plan = Domain.from_positions(vertices, faces)
    rim = conditions.binormal(plan, vertices, plan.boundary_edges, tilt=tilt)
    whole = HarmonicSolver(plan).solve(rim, tolerance=1e-10)
    assert_allclose(result.normals, whole.normals[: len(points)], rtol=0, atol=1e-7)
    assert_allclose(4 * result.energy, whole.energy, rtol=1e-10, atol=0)


@pytest.mark.parametrize("sites", SITES)
@pytest.mark.parametrize("method", METHODS)
def test_every_method_finds_the_same(sites, method):
    domain, points, arc, flat = half_disc(60)
    solver = HarmonicSolver(domain, sites=sites, energy="cotan" if sites == "vertices" else "mobius")
    condition = half_dome(domain, points, arc, flat)
    expected = solver.solve(condition, tolerance=1e-9)
    result = solver.solve(condition, method=method, tolerance=1e-7)
    assert result.status is Status.CONVERGED
    assert_allclose(result.normals, expected.normals, rtol=0, atol=1e-6)
    at = result.admissible.mirrors.sites
    assert_allclose(result.normals[at] @ E_Y, 0, rtol=0, atol=1e-14)


def grid_dome(points, domain, tilt=0.4):
    """Mirrors along x = 0 and y = 0, a leaning rim elsewhere."""
    middle = points[domain.edges[domain.boundary_edges]].mean(axis=1)
    left, bottom = (domain.boundary_edges[middle[:, k] == 0] for k in (0, 1))
    plan = np.column_stack([points, np.zeros(len(points))])
    outer = domain.boundary_edges[(middle > 0).all(axis=1)]
    sides = conditions.mirror(domain, left, -E_X) + conditions.mirror(domain, bottom, -E_Y)
    return conditions.binormal(domain, plan, outer, tilt=tilt) + sides


@pytest.mark.parametrize("sites", ["faces", "faces_and_rim"])
def test_gauss_seidel_turns_the_halves_of_rectangles_within_their_mirrors(sites):
    points, domain = quad_grid(5, [[0, 1, 2], [0, 2, 3]])
    solver = HarmonicSolver(domain, sites=sites, energy="mobius")
    condition = grid_dome(points, domain)
    slow = solver.solve(condition, method="gauss_seidel", tolerance=1e-5, max_iterations=300)
    fast = solver.solve(condition, tolerance=1e-5)
    assert slow.status is Status.CONVERGED
    assert_allclose(slow.normals, fast.normals, rtol=0, atol=1e-4)
    at, planes = slow.admissible.mirrors.sites, slow.admissible.mirrors.normals
    assert_allclose(sphere.dot(slow.normals[at], planes), 0, rtol=0, atol=1e-14)


@pytest.mark.parametrize("sites", ["faces", "faces_and_rim"])
def test_ears_between_two_mirrors_lie_in_both(sites):
    """A face whose tip is the corner; the halves of squares share a normal, so all of a square does there."""
    points, domain = quad_grid(5, [[0, 1, 3], [1, 2, 3]])
    surface = solve_cmc(domain, grid_dome(points, domain), sites=sites, energy="mobius", tolerance=1e-8)
    assert surface.status is Status.CONVERGED
    if sites == "faces":
        ear = int(np.flatnonzero((domain.faces == 0).any(axis=1))[0])
        assert_array_equal(surface.harmonic.admissible.corners, [ear])
        assert_allclose(surface.harmonic.normals[ear], E_Z, rtol=0, atol=0)
    for axis, normal in ((0, E_X), (1, E_Y)):
        on = points[:, axis] == 0
        assert_allclose(np.ptp(surface.f_plus[on] @ normal), 0, rtol=0, atol=1e-7)
        assert_allclose(surface.normals[on] @ normal, 0, rtol=0, atol=1e-13)


@pytest.mark.parametrize("sites", SITES)
def test_a_rotation_of_space_rotates_the_map(sites):
    """Mirrors alone: honeycomb module; planes and signs turn with it."""
    shape, _ = jittered_strip(2.0, 1.0, 9)
    turn = np.linalg.qr(np.random.default_rng(2).normal(size=(3, 3)))[0]
    turn *= np.sign(np.linalg.det(turn))
    bisector = np.array([-np.sin(np.pi / 3), np.cos(np.pi / 3), 0.0])
    planes = {"bottom": -E_Y, "right": E_X, "top": -E_Z, "left": bisector}
    solver = HarmonicSolver(shape.domain, sites=sites)
    one = solver.solve(mirrors(shape, **planes), tolerance=1e-9)
    other = solver.solve(mirrors(shape, **{side: turn @ n for side, n in planes.items()}), tolerance=1e-9)
    assert_allclose(other.normals, one.normals @ turn.T, rtol=0, atol=1e-7)
    assert_allclose(other.energy, one.energy, rtol=1e-12, atol=0)
