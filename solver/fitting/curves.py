"""Polylines in space, open or closed: lengths, samples, closest points."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Int = NDArray[np.integer]

# Pairs of points and segments compared at once.
_CHUNK = 2_000_000
# Points nearer to each other than this part of the length are one.
_SAME = 1e-9


class Closest(NamedTuple):
    """Points (n, 3) of a curve; each `along` (n,) its segment, from 0 at point `start` to 1 at point `end`."""

    points: Array
    start: Int
    end: Int
    along: Array


@dataclass(frozen=True, eq=False)
class Curve:
    """points: (m, 3), joined in order; a closed curve returns to its first point."""

    points: Array
    closed: bool

    @property
    def _segments(self) -> tuple[Int, Int]:
        count = len(self.points)
        start = np.arange(count if self.closed else count - 1)
        return start, (start + 1) % count

    @cached_property
    def lengths(self) -> Array:
        start, end = self._segments
        return np.linalg.norm(self.points[end] - self.points[start], axis=1)

    @property
    def length(self) -> float:
        return float(self.lengths.sum())

    @cached_property
    def shares(self) -> Array:
        """(m,) half of the segments at each point, as parts of the length."""
        start, end = self._segments
        count = len(self.points)
        return 0.5 * (np.bincount(start, self.lengths, count) + np.bincount(end, self.lengths, count)) / self.length

    @cached_property
    def samples(self) -> Array:
        """(n, 3) evenly spaced points, about two per segment, from 200 to 1000."""
        return self.at(np.arange(n := int(np.clip(2 * len(self.points), 200, 1000))) / n)

    def at(self, fraction: Array) -> Array:
        """Points (n, 3) at parts (n,) of the length, from the first point."""
        start, end = self._segments
        ends = np.cumsum(self.lengths)
        place = np.asarray(fraction) * ends[-1]
        k = np.clip(np.searchsorted(ends, place, side="right"), 0, len(start) - 1)
        along = (place - (ends[k] - self.lengths[k])) / np.maximum(self.lengths[k], 1e-300)
        return self.points[start[k]] + along[:, None] * (self.points[end[k]] - self.points[start[k]])

    def closest(self, points: Array) -> Closest:
        """The closest points of the curve, over all segments."""
        chunks = np.array_split(points, max(1, len(points) * len(self.points) // _CHUNK + 1))
        return Closest(*(np.concatenate(parts) for parts in zip(*map(self._closest, chunks), strict=True)))

    def between(self, first: Array, last: Array) -> Curve:
        """The open piece of a closed curve from its place nearest to a point (3,) to that nearest to another."""
        ends = self.closest(np.stack([first, last]))
        start, stop = (int(k) for k in ends.start)
        steps = (stop - start) % len(self.points)
        if steps == 0 and ends.along[1] <= ends.along[0]:
            steps = len(self.points)
        inner = self.points[(start + 1 + np.arange(steps)) % len(self.points)]
        way = np.concatenate([ends.points[:1], inner, ends.points[1:]])
        apart = np.linalg.norm(np.diff(way, axis=0), axis=1) > _SAME * self.length
        return Curve(np.concatenate([way[:-1][apart], way[-1:]]), closed=False)

    def _closest(self, points: Array) -> Closest:
        start, end = self._segments
        a, d = self.points[start], self.points[end] - self.points[start]
        squares = np.maximum(np.einsum("mi,mi->m", d, d), 1e-300)
        along = np.clip((points @ d.T - np.einsum("mi,mi->m", a, d)) / squares, 0.0, 1.0)
        # |p - a - t d|² without its part |p|²
        far = -2.0 * (points @ a.T) + np.einsum("mi,mi->m", a, a) + along**2 * squares
        far += 2.0 * along * (np.einsum("mi,mi->m", a, d) - points @ d.T)
        k = np.argmin(far, axis=1)
        t = along[np.arange(len(points)), k]
        return Closest(a[k] + t[:, None] * d[k], start[k], end[k], t)
