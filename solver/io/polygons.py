"""Triangulation of polygons: quads along their better diagonal, larger ones by ear clipping."""

from __future__ import annotations

import heapq
import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import MeshError, listed, plural
from ..linalg import out_of_range

Array = NDArray[np.float64]
Int = NDArray[np.int32]

# Sine of the angle below which a corner counts as a spike and a triangle as flat: single precision leaves 1e-7.
_FLAT = 1e-6
# A corner farther than this part of the longest side from the box of an ear is not in the ear.
_TIP = 1e-3


def triangulate_polygons(vertices: ArrayLike, polygons: Sequence[ArrayLike]) -> tuple[Int, Int]:
    """Triangles (T, 3) of polygons, in their order and orientation, and the polygon (T,) each belongs to.

    vertices (V, 2) or (V, 3); polygons as lists of vertex indices, convex or not, planar or nearly. No vertex is added:
    a polygon of k corners gives k - 2 triangles. A quad is cut along the diagonal with the larger smallest angle; on
    larger polygons the best-shaped ear is clipped first. Raises `MeshError`, naming polygon and vertex, on a polygon
    with fewer than three corners, a repeated vertex, a vertex out of range, a spike (the outline runs out and back
    again), no area, or an outline that crosses itself.
    """
    points = _in_space(vertices)
    corners = [np.asarray(polygon) for polygon in polygons]
    sizes = np.array([len(polygon) for polygon in corners], dtype=np.int64)
    flat = np.concatenate([np.zeros(0, dtype=np.int32), *corners]).astype(np.int32)
    _check_corners(flat, sizes, len(points))
    first, row = (np.concatenate([[0], np.cumsum(counts)[:-1]]) for counts in (sizes, sizes - 2))
    triangles = np.empty((int((sizes - 2).sum()), 3), dtype=np.int32)
    for size in np.unique(sizes):
        which = np.flatnonzero(sizes == size)
        block = flat[first[which][:, None] + np.arange(size)]
        _check_repeats(block, which)
        outlines = _projected(points, block, which)
        rows = row[which][:, None] + np.arange(size - 2)
        if size == 3:
            triangles[rows[:, 0]] = block
        elif size == 4:
            triangles[rows] = _cut_quads(outlines, block, which)
        else:
            for outline, polygon, index, own in zip(outlines, block, which, rows, strict=True):
                triangles[own] = polygon[_clip_ears(outline, polygon, int(index))]
    return triangles, np.repeat(np.arange(len(sizes), dtype=np.int32), sizes - 2)


def _in_space(vertices: ArrayLike) -> Array:
    points = np.asarray(vertices, dtype=np.float64)
    if points.ndim != 2 or points.shape[1] not in (2, 3):
        raise MeshError(f"Vertices must have shape (V, 2) or (V, 3), not {points.shape}.")
    bad, what = out_of_range(points)
    if bad.size:
        raise MeshError(f"The position of {plural('vertex', bad)} is {what}; repair or delete it.", vertices=bad)
    return points if points.shape[1] == 3 else np.column_stack([points, np.zeros(len(points))])


def _check_corners(flat: Int, sizes: NDArray[np.int64], vertex_count: int) -> None:
    small = np.flatnonzero(sizes < 3)
    if small.size:
        raise MeshError(f"Polygon {listed(small)} has fewer than three corners; delete it.", faces=small)
    outside = np.flatnonzero((flat < 0) | (flat >= vertex_count))
    if outside.size:
        index = int(np.searchsorted(np.cumsum(sizes), outside[0], side="right"))
        raise MeshError(
            f"Polygon {index} uses vertex {flat[outside[0]]}, but there are {vertex_count} vertices.",
            faces=[index],
            vertices=[int(flat[outside[0]])],
        )


