"""Flat domains of few vertices, in which two edges may join the same vertices, or an edge a vertex to itself.

All are triangulations of a lattice with the basis u, v, rolled up: the triangles (p, p + u, p + u + v) and
(p, p + u + v, p + v) for p in the lattice.
"""

from __future__ import annotations

import numpy as np

from solver import Domain


def small_torus(columns: int, rows: int, u: tuple[float, float], v: tuple[float, float]) -> Domain:
    """Lattice points a u + b v with a modulo `columns` and b modulo `rows`; one by one is a single vertex."""
    a, b = (grid.ravel() for grid in np.meshgrid(np.arange(columns), np.arange(rows), indexing="ij"))
    number = lambda da, db: (a + da) % columns * rows + (b + db) % rows  # noqa: E731
    return _from_lattice(number, u, v)


def small_cylinder(columns: int, u: tuple[float, float], v: tuple[float, float]) -> Domain:
    """One row of quads around a cylinder: bottom vertices 0 … columns - 1, then the top ones."""
    a = np.arange(columns)
    return _from_lattice(lambda da, db: (a + da) % columns + db * columns, u, v)


def seven_vertex_torus(u: tuple[float, float], v: tuple[float, float]) -> Domain:
    """Möbius' torus, in which every two of the seven vertices are joined by one edge: a u + b v is vertex a + 2 b."""
    k = np.arange(7)
    return _from_lattice(lambda da, db: (k + da + 2 * db) % 7, u, v)


def helix(n: int, u: tuple[float, float], v: tuple[float, float]) -> Domain:
    """A tube of vertices 0 … n - 1 along a helix, a u + b v being vertex a + 2 b; a loop of three at either end.

    Its axis is along `v - 2 u`, turned by 90°.
    """
    k = np.arange(n - 3)
    return _from_lattice(lambda da, db: k + da + 2 * db, u, v)


def helix_height(n: int, u: tuple[float, float], v: tuple[float, float]) -> np.ndarray:
    """The position (n,) of each vertex of `helix` along its axis."""
    around = np.subtract(v, np.multiply(2.0, u))
    axis = np.array([-around[1], around[0]]) / np.linalg.norm(around)
    return np.arange(n) * float(axis @ u)


def edge_vectors(domain: Domain, u: tuple[float, float], v: tuple[float, float]) -> np.ndarray:
    """The lattice vector (E, 2) along each edge of one of these domains."""
    a, b = np.array(u), np.array(v)
    sides = np.array([[b, -a - b, a], [-a, -b, a + b]])
    return sides.repeat(len(domain.faces) // 2, axis=0).reshape(-1, 2)[domain.half_edges[:, 0]]


def _from_lattice(number, u: tuple[float, float], v: tuple[float, float]) -> Domain:
    """Two triangles at every lattice point p; `number(a, b)` is the vertex at p + a u + b v, for all p at once."""
    o, right, across, up = number(0, 0), number(1, 0), number(1, 1), number(0, 1)
    faces = np.concatenate([np.column_stack([o, right, across]), np.column_stack([o, across, up])])
    a, b, c = (float(np.hypot(*w)) for w in (u, v, np.add(u, v)))
    lengths = np.repeat([[b, c, a], [a, b, c]], len(o), axis=0)
    # an edge is the lattice point that it starts from and its direction: along u, along v, across
    kinds = np.concatenate([np.column_stack([right, o, o]), np.column_stack([up, o, o])])
    direction = np.repeat([[1, 2, 0], [0, 1, 2]], len(o), axis=0)
    face_edges = np.unique(3 * kinds + direction, return_inverse=True)[1].reshape(-1, 3)
    return Domain.from_edge_lengths(faces, lengths, face_edges=face_edges)
