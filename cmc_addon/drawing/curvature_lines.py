"""Strokes along lines of curvature: where they are, evenly spread over a surface, and their ends. Arrays only."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial import KDTree

Array = NDArray[np.float64]
Int = NDArray[np.integer]

# Distance between strokes as a part of the size of a surface, unless it is chosen.
_DEFAULT = 1.0 / 40.0
# Length of a stroke as a part of the distance.
_LENGTH = 0.62
# No more strokes than this, whatever distance is chosen.
_MOST = 20000


def default_spacing(points: Array) -> float:
    """Distance between strokes that suits the size of a surface with these points (n, 3)."""
    return default_spacing_of(np.ptp(points, axis=0)) if len(points) else 0.0


def default_spacing_of(extent: ArrayLike) -> float:
    """The same from the extent (3,) of the surface along the axes."""
    return _DEFAULT * float(np.linalg.norm(extent))


def spread(points: Array, spacing: float) -> Int:
    """Indices of some of the points (n, 3), none nearer to another than the spacing, and no place left between them.

    The same for the same points: they are gone through in an order that depends on their number only. At most 20000.
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


def curvature_lines(points: Array, normals: Array, lines: Array, which: str, spacing: float) -> tuple[Array, Array]:
    """Ends (k, 2, 3) of strokes along the larger principal curvature and of those along the smaller one.

    points, normals and lines (m, 3): where strokes are, and there the unit normal and the direction of the larger
    curvature, zero where there is none. which: "MAX", "MIN" or "BOTH".
    """
    known = np.linalg.norm(lines, axis=1) > 0.5
    at, along = points[known], lines[known]
    across = np.cross(normals[known], along)
    none = np.zeros((0, 2, 3))
    first = _ends(at, along, spacing) if which in ("MAX", "BOTH") else none
    second = _ends(at, across, spacing) if which in ("MIN", "BOTH") else none
    return first, second


def _ends(at: Array, along: Array, spacing: float) -> Array:
    half = 0.5 * _LENGTH * spacing * along
    return np.stack([at - half, at + half], axis=1)
