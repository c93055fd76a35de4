"""Angles of plane triangles, and a smoother that opens small ones by moving one vertex at a time."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

_WANTED = np.radians(38.0)  # smaller angles are improved
_RADII = (0.24, 0.12, 0.06, 0.03)  # of the mean edge at the vertex


def smallest_angles(points: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """The smallest angle (F,) of each triangle, in radians; not positive if it is clockwise."""
    return _smallest(points[triangles])


def open_angles(points: np.ndarray, triangles: np.ndarray, first: int, last: int, sweeps: int = 3) -> np.ndarray:
    """Move vertices first … last - 1 so that the smallest angle around each grows; the triangles stay.

    Only vertices of triangles with an angle below 38° are tried, each on four circles around its place.
    """
    points = points.copy()
    turn = 2 * np.pi * np.arange(8) / 8
    ways = np.concatenate([r * np.column_stack([np.cos(turn + r), np.sin(turn + r)]) for r in _RADII])
    for _ in range(sweeps):
        bad = np.unique(triangles[smallest_angles(points, triangles) < _WANTED])
        bad = bad[(bad >= first) & (bad < last)]
        moved = [_move(points, star, vertex, ways) for vertex, star in zip(bad, _stars(triangles, bad), strict=True)]
        if not any(moved):
            break
    return points


def _stars(triangles: np.ndarray, vertices: np.ndarray) -> Iterator[np.ndarray]:
    """The triangles (k, 3) around each of the vertices, in their order."""
    corners = triangles.ravel()
    order = np.argsort(corners, kind="stable")
    first, last = (np.searchsorted(corners, vertices, side=side, sorter=order) for side in ("left", "right"))
    for low, high in zip(first, last, strict=True):
        yield triangles[order[low:high] // 3]


def _move(points: np.ndarray, star: np.ndarray, vertex: int, ways: np.ndarray) -> bool:
    """Move one vertex to the best of the places tried; returns whether it moved."""
    at = star == vertex
    corners = points[star]
    size = np.linalg.norm(corners[:, 1] - corners[:, 0], axis=1).mean()
    places = points[vertex] + size * np.concatenate([np.zeros((1, 2)), ways])
    tried = np.where(at[None, :, :, None], places[:, None, None, :], corners[None])
    worst = _smallest(tried).min(axis=1)
    best = int(np.argmax(worst))
    points[vertex] = places[best]
    return worst[best] > worst[0] + 1e-3


def _smallest(corners: np.ndarray) -> np.ndarray:
    """Smallest angle of triangles (…, 3, 2); negative for clockwise ones."""
    ahead = np.roll(corners, -1, axis=-2) - corners
    back = np.roll(corners, 1, axis=-2) - corners
    cross = ahead[..., 0] * back[..., 1] - ahead[..., 1] * back[..., 0]
    return np.arctan2(cross, np.sum(ahead * back, axis=-1)).min(axis=-1)
