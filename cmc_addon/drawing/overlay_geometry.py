"""Geometry of the overlay: arrows, dashes, plates and walls as lines and triangles. Arrays only.

Lines are ends (n, 2, 3), triangles corners (n, 3, 3). Lengths are those of the points.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .rim import Walk

Array = NDArray[np.float64]

# The head of an arrow: its length as a part of the arrow, half its width as a part of that, its number of sides.
_HEAD, _SPREAD, _SIDES = 0.28, 0.32, 8
# A vector shorter than this part of another has no direction.
_TINY = 1e-6

NOWHERE = np.zeros((0, 3))
NO_LINES = np.zeros((0, 2, 3))
NO_TRIANGLES = np.zeros((0, 3, 3))


# --- where along the rim --------------------------------------------------------------------

def spread(walk: Walk, spacing: float) -> tuple[Array, Array, Array]:
    """Points, normals and tangents (n, 3) along a walk, evenly spaced in arc length and not nearer than `spacing`.

    They are the vertices if these are no denser; otherwise points between them, with interpolated normals. The ends of
    a walk, where another group begins, are left out. A single edge gives its midpoint.
    """
    steps = np.diff(walk.points, axis=0)
    lengths = np.linalg.norm(steps, axis=1)
    total = float(lengths.sum())
    if not total > 0.0:
        return NOWHERE, NOWHERE, NOWHERE
    if len(steps) == 1:
        return 0.5 * (walk.points[:1] + walk.points[1:]), walk.middles, steps / total
    at = np.concatenate([[0.0], np.cumsum(lengths)])
    tangents = unit_vectors(unit_vectors(steps) + np.roll(unit_vectors(steps), 1, axis=0))
    values = np.concatenate([walk.points, walk.normals, np.concatenate([tangents, tangents[:1]])], axis=1)
    inside = slice(0, -1) if walk.closed else slice(1, -1)
    places = _even(total, spacing, walk.closed)
    if len(at[inside]) > len(places):
        if not walk.closed:
            at, values = at[inside], values[inside]
        values = np.stack([np.interp(places, at, column) for column in values.T], axis=1)
    else:
        values = values[inside]
    points, normals, tangents = np.split(values, 3, axis=1)
    return points, unit_vectors(normals), unit_vectors(tangents)


def _even(total: float, spacing: float, closed: bool) -> Array:
    """Evenly spaced places along a length, as many as fit."""
    count = max(1, int(total / spacing + 1e-9)) if spacing > 0.0 else 1
    return (np.arange(count) + (0.0 if closed else 0.5)) * total / count


def dashes(points: Array, period: float, part: float = 0.55) -> Array:
    """Lines along a polyline (m + 1, 3): dashes that cover `part` of each period of its length."""
    lengths = np.linalg.norm(np.diff(points, axis=0), axis=1)
    ends = np.concatenate([[0.0], np.cumsum(lengths)])
    total = float(ends[-1])
    if not (total > 0.0 and period > 0.0):
        return NO_LINES
    count = max(1, round(total / period))
    starts = np.arange(count) * total / count
    stops = starts + part * total / count
    cuts = np.unique(np.concatenate([starts, stops, ends]))
    middles = 0.5 * (cuts[:-1] + cuts[1:])
    is_dash = (middles * count / total) % 1.0 < part
    places = np.stack([np.interp(cuts, ends, points[:, k]) for k in range(3)], axis=1)
    return np.stack([places[:-1], places[1:]], axis=1)[is_dash]


# --- shapes ----------------------------------------------------------------------------------

def arrows(points: Array, vectors: Array) -> tuple[Array, Array]:
    """Shafts, as lines, and heads, as triangles, of arrows from points (n, 3) along vectors (n, 3); none where zero."""
    length = np.linalg.norm(vectors, axis=1)
    known = np.isfinite(vectors).all(axis=1) & np.isfinite(points).all(axis=1) & (length > 0.0)
    points, vectors, length = points[known], vectors[known], length[known]
    if not len(points):
        return NO_LINES, NO_TRIANGLES
    tips = points + vectors
    necks = points + (1.0 - _HEAD) * vectors
    first, second = across(vectors)
    turn = 2.0 * np.pi * np.arange(_SIDES) / _SIDES
    radius = _HEAD * _SPREAD * length[:, None, None]
    ring = np.cos(turn)[:, None] * first[:, None] + np.sin(turn)[:, None] * second[:, None]
    base = necks[:, None] + radius * ring
    following = np.roll(base, -1, axis=1)
    peak, middle = (np.broadcast_to(p[:, None], base.shape) for p in (tips, necks))
    sides = np.stack([base, following, peak], axis=2)
    floors = np.stack([following, base, middle], axis=2)
    heads = np.concatenate([sides, floors], axis=1).reshape(-1, 3, 3)
    return np.stack([points, necks], axis=1), heads


def across(vectors: Array) -> tuple[Array, Array]:
    """Two unit vectors (n, 3) square to vectors (n, 3) and to each other."""
    along = unit_vectors(vectors)
    other = np.eye(3)[np.argmin(np.abs(along), axis=1)]
    first = unit_vectors(np.cross(along, other))
    return first, np.cross(along, first)


def ticks(points: Array, directions: Array, length: float) -> Array:
    """Lines of this length through points (n, 3), half on either side; none where a direction is not known."""
    known = np.isfinite(directions).all(axis=1) & (np.linalg.norm(directions, axis=1) > _TINY)
    half = 0.5 * length * unit_vectors(directions[known])
    return np.stack([points[known] - half, points[known] + half], axis=1)


def plates(points: Array, normals: Array, tangents: Array, width: float, height: float) -> tuple[Array, Array]:
    """Triangles and outlines of rectangles at points (n, 3), square to normals (n, 3), two sides along the tangents."""
    known = np.isfinite(normals).all(axis=1)
    points, normals, tangents = points[known], normals[known], tangents[known]
    flat = tangents - np.einsum("ij,ij->i", tangents, normals)[:, None] * normals
    lost = np.linalg.norm(flat, axis=1) < 1e-3
    if lost.any():
        flat[lost] = across(normals[lost])[0]
    side = 0.5 * width * unit_vectors(flat)
    up = 0.5 * height * np.cross(normals, unit_vectors(flat))
    corners = np.stack([points - side - up, points + side - up, points + side + up, points - side + up], axis=1)
    return filled(corners), outlined(corners)


def panes(points: Array, rise: Array) -> Array:
    """Corners (m, 4, 3) of the rectangles over the edges of a polyline (m + 1, 3), from it up by `rise` (3,)."""
    below, after = points[:-1], points[1:]
    return np.stack([below, after, after + rise, below + rise], axis=1)


def filled(corners: Array) -> Array:
    """Triangles of rectangles, corners (n, 4, 3)."""
    return corners[:, [[0, 1, 2], [0, 2, 3]]].reshape(-1, 3, 3)


def outlined(corners: Array) -> Array:
    """Lines around rectangles, corners (n, 4, 3)."""
    return np.stack([corners, np.roll(corners, -1, axis=1)], axis=2).reshape(-1, 2, 3)


def wall(points: Array, normal: Array, up: Array, least: float, offset: float | None = None) -> Array:
    """Corners (4, 3) of a rectangle in the plane with this unit normal that covers points (n, 3) seen along it.

    Upright, if the plane is not square to `up` (3,). offset: normal · x of the plane, by default the points' mean. A
    side that would be shorter than `least` grows: upwards from the points where that is a direction, else to both
    sides.
    """
    upright = up - (up @ normal) * normal
    stands = np.linalg.norm(upright) > 0.1 * np.linalg.norm(up)
    second = unit_vectors(upright) if stands else across(normal[None])[1][0]
    first = np.cross(second, normal)
    offset = float((points @ normal).mean()) if offset is None else offset
    spans = []
    for axis, grows_up in ((first, False), (second, stands)):
        low, high = float((points @ axis).min()), float((points @ axis).max())
        missing = max(least - (high - low), 0.0)
        margin = 0.03 * max(high - low, least)
        below = 0.1 * missing if grows_up else 0.5 * missing
        spans.append((low - below - margin, high + missing - below + margin))
    (a, b), (c, d) = spans
    return np.array([x * first + y * second + offset * normal for x, y in ((a, c), (b, c), (b, d), (a, d))])


def unit_vectors(vectors: Array) -> Array:
    """Unit vectors along the last axis; zero where there is no direction."""
    length = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return np.divide(vectors, length, out=np.full_like(vectors, 0.0), where=length != 0.0)
