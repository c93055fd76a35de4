"""Wente's tori (paper, Sec. 5.3.3, 5.3.4 and Figure 15): completed, and whole as saddles of the energy."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

from solver import (
    Conditions,
    Domain,
    HarmonicSolver,
    Status,
    complete,
    conditions,
    mean_curvature_of,
    modes_of,
    saddle,
    wente,
    whole,
)
from solver.gauss.balance import imbalance, moment_gradients
from solver.gauss.modes import flat_axis, problem_of
from solver.gauss.sphere import exp, inner
from tests.solver.exact_surfaces import rates
from tests.solver.wente_cylinders import jittered_cylinder, nearby


def completed(angle, columns):
    quarter = wente(np.radians(angle), columns)
    return quarter, complete(quarter.surface, quarter.sides)


def curvature_error(mesh) -> float:
    """L² of H - ½ over ½."""
    a, b, c = (mesh.vertices[mesh.faces[:, k]] for k in range(3))
    areas = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    errors = mean_curvature_of(mesh.vertices, mesh.faces, mesh.normals) - 0.5
    return float(np.sqrt(areas @ errors**2 / areas.sum()) / 0.5)


def test_the_completed_torus_is_closed_and_its_mean_curvature_converges():
    errors, gaps = [], []
    for n in (16, 32):
        quarter, completion = completed(120, n)
        mesh = completion.mesh
        torus = Domain.from_positions(mesh.vertices, mesh.faces)
        assert completion.is_whole and len(completion.copies) == 4 * quarter.cylinders == 24
        assert torus.genus == 1 and not len(torus.boundary_edges)
        errors.append(curvature_error(mesh))
        gaps.append(max(gap.relative for gap in completion.gaps))
    assert (rates(errors) > 0.9).all() and errors[-1] < 0.1
    assert (rates(gaps) > 1.8).all() and gaps[-1] < 2e-4


@pytest.mark.parametrize(("angle", "columns", "covers"), [(120, 16, 2), (90, 14, 1), (150, 10, 1), (72, 24, 2)])
def test_half_a_quarter_makes_the_torus_once(angle, columns, covers):
    """With angle / 2π of odd denominator n, N is the same π further around and n cylinders further along."""
    quarter, half = (wente(np.radians(angle), columns, halved=halved) for halved in (False, True))
    assert quarter.closed and half.closed and quarter.covers == half.covers == covers
    assert ("twice" in half.message) == (covers == 2)
    assert_allclose(half.height, quarter.height, rtol=0.02, atol=0)
    assert_allclose(2.0 * half.surface.harmonic.energy, quarter.surface.harmonic.energy, rtol=0.01, atol=0)
    once, often = (complete(bubble.surface, bubble.sides) for bubble in (half, quarter))
    assert len(once.copies) == 8 * half.cylinders / covers and len(often.copies) == 4 * quarter.cylinders
    torus = Domain.from_positions(once.mesh.vertices, once.mesh.faces)
    assert once.is_whole and torus.genus == 1 and once.mesh.is_closed
    for completion, expected in ((often, covers), (once, 1)):
        middle = completion.copies[0].points(completion.surface.f_plus.mean(axis=0))
        near = [
            np.linalg.norm(copy.points(completion.surface.sheet(sheet).mean(axis=0)) - middle) < 0.01
            for copy, sheet in zip(completion.copies, completion.sheets, strict=True)
        ]
        assert sum(near) == expected


@pytest.mark.parametrize(("angle", "columns", "cylinders"), [(120, 8, 6), (90, 14, 4), (108, 10, 10)])
def test_the_map_of_the_whole_torus_is_harmonic(angle, columns, cylinders):
    quarter, completion = completed(angle, columns)
    torus = whole(completion)
    assert completion.is_whole and len(completion.copies) == 4 * cylinders
    assert torus.domain.genus == 1 and not len(torus.domain.boundary_edges)
    point = problem_of(HarmonicSolver(torus.domain), Conditions()).at(torus.normals)
    assert_allclose(point.residual, 0, rtol=0, atol=1e-9)
    assert_allclose(point.energy, 4 * cylinders * quarter.surface.harmonic.energy, rtol=1e-12, atol=0)


def test_the_whole_torus_is_found_again_from_a_perturbed_start():
    """Residual 1e-9 by Newton's method with three rotations and two translations held; ΣN μ = 0 (Theorem E.2)."""
    torus = whole(completed(120, 8)[1])
    solver = HarmonicSolver(torus.domain)
    problem, start = problem_of(solver, Conditions()), nearby(solver, torus.normals)
    assert problem.at(start).residual > 1.0
    found = saddle(solver, Conditions(), start, index=None, tolerance=1e-9)
    assert found.status is Status.CONVERGED and found.iterations <= 8
    assert_allclose(found.energy, problem.at(torus.normals).energy, rtol=1e-9, atol=0)
    assert_allclose(imbalance(problem, found.normals), 0, rtol=0, atol=1e-10)
    assert np.abs(imbalance(problem, start)).max() > 1e-4
    assert modes_of(solver, Conditions(), found.normals).index >= 24


def test_the_jittered_cylinder_has_a_saddle_of_index_one():
    domain, held, start = jittered_cylinder(np.radians(120), 48, seed=0)
    solver = HarmonicSolver(domain)
    found = saddle(solver, held, start)
    assert found.status is Status.CONVERGED
    assert_allclose(found.energy, 26.82, rtol=0, atol=0.45)
    modes = modes_of(solver, held, found.normals)
    assert (modes.index, modes.nullity) == (1, 1)
    assert modes.values[0] < -5e-3 < modes.values[1] < 5e-3 < modes.values[2]
    fallen = solver.solve(held, start)
    assert fallen.energy < 9 and np.abs(fallen.normals[:, 2]).max() < 1e-6
    assert flat_axis(fallen.normals) is not None and flat_axis(found.normals) is None


def test_balanced_descent_does_not_end_at_a_constant():
    """From near the saddle: minimising collapses, among balanced maps it ends at a great circle, covered evenly
    (Sec. 5.3.4)."""
    torus = whole(completed(120, 8)[1])
    solver = HarmonicSolver(torus.domain)
    problem, start = problem_of(solver, Conditions()), nearby(solver, torus.normals, 0.1)
    assert solver.solve(Conditions(), start).status is Status.COLLAPSED
    found = solver.solve(conditions.balanced(torus.domain), start)
    assert found.status is Status.CONVERGED and found.energy > 1.0
    assert flat_axis(found.normals) is not None
    assert_allclose(imbalance(problem, found.normals), 0, rtol=0, atol=1e-10)
    point = problem.at(start)
    d = problem.project(start, np.random.default_rng(0).standard_normal(start.shape))
    ahead, back = (problem.at(exp(start, t * d)) for t in (1e-5, -1e-5))
    change = sum(s * p.energy * imbalance(problem, p.N) for s, p in ((1, ahead), (-1, back))) / 2e-5
    assert_allclose(change, [inner(a, d) for a in moment_gradients(problem, point)], rtol=1e-5, atol=1e-5)
