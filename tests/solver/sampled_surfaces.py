"""Exact surfaces of constant mean curvature, sampled: patches over a jittered grid."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Sample:
    """A triangle mesh of an exact surface: parameters (n, 2), points and normals (n, 3), faces (F, 3)."""

    parameters: Array
    points: Array
    normals: Array
    faces: NDArray[np.int32]

    @property
    def layout(self) -> Array:
        """The parameters of each face's corners, (F, 3, 2)."""
        return self.parameters[self.faces]

    @property
    def centres(self) -> Array:
        """The parameters at the middle of each face, (F, 2)."""
        return self.layout.mean(axis=1)

    @property
    def areas(self) -> Array:
        a, b, c = (self.points[self.faces[:, k]] for k in range(3))
        return 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1)


def grid(
    columns: int, rows: int, width: float, height: float, jitter: float = 0.0, seed: int = 7
) -> tuple[Array, NDArray[np.int32]]:
    """Points (n, 2) and counter-clockwise triangles over a rectangle, inner points moved at random."""
    random = np.random.default_rng(seed)
    x, y = np.meshgrid(np.linspace(0, 1, columns + 1), np.linspace(0, 1, rows + 1), indexing="ij")
    move = jitter * random.uniform(-1, 1, (2, columns - 1, rows - 1))
    x[1:-1, 1:-1] += move[0] / columns
    y[1:-1, 1:-1] += move[1] / rows
    index = np.arange(x.size, dtype=np.int32).reshape(x.shape)
    a, b, c, d = (corner.ravel() for corner in (index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:]))
    turned = random.random(len(a)) < (0.5 if jitter else 0.0)
    first = np.where(turned[:, None], np.stack([a, b, d], axis=1), np.stack([a, b, c], axis=1))
    second = np.where(turned[:, None], np.stack([b, c, d], axis=1), np.stack([a, c, d], axis=1))
    points = np.stack([width * x.ravel(), height * y.ravel()], axis=1)
    return points, np.concatenate([first, second]).astype(np.int32)


def sample(
    surface: Callable[[Array, Array], tuple[Array, Array]],
    columns: int,
    rows: int,
    size: tuple[float, float],
    jitter: float,
) -> Sample:
    """Sample `surface(t, s) -> (points, normals)` over [0, width] × [0, height]."""
    parameters, faces = grid(columns, rows, *size, jitter)
    points, normals = surface(parameters[:, 0], parameters[:, 1])
    return Sample(parameters, points, normals, faces)


def sphere(t: Array, s: Array) -> tuple[Array, Array]:
    """Radius 2 with the outer normal, in Mercator coordinates: conformal."""
    across, up = 1.0 / np.cosh(s), np.tanh(s)
    N = np.stack([across * np.cos(t), across * np.sin(t), up], axis=1)
    return 2.0 * N, N


def cylinder(t: Array, s: Array) -> tuple[Array, Array]:
    """Radius 1 with the outer normal; an isometry."""
    N = np.stack([np.cos(t), np.sin(t), np.zeros_like(t)], axis=1)
    return np.stack([np.cos(t), np.sin(t), s], axis=1), N


@dataclass(frozen=True)
class Delaunay:
    """The Delaunay surface ψ'² = c + sin² ψ with constant c and ψ(0) = `start`; `sign` +1 for f+, -1 for f-."""

    c: float
    start: float
    sign: int = 1

    def profile(self, s: Array) -> tuple[Array, Array, Array]:
        """ψ, ψ' and the height ∫ sin²ψ at s: ψ'' = sin ψ cos ψ, which is regular at turning points."""
        slope = np.sqrt(self.c + np.sin(self.start) ** 2)
        knots, back = np.unique(s, return_inverse=True)
        solution = solve_ivp(
            lambda _, y: (y[1], np.sin(y[0]) * np.cos(y[0]), np.sin(y[0]) ** 2),
            (0.0, float(knots[-1])),
            (self.start, slope, 0.0),
            method="DOP853",
            t_eval=knots,
            rtol=1e-12,
            atol=1e-12,
        )
        psi, slopes, heights = solution.y[:, back]
        return psi, slopes, heights

    def __call__(self, t: Array, s: Array) -> tuple[Array, Array]:
        psi, slope, height = self.profile(s)
        N = np.stack([np.sin(psi) * np.cos(t), np.sin(psi) * np.sin(t), np.cos(psi)], axis=1)
        g = np.stack([-slope * np.cos(t), -slope * np.sin(t), height], axis=1)
        return g + self.sign * N, self.sign * N

    def curvatures(self, s: Array) -> tuple[Array, Array]:
        """Principal curvatures along the parallel and along the meridian, at the parameters s."""
        order = np.argsort(s)
        psi, slope, _ = (values[np.argsort(order)] for values in self.profile(s[order]))
        parallel = np.sin(psi) / (np.sin(psi) - self.sign * slope)
        return parallel, 1.0 - parallel


NODOID = Delaunay(0.5, 0.4)
NODOID_TWIN = Delaunay(0.5, 0.4, -1)
UNDULOID = Delaunay(-0.6, np.pi / 2)
UNDULOID_TWIN = Delaunay(-0.6, np.pi / 2, -1)
