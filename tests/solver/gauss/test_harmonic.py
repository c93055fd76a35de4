"""Harmonic maps to the sphere: exact ones, sides, degrees, natural conditions."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from solver import ConditionError, HarmonicSolver, Status, conditions, shapes
from solver.gauss import sphere
from solver.gauss.initial_map import wound_start
from tests.solver.exact_surfaces import Nodoid, cylinder, disc, hemisphere, rates
from tests.solver.rim_conditions import rim

L_PLAN = [(0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2)]
PLANS = {
    "square": ([(0, 0), (1, 0), (1, 1), (0, 1)], [], 0.2),
    "L": (L_PLAN, [], 0.3),
    "rounded rectangle": ([(0, 0), (3, 0), (3, 2), (0, 2)], [], 0.5),
    "canopy": ([(0, 0), (8, 0), (8, 1), (0, 1)], [], 0.2),
    "courtyard": ([(0, 0), (3, 0), (3, 3), (0, 3)], [[(1, 1), (2, 1), (2, 2), (1, 2)]], 0.3),
}


def outward(shape, tilt=0.0):
    return conditions.binormal(shape.domain, shape.positions, shape.domain.boundary_edges, tilt=tilt)


def inside(domain):
    return np.setdiff1d(np.arange(domain.vertex_count), domain.boundary_vertices)


@pytest.mark.parametrize("side", [1, -1])
def test_conormals_of_the_disc_give_the_hemisphere(side):
    """Flat data: the solver must leave their plane, to the given side. E = 2π, degree ±½."""
    errors = []
    for n in (500, 2000, 8000):
        domain, points = disc(n)
        result = HarmonicSolver(domain).solve(rim(domain, points), side=side)
        assert result.status is Status.CONVERGED and result.residual <= 1e-6
        assert_allclose(result.degree, side / 2, rtol=0, atol=1e-3)
        errors.append(np.abs(result.normals - hemisphere(points) * [1, 1, side]).max())
    assert_allclose(result.energy, 2 * np.pi, rtol=1e-3, atol=0)
    assert rates(errors).min() > 1.7


def test_the_two_sides_are_mirror_images():
    domain, points = disc(1500)
    solver = HarmonicSolver(domain)
    up, down = (solver.solve(rim(domain, points), side=side, tolerance=1e-11).normals for side in (1, -1))
    assert_allclose(down, up * [1, 1, -1], rtol=0, atol=1e-9)


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("with_positions", [True, False])
def test_up_is_the_plans_own_normal_however_it_lies_in_space(seed, with_positions):
    domain, points = disc(300)
    turn = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))[0]
    turn *= np.sign(np.linalg.det(turn))
    positions = np.column_stack([points, 0 * points[:, 0]]) @ turn.T
    condition = conditions.binormal(domain, positions, domain.boundary_edges, against="surface")
    if not with_positions:
        condition = conditions.fixed_at(domain, condition.vertices, condition.vertex_normals)
    result = HarmonicSolver(domain).solve(condition)
    assert (result.normals @ turn[:, 2])[inside(domain)].min() > 0


@pytest.mark.parametrize("name", PLANS)
def test_flat_plans_bulge_upwards_and_their_energies_settle(name):
    outline, holes, radius = PLANS[name]
    width = min(np.ptp(np.array(outline, dtype=float), axis=0))
    energies = []
    for divisions in (25, 50):
        shape = shapes.polygon(outline, holes, max_edge=width / divisions, corner_radius=radius)
        result = HarmonicSolver(shape.domain).solve(outward(shape))
        assert result.status is Status.CONVERGED
        assert result.normals[inside(shape.domain), 2].min() > 0
        energies.append(result.energy)
    assert_allclose(energies[0], energies[1], rtol=0.02, atol=0)


def test_the_side_is_known_without_positions():
    """Data given as bare vectors: the winding of the normals along the loop orients the plane they lie in."""
    domain, points = disc(800)
    loop = domain.boundary_loops[0]
    radii = np.column_stack([points[loop], np.zeros(len(loop))])
    result = HarmonicSolver(domain).solve(conditions.fixed_at(domain, loop, radii))
    assert result.normals[inside(domain), 2].min() > 0


@pytest.mark.parametrize("tilt", [-30, -10, 10, 30])
def test_caps_of_every_tilt_stay_on_the_upper_side(tilt):
    """Conformal caps, E = 2π (1 - sin tilt), continuous through 0: a rim that leans out is more than a hemisphere."""
    domain, points = disc(4000)
    result = HarmonicSolver(domain).solve(rim(domain, points, np.radians(tilt)))
    assert result.status is Status.CONVERGED
    assert_allclose(result.energy, 2 * np.pi * (1 - np.sin(np.radians(tilt))), rtol=3e-3, atol=0)
    assert result.normals[np.argmin(np.linalg.norm(points, axis=1)), 2] > 0.9


def test_energy_of_the_first_twisted_disc():
    shape = shapes.disc(12500)
    edges = shape.domain.boundary_edges
    result = HarmonicSolver(shape.domain).solve(conditions.twisted(shape.domain, shape.positions, edges, 1))
    assert_allclose(result.energy, 4.1246, rtol=0, atol=5e-4)


def test_a_saddle_is_left():
    """Twisted twice, a symmetric start runs into a critical map that is no minimiser (E = 12.80)."""
    domain, points = disc(8000, jitter=0.02)
    result = HarmonicSolver(domain).solve(conditions.twisted(domain, points, domain.boundary_edges, 2))
    assert result.status is Status.CONVERGED and result.iterations < 30
    assert result.energy < 12.78


@pytest.mark.parametrize("degree", [1, -1])
def test_a_wound_start_finds_the_nodoid(degree):
    exact = Nodoid(0.5)
    errors = []
    for columns in (32, 64):
        domain, _ = cylinder(exact.height, columns)
        result = HarmonicSolver(domain).solve(ends(domain), degree=degree)
        assert result.status is Status.CONVERGED
        assert_allclose(result.degree, degree, rtol=0, atol=1e-9)
        errors.append(abs(result.energy - exact.energy))
    assert errors[1] / exact.energy < 4e-3
    assert rates(errors).min() > 1.6


def test_without_a_degree_the_cylinder_does_not_wind():
    domain, _ = cylinder(Nodoid(0.5).height, 96)
    result = HarmonicSolver(domain).solve(ends(domain))
    assert_allclose(result.degree, 0, rtol=0, atol=1e-9)
    assert_allclose(result.energy, 9.351, rtol=2e-3, atol=0)


def test_a_degree_turns_the_small_cap_into_the_large_one():
    domain, points = disc(3000)
    condition = rim(domain, points, np.radians(20))
    solver = HarmonicSolver(domain)
    small = solver.solve(condition)
    large = solver.solve(condition, degree=small.degree - 1)
    assert large.status is Status.CONVERGED
    assert_allclose(small.degree - large.degree, 1, rtol=0, atol=1e-9)
    assert_allclose(large.energy, 2 * np.pi * (1 + np.sin(np.radians(20))), rtol=5e-3, atol=0)


def test_a_degree_without_a_start_is_refused():
    shape = shapes.polygon(*PLANS["courtyard"][:2], max_edge=0.2, corner_radius=0.3)
    with pytest.raises(ConditionError, match="degree 3"):
        HarmonicSolver(shape.domain).solve(outward(shape), degree=3)


def ends(domain):
    first, second = domain.boundary_loops
    return conditions.fixed_at(domain, first, [1, 0, 0]) + conditions.fixed_at(domain, second, [-1, 0, 0])


def test_free_sides_take_the_natural_condition():
    """A strip between two constant normals 60° apart, its long sides free: the geodesic, uniform across."""
    shape = shapes.strip(2.0, 1.0, 24)
    b = np.array([np.cos(np.pi / 3), 0, np.sin(np.pi / 3)])
    condition = conditions.fixed(shape.domain, shape.sides["left"], [1, 0, 0]) + conditions.fixed(
        shape.domain, shape.sides["right"], b
    )
    result = HarmonicSolver(shape.domain).solve(condition)
    angle = np.pi / 3 * shape.positions[:, 0] / 2.0
    expected = np.column_stack([np.cos(angle), 0 * angle, np.sin(angle)])
    assert_allclose(result.normals, expected, rtol=0, atol=1e-3)
    assert_allclose(result.energy, 0.5 * (np.pi / 3) ** 2 / 2.0, rtol=1e-3, atol=0)


def test_normals_are_units_and_the_boundary_is_as_prescribed():
    domain, points = disc(800)
    condition = rim(domain, points, 0.3)
    result = HarmonicSolver(domain).solve(condition)
    sites, data = condition.resolve()
    assert_array_equal(result.normals[sites], data)
    assert_allclose(np.linalg.norm(result.normals, axis=1), 1, rtol=0, atol=1e-14)


def test_the_residual_is_the_one_of_the_returned_map():
    domain, points = disc(800)
    result = HarmonicSolver(domain).solve(rim(domain, points, 0.3))
    G = domain.laplacian @ result.normals
    tangent = sphere.project(result.normals, G)[inside(domain)]
    areas = domain.vertex_areas[inside(domain)]
    expected = np.sqrt(domain.area * np.sum(np.sum(tangent**2, axis=1) / areas))
    assert_allclose(result.residual, expected, rtol=1e-3, atol=1e-12)
    assert_allclose(result.energy, 0.5 * np.sum(result.normals * G), rtol=1e-12, atol=0)
    energies = [line.energy for line in result.history]
    assert (np.diff(energies) <= 1e-12).all() and len(energies) == result.iterations + 1


@pytest.mark.parametrize("factor", [1e-3, 1e3])
def test_units_do_not_matter(factor):
    shape = shapes.polygon(L_PLAN, max_edge=0.1, corner_radius=0.2)
    scaled = shapes.polygon(factor * np.array(L_PLAN), max_edge=0.1 * factor, corner_radius=0.2 * factor)
    one = HarmonicSolver(shape.domain).solve(outward(shape))
    other = HarmonicSolver(scaled.domain).solve(outward(scaled))
    assert one.iterations == other.iterations
    assert_allclose(other.energy, one.energy, rtol=1e-6, atol=0)


def test_a_bubble_is_grafted_where_normals_point_to_all_sides():
    """There is no pole to go over then: on the flat map of a circle's outward normals, whose middle leans to one side
    as much as the vertices around it to the other."""
    shape = shapes.disc(600)
    x, y = shape.positions[:, :2].T
    centre, *around = np.argsort(np.hypot(x, y))[:7].tolist()
    areas = shape.domain.vertex_areas
    down = -areas[centre] / areas[around].sum()
    flat = np.column_stack([x, y, np.zeros_like(x)])
    flat[centre] = [0.0, 0.0, 1.0]
    flat /= np.linalg.norm(flat, axis=1)[:, None]
    flat[around] = flat[around] * np.sqrt(1.0 - down**2) + [0.0, 0.0, down]
    assert np.linalg.norm(areas @ flat) < 1e-9 * areas.sum()
    dirichlet = HarmonicSolver(shape.domain).dirichlet(shape.domain.boundary_vertices)
    degree = sphere.degree(flat, shape.domain.faces)
    wound = wound_start(dirichlet, flat, degree + 1.0)
    assert_allclose(sphere.degree(wound, shape.domain.faces), degree + 1.0, rtol=0, atol=1e-9)
    assert_allclose(wound[dirichlet.fixed], flat[dirichlet.fixed], rtol=0, atol=0)
