"""The gradient of the sum of targets by boundary normals, scale and shift, against finite differences."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

from solver import HarmonicSolver, conditions, shapes
from solver.fitting.gauss_newton import GaussNewtonModel
from solver.fitting.objective import Objective
from solver.fitting.response import KNOTS, Response
from solver.fitting.targets import Area, Closed, Crown, SmoothRim
from solver.gauss import sphere
from solver.surface.adjoint import AdjointSolver
from tests.solver.closing_plans import courtyard

_SCALE, _SHIFT = -4, slice(-3, None)


@pytest.fixture(scope="module")
def open_court():
    """The response of a courtyard whose surface has a gap, and its boundary normals."""
    shape, rim = courtyard(0.2)
    return Response(AdjointSolver(HarmonicSolver(shape.domain), rim)), rim.resolve()[1]


def objective_of(response, targets, free: bool = True) -> Objective:
    return Objective(response, targets, side=1.0, size=2.5, free_scale=free, free_shift=free, first=None)


@pytest.mark.parametrize("target", [Closed(), Area(2.0), Crown(0.7)], ids=["periods", "points", "highest point"])
def test_the_gradient_by_scale_and_shift(open_court, target):
    """Periods grow with the scale, too, and nothing that is only a length depends on the shift."""
    response, rim = open_court
    objective = objective_of(response, [target])
    x = objective.vector(rim, 0.8, np.array([0.1, -0.2, 0.3]))
    value, gradient = objective(x)
    assert value > 1e-4
    step = 1e-4
    for k in range(len(x) + _SCALE, len(x)):
        ahead, behind = (objective(x + sign * step * np.eye(len(x))[k])[0] for sign in (1, -1))
        assert_allclose(gradient[k], (ahead - behind) / (2 * step), rtol=1e-5, atol=1e-8 * value)
    assert abs(gradient[_SCALE]) > 0.1 * value


def test_what_is_not_free_has_no_gradient(open_court):
    response, rim = open_court
    objective = objective_of(response, [Closed(), Crown(0.7)], free=False)
    gradient = objective(objective.vector(rim, 0.8, np.zeros(3)))[1]
    assert gradient[_SCALE] == 0.0 and not gradient[_SHIFT].any() and gradient[:_SCALE].any()


def test_the_model_on_a_rim_of_more_vertices_than_knots():
    """`back` is the transpose of `forth`."""
    shape = shapes.disc(4000)
    rim = conditions.binormal(shape.domain, shape.positions, shape.domain.boundary_edges, 0.4)
    assert len(shape.domain.boundary_vertices) > KNOTS
    response = Response(AdjointSolver(HarmonicSolver(shape.domain), rim))
    objective = objective_of(response, [SmoothRim(), Area(2.0)])
    x = objective.vector(rim.resolve()[1], 0.8, np.zeros(3))
    objective(x)
    model = GaussNewtonModel(objective, x)
    y, gradient = np.random.default_rng(6).normal(size=(2, len(x)))
    assert_allclose(gradient @ model.forth(y), model.back(gradient) @ y, rtol=1e-10, atol=0)


def test_each_map_starts_from_the_best_one_and_the_change_of_the_rim(open_court, monkeypatch):
    response, rim = open_court
    objective = objective_of(response, [Area(2.0)])
    starts, solve = [], AdjointSolver.__call__

    def spy(extension, rim, start, *more):
        starts.append(start)
        return solve(extension, rim, start, *more)

    monkeypatch.setattr(AdjointSolver, "__call__", spy)
    turned = sphere.normalize(rim + 0.01 * np.random.default_rng(2).normal(size=rim.shape))
    first = objective.best
    objective(objective.vector(rim, 0.8, np.zeros(3)))
    there = objective.place(objective.vector(turned, 0.8, np.zeros(3))).state.N
    assert first is None and starts[0] is None
    assert_allclose(starts[1][objective.extension.fixed], turned, rtol=0, atol=1e-3)
    moved = np.abs(there - objective.best.state.N).max()
    assert np.abs(starts[1] - there).max() < 0.3 * moved
