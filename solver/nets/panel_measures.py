"""Measures of panels with k corners: planarity, diagonal, area and angles, of many at once."""

from __future__ import annotations

from itertools import combinations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

# Panels with more corners are measured in the direction of least variance alone.
_EXACT = 8


def vector_area(corners: Array) -> Array:
    """½ Σ p_i × p_{i+1} (p, 3) of panels with corners (p, k, 3), about their means."""
    about = corners - corners.mean(axis=1, keepdims=True)
    return 0.5 * np.cross(about, np.roll(about, -1, axis=1)).sum(axis=1)


def longest_diagonal(corners: Array) -> Array:
    """The largest distance (p,) of two corners."""
    apart = np.linalg.norm(corners[:, :, None] - corners[:, None], axis=3)
    return apart.max(axis=(1, 2))


def corner_angles(corners: Array) -> Array:
    """The angles (p, k) between the two sides at each corner, in radians."""
    before = np.roll(corners, 1, axis=1) - corners
    after = np.roll(corners, -1, axis=1) - corners
    across = np.linalg.norm(np.cross(before, after), axis=2)
    return np.arctan2(across, np.einsum("pkd,pkd->pk", before, after))


def least_width(corners: Array) -> Array:
    """The least distance (p,) of two parallel planes with all corners (p, k, 3) between them.

    Two such planes touch a face and a corner of the convex hull, or two of its edges: all are tried.
    """
    count = corners.shape[1]
    if count <= 3:
        return np.zeros(len(corners))
    if count > _EXACT:
        about = corners - corners.mean(axis=1, keepdims=True)
        direction = np.linalg.svd(about, full_matrices=False)[2][:, 2]
        return np.ptp(np.einsum("pkd,pd->pk", about, direction), axis=1)
    width = np.full(len(corners), np.inf)
    triples = [(i, j, i, k) for i, j, k in combinations(range(count), 3)]
    pairs = list(combinations(range(count), 2))
    crossed = [(*one, *two) for one, two in combinations(pairs, 2) if not set(one) & set(two)]
    size = longest_diagonal(corners)
    for i, j, k, m in triples + crossed:
        normal = np.cross(corners[:, j] - corners[:, i], corners[:, m] - corners[:, k])
        length = np.linalg.norm(normal, axis=1)
        proper = length > 1e-9 * size**2
        across = np.ptp(np.einsum("pkd,pd->pk", corners - corners[:, :1], normal), axis=1)
        width = np.where(proper, np.minimum(width, across / np.where(proper, length, 1.0)), width)
    return np.where(np.isfinite(width), width, 0.0)