def _check_repeats(block: Int, which: NDArray[np.int64]) -> None:
    ordered = np.sort(block, axis=1)
    repeated = ordered[:, 1:] == ordered[:, :-1]
    for row in np.flatnonzero(repeated.any(axis=1))[:1]:
        index, twice = int(which[row]), np.unique(ordered[row, 1:][repeated[row]])
        raise MeshError(
            f"Polygon {index} passes through vertex {listed(twice)} more than once; split it there.",
            faces=[index],
            vertices=twice,
        )


def _projected(points: Array, block: Int, which: NDArray[np.int64]) -> Array:
    """Outlines (P, k, 2) in the plane of their area vector, counter-clockwise; `MeshError` on spikes and no area."""
    outline = points[block]
    step = np.roll(outline, -1, axis=1) - outline
    lengths = np.linalg.norm(step, axis=2)
    back = np.roll(step, 1, axis=1)
    sines = np.linalg.norm(np.cross(back, step), axis=2)
    limit = _FLAT * lengths * np.roll(lengths, 1, axis=1)
    if block.shape[1] > 3:
        spikes = np.argwhere((sines <= limit) & (np.einsum("pki,pki->pk", back, step) < 0))
        for row, corner in spikes[:1]:
            polygon, vertex = int(which[row]), int(block[row, corner])
            raise MeshError(
                f"Polygon {polygon} has a spike at vertex {vertex}: its outline runs out and back again; "
                "dissolve the vertex or merge by distance.",
                faces=[polygon],
                vertices=[vertex],
            )
    centred = outline - outline.mean(axis=1, keepdims=True)
    area = 0.5 * np.cross(centred, np.roll(centred, -1, axis=1)).sum(axis=1)
    size = np.linalg.norm(area, axis=1)
    none = np.flatnonzero(size <= _FLAT * 0.5 * (lengths**2).max(axis=1))
    if none.size:
        polygon, vertices = int(which[none[0]]), block[none[0]]
        raise MeshError(
            f"Polygon {polygon} (vertices {listed(vertices)}) has no area; delete it or merge by distance.",
            faces=which[none],
            vertices=vertices,
        )
    normal = area / size[:, None]
    first = np.cross(normal, np.eye(3)[np.argmin(np.abs(normal), axis=1)])
    first /= np.linalg.norm(first, axis=1, keepdims=True)
    second = np.cross(normal, first)
    return np.stack([np.einsum("pki,pi->pk", centred, first), np.einsum("pki,pi->pk", centred, second)], axis=2)


def _shape(a: Array, b: Array, c: Array) -> Array:
    """Quality of triangles (…, 2): the sine of the smallest angle, negative if clockwise."""
    ab, bc, ca = b - a, c - b, a - c
    cross = ab[..., 0] * bc[..., 1] - ab[..., 1] * bc[..., 0]
    sides = np.sort(np.stack([np.linalg.norm(side, axis=-1) for side in (ab, bc, ca)], axis=-1), axis=-1)
    longest = sides[..., 1] * sides[..., 2]
    return cross / np.where(longest > 0, longest, 1.0)


def _cut_quads(flat: Array, block: Int, which: NDArray[np.int64]) -> Int:
    """(P, 2, 3) triangles of quads (P, 4)."""
    a, b, c, d = (flat[:, k] for k in range(4))
    along = np.minimum(_shape(a, b, c), _shape(a, c, d))
    across = np.minimum(_shape(b, c, d), _shape(b, d, a))
    for row in np.flatnonzero(np.maximum(along, across) <= _FLAT)[:1]:
        raise _crossing(int(which[row]), block[row])
    # A quad with two equally good diagonals is always cut the same way, whatever the rounding.
    first = (along >= across - 1e-6)[:, None, None]
    return np.where(first, block[:, [[0, 1, 2], [0, 2, 3]]], block[:, [[1, 2, 3], [1, 3, 0]]])


def _crossing(polygon: int, vertices: Int) -> MeshError:
    return MeshError(
        f"The outline of polygon {polygon} (vertices {listed(vertices)}) crosses or touches itself; "
        "triangulate it by hand or redraw it.",
        faces=[polygon],
        vertices=vertices,
    )


