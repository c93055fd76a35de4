"""The Hessian of the energy as a sparse matrix, in coordinates of the tangent planes.

At a map N each free site has two coordinates, a site on a mirror one, a fixed site none. With T (3 S, n) the
orthonormal frames, H = Tᵀ (L - λ - Σ dstar u uᵀ) T is the Hessian of `problem` and K = Tᵀ L T, with the mass where
nothing is fixed, the H¹ product. Eigenvalues of H v = λ K v are below one, independent of units and nearly so of the
mesh; almost all of them are close to one.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray
from scipy.sparse.linalg import LinearOperator, eigsh, splu

from ..linalg import Factor, Sparse, factorize
from .problem import EnergyProblem, Point
from .sphere import dot, normalize, tangent_axes

Array = NDArray[np.float64]

# Gauge directions get this eigenvalue, well above the lowest ones.
_LIFTED = 6.0
# A pivot off the diagonal is taken where the one on it is smaller by this factor.
_PIVOT = 1e-3
# Vectors that Lanczos' method keeps at least: long thin plans have many modes with nearly the same eigenvalue.
_WIDE = 20
# Shifts tried for it: the nearer to the eigenvalues, the farther apart it sees them.
_SHIFTS = (-1e-3, -1e-2, -0.1, -1.0)
# Part of the distance from the shift by which eigenvalues may differ and count as one.
_ALIKE = 1e-6


@dataclass(frozen=True, eq=False)
class TangentSystem:
    """The second order of an energy at a map. frames: T (3 S, n). gradient: (n,). H, K: (n, n)."""

    frames: sp.csr_array
    gradient: Array
    H: sp.csc_array
    K: sp.csc_array

    @classmethod
    def of(cls, problem: EnergyProblem, point: Point) -> TangentSystem:
        frames = _frames(problem, point.N)
        hessian = sp.kron(point.L, sp.eye_array(3)) - sp.diags_array(np.repeat(dot(point.N, point.gradient)[:, 0], 3))
        bending = problem.bending(point)
        if bending is not None:
            rows, dstar = bending
            hessian = hessian - rows.T @ sp.diags_array(dstar) @ rows
        graph, dirichlet = problem.graph, problem.dirichlet
        product = graph.laplacian(dirichlet.weights)
        if not len(dirichlet.fixed):
            product = product + sp.diags_array(graph.areas / graph.areas.sum())
        H, K = (sp.csc_array(frames.T @ A @ frames) for A in (hessian, sp.kron(product, sp.eye_array(3))))
        return cls(frames, frames.T @ point.gradient.ravel(), H, K)

    @cached_property
    def product_factor(self) -> Factor:
        return factorize(self.K)

    def coordinates(self, fields: Array) -> Array:
        """(n, k) of the tangent parts of fields (k, S, 3)."""
        return np.asarray(self.frames.T @ fields.reshape(len(fields), fields.shape[1] * fields.shape[2]).T)

    def in_space(self, d: Array) -> Array:
        """(S, 3) of coordinates (n,)."""
        return (self.frames @ d).reshape(-1, 3)

    def dual_norm(self, covector: Array) -> float:
        """The norm of a gradient (n,) in the dual of the H¹ product."""
        return float(np.sqrt(covector @ self.product_factor.solve(covector)))

    def orthonormal(self, columns: Array) -> Array:
        """Columns (n, k), made orthonormal in the H¹ product; linearly dependent ones are dropped."""
        if not columns.shape[1]:
            return columns
        values, turn = np.linalg.eigh(columns.T @ (self.K @ columns))
        kept = values > 1e-10 * max(float(values.max()), 1e-300)
        return columns @ (turn[:, kept] / np.sqrt(values[kept]))

    def solve(self, right: Array, gauge: Array) -> tuple[Array, Array]:
        """d (n,) and multipliers m with H d + K B m = right, Bᵀ K d = 0, for the columns B (n, k) of `gauge`.

        One sparse factorisation of the bordered matrix. d is not finite where it is singular.
        """
        border = sp.csc_array(self.K @ gauge)
        matrix = sp.block_array([[self.H, border], [border.T, None]]) if gauge.shape[1] else self.H
        count = gauge.shape[1]
        try:
            solved = _lu(matrix, _PIVOT).solve(np.concatenate([right, np.zeros(count)]))
        except RuntimeError:  # SuperLU: "Factor is exactly singular"
            solved = np.full(len(right) + count, np.nan)
        return solved[: len(right)], solved[len(right) :]

    def lowest(self, count: int, gauge: Array) -> tuple[Array, Array]:
        """The lowest eigenvalues (k,) of H v = λ K v, and their v (n, k), orthonormal for K and orthogonal to `gauge`.

        Lanczos' method on (H - σ K)⁻¹, σ below them all; at most n - 1 of them. On a symmetric map it may report a
        double eigenvalue once, so it runs again orthogonal to its modes until there are as many as `below` counts.
        """
        n = len(self.gradient)
        count = missing = min(count, n - 1)
        if n <= max(60, 4 * count):
            return self._dense(count, self.K @ gauge)
        shift = self._under(gauge)
        values, modes = np.zeros(0), np.zeros((n, 0))
        while missing > 0:
            more, others = self._lanczos(missing, np.concatenate([gauge, modes], axis=1), shift)
            values, modes = np.concatenate([values, more]), np.concatenate([modes, others], axis=1)
            order = np.argsort(values)
            values, modes = values[order], modes[:, order]
            top = values[count - 1] - _ALIKE * (values[count - 1] - shift)
            missing = self.count(top, gauge) - int((values < top).sum())
        return values[:count], modes[:, :count]

    def _under(self, gauge: Array) -> float:
        """A shift below every eigenvalue, and not far below."""
        for shift in _SHIFTS:
            if not self.count(shift, gauge):
                return shift
        while self.count(2.0 * shift, gauge):
            shift *= 2.0
        return 2.0 * shift

    def _lanczos(self, count: int, without: Array, shift: float) -> tuple[Array, Array]:
        n, factor, border = len(self.gradient), _lu(self._bordered(shift, without), 0.0), np.zeros(without.shape[1])

        def solved(x: Array) -> Array:
            return factor.solve(np.concatenate([x, border]))[:n]

        inverse = LinearOperator((n, n), matvec=solved, dtype=np.float64)  # pyright: ignore[reportCallIssue]
        start = np.random.default_rng(without.shape[1]).standard_normal(n)
        wide = min(n, max(2 * count + 1, _WIDE))
        values, vectors = eigsh(self.H, count, M=self.K, sigma=shift, OPinv=inverse, v0=start, tol=1e-8, ncv=wide)  # pyright: ignore[reportArgumentType]
        order = np.argsort(values)
        return values[order], vectors[:, order]

    def _dense(self, count: int, border: Array) -> tuple[Array, Array]:
        lifted = self.H.toarray() + _LIFTED * border @ border.T
        half = np.linalg.inv(np.linalg.cholesky(self.K.toarray()))
        values, vectors = np.linalg.eigh(half @ lifted @ half.T)
        return values[:count], half.T @ vectors[:, :count]

    def below(self, shift: float, gauge: Array | None = None) -> int:
        """How many eigenvalues of H v = λ K v are below `shift`: negative pivots of H - shift K (Sylvester).

        gauge: (n, k) orthonormal directions, lifted above the shift. They border the matrix, with -1 over the lift on
        the diagonal, which adds one negative pivot each.
        """
        factor = _lu(self._bordered(shift, gauge), 0.0)
        if not np.array_equal(factor.perm_r, factor.perm_c):
            raise ArithmeticError("a pivot vanished")
        return int((factor.U.diagonal() < 0.0).sum()) - (0 if gauge is None else gauge.shape[1])

    def count(self, shift: float, gauge: Array) -> int:
        """`below`, where it does not matter whether a mode at the shift itself counts."""
        for aside in (0.0, 1e-9, 1e-8, 1e-7):
            try:
                return self.below(shift + aside, gauge)
            except (ArithmeticError, RuntimeError):  # SuperLU: "Factor is exactly singular"
                continue
        raise ArithmeticError("pivots vanished")

    def _bordered(self, shift: float, gauge: Array | None) -> Sparse:
        matrix = self.H - shift * self.K
        if gauge is None or not gauge.shape[1]:
            return matrix
        border = sp.csc_array(self.K @ gauge)
        return sp.block_array([[matrix, border], [border.T, -sp.eye_array(gauge.shape[1]) / _LIFTED]])


def _frames(problem: EnergyProblem, N: Array) -> sp.csr_array:
    unknown, mirrors = problem.dirichlet.unknown, problem.mirrors
    first = tangent_axes(N)[:, 0]
    first[mirrors.sites] = normalize(np.cross(mirrors.normals, N[mirrors.sites]))
    two = np.setdiff1d(unknown, mirrors.sites)
    sites = np.concatenate([unknown, two])
    vectors = np.concatenate([first[unknown], np.cross(N, first)[two]])
    order = np.argsort(sites, kind="stable")
    rows = (3 * sites[order, None] + np.arange(3)).ravel()
    columns = np.repeat(np.arange(len(sites)), 3)
    return sp.csr_array((vectors[order].ravel(), (rows, columns)), shape=(3 * len(N), len(sites)))


def _lu(matrix: Sparse, pivot: float) -> Any:
    return splu(
        sp.csc_matrix(matrix),
        permc_spec="MMD_AT_PLUS_A",
        diag_pivot_thresh=pivot,
        options={"SymmetricMode": True},
    )
