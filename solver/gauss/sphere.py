"""The unit sphere: its tangent projection, its exponential map, the degree of a map into it. Arrays are (n, 3)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linprog

Array = NDArray[np.float64]


def dot(a: Array, b: Array) -> Array:
    """<a_i, b_i> as (n, 1), which multiplies rows.

    einsum, not matrix products: those wake BLAS threads, which cost more than they save on a busy machine.
    """
    return np.einsum("ij,ij->i", a, b)[:, None]


def inner(a: Array, b: Array) -> float:
    """Σ_i <a_i, b_i>."""
    return float(np.einsum("ij,ij->", a, b))


def project(N: Array, X: Array) -> Array:
    """The tangent part of X at N: X - <X, N> N."""
    return X - dot(X, N) * N


def normalize(X: Array) -> Array:
    """X / |X|, row by row; rows must not vanish."""
    return X / np.sqrt(dot(X, X))


def tangent_axes(N: Array) -> Array:
    """Two orthonormal tangent vectors (n, 2, 3) at each N; the second is N times the first."""
    first = normalize(np.cross(N, np.eye(3)[np.argmin(np.abs(N), axis=1)]))
    return np.stack([first, np.cross(N, first)], axis=1)


def exp(N: Array, d: Array) -> Array:
    """Follow the great circles from N along the tangent vectors d: cos|d| N + sin|d| d/|d|."""
    length = np.sqrt(dot(d, d))
    # np.sinc(x) = sin(πx) / (πx), finite at 0
    return normalize(np.cos(length) * N + np.sinc(length / np.pi) * d)


def solid_angles(N: Array, faces: NDArray[np.integer]) -> Array:
    """Signed areas (F,) of the spherical triangles spanned by the normals of each face (Van Oosterom and Strackee)."""
    a, b, c = (N[faces[:, k]] for k in range(3))
    volume = np.einsum("ij,ij->i", a, np.cross(b, c))
    ab, bc, ca = (np.einsum("ij,ij->i", x, y) for x, y in ((a, b), (b, c), (c, a)))
    return 2.0 * np.arctan2(volume, 1.0 + ab + bc + ca)


def degree(N: Array, faces: NDArray[np.integer]) -> float:
    """Signed area covered by the map, as a part of the sphere: an integer where each boundary loop maps to a point."""
    return float(solid_angles(N, faces).sum() / (4.0 * np.pi))


def fits_in_hemisphere(data: Array) -> bool:
    """Whether unit vectors (n, 3) lie in a closed hemisphere: a · N >= 0 for some a that is not zero."""
    total = data.sum(axis=0)
    if (data @ total).min(initial=0.0) >= 0.0 < total @ total:  # usually
        return True
    if len(data) < 3 or np.linalg.svd(data, compute_uv=False)[-1] < 1e-6 * np.sqrt(len(data)):
        return True
    best = linprog(-total, A_ub=-data, b_ub=np.zeros(len(data)), bounds=(-1.0, 1.0))
    return bool(best.status == 0 and -best.fun > 1e-9 * len(data))
