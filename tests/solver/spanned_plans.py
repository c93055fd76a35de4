"""Plans and exact surfaces for tests of `span_outline`."""

from __future__ import annotations

import numpy as np
from scipy.optimize import brentq

from solver import Domain, Shape, conformal_distortion, mean_curvature_of, shapes
from solver.measure.arrays import face_areas_in_space
from tests.solver.exact_surfaces import moved


def ring(n: int, inner: float, jitter: float = 0.2, seed: int = 1) -> tuple[Domain, np.ndarray]:
    """The ring between the circles of radius 1 and `inner`, points inside moved by up to `jitter` edge lengths."""
    shape = shapes.annulus(inner, 1.0, n)
    radius = np.linalg.norm(shape.positions, axis=1)
    inside = (radius < 1.0 - 1e-9) & (radius > inner + 1e-9)
    points = moved(shape.positions, inside, jitter * shape.domain.edge_lengths.mean(), seed)
    return Domain.from_positions(points, shape.domain.faces), points


def raised(domain: Domain, points: np.ndarray, height: float) -> np.ndarray:
    """Positions (V, 3) whose inner loops lie at a height, the rest at 0."""
    positions = np.column_stack([points, np.zeros(len(points))])
    lengths = [domain.edge_lengths[edges].sum() for edges in domain.boundary_loop_edges]
    for k, loop in enumerate(domain.boundary_loops):
        positions[loop, 2] = 0.0 if k == np.argmax(lengths) else height
    return positions


def cap_error(points: np.ndarray, H: float) -> float:
    """The largest distance from the smaller cap of the sphere of radius 1/H over the unit circle."""
    return sphere_error(points, -np.sqrt(1.0 / H**2 - 1.0) * np.sign(H), 1.0 / abs(H))


def sphere_error(points: np.ndarray, centre: float, radius: float) -> float:
    """The largest distance from a sphere with its centre at this height over the origin."""
    return float(np.abs(np.linalg.norm(points - [0.0, 0.0, centre], axis=1) - radius).max())


def hemispheres(H: float) -> float:
    """The volume under the larger cap of curvature H over the unit circle."""
    h = (1.0 + np.sqrt(1.0 - H**2)) / H
    return np.pi * h * (3.0 + h**2) / 6.0


def enneper(z: np.ndarray) -> np.ndarray:
    """Enneper's surface (n, 3) at complex numbers (n,)."""
    return np.column_stack([(z - z**3 / 3).real, (z + z**3 / 3).imag, (z**2).real])


def enneper_error(points: np.ndarray) -> float:
    """The largest difference in height, at the same place seen from above."""
    w = points[:, 0] + 1j * points[:, 1]
    z = w
    for _ in range(200):
        z = w + np.conj(z) ** 3 / 3
    return float(np.abs((z**2).real - points[:, 2]).max())


def catenoid(height: float, inner: float) -> tuple[float, float]:
    """Waist c and its height z₀ of the stable catenoid r = c cosh((z - z₀) / c), r = 1 at 0 and `inner` at `height`."""
    solutions = []
    waists = np.linspace(1e-3, inner, 2001)
    for side in (1.0, -1.0):  # whether the waist lies between the circles

        def gap(c: float, side: float = side) -> float:
            return c * (np.arccosh(1.0 / c) + side * np.arccosh(inner / c)) - height

        values = [gap(c) for c in waists]
        for k in np.flatnonzero(np.diff(np.sign(values))):
            solutions.append(brentq(gap, waists[k], waists[k + 1]))
    waist = max(solutions)
    return waist, waist * np.arccosh(1.0 / waist)


def catenoid_error(points: np.ndarray, waist: float, middle: float) -> float:
    """The largest distance from a catenoid about the vertical axis, to first order."""
    along = (points[:, 2] - middle) / waist
    off = np.linalg.norm(points[:, :2], axis=1) - waist * np.cosh(along)
    return float(np.abs(off / np.cosh(along)).max())


def inside_curvature(span) -> np.ndarray:
    """H measured with the span's normals on the faces that do not touch the rim."""
    H = mean_curvature_of(span.points, span.faces, span.normals)
    return H[~np.isin(span.faces, span.domain.boundary_vertices).any(axis=1)]


def distortion(span) -> float:
    """The mean over the surface of ½ (Q + 1/Q) - 1."""
    Q = conformal_distortion(span.domain, span.points)
    areas = face_areas_in_space(span.points, span.faces)
    return float(areas @ (0.5 * (Q + 1.0 / Q) - 1.0) / areas.sum())


def quarter_disc(n: int) -> Shape:
    """A quarter of the unit disc with about n vertices; sides "side0" along x, "side1" the arc …, the last along y."""
    angle = np.linspace(0.0, 0.5 * np.pi, 33)
    arc = np.column_stack([np.cos(angle), np.sin(angle)])
    return shapes.polygon(np.vstack([[0.0, 0.0], arc]), max_edge=np.sqrt(0.9 / n))
