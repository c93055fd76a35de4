"""Saddles and their Morse index, two solutions for one boundary (Theorem D.1)."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

from solver import ConditionError, Conditions, HarmonicSolver, MeshError, Status, conditions, shapes
from solver.gauss.modes import flat_axis, index_of, modes_of, problem_of, saddle
from solver.gauss.null_directions import drifts, free_rotations, translations
from solver.gauss.saddles import _turned
from solver.gauss.tangent import TangentSystem

E_X, E_Y, E_Z = np.eye(3)


def outward_disc(n=300):
    disc = shapes.disc(n)
    return disc, conditions.binormal(disc.domain, disc.positions, disc.domain.boundary_edges)


def test_the_flat_map_of_outward_normals_is_a_saddle_between_two_hemispheres():
    """Up along the mode that lifts it to either side."""
    disc, held = outward_disc()
    solver = HarmonicSolver(disc.domain)
    up = solver.solve(held, tolerance=1e-9)
    flat = up.normals * [1, 1, 0] + 0.02 * np.random.default_rng(0).standard_normal(up.normals.shape)
    flat[:, :2] += 1e-3
    result = saddle(solver, held, flat, tolerance=1e-9)
    assert result.status is Status.COLLAPSED and result.residual < 1e-9
    assert_allclose(np.abs(flat_axis(result.normals)), E_Z, rtol=0, atol=1e-6)
    assert result.energy > 1.5 * up.energy and modes_of(solver, held, result.normals).index == 1
    assert modes_of(solver, held, up.normals).index == 0
    down = saddle(solver, held, flat, index=0, tolerance=1e-9)
    assert_allclose(down.energy, up.energy, rtol=1e-10, atol=0)


@pytest.mark.parametrize(("sites", "energy"), [("vertices", "cotan"), ("faces", "mobius")])
def test_the_matrix_is_the_hessian(sites, energy):
    disc, held = outward_disc(60)
    solver = HarmonicSolver(disc.domain, sites, energy)
    problem = problem_of(solver, held)
    point = problem.at(solver.solve(held).normals)
    system = TangentSystem.of(problem, point)
    d = np.random.default_rng(0).standard_normal(len(system.gradient))
    by_hand = problem.hessian(point)(system.in_space(d))
    assert_allclose(system.in_space(system.H @ d), by_hand, rtol=0, atol=1e-10)
    values = np.linalg.eigvals(np.linalg.solve(system.K.toarray(), system.H.toarray())).real
    assert_allclose(system.lowest(3, np.zeros((len(d), 0)))[0], np.sort(values)[:3], rtol=0, atol=1e-7)
    assert system.below(0.4) == (values < 0.4).sum()


def test_eigenvalues_in_clusters_are_found_as_often_as_they_are():
    """Of a symmetric map, whose modes come in pairs of one eigenvalue; the dense solver as the second method."""
    system = rim_that_turns(24)
    gauge, n = np.zeros((len(system.gradient), 0)), len(system.gradient)
    expected = np.sort(np.linalg.eigvals(np.linalg.solve(system.K.toarray(), system.H.toarray())).real)
    pairs = np.diff(expected[:12]) < 1e-9
    assert n > 120 and pairs.sum() >= 3
    for count in (1, 2, 5, 12):
        values, modes = system.lowest(count, gauge)
        assert_allclose(values, expected[:count], rtol=0, atol=1e-9)
        assert_allclose(modes.T @ (system.K @ modes), np.eye(count), rtol=0, atol=1e-7)
    values, modes = system.lowest(3, system.lowest(2, gauge)[1])
    assert_allclose(values, expected[2:5], rtol=0, atol=1e-8)


@pytest.mark.parametrize("most", [100, 0])
def test_a_step_leads_down_but_along_the_lowest_modes(most, monkeypatch):
    """Also where the modes are too many to be looked for, and the H¹ gradient leads the way down."""
    monkeypatch.setattr("solver.gauss.saddles._MANY", most)
    system = rim_that_turns(24, noise=0.3)
    gauge, G = np.zeros((len(system.gradient), 0)), system.gradient
    newton = system.solve(-G, gauge)[0]
    values, modes = system.lowest(4, gauge)
    assert (values[:3] < 0.0).all()
    for index in (0, 1, 2):
        step = _turned(system, gauge, index, newton, is_near=False)
        along = (modes.T @ (system.K @ step)) * (modes.T @ G)
        assert (along[:index] > 0.0).all() and (along[index:3] < 0.0).all()
        assert step @ G - along[:index].sum() < 0.0
        assert not np.array_equal(step, newton)
    assert np.array_equal(_turned(system, gauge, system.count(0.0, gauge), newton, is_near=True), newton)


def rim_that_turns(columns, noise=0.0):
    """A regular polygon of triangles around one vertex, in rings, whose map has the symmetry of the polygon."""
    disc = shapes.disc(columns * columns // 2)
    solver = HarmonicSolver(disc.domain)
    held = conditions.binormal(disc.domain, disc.positions, disc.domain.boundary_edges)
    problem, rng = problem_of(solver, held), np.random.default_rng(3)
    N = solver.solve(held, tolerance=1e-10).normals
    moved = N + noise * rng.standard_normal(N.shape)
    moved /= np.linalg.norm(moved, axis=1)[:, None]
    moved[problem.dirichlet.fixed] = N[problem.dirichlet.fixed]
    return TangentSystem.of(problem, problem.at(moved))


def test_rotations_that_respect_the_conditions():
    disc, held = outward_disc(60)
    solver, N = HarmonicSolver(disc.domain), np.tile(E_Z, (disc.domain.vertex_count, 1))
    rim = disc.domain.boundary_edges
    assert len(free_rotations(problem_of(solver, Conditions()), N)) == 3
    assert_allclose(np.abs(free_rotations(problem_of(solver, conditions.fixed(disc.domain, rim, E_Z)), N)), [E_Z])
    assert_allclose(np.abs(free_rotations(problem_of(solver, conditions.mirror(disc.domain, rim, E_X)), N)), [E_X])
    assert not len(free_rotations(problem_of(solver, held), solver.solve(held).normals))


def test_translations_of_flat_domains():
    torus = shapes.torus(3.0, 2.0, 40)
    x, y = torus.positions.T * [[2 * np.pi / 3.0], [np.pi]]
    N = np.column_stack([np.cos(x), np.sin(x), np.sin(y)])
    fields = translations(torus.domain)(N)
    assert fields.shape == (2, torus.domain.vertex_count, 3)
    speeds = np.sort(np.linalg.norm(fields[:, :, :2], axis=2).mean(axis=1))
    assert_allclose(np.sum(speeds**2), (2 * np.pi / 3.0) ** 2, rtol=0.02, atol=0)
    tube = shapes.cylinder(3.0, 1.0, 12).domain
    assert len(translations(tube)(np.ones((tube.vertex_count, 3)))) == 1
    with pytest.raises(MeshError, match="flat"):
        translations(shapes.sphere(100).domain)
    with pytest.raises(MeshError, match="straight"):
        translations(shapes.disc(60).domain)


def test_the_index_by_factorisations_is_that_by_modes():
    """Alone, and with a mode along which nothing should change though it does."""
    disc, held = outward_disc()
    solver = HarmonicSolver(disc.domain)
    up = solver.solve(held).normals
    flat = up * [1, 1, 0] + 0.02 * np.random.default_rng(0).standard_normal(up.shape)
    flat[:, :2] += 1e-3
    result = saddle(solver, held, flat, tolerance=1e-9).normals
    modes = modes_of(solver, held, result)
    assert index_of(solver, held, result) == (modes.index, modes.nullity) == (1, 0)

    def lowest(N):
        return modes.fields[:1]

    assert index_of(solver, held, result, null=lowest) == (0, 1)


def test_a_wrong_index_is_refused():
    disc, held = outward_disc(60)
    with pytest.raises(ConditionError, match="whole number"):
        saddle(HarmonicSolver(disc.domain), held, np.ones((disc.domain.vertex_count, 3)), index=-1)


def test_two_solutions_for_one_boundary():
    """The small cap and the large bubble over a circle, normals tilted by 45°: together a sphere (Theorem D.1)."""
    disc = shapes.disc(4000)
    held = conditions.binormal(disc.domain, disc.positions, disc.domain.boundary_edges, tilt=0.25 * np.pi)
    solver = HarmonicSolver(disc.domain)
    small = solver.solve(held)
    large = solver.solve(held, degree=small.degree - 1.0)
    assert small.status is large.status is Status.CONVERGED
    parts = (0.5 * (1 - np.cos(0.25 * np.pi)), 0.5 * (1 + np.cos(0.25 * np.pi)))
    assert_allclose([small.degree, large.degree], [parts[0], -parts[1]], rtol=0, atol=2e-3)
    assert_allclose([small.energy, large.energy], 4 * np.pi * np.array(parts), rtol=0.02, atol=0)
    assert modes_of(solver, held, large.normals).negative == 0


def test_translations_of_a_cylinder_are_null_directions_if_its_ends_are_constant():
    shape = shapes.cylinder(2 * np.pi, 2.0, 12)
    solver, rim = HarmonicSolver(shape.domain), shape.domain.boundary_vertices
    turning = np.column_stack([f(shape.positions[rim, 0]) for f in (np.cos, np.sin, np.zeros_like)])
    for normals, is_null in ((np.tile(E_X, (len(rim), 1)), True), (turning, False)):
        N = np.tile(E_Z, (shape.domain.vertex_count, 1))
        N[rim] = normals
        problem = problem_of(solver, conditions.fixed_at(shape.domain, rim, normals))
        assert (drifts(problem, N) is not None) == is_null
