"""A Gauss–Newton model of the objective, which preconditions L-BFGS.

With the response J of the points to the vector x, and the curvature C of each target, the model is H = Σ weight Jᵀ C J.
Short waves of the boundary normals hardly move the sheet in half of the directions (g + N is conformal to N in one
orientation only), so H is badly conditioned; in the coordinates y of x = x₀ + T y, T Tᵀ = H⁻¹, L-BFGS needs a tenth of
the steps.
"""

from __future__ import annotations

from copy import copy

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray
from scipy.linalg import cholesky, solve_triangular

from .objective import Objective, Placed
from .response import KNOTS
from .target import Curvature

Array = NDArray[np.float64]
Int = NDArray[np.integer]

# Curvature added in all directions, as a part of the mean, which limits steps along the flattest ones: at first, once a
# search is near its end, and where it continues another one, whose surface it should stay near.
FAR, NEAR, CONTINUED = 1e-2, 1e-3, 1.0


class GaussNewtonModel:
    """T at x (m,): `forth(y)` is T y, `back(gradient)` is Tᵀ gradient.

    H is known on the knots of the boundary: with an orthonormal basis Q of their hat functions and H = C Cᵀ,
    T = Q C⁻ᵀ Qᵀ there, and a mean on the rest. damping: of H, see `FAR`.
    """

    def __init__(self, objective: Objective, x: Array, damping: float = FAR) -> None:
        self._free = objective.response, objective.free_scale, objective.free_shift
        placed = objective.place(x) if objective.best is None else objective.best
        hats = objective.response.hats.toarray()
        self._basis, triangle = np.linalg.qr(objective.roots * hats)
        N = placed.rim[objective.response.free[_middles(hats)]]
        H = _in_basis(_hessian(objective, x, placed, hats, N), triangle)
        mean = np.trace(H) / len(H)
        lengths = _in_basis(_lengths(objective, hats, N), triangle)
        self._spread = 1.0 / np.sqrt(mean)
        self._mean, self._model = mean, H + mean * lengths + _held(objective, mean, len(H))
        self._cholesky = self._factor(damping)

    def damped(self, damping: float) -> GaussNewtonModel:
        """The same model with another damping."""
        other = copy(self)
        other._cholesky = self._factor(damping)
        return other

    def _factor(self, damping: float) -> Array:
        return cholesky(self._model + damping * self._mean * np.eye(len(self._model)), lower=True)

    def suits(self, objective: Objective) -> bool:
        """Whether it is of the same unknowns."""
        return self._free == (objective.response, objective.free_scale, objective.free_shift)

    def forth(self, y: Array) -> Array:
        low = self._onto(y)
        inside = solve_triangular(self._cholesky, low, lower=True, trans=1)
        return self._spread * y + self._into(inside - self._spread * low)

    def back(self, gradient: Array) -> Array:
        low = self._onto(gradient)
        inside = solve_triangular(self._cholesky, low, lower=True)
        return self._spread * gradient + self._into(inside - self._spread * low)

    def _onto(self, x: Array) -> Array:
        return np.concatenate([(self._basis.T @ x[:-4].reshape(-1, 3)).ravel(), x[-4:]])

    def _into(self, low: Array) -> Array:
        return np.concatenate([(self._basis @ low[:-4].reshape(-1, 3)).ravel(), low[-4:]])


def _hessian(objective: Objective, x: Array, placed: Placed, hats: Array, N: Array) -> Array:
    """H (3 m + 4, 3 m + 4) by turns: vectors in space at the knots, projected on the tangent planes."""
    tangent = np.eye(3) - N[:, :, None] * N[:, None, :]
    size = 3 * len(N) + 4
    H = np.zeros((size, size))
    for target in objective.targets:
        curvature = target.curvature(placed.shape)
        if len(curvature.vertices):
            rows = _moving(objective, placed, curvature, tangent)
            H += target.weight * rows.T @ rows
        if curvature.stiffness is not None:
            H[:-4, :-4] += target.weight * _turning(objective, curvature.stiffness, tangent)
        for row in curvature.rows:
            slope = objective.gradient(x, placed, row)
            slope = np.concatenate([(hats.T @ (objective.roots * slope[:-4].reshape(-1, 3))).ravel(), slope[-4:]])
            H += target.weight * np.outer(slope, slope)
    return H


def _middles(hats: Array) -> Int:
    """(m,) the vertex nearest to the top of each hat function."""
    return np.argmax(hats, axis=0)


def _moving(objective: Objective, placed: Placed, curvature: Curvature, tangent: Array) -> Array:
    """(3 k, 3 m + 4) metric^½ J of moving points, at most `KNOTS` of them."""
    step = -(-len(curvature.vertices) // KNOTS)
    points, metrics = curvature.vertices[::step], step * curvature.metrics[::step]
    J = objective.response.of_points(placed.state, points, objective.side)
    J = placed.scale * np.einsum("kamb,mbc->kamc", J, tangent).reshape(len(points), 3, -1)
    by_scale = objective.free_scale * (placed.shape.points[points] - placed.shift)
    by_shift = np.broadcast_to(objective.free_shift * objective.size * np.eye(3), (len(points), 3, 3))
    J = np.concatenate([J, by_scale[:, :, None], by_shift], axis=2)
    values, vectors = np.linalg.eigh(metrics)
    roots = np.sqrt(np.maximum(values, 0.0))[:, :, None] * vectors.transpose(0, 2, 1)
    return np.einsum("kab,kbm->kam", roots, J).reshape(3 * len(points), -1)


def _turning(objective: Objective, stiffness: sp.csr_array, tangent: Array) -> Array:
    """(3 m, 3 m) of turning normals: each component alone, in the tangent planes of the knots."""
    spread = objective.response.spread
    stiff = spread.T @ (stiffness @ spread)
    blocks = np.einsum("nab,nm,mbc->namc", tangent, stiff, tangent, optimize=True)
    return blocks.reshape(3 * len(tangent), -1)


def _in_basis(H: Array, triangle: Array) -> Array:
    """H in the coordinates of the orthonormal basis, three per knot."""
    wide = np.eye(len(H))
    wide[:-4, :-4] = np.kron(triangle, np.eye(3))
    half = solve_triangular(wide, H, trans=1)
    return solve_triangular(wide, half.T, trans=1)


def _lengths(objective: Objective, hats: Array, N: Array) -> Array:
    """A penalty on the lengths of the vectors, which do not matter here but would where the tangent planes differ."""
    lengths = np.zeros((3 * len(N) + 4, 3 * len(N) + 4))
    gram = (objective.roots * hats).T @ (objective.roots * hats)
    lengths[:-4, :-4] = np.einsum("nm,na,mb->namb", gram, N, N).reshape(3 * len(N), -1)
    return lengths


def _held(objective: Objective, mean: float, size: int) -> Array:
    """Holds on the scale and the shift where they are fixed."""
    held = np.zeros(size)
    held[-4] = mean * (not objective.free_scale)
    held[-3:] = mean * (not objective.free_shift)
    return np.diag(held)
