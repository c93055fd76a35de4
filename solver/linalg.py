"""Arrays and sparse linear algebra: checked numbers, graph Laplacians, factors of positive definite matrices.

Matrices are factored by cholespy (supernodal Cholesky) where it is installed, and by SciPy's SuperLU elsewhere.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, Protocol

import numpy as np
import scipy.sparse as sp
from numpy.typing import ArrayLike, NDArray
from scipy.sparse.csgraph import connected_components
from scipy.sparse.linalg import splu
from scipy.spatial import KDTree

from .errors import CmcError, MeshError
from .interrupts import compiled
from .limits import LARGEST

Array = NDArray[np.float64]
# Distance from the origin, as a multiple of the extent.
_DISTANT = 1e9
Sparse = Any  # scipy.sparse ships no types


class Factor(Protocol):
    """A factorised symmetric positive definite matrix A."""

    def solve(self, b: Array) -> Array:
        """Solve A x = b; b is (n,) or (n, k), and x has its shape."""
        ...


def as_array(values: ArrayLike, what: str, error: type[CmcError]) -> NDArray[Any]:
    """The values as an array of their own type; raises `error`, naming `what`, where they are ragged."""
    try:
        return np.asarray(values)
    except ValueError:
        raise error(f"{what} must be a regular array.") from None


def as_numbers(values: ArrayLike, what: str, error: type[CmcError]) -> Array:
    """The values as a float64 array; raises `error`, naming `what`, where they are ragged, no numbers or too large."""
    try:
        if np.iscomplexobj(given := np.asarray(values)):
            raise TypeError
        numbers = given.astype(np.float64, copy=False)
    except (OverflowError, TypeError, ValueError):
        raise error(f"{what} must be numbers in a regular array.") from None
    if (np.isfinite(numbers) & (np.abs(numbers) > LARGEST)).any():
        raise error(f"{what} must be numbers of at most {LARGEST:g} in size.")
    return numbers


def out_of_range(points: Array) -> tuple[NDArray[np.int64], str]:
    """The rows of points (n, …) that are no places, and what they are, "not finite" or "beyond 1e+30"."""
    largest = np.abs(points).max(axis=tuple(range(1, points.ndim)), initial=0.0)
    bad = np.flatnonzero(~(largest <= LARGEST))
    return bad, "not finite" if not np.isfinite(largest).all() else f"beyond {LARGEST:g}"


def check_near(points: Array, what: str) -> None:
    """Raise `MeshError` where rounding moves points (n, d), far from the origin, by 1e-7 of their extent.

    That is as much as single precision leaves of a mesh. Points all in one place are not refused here.
    """
    size, far = float(np.ptp(points, axis=0).max()), float(np.abs(points).max())
    if far > _DISTANT * size > 0.0:
        raise MeshError(
            f"{what} measures {size:.3g} and lies {far:.3g} from the origin, where coordinates are rounded to "
            f"{np.spacing(far):.1g}; move it nearer."
        )


def sum_rows(rows: NDArray[np.integer], values: Array, count: int) -> Array:
    """Add the rows of `values` (n, k), or (n,), into a table of `count` rows: `table[rows[i]] += values[i]`."""
    if values.ndim == 1:
        return np.asarray(np.bincount(rows, values, count), dtype=np.float64)
    return np.stack([sum_rows(rows, column, count) for column in values.T], axis=1)


def reach_of_place(points: Array) -> float:
    """How near points (n, d) of a mesh are in one place: a millionth of the diagonal; single precision leaves 1e-7."""
    return 1e-6 * float(np.linalg.norm(np.ptp(points, axis=0))) if len(points) else 0.0


def same_places(points: Array, reach: float) -> NDArray[np.int64]:
    """For each of points (n, d) the first one in its place; chains of points within about `reach` share a place.

    Points in one small cell are one to begin with, so that thousands in one place make no millions of pairs.
    """
    if not len(points):
        return np.zeros(0, dtype=np.int64)
    cell = np.floor((points - points.min(axis=0)) / (max(reach, 1e-300) / 8.0))
    _, chosen, member = np.unique(cell, axis=0, return_index=True, return_inverse=True)
    pairs = KDTree(points[chosen]).query_pairs(reach, output_type="ndarray")
    links = sp.coo_array((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(len(chosen), len(chosen)))
    label = connected_components(links, directed=False)[1][member.ravel()]
    _, first, place = np.unique(label, return_index=True, return_inverse=True)
    return first[place]


def graph_laplacian(links: NDArray[np.integer], weights: Array, count: int) -> sp.csr_array:
    """L (count, count) of the `links` (K, 2): `<Lu, u> = Σ weight (u_i - u_j)²`; a link from i to i adds nothing."""
    i, j = links.T
    diagonal = np.bincount(i, weights, count) + np.bincount(j, weights, count)
    every = np.arange(count, dtype=np.int32)
    rows, cols = np.concatenate([i, j, every]), np.concatenate([j, i, every])
    data = np.concatenate([-weights, -weights, diagonal])
    return sp.csr_array(sp.coo_array((data, (rows, cols)), shape=(count, count)))


class Patience:
    """The number of unknowns above which `factorize` avoids cholespy.

    cholespy blocks all other threads of the process, so a window would freeze. SuperLU does not, and takes a third
    longer.
    """

    largest: float = math.inf


def factorize(A: Sparse, backend: str = "auto") -> Factor:
    """Factor the symmetric positive definite sparse matrix A (n, n); a matrix of size zero has a factor, too.

    `backend` is "cholespy", "superlu" or "auto" (cholespy where it is installed, and A not too large for `Patience`).
    Raises `ImportError` when cholespy is chosen by name and missing. A factor can be pickled and copied: the copy
    holds A alone and factors it at its first solve.
    """
    if backend == "superlu" or A.shape[0] == 0 or (backend == "auto" and A.shape[0] >= Patience.largest):
        return _SuperLU(A)
    try:
        compiled("cholespy")
    except ImportError:
        if backend == "cholespy":
            raise
        return _SuperLU(A)
    return _Cholespy(A)


class _Factored:
    """Holds A beside its factor, which belongs to a library and can be neither pickled nor copied."""

    def __init__(self, A: Sparse) -> None:
        self.A = A
        self._solve: Callable[[Array], Array] | None = self._factored()

    def _factored(self) -> Callable[[Array], Array]:
        """A⁻¹, applied to (n,) or (n, k)."""
        raise NotImplementedError

    def solve(self, b: Array) -> Array:
        if self._solve is None:
            self._solve = self._factored()
        return self._solve(np.asarray(b, dtype=np.float64))

    def __getstate__(self) -> dict[str, Any]:
        return {"A": self.A, "_solve": None}


class _SuperLU(_Factored):
    """The ordering and the symmetric mode matter: with SciPy's defaults this takes minutes, not seconds."""

    def _factored(self) -> Callable[[Array], Array]:
        if not self.A.shape[0]:
            return lambda b: b
        return splu(
            sp.csc_matrix(self.A),
            permc_spec="MMD_AT_PLUS_A",
            diag_pivot_thresh=0.0,
            options={"SymmetricMode": True},
        ).solve


