"""Balanced maps (paper, Sec. 5.3.4) and Theorem E.2 on closed domains."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

from solver import ConditionError, Conditions, HarmonicSolver, Status, conditions, shapes
from solver.gauss.balance import imbalance
from solver.gauss.modes import problem_of
from solver.gauss.sphere import normalize

TORUS = shapes.torus(2 * np.pi, 2.0, 24)
SITES = [("vertices", "cotan"), ("faces", "cotan"), ("faces", "mobius")]


def winding(solver, bend=0.0):
    """Once around a great circle along the torus, and off it by `bend`; at faces as at one of their corners."""
    at = TORUS.positions if solver.graph.at_vertices else TORUS.positions[TORUS.domain.faces[:, 0]]
    x, y = at[:, :2].T
    return normalize(np.column_stack([np.cos(x), np.sin(x), bend * np.sin(np.pi * y)]))


@pytest.mark.parametrize(("sites", "energy"), SITES)
def test_the_moment_is_minus_the_sum_of_the_tangent_parts(sites, energy):
    """The gradients of a closed domain add up to nothing, whatever the map."""
    solver = HarmonicSolver(TORUS.domain, sites, energy)
    problem = problem_of(solver, Conditions())
    point = problem.at(winding(solver, bend=0.5))
    assert_allclose(point.energy * imbalance(problem, point.N), -point.tangent.sum(axis=0), rtol=0, atol=1e-12)
    assert np.abs(point.tangent.sum(axis=0)).max() <= point.residual


@pytest.mark.parametrize(("sites", "energy"), SITES)
def test_critical_maps_of_closed_domains_are_balanced(sites, energy):
    solver = HarmonicSolver(TORUS.domain, sites, energy)
    result = solver.solve(Conditions(), winding(solver, bend=0.1), method="critical", tolerance=1e-10)
    assert result.status is Status.CONVERGED and result.energy > 1.0
    assert result.imbalance is not None and result.imbalance < 1e-10
    off = solver.solve(Conditions(), winding(solver, bend=0.5) + [0.3, 0.0, 0.0], max_iterations=0)
    assert off.imbalance is not None and off.imbalance > 1e-3


def test_balance_is_for_closed_domains():
    disc = shapes.disc(60).domain
    with pytest.raises(ConditionError, match="closed domains only"):
        conditions.balanced(disc)
    held = conditions.fixed(disc, disc.boundary_edges, [0, 0, 1])
    assert HarmonicSolver(disc).solve(held).imbalance is None


def test_balance_survives_addition_and_has_its_own_method():
    held = Conditions() + conditions.balanced(TORUS.domain)
    assert held.is_balanced and not (Conditions() + Conditions()).is_balanced
    solver = HarmonicSolver(TORUS.domain)
    with pytest.raises(ConditionError, match="leave out method='flow'"):
        solver.solve(held, winding(solver), method="flow")
    with pytest.raises(ConditionError, match="closed"):
        solver.solve(held)


def test_balanced_descent_keeps_away_from_constants():
    """Where plain descent slides off the great circle, which is a saddle, to a constant map."""
    solver = HarmonicSolver(TORUS.domain)
    off = winding(solver) + [0.02, 0.0, 0.05]
    assert solver.solve(Conditions(), off).status is Status.COLLAPSED
    result = solver.solve(conditions.balanced(TORUS.domain), off, tolerance=1e-9)
    assert result.status is Status.CONVERGED
    assert_allclose(result.energy, 0.5 * 2 * np.pi * 2.0, rtol=5e-3)
    assert result.imbalance < 1e-8 and len(result.history) < 60
