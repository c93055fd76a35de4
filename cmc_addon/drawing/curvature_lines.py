"""Curvature lines: short lines along the principal curvatures, spread evenly over a surface. Arrays only."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial import KDTree

Array = NDArray[np.float64]
Int = NDArray[np.integer]

# Default distance between the lines, as a part of the size of the surface.
_DEFAULT = 1.0 / 40.0
# Length of a line as a part of the distance.
_LENGTH = 0.62
# Largest number of lines, however short the distance.
_MOST = 20000


def default_spacing(points: Array) -> float:
    """Distance between the lines that suits a surface with points (n, 3)."""
    return default_spacing_of(np.ptp(points, axis=0)) if len(points) else 0.0


def default_spacing_of(extent: ArrayLike) -> float:
    """The same from the extent (3,) of the surface along the axes."""
    return _DEFAULT * float(np.linalg.norm(extent))


def spread(points: Array, spacing: float) -> Int:
    """Indices of a maximal subset of points (n, 3) at least the spacing apart; at most 20000.

    Reproducible: the points are visited in an order that depends on their number only.
    """
    if not len(points) or spacing <= 0.0:
        return np.zeros(0, dtype=np.int64)
    order = np.random.default_rng(1).permutation(len(points))
    tree, taken, kept = KDTree(points), np.zeros(len(points), dtype=bool), []
    for index in order.tolist():
        if taken[index]:
            continue
        kept.append(index)
        taken[tree.query_ball_point(points[index], spacing)] = True
        if len(kept) == _MOST:
            break
    return np.array(kept, dtype=np.int64)


def curvature_lines(
    points: Array, normals: Array, directions: Array, which: str, spacing: float
) -> tuple[Array, Array]:
    """Ends (k, 2, 3) of the lines along the larger principal curvature, and of those along the smaller one.

    points, normals and directions (m, 3): the midpoints, their unit normals and the directions of the larger curvature,
    zero at umbilics. which: "MAX", "MIN" or "BOTH".
    """
    known = np.linalg.norm(directions, axis=1) > 0.5
    at, along = points[known], directions[known]
    across = np.cross(normals[known], along)
    none = np.zeros((0, 2, 3))
    first = _ends(at, along, spacing) if which in ("MAX", "BOTH") else none
    second = _ends(at, across, spacing) if which in ("MIN", "BOTH") else none
    return first, second


def _ends(at: Array, along: Array, spacing: float) -> Array:
    half = 0.5 * _LENGTH * spacing * along
    return np.stack([at - half, at + half], axis=1)
