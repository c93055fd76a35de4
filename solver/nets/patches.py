"""The curved surface of whole panels: points on it, and polynomials that continue it a little."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..gauss.sphere import normalize
from .net import Net

Array = NDArray[np.float64]
Int = NDArray[np.integer]

# Points along a side of a panel; 5 include the middles, where panels are farthest from a sphere.
_ALONG = np.linspace(0.0, 1.0, 5)
_POWERS = [(i, j) for order in range(5) for i in range(order, -1, -1) for j in [order - i]]


def quads(net: Net) -> Int:
    """The whole panels with four corners."""
    return np.array([panel for panel in net.inner if len(net.polygons[panel]) == 4], dtype=np.int64)


def samples(net: Net, panels: Int) -> Array:
    """Points (p, 25, 3) on the surface of four-sided panels, 5 × 5.

    Coons' patch between cubics that have the net's nodes as ends and are tangent to the surface there: the error is of
    fourth order in the side.
    """
    corners = np.stack([net.polygons[panel] for panel in panels])
    X, N = net.vertices[corners], net.normals[corners]
    s = _ALONG
    # sides from corner 0 to 1 and 3 to 2 (along u), from 0 to 3 and 1 to 2 (along v)
    bottom, top = _cubic(X[:, 0], X[:, 1], N[:, 0], N[:, 1]), _cubic(X[:, 3], X[:, 2], N[:, 3], N[:, 2])
    start, stop = _cubic(X[:, 0], X[:, 3], N[:, 0], N[:, 3]), _cubic(X[:, 1], X[:, 2], N[:, 1], N[:, 2])
    u, v = s[None, :, None, None], s[None, None, :, None]
    across = (1.0 - v) * bottom[:, :, None] + v * top[:, :, None]
    up = (1.0 - u) * start[:, None, :] + u * stop[:, None, :]
    flat = (
        (1.0 - u) * (1.0 - v) * X[:, 0, None, None] + u * (1.0 - v) * X[:, 1, None, None]
        + u * v * X[:, 2, None, None] + (1.0 - u) * v * X[:, 3, None, None]
    )
    return (across + up - flat).reshape(len(panels), -1, 3)


def _cubic(a: Array, b: Array, na: Array, nb: Array) -> Array:
    """Points (p, 5, 3) of the cubic from a to b (p, 3), tangent to the planes with normals na and nb."""
    chord = b - a
    length = np.linalg.norm(chord, axis=1, keepdims=True)
    ta, tb = (length * normalize(chord - np.einsum("pi,pi->p", chord, n)[:, None] * n) for n in (na, nb))
    s = _ALONG[None, :, None]
    h00, h10 = (1.0 + 2.0 * s) * (1.0 - s) ** 2, s * (1.0 - s) ** 2
    h01, h11 = s**2 * (3.0 - 2.0 * s), s**2 * (s - 1.0)
    return h00 * a[:, None] + h10 * ta[:, None] + h01 * b[:, None] + h11 * tb[:, None]


def frames(net: Net, panels: Int, points: Array) -> tuple[Array, Array]:
    """Centres (p, 3) and rows x, y, N (p, 3, 3) of frames of panels, x along the lines of the larger curvature."""
    corners = np.stack([net.polygons[panel] for panel in panels])
    X = net.vertices[corners]
    family = {(int(i), int(j)): int(f) for (i, j), f in zip(net.edges, net.family, strict=True)}
    first = np.array([family[min(a, b), max(a, b)] == 0 for a, b in corners[:, :2].tolist()])
    along = X[:, 1] + X[:, 2] - X[:, 0] - X[:, 3]
    across = X[:, 2] + X[:, 3] - X[:, 0] - X[:, 1]
    N = normalize(net.normals[corners].sum(axis=1))
    x = np.where(first[:, None], along, across)
    x = normalize(x - np.einsum("pi,pi->p", x, N)[:, None] * N)
    return points[:, 12], np.stack([x, np.cross(N, x), N], axis=1)


def local(points: Array, centres: Array, axes: Array) -> Array:
    """Points (p, n, 3) in frames: centres (p, 3), rows of axes (p, 3, 3)."""
    return np.einsum("pkd,pnd->pnk", axes, points - centres[:, None])


def quartic(points: Array, weights: Array) -> Array:
    """The 15 coefficients of the polynomial z(x, y) of degree 4 nearest to points (n, 3) with weights (n,)."""
    size = np.abs(points[:, :2]).max()
    scale = np.array([size ** -(i + j) for i, j in _POWERS])
    A = np.stack([points[:, 0] ** i * points[:, 1] ** j for i, j in _POWERS], axis=1) * scale
    return np.linalg.lstsq(A * weights[:, None], points[:, 2] * weights, rcond=1e-10)[0] * scale


def height(coefficients: Array, x: Array, y: Array) -> tuple[Array, Array, Array]:
    """z and its derivatives in x and y, of x's shape, by Horner's rule in y of polynomials in x."""
    c = dict(zip(_POWERS, coefficients.tolist(), strict=True))
    z, zx, zy = (np.zeros_like(x) for _ in range(3))
    for j in range(4, -1, -1):
        inner, slope = np.zeros_like(x), np.zeros_like(x)
        for i in range(4 - j, -1, -1):
            slope = slope * x + inner
            inner = inner * x + c[i, j]
        zy = zy * y + z
        z, zx = z * y + inner, zx * y + slope
    return z, zx, zy


def sphere_quartic(curvature: float) -> Array:
    """The coefficients of the sphere of a curvature through the origin, z = ½ k r² + ⅛ k³ r⁴ on the side of -N."""
    k = curvature
    series = {(2, 0): 0.5 * k, (0, 2): 0.5 * k, (4, 0): k**3 / 8, (2, 2): k**3 / 4, (0, 4): k**3 / 8}
    return -np.array([series.get(power, 0.0) for power in _POWERS])
