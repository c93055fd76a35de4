"""Smooth curves through the points of drawn lines: C² cubic splines, split at sharp corners.

A spline through points h apart is O(h⁴) off the smooth curve that they were taken from; along straight runs that end in
corners it is straight. Its parameter s is the length of the polyline.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

Array = NDArray[np.float64]
Int = NDArray[np.integer]

# Turns of a polyline sharper than the first are corners: an arc of two segments a right angle would be one. Those
# sharper than the second are, too, where they are this multiple of the turns at both neighbours.
_SHARP = np.radians(35.0)
_SINGLE = np.radians(25.0)
_ALONE = 3.0
# Points closer than this part of the length are one.
_SAME = 1e-9


@dataclass(frozen=True, eq=False)
class SmoothCurve:
    """A curve γ through `points` (m, 3); a closed one returns to its first point. s runs from 0 to `length`."""

    points: Array
    closed: bool

    @cached_property
    def knots(self) -> Array:
        """s at the points; at the return to the first one, too, if the curve is closed."""
        way = np.concatenate([self.points, self.points[:1]]) if self.closed else self.points
        return np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(way, axis=0), axis=1))])

    @property
    def length(self) -> float:
        """Of the polyline: the period of s on a closed curve."""
        return float(self.knots[-1])

    @cached_property
    def _spline(self) -> Any:  # scipy ships no types
        way = np.concatenate([self.points, self.points[:1]]) if self.closed else self.points
        return CubicSpline(self.knots, way, bc_type="periodic" if self.closed else "not-a-knot")

    def at(self, s: Array) -> tuple[Array, Array, Array]:
        """γ, γ' and γ'' (n, 3) at s (n,)."""
        s = s % self.length if self.closed else s
        return self._spline(s), self._spline(s, 1), self._spline(s, 2)

    def wrapped(self, change: Array) -> Array:
        """Differences of s, on a closed curve between -½ and ½ of its length."""
        return (change + 0.5 * self.length) % self.length - 0.5 * self.length if self.closed else change


def turns(points: Array) -> Array:
    """(m,) by how much a closed polyline turns at each of its points, in radians, 0 to π."""
    ahead = np.roll(points, -1, axis=0) - points
    behind = np.roll(ahead, 1, axis=0)
    return np.arctan2(np.linalg.norm(np.cross(behind, ahead), axis=1), np.einsum("ij,ij->i", behind, ahead))


def corners(points: Array) -> Int:
    """Places of the sharp corners of a closed polyline (m, 3), sorted."""
    turn = turns(points)
    around = np.maximum(np.roll(turn, 1), np.roll(turn, -1))
    return np.flatnonzero((turn > _SHARP) | ((turn > _SINGLE) & (turn > _ALONE * around)))


def without_repeats(points: Array) -> Array:
    """A closed polyline (m, 3) without points that coincide with the one before them."""
    steps = np.linalg.norm(points - np.roll(points, 1, axis=0), axis=1)
    return points[steps > _SAME * steps.sum()]


def enclosed(points: Array) -> float:
    """The area that a closed polyline encloses, seen from above; positive where it runs counter-clockwise."""
    x, y = points[:, 0], points[:, 1]
    return 0.5 * float(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)))