def _clip_ears(outline: Array, vertices: Int, polygon: int) -> Int:
    """(k - 2, 3) corner indices of a simple outline (k, 2), counter-clockwise; in about k log k on common outlines."""
    ring = _Ring(outline)
    triangles = []
    while ring.count > 3:
        best = ring.best_ear()
        if best < 0:
            raise _crossing(polygon, vertices)
        triangles.append((ring.before[best], best, ring.after[best]))
        ring.remove(best)
    last = np.flatnonzero(ring.left)
    if _shape(*outline[last]) <= _FLAT:
        raise _crossing(polygon, vertices)
    return np.array([*triangles, last], dtype=np.int32)


class _Ring:
    """The corners of an outline that are left, and a queue of their ears.

    Corners are kept sorted by x, so that an ear is compared with those of its own strip only.
    """

    def __init__(self, outline: Array) -> None:
        self.outline, self.count = outline, len(outline)
        self.points = outline.tolist()
        self.before = np.roll(np.arange(self.count), 1).tolist()
        self.after = np.roll(np.arange(self.count), -1).tolist()
        self.left = np.ones(self.count, dtype=bool)
        self._sort()
        self._queue_all()

    def best_ear(self) -> int:
        """The corner with the best-shaped ear, -1 if there is none; of equal ears the first."""
        for _ in range(2):
            while self.queue:
                quality, corner = heapq.heappop(self.queue)
                if self.left[corner] and self.quality[corner] == -quality:
                    return corner
            self._queue_all()  # corners that stood in the way may be gone
        return -1

    def remove(self, corner: int) -> None:
        self.left[corner] = False
        self.count -= 1
        before, after = self.before[corner], self.after[corner]
        self.after[before], self.before[after] = after, before
        if self.count < len(self.order) // 2:
            self._sort()
        for other in (before, after):
            self._queue(other)

    def _sort(self) -> None:
        corners = np.flatnonzero(self.left)
        self.order = corners[np.argsort(self.outline[corners, 0], kind="stable")]
        self.sorted_points = self.outline[self.order]
        self.x = self.sorted_points[:, 0].copy()

    def _queue_all(self) -> None:
        self.quality: dict[int, float] = {}
        self.queue: list[tuple[float, int]] = []
        for corner in np.flatnonzero(self.left).tolist():
            self._queue(corner)

    def _queue(self, corner: int) -> None:
        quality = self._ear(corner)
        self.quality[corner] = quality
        if quality > _FLAT:
            heapq.heappush(self.queue, (-quality, corner))

    def _ear(self, i: int) -> float:
        """Quality of the ear at a corner; -1 if it is no ear."""
        corners = (self.before[i], i, self.after[i])
        a, b, c = (self.points[k] for k in corners)
        ab, bc, ca = ((q[0] - p[0], q[1] - p[1]) for p, q in ((a, b), (b, c), (c, a)))
        sides = sorted(math.sqrt(x * x + y * y) for x, y in (ab, bc, ca))
        cross = ab[0] * bc[1] - ab[1] * bc[0]
        quality = cross / (sides[1] * sides[2]) if sides[1] > 0 else cross
        if quality <= _FLAT:
            return -1.0
        margin = _TIP * sides[2]
        low, high = np.searchsorted(self.x, [min(a[0], b[0], c[0]) - margin, max(a[0], b[0], c[0]) + margin])
        others, points = self.order[low:high], self.sorted_points[low:high]
        lowest, highest = min(a[1], b[1], c[1]) - margin, max(a[1], b[1], c[1]) + margin
        near = (points[:, 1] >= lowest) & (points[:, 1] <= highest)
        others, points = others[near], points[near]
        inside = self.left[others] & ~np.isin(others, corners)
        for p, side in ((a, ab), (b, bc), (c, ca)):
            inside &= side[0] * (points[:, 1] - p[1]) - side[1] * (points[:, 0] - p[0]) >= -_FLAT * (
                side[0] * side[0] + side[1] * side[1]
            )
        return -1.0 if inside.any() else quality
