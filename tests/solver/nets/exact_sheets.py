"""Exact surfaces as sheets, with what their Hopf differential is in the coordinates of their parameters."""

from __future__ import annotations

import numpy as np

from solver import Domain
from solver.nets.sheets import Sheet
from tests.solver.exact_surfaces import Nodoid, cylinder, disc
from tests.solver.sampled_surfaces import Delaunay


def nodoid(columns: int, sign: int = 1, c: float = 0.5) -> tuple[Sheet, np.ndarray]:
    """f± of a Delaunay surface, with the sheet's normals ±N, and the parameters (F, 3) of the corners; Q = -c."""
    exact = Nodoid(c)
    domain, points = cylinder(exact.height, columns)
    N, g = exact(points)
    return Sheet(domain, g + sign * N, sign * N, 0.5), unrolled(domain, points)


def unduloid(columns: int, c: float = -0.6) -> tuple[Sheet, np.ndarray]:
    """f+ of the Delaunay surface ψ'² = c + sin² ψ from one bulge to the next neck; Q = -c."""
    domain, points = cylinder(2.0, columns)
    f, N = Delaunay(c, 0.5 * np.pi)(points[:, 0], points[:, 1])
    return Sheet(domain, f, N, 0.5), unrolled(domain, points)


def unrolled(domain: Domain, points: np.ndarray) -> np.ndarray:
    """Corners (F, 3) as complex numbers t + is, those across t = 2π beside the others."""
    corners = points[domain.faces]
    across = corners[:, :, 0] - corners[:, :1, 0]
    corners[:, :, 0] -= 2.0 * np.pi * np.round(across / (2.0 * np.pi))
    return corners[..., 0] + 1j * corners[..., 1]


def catenoid(columns: int, height: float = 2.0) -> tuple[Sheet, np.ndarray]:
    """(cosh s cos t, cosh s sin t, s) with the outward normal; Q = 2: parallels have the larger curvature."""
    domain, points = cylinder(height, columns)
    t, s = points[:, 0], points[:, 1] - 0.5 * height
    X = np.column_stack([np.cosh(s) * np.cos(t), np.cosh(s) * np.sin(t), s])
    N = np.column_stack([np.cos(t), np.sin(t), -np.sinh(s)]) / np.cosh(s)[:, None]
    return Sheet(domain, X, N, 0.0), unrolled(domain, points)


def enneper(n: int, size: float = 0.8) -> tuple[Sheet, np.ndarray]:
    """Enneper's surface over a disc; Q = 4."""
    domain, points = disc(n)
    z = size * (points[:, 0] + 1j * points[:, 1])
    X = np.column_stack([(z - z**3 / 3).real, -(z + z**3 / 3).imag, (z**2).real])
    N = np.column_stack([2.0 * z.real, 2.0 * z.imag, np.abs(z) ** 2 - 1.0]) / (1.0 + np.abs(z) ** 2)[:, None]
    domain = Domain.from_positions(size * points, domain.faces)
    return Sheet(domain, X, N, 0.0), (points[:, 0] + 1j * points[:, 1])[domain.faces]


def in_parameters(q: np.ndarray, corners: np.ndarray) -> np.ndarray:
    """q (F,) of the layouts of faces, in the parameters that their corners (F, 3) have."""
    along = corners[:, 1] - corners[:, 0]
    return q * (np.conj(along) / np.abs(along)) ** 2
