"""Factors with and without cholespy, pickled and copied, and sums over rows."""

from __future__ import annotations

import copy
import pickle
import sys

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from solver import Status, conditions, linalg, solve_cmc
from tests.solver.exact_surfaces import disc


def laplacian(n=400):
    domain, _ = disc(n)
    inside = np.setdiff1d(np.arange(domain.vertex_count), domain.boundary_vertices)
    return domain.laplacian[inside][:, inside]


@pytest.mark.parametrize("backend", ["superlu", "cholespy", "auto"])
@pytest.mark.parametrize("columns", [None, 1, 3])
def test_factors_solve(backend, columns):
    if backend == "cholespy":
        pytest.importorskip("cholespy")
    A = laplacian()
    x = np.random.default_rng(0).normal(size=A.shape[0] if columns is None else (A.shape[0], columns))
    solved = linalg.factorize(A, backend).solve(A @ x)
    assert solved.shape == x.shape
    assert_allclose(solved, x, rtol=0, atol=1e-9)


def test_without_cholespy_everything_still_works(monkeypatch):
    monkeypatch.setitem(sys.modules, "cholespy", None)  # importing it now fails
    assert isinstance(linalg.factorize(laplacian()), linalg._SuperLU)
    with pytest.raises(ImportError):
        linalg.factorize(laplacian(), "cholespy")
    domain, points = disc(400)
    surface = solve_cmc(domain, conditions.binormal(domain, points, domain.boundary_edges, tilt=0.2))
    assert surface.status is Status.CONVERGED


def test_an_empty_matrix_has_a_factor():
    A = laplacian()[:0][:, :0]
    assert linalg.factorize(A).solve(np.zeros((0, 3))).shape == (0, 3)


def pickled(value):
    return pickle.loads(pickle.dumps(value))


@pytest.mark.parametrize("duplicate", [pickled, copy.deepcopy])
@pytest.mark.parametrize("backend", ["superlu", "cholespy"])
def test_a_copied_factor_factors_again(backend, duplicate):
    if backend == "cholespy":
        pytest.importorskip("cholespy")
    A = laplacian()
    factor = linalg.factorize(A, backend)
    b = np.random.default_rng(0).normal(size=(A.shape[0], 3))
    duplicated = duplicate(factor)
    assert type(duplicated) is type(factor)
    assert duplicated._solve is None
    assert_allclose(duplicated.solve(b), factor.solve(b), rtol=0, atol=1e-12)
    assert duplicated._solve is not None
    nearby = linalg.ReusedFactor(1.01 * A, factor)
    assert_allclose(duplicate(nearby).solve(b), nearby.solve(b), rtol=0, atol=1e-12)


def test_a_factor_of_cholespy_opens_without_it(monkeypatch):
    pytest.importorskip("cholespy")
    A = laplacian()
    data = pickle.dumps(linalg.factorize(A, "cholespy"))
    monkeypatch.setitem(sys.modules, "cholespy", None)
    b = np.ones(A.shape[0])
    assert_allclose(A @ pickle.loads(data).solve(b), b, rtol=0, atol=1e-10)


def test_rows_are_summed():
    rows = np.array([2, 0, 2])
    assert_array_equal(linalg.sum_rows(rows, np.array([1.0, 2.0, 4.0]), 4), [2, 0, 5, 0])
    values = np.arange(6.0).reshape(3, 2)
    assert_array_equal(linalg.sum_rows(rows, values, 4), [[2, 3], [0, 0], [4, 6], [0, 0]])


def test_no_points_are_in_range():
    assert linalg.out_of_range(np.zeros((0, 3)))[0].size == 0
    assert linalg.out_of_range(np.array([[1.0, np.nan], [1.0, 2.0]]))[0].tolist() == [0]
