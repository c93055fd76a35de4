"""The size field of a plan: the edge length at each point, in units of the wanted length.

It is 1 wherever the plan allows, less at bends and narrow places, and grows away from them by `GROWTH` a unit of
distance.
"""

from __future__ import annotations

import numpy as np
from scipy.spatial import KDTree

GROWTH = 0.3


class SizeField:
    """The edge length at a point: at most 1, less near the `places` (n, 2) whose `sizes` (n,) are less.

    The sizes must already grow by at most `GROWTH` a unit of distance between places; see `graded`.
    """

    def __init__(self, places: np.ndarray, sizes: np.ndarray) -> None:
        small = sizes < 0.98
        self._places, self._sizes = places[small], sizes[small]
        self._tree = KDTree(self._places) if small.any() else None

    def __call__(self, points: np.ndarray) -> np.ndarray:
        return np.minimum(1.0, self._grown(points, 1.0))

    def room(self, points: np.ndarray, most: float) -> np.ndarray:
        """The radius around each point, up to `most`, in which the full length holds; negative where it does not."""
        return np.minimum(most, (self._grown(points, 1.0 + most * GROWTH) - 1.0) / GROWTH)

    def _grown(self, points: np.ndarray, most: float) -> np.ndarray:
        if self._tree is None:
            return np.full(len(points), np.inf)
        # The sizes are graded, so a few near places decide.
        count = min(8, len(self._places))
        reach = (most - self._sizes.min()) / GROWTH
        distance, index = self._tree.query(points, k=count, distance_upper_bound=reach)
        grown = np.append(self._sizes, np.inf)[index] + GROWTH * np.minimum(distance, reach)
        return grown.reshape(len(points), count).min(axis=1)


def graded(places: np.ndarray, sizes: np.ndarray) -> np.ndarray:
    """The largest sizes below `sizes` that grow by no more than `GROWTH` a unit of distance between places."""
    result = sizes.copy()
    small = np.flatnonzero(sizes < 0.98)
    if len(small):
        reach = (1 - sizes[small].min()) / GROWTH
        near = KDTree(places).sparse_distance_matrix(KDTree(places[small]), reach, output_type="ndarray")
        np.minimum.at(result, near["i"], sizes[small][near["j"]] + GROWTH * near["v"])
    return result


def graded_along(length: np.ndarray, sizes: np.ndarray) -> np.ndarray:
    """Graded sizes along a closed curve: piece k of `length` (n,) leads from sample k to sample k + 1."""
    twice = np.concatenate([[0.0], np.cumsum(np.tile(length, 2))[:-1]])
    double = np.tile(sizes, 2)
    ahead = np.minimum.accumulate(double - GROWTH * twice) + GROWTH * twice
    back = np.minimum.accumulate((double + GROWTH * twice)[::-1])[::-1] - GROWTH * twice
    return np.minimum(ahead[len(sizes) :], back[: len(sizes)])
