"""Wente's tori (paper, Sec. 5.3.3, Figures 13 and 15): closed over the height, whole, and as saddles."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

from solver import Conditions, HarmonicSolver, Status, complete, conditions
from solver.gauss.balance import imbalance, moment_gradients
from solver.gauss.saddle_maps import flat_axis, modes_of, problem_of, saddle
from solver.gauss.sphere import exp, inner, normalize
from solver.gauss.symmetries import translations
from solver.surface.whole import whole
from tests.solver.exact import rates
from tests.solver.wente import HEIGHTS, closed_quarter, jittered_cylinder


@pytest.mark.parametrize(("angle", "columns"), [(120, (12, 24, 48)), (60, (40, 80))])
def test_the_closing_height_converges_at_second_order(angle, columns):
    errors = []
    for n in columns:
        closing, _, height = closed_quarter(angle, n, 1.1 * HEIGHTS[angle])
        assert closing.closed and len(closing.gaps) - 1 <= 6 and closing.gaps[-1] < 1e-10
        errors.append(abs(height / HEIGHTS[angle] - 1.0))
    assert (rates(errors) > 1.8).all() and errors[-1] < 0.011


@pytest.mark.parametrize(("angle", "columns", "cylinders"), [(120, 12, 6), (90, 20, 4)])
def test_the_whole_torus_is_found_again_from_a_perturbed_start(angle, columns, cylinders):
    """Residual 1e-9 by Newton's method with three rotations and two translations held; ΣN μ = 0 (Theorem E.2)."""
    closing, sides, _ = closed_quarter(angle, columns, {120: 1.66, 90: 1.85}[angle])
    assert closing.closed and np.abs(closing.surface.normals[:, 2]).max() > 0.99
    completion = complete(closing.surface, sides)
    torus = whole(completion)
    assert completion.is_whole and len(completion.copies) == 4 * cylinders
    assert torus.domain.genus == 1 and not len(torus.domain.boundary_edges)
    solver = HarmonicSolver(torus.domain)
    problem = problem_of(solver, Conditions())
    assert_allclose(problem.at(torus.normals).residual, 0, rtol=0, atol=1e-9)
    noise = np.random.default_rng(1).standard_normal(torus.normals.shape)
    smooth = problem.dirichlet.precondition(problem.graph.areas[:, None] * noise)
    start = normalize(torus.normals + 0.05 * smooth / np.abs(smooth).max())
    assert problem.at(start).residual > 1.0
    fields = translations(torus.domain)
    found = saddle(solver, Conditions(), start, index=None, null=fields, tolerance=1e-9)
    assert found.status is Status.CONVERGED and found.iterations <= 12
    assert_allclose(found.energy, 4 * cylinders * closing.surface.harmonic.energy, rtol=1e-9, atol=0)
    assert_allclose(imbalance(problem, found.normals), 0, rtol=0, atol=1e-10)
    assert np.abs(imbalance(problem, start)).max() > 1e-4


def test_the_jittered_cylinder_has_a_saddle_of_index_one():
    domain, held, start = jittered_cylinder(120, 64, seed=3)
    solver, fields = HarmonicSolver(domain), translations(domain)
    found = saddle(solver, held, start, null=fields)
    assert found.status is Status.CONVERGED
    assert_allclose(found.energy, 26.82, rtol=0, atol=0.25)
    modes = modes_of(solver, held, found.normals, null=fields)
    assert (modes.index, modes.nullity) == (1, 1)
    assert modes.values[0] < -5e-3 < modes.values[1] < 5e-3 < modes.values[2]
    fallen = solver.solve(held, start)
    assert fallen.energy < 9 and np.abs(fallen.normals[:, 2]).max() < 1e-6
    assert flat_axis(fallen.normals) is not None and flat_axis(found.normals) is None


def test_balanced_descent_does_not_end_at_a_constant():
    """From near the saddle: minimising collapses, among balanced maps it ends at a great circle, covered evenly
    (Sec. 5.3.4)."""
    closing, sides, _ = closed_quarter(120, 8, 1.7)
    torus = whole(complete(closing.surface, sides))
    solver, random = HarmonicSolver(torus.domain), np.random.default_rng(0)
    problem = problem_of(solver, Conditions())
    noise = random.standard_normal(torus.normals.shape)
    smooth = problem.dirichlet.precondition(problem.graph.areas[:, None] * noise)
    start = normalize(torus.normals + 0.1 * smooth / np.abs(smooth).max())
    assert solver.solve(Conditions(), start).status is Status.COLLAPSED
    found = solver.solve(conditions.balanced(torus.domain), start)
    assert found.status is Status.CONVERGED and found.energy > 1.0
    assert flat_axis(found.normals) is not None
    assert_allclose(imbalance(problem, found.normals), 0, rtol=0, atol=1e-10)
    point = problem.at(start)
    d = problem.project(start, noise)
    ahead, back = (problem.at(exp(start, t * d)) for t in (1e-5, -1e-5))
    change = sum(s * p.energy * imbalance(problem, p.N) for s, p in ((1, ahead), (-1, back))) / 2e-5
    assert_allclose(change, [inner(a, d) for a in moment_gradients(problem, point)], rtol=1e-5, atol=1e-5)
