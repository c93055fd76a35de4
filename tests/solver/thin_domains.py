"""Domains that are far from Delaunay: sheared, stretched, with few vertices; and their angles."""

from __future__ import annotations

import numpy as np
from scipy.spatial import Delaunay

from solver import Domain, shapes
from tests.solver import meshes, tiny_domains

WITH_HOLES = (
    [(0, 0), (4, 0), (4, 3), (0, 3)],
    [[(0.5, 0.5), (1.5, 0.5), (1.5, 1.5), (0.5, 1.5)], [(2.3, 1.2), (3.4, 1.2), (3.4, 2.4), (2.3, 2.4)]],
)


def sheared_grid(columns: int = 20, rows: int = 6, shear: float = 3.3) -> tuple[np.ndarray, np.ndarray]:
    x, y = (a.ravel() for a in np.meshgrid(np.arange(columns), np.arange(rows), indexing="ij"))
    i, j = (a.ravel() for a in np.meshgrid(np.arange(columns - 1), np.arange(rows - 1), indexing="ij"))
    o = i * rows + j
    faces = np.concatenate([np.column_stack([o, o + rows, o + rows + 1]), np.column_stack([o, o + rows + 1, o + 1])])
    return np.column_stack([x + shear * y, y]).astype(float), faces


def stretched(factor: float, n: int = 400, seed: int = 3) -> tuple[np.ndarray, np.ndarray]:
    """Random points in a square, triangulated well, then drawn apart in y: needles."""
    points = np.random.default_rng(seed).random((n, 2)) * [1.0, factor]
    return points, stretched_faces(points, 1.0 / factor)


def stretched_faces(points: np.ndarray, factor: float) -> np.ndarray:
    """Triangles that would be good ones if y were `factor` times as large; counter-clockwise."""
    faces = Delaunay(points * [1.0, factor]).simplices
    a, b, c = (points[faces[:, k]] for k in range(3))
    twice = (b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]
    faces = np.where((twice < 0)[:, None], faces[:, ::-1], faces)
    return faces[np.abs(twice) > 1e-9 * np.abs(twice).max()]


def thin_strip() -> tuple[np.ndarray, np.ndarray]:
    """Fans across a strip, 40 times as long as wide, with vertices at its two long sides only."""
    n = 30
    x = np.linspace(0, 40, n)
    points = np.concatenate([np.column_stack([x, 0 * x]), np.column_stack([x, 0 * x + 1])])
    k = np.arange(n - 1)
    # all of the bottom hangs on the first vertex of the top, all of the top on the last one of the bottom
    faces = np.concatenate([np.column_stack([k, k + 1, 0 * k + n]), np.column_stack([n + k + 1, n + k, 0 * k + n - 1])])
    return points, faces


FLAT = {
    "a sheared grid": sheared_grid,
    "needles": lambda: stretched(30.0),
    "finer needles": lambda: stretched(1e3),
    "a thin strip": thin_strip,
}
DOMAINS = {name: lambda make=make: Domain.from_positions(*make()) for name, make in FLAT.items()} | {
    "a stretched annulus": lambda: Domain.from_positions(
        shapes.annulus(0.4, 1.0, 300).positions * [1, 5], shapes.annulus(0.4, 1.0, 300).domain.faces
    ),
    "two holes, stretched": lambda: Domain.from_positions(
        shapes.polygon(*WITH_HOLES, max_edge=0.3).positions * [1, 7],
        shapes.polygon(*WITH_HOLES, max_edge=0.3).domain.faces,
    ),
    "a twisted sphere": lambda: Domain.from_positions(*_twisted_sphere()),
    "a torus in space": lambda: Domain.from_positions(*meshes.torus(20, 8, 0.8, 14)),
    "a torus of one vertex": lambda: tiny_domains.small_torus(1, 1, (1.0, 0.0), (5.3, 1.0)),
    "a torus of nine vertices": lambda: tiny_domains.small_torus(3, 3, (1.0, 0.0), (5.3, 1.0)),
    "seven vertices": lambda: tiny_domains.seven_vertex_torus((1.0, 0.0), (2.03, 0.1)),
    "a cylinder of one column": lambda: tiny_domains.small_cylinder(1, (1.0, 0.0), (3.3, 1.0)),
    "a cylinder of two columns": lambda: tiny_domains.small_cylinder(2, (1.0, 0.0), (3.3, 1.0)),
    "a cylinder of three columns": lambda: tiny_domains.small_cylinder(3, (1.0, 0.0), (3.3, 1.0)),
    "a tube": lambda: tiny_domains.helix(9, (0.4, 1.0), (1.8, 2.0)),
}


def _twisted_sphere():
    points, faces = meshes.sphere(300, 0.3)
    return meshes.twisted(points, 20.0), faces


def opposite_angles(domain: Domain) -> np.ndarray:
    """(n,) sum of the two angles opposite each interior edge."""
    return np.bincount(domain.face_edges.ravel(), domain.corner_angles.ravel())[domain.interior_edges]