class _Cholespy(_Factored):
    """Falls back on SuperLU where a pickle is opened without cholespy."""

    def _factored(self) -> Callable[[Array], Array]:
        try:
            cholespy = compiled("cholespy")
        except ImportError:  # it was installed where this factor was pickled
            return _SuperLU(self.A).solve
        coo = self.A.tocoo()
        factor = cholespy.CholeskySolverD(
            self.A.shape[0],
            coo.row.astype(np.int32),
            coo.col.astype(np.int32),
            coo.data.astype(np.float64),
            cholespy.MatrixType.COO,
        )

        def solve(b: Array) -> Array:
            b = np.ascontiguousarray(b)
            x = np.zeros_like(b)
            factor.solve(b, x)
            return x

        return solve


# The residual, as a part of the right-hand side; and the most iterations: a factorisation costs about sixty.
_TOLERANCE = 1e-11
_LIMIT = 40


class ReusedFactor:
    """Solves with A (n, n) by conjugate gradients, preconditioned with the factor of a nearby matrix.

    Where that takes more than a few dozen iterations A itself is factored, so a solution is always exact.
    factor: the one in use. iterations: the most that a solve has taken so far, None before the first.
    """

    def __init__(self, A: Sparse, factor: Factor) -> None:
        self.A = A
        self.factor = factor
        self.iterations: int | None = None

    def solve(self, b: Array) -> Array:
        """A x = b; b is (n,) or (n, k), and x has its shape."""
        columns = np.asarray(b, dtype=np.float64).reshape(len(b), -1)
        x, count = self._iterate(columns)
        if count > _LIMIT:
            self.factor, count = factorize(self.A), 0
            x = self.factor.solve(columns)
        self.iterations = max(count, self.iterations or 0)
        return x.reshape(b.shape)

    def _iterate(self, b: Array) -> tuple[Array, int]:
        """x and the number of iterations; all columns at once, each with its own step lengths."""
        enough = _TOLERANCE**2 * _column_squares(b, b)
        x = self.factor.solve(b)
        rest = b - self.A @ x
        z = self.factor.solve(rest)
        p, slope = z, _column_squares(rest, z)
        for count in range(_LIMIT + 1):
            if (_column_squares(rest, rest) <= enough).all():
                return x, count
            curved = self.A @ p
            step = slope / np.maximum(_column_squares(p, curved), np.finfo(float).tiny)
            x = x + step * p
            rest = rest - step * curved
            z = self.factor.solve(rest)
            slope, last = _column_squares(rest, z), slope
            p = z + slope / np.maximum(last, np.finfo(float).tiny) * p
        return x, _LIMIT + 1


def _column_squares(a: Array, b: Array) -> Array:
    """<a, b> (k,) of each column of (n, k)."""
    return np.einsum("ij,ij->j", a, b)
