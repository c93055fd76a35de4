"""Sparse factorisation of symmetric positive definite matrices, in one place.

cholespy (a supernodal Cholesky factorisation) is used where it is installed; SciPy's SuperLU otherwise.
"""

from __future__ import annotations

import importlib
from collections.abc import Callable
from typing import Any, Protocol

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray
from scipy.sparse.linalg import splu

Array = NDArray[np.float64]


class Factor(Protocol):
    """A factorised symmetric positive definite matrix A."""

    def solve(self, b: Array) -> Array:
        """Solve A x = b; b is (n,) or (n, k), and x has its shape."""
        ...


def factorize(A: sp.sparray | sp.spmatrix, backend: str = "auto") -> Factor:
    """Factor the symmetric positive definite sparse matrix A (n, n).

    `backend` is "cholespy", "superlu" or "auto" (cholespy where it is installed). Raises `ImportError` when
    cholespy is asked for by name and missing. A matrix of size zero has a factor, too.
    """
    if backend == "superlu" or A.shape[0] == 0:
        return _SuperLU(A)
    try:
        cholespy = importlib.import_module("cholespy")
    except ImportError:
        if backend == "cholespy":
            raise
        return _SuperLU(A)
    return _Cholespy(A, cholespy)


class _Cholespy:
    def __init__(self, A: sp.sparray | sp.spmatrix, cholespy: Any) -> None:
        coo = sp.coo_array(A)
        self._solver = cholespy.CholeskySolverD(
            coo.shape[0],
            coo.row.astype(np.int32),
            coo.col.astype(np.int32),
            coo.data.astype(np.float64),
            cholespy.MatrixType.COO,
        )

    def solve(self, b: Array) -> Array:
        b = np.ascontiguousarray(b, dtype=np.float64)
        x = np.zeros_like(b)
        self._solver.solve(b, x)
        return x


class _SuperLU:
    """The ordering and the symmetric mode matter: with SciPy's defaults this takes minutes, not seconds."""

    def __init__(self, A: sp.sparray | sp.spmatrix) -> None:
        self._solve: Callable[[Array], Array] = lambda b: b
        if A.shape[0]:
            self._solve = splu(
                sp.csc_matrix(A),
                permc_spec="MMD_AT_PLUS_A",
                diag_pivot_thresh=0.0,
                options={"SymmetricMode": True},
            ).solve

    def solve(self, b: Array) -> Array:
        return self._solve(np.asarray(b, dtype=np.float64))
