"""Triangulation of polygons: quads along their better diagonal, larger ones by ear clipping."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import MeshError, listed

Array = NDArray[np.float64]
Int = NDArray[np.int32]

# Sine of the angle below which a corner counts as a spike and a triangle as flat: single precision leaves 1e-7.
_FLAT = 1e-6


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
    bad = np.flatnonzero(~np.isfinite(points).all(axis=1))
    if bad.size:
        raise MeshError(
            f"The position of vertex {listed(bad)} is not a finite number; repair or delete it.", vertices=bad
        )
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
    """(k - 2, 3) corner indices of a simple outline (k, 2), counter-clockwise."""
    left = list(range(len(outline)))
    quality = np.array([_ear(outline, left, i) for i in range(len(left))])
    triangles = []
    while len(left) > 3:
        best = int(np.argmax(quality))
        if quality[best] <= _FLAT:
            quality = np.array([_ear(outline, left, i) for i in range(len(left))])
            best = int(np.argmax(quality))
            if quality[best] <= _FLAT:
                raise _crossing(polygon, vertices)
        triangles.append((left[best - 1], left[best], left[(best + 1) % len(left)]))
        del left[best]
        quality = np.delete(quality, best)
        for i in ((best - 1) % len(left), best % len(left)):
            quality[i] = _ear(outline, left, i)
    if _shape(*outline[left]) <= _FLAT:
        raise _crossing(polygon, vertices)
    return np.array([*triangles, left], dtype=np.int32)


def _ear(outline: Array, left: list[int], i: int) -> float:
    """Quality of the ear at place i of the remaining corners; -1 if it is no ear."""
    a, b, c = left[i - 1], left[i], left[(i + 1) % len(left)]
    quality = float(_shape(outline[a], outline[b], outline[c]))
    if quality <= _FLAT:
        return -1.0
    others = outline[[j for j in left if j not in (a, b, c)]]
    inside = np.ones(len(others), dtype=bool)
    for p, q in ((a, b), (b, c), (c, a)):
        side, offset = outline[q] - outline[p], others - outline[p]
        inside &= side[0] * offset[:, 1] - side[1] * offset[:, 0] >= -_FLAT * (side @ side)
    return -1.0 if inside.any() else quality
