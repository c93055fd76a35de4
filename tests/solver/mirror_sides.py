"""Plans with mirrors along their sides, and grids of halved squares."""

from __future__ import annotations

import numpy as np

from solver import Domain, conditions

E_X, E_Y, E_Z = np.eye(3)


def mirrors(shape, **normals):
    total = conditions.Conditions()
    for side, normal in normals.items():
        total = total + conditions.mirror(shape.domain, shape.sides[side], normal)
    return total


def quad_grid(count, corners):
    """The unit square in count² squares, each of two triangles: positions (V, 2) and domain."""
    x, y = (a.ravel() for a in np.meshgrid(np.arange(count + 1), np.arange(count + 1), indexing="ij"))
    first = ((count + 1) * x + y)[(x < count) & (y < count)]
    quads = np.column_stack([first, first + count + 1, first + count + 2, first + 1])
    points = np.column_stack([x, y]) / count
    return points, Domain.from_positions(points, np.concatenate([quads[:, c] for c in corners]))
