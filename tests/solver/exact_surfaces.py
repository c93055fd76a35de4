"""Jittered domains and exact surfaces of mean curvature ½ on them, for tests of rates."""

from __future__ import annotations

import numpy as np
from scipy.integrate import quad, solve_ivp

from solver import Domain, shapes


def moved(points: np.ndarray, inside: np.ndarray, amount: float, seed: int) -> np.ndarray:
    """Points, those `inside` moved at random by up to `amount` along each axis."""
    random = np.random.default_rng(seed)
    return points + amount * random.uniform(-1, 1, points.shape) * inside[:, None]


def disc(n: int, jitter: float = 0.2, seed: int = 1) -> tuple[Domain, np.ndarray]:
    """The unit disc with about n vertices, inside ones moved by up to `jitter` edge lengths."""
    shape = shapes.disc(n)
    inside = np.linalg.norm(shape.positions, axis=1) < 1 - 1e-9
    points = moved(shape.positions, inside, jitter * shape.domain.edge_lengths.mean(), seed)
    return Domain.from_positions(points, shape.domain.faces), points


def cylinder(height: float, columns: int, jitter: float = 0.25, seed: int = 1) -> tuple[Domain, np.ndarray]:
    """A cylinder of circumference 2π; unrolled positions (V, 2), loops at y = 0 (first) and y = height."""
    shape = shapes.cylinder(2 * np.pi, height, columns)
    inside = (shape.positions[:, 1] > 1e-9) & (shape.positions[:, 1] < height - 1e-9)
    points = moved(shape.positions, inside, jitter * 2 * np.pi / columns, seed)
    corners = points[shape.domain.faces]
    across = corners[:, :, 0] - corners[:, :1, 0]
    corners[:, :, 0] -= 2 * np.pi * np.round(across / (2 * np.pi))
    return Domain.from_corners(shape.domain.faces, corners), points


def hemisphere(points: np.ndarray) -> np.ndarray:
    """Outward normals (V, 3) of the conformal hemisphere over the unit disc."""
    r2 = np.sum(points**2, axis=1, keepdims=True)
    return np.hstack([2 * points, 1 - r2]) / (1 + r2)


class Nodoid:
    """The Delaunay surface N = (cos ψ, sin ψ cos t, sin ψ sin t), ψ'² = c + sin² ψ, ψ from 0 to π: normals
    ±e₁ at its ends.

    g = (∫ sin² ψ, -ψ' cos t, -ψ' sin t), f± = g ± N.
    """

    def __init__(self, c: float = 0.5) -> None:
        self.c = c
        self.height = quad(lambda p: 1 / np.sqrt(c + np.sin(p) ** 2), 0, np.pi)[0]
        self.energy = np.pi * (
            c * self.height + 2 * quad(lambda p: np.sin(p) ** 2 / np.sqrt(c + np.sin(p) ** 2), 0, np.pi)[0]
        )
        self._profile = solve_ivp(
            lambda s, y: [np.sqrt(c + np.sin(y[0]) ** 2), np.sin(y[0]) ** 2],
            (0, self.height),
            [0.0, 0.0],
            dense_output=True,
            rtol=1e-11,
            atol=1e-12,
        ).sol

    def __call__(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """N and g (V, 3) at (t, s)."""
        t, s = points.T
        psi, along = self._profile(np.clip(s, 0, self.height))
        slope = np.sqrt(self.c + np.sin(psi) ** 2)
        N = np.column_stack([np.cos(psi), np.sin(psi) * np.cos(t), np.sin(psi) * np.sin(t)])
        g = np.column_stack([along, -slope * np.cos(t), -slope * np.sin(t)])
        return N, g


def rates(errors: list[float]) -> np.ndarray:
    """Observed orders of convergence, the edge length halving from one error to the next."""
    values = np.asarray(errors)
    return np.log2(values[:-1] / values[1:])
