"""Smooth curves through the points of drawn lines: cubic splines, split at sharp corners, straight along straight runs.

A spline through points h apart is O(h⁴) off the smooth curve that they were taken from. Where a straight run meets an
arc it is C¹, elsewhere C². Its parameter s is the length of the polyline.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicHermiteSpline, CubicSpline

Array = NDArray[np.float64]
Int = NDArray[np.integer]

# Turns of a polyline sharper than the first are corners: an arc of two segments a right angle would be one. Those
# sharper than the second are, too, where they are this multiple of the turns at both neighbours.
_SHARP = np.radians(35.0)
_SINGLE = np.radians(25.0)
_ALONE = 3.0
# Sine of the turn up to which a polyline goes straight on: single precision leaves 1e-6.
_STRAIGHT = 1e-5
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
        straight = _straight_segments(way, self.closed)
        if straight.any() and not straight.all():
            return CubicHermiteSpline(self.knots, way, _slopes(self.knots, way, straight, self.closed))
        return CubicSpline(self.knots, way, bc_type="periodic" if self.closed else "not-a-knot")

    def at(self, s: Array) -> tuple[Array, Array, Array]:
        """γ, γ' and γ'' (n, 3) at s (n,)."""
        s = s % self.length if self.closed else s
        return self._spline(s), self._spline(s, 1), self._spline(s, 2)

    def wrapped(self, change: Array) -> Array:
        """Differences of s, on a closed curve between -½ and ½ of its length."""
        return (change + 0.5 * self.length) % self.length - 0.5 * self.length if self.closed else change


def _straight_segments(way: Array, closed: bool) -> NDArray[np.bool_]:
    """(m - 1,) which segments of a polyline (m, 3) continue a neighbour straight on."""
    ahead = np.diff(way, axis=0)
    turned = np.linalg.norm(np.cross(ahead[:-1], ahead[1:]), axis=1)
    on = (turned < _STRAIGHT * np.linalg.norm(ahead[:-1], axis=1) * np.linalg.norm(ahead[1:], axis=1)).tolist()
    around = np.linalg.norm(np.cross(ahead[-1], ahead[0])) < _STRAIGHT * np.linalg.norm(ahead[-1]) * np.linalg.norm(
        ahead[0]
    )
    end = [bool(closed and around)]
    joints = np.array([*end, *on, *end])
    return joints[:-1] | joints[1:]


def _slopes(knots: Array, way: Array, straight: NDArray[np.bool_], closed: bool) -> Array:
    """γ' (m, 3) at the knots: that of the line along straight runs, and between them that of a spline with these ends.

    Where an arc begins the curvature jumps, and a spline through both would swing about the line.
    """
    count = len(straight)
    way_out = np.diff(way, axis=0) / np.diff(knots)[:, None]
    slopes = np.empty_like(way)
    slopes[:-1][straight] = way_out[straight]
    slopes[1:][straight] = way_out[straight]
    if closed:  # the first knot is the last, too
        if straight[-1]:
            slopes[0] = slopes[-1]
        else:
            slopes[-1] = slopes[0]
    first = int(np.argmax(straight)) if closed else 0  # a closed curve is walked from a straight segment on
    order = (first + np.arange(count)) % count
    bends = np.flatnonzero(~straight[order])
    for run in np.split(bends, np.flatnonzero(np.diff(bends) > 1) + 1):
        segments = order[run]
        steps = np.diff(knots)[segments]
        s = np.concatenate([[0.0], np.cumsum(steps)])
        points = np.concatenate([way[segments], way[segments[-1:] + 1]])
        ends: Any = [
            (1, slopes[segments[0]]) if run[0] > 0 or closed else (2, np.zeros(3)),
            (1, slopes[segments[-1] + 1]) if run[-1] < count - 1 or closed else (2, np.zeros(3)),
        ]
        made = CubicSpline(s, points, bc_type=ends)
        slopes[segments], slopes[segments[-1] + 1] = made(s[:-1], 1), made(s[-1], 1)
    if closed:
        slopes[-1] = slopes[0]
    return slopes


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
