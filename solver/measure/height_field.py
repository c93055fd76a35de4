"""Whether a mesh is a graph over a plane: a quick proof that it does not intersect itself.

When every triangle keeps its orientation seen along some direction, a point of the plane is covered as often
as the boundary winds around it. If the boundary curves are simple and disjoint there, it suffices to count
on the left of each of them: once everywhere means that the mesh is a graph.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from .aabb_tree import overlapping_boxes
from .arrays import Array, Indices, dot, edge_vectors

# Least sine of the angle between a triangle of a graph and the direction of view.
_STEEPEST = 1e-3
_ROUNDING = 1e-9


def is_graph(points: Array, triangles: Indices) -> bool:
    """Whether the mesh is a graph over the plane across its area vector; False where it is not certain.

    points (n, 3), triangles (F, 3). Two faces of a graph have no inner point in common.
    """
    u, v = edge_vectors(points, triangles)
    normals = np.cross(u, v, axis=0)
    direction = normals.sum(axis=1)
    length = np.linalg.norm(direction)
    if not length > 0:
        return False
    direction /= length
    if not (direction @ normals > _STEEPEST * np.sqrt(dot(normals, normals))).all():
        return False
    sides = _boundary(triangles, len(points))
    if sides is None or not len(sides):
        return False
    across = np.linalg.svd(direction[None])[2][1:]
    if np.linalg.det(np.vstack([across, direction])) < 0:
        across = across[::-1]
    plane = (points - points.mean(axis=0)) @ across.T
    return _are_simple(plane, sides) and _covers_once(plane, sides)


def _boundary(triangles: Indices, count: int) -> NDArray[np.int64] | None:
    """Directed boundary edges (K, 2), the mesh on their left; None where they do not form curves."""
    a = triangles.ravel().astype(np.int64)
    b = triangles[:, [1, 2, 0]].ravel().astype(np.int64)
    forward = np.sort(a * count + b)
    if (np.diff(forward) == 0).any():
        return None
    free = ~np.isin(a * count + b, b * count + a)
    sides = np.stack([a[free], b[free]], axis=1)
    starts, ends = np.sort(sides[:, 0]), np.sort(sides[:, 1])
    if not np.array_equal(starts, ends) or (np.diff(starts) == 0).any():
        return None
    return sides


def _are_simple(plane: Array, sides: NDArray[np.int64]) -> bool:
    """Whether no two boundary edges have a point in common but for their common vertex."""
    p, q = plane[sides[:, 0]], plane[sides[:, 1]]
    flat = np.zeros((len(sides), 1))
    low, high = np.hstack([np.minimum(p, q), flat]), np.hstack([np.maximum(p, q), flat])
    for pairs in overlapping_boxes(low, high):
        a, b = sides[pairs[:, 0]], sides[pairs[:, 1]]
        apart = (a[:, :, None] != b[:, None, :]).all(axis=(1, 2))
        if _meet(plane, a[apart], b[apart]).any() or _fold(plane, a[~apart], b[~apart]).any():
            return False
    return True


def _meet(plane: Array, a: NDArray[np.int64], b: NDArray[np.int64]) -> NDArray[np.bool_]:
    """Whether segments cross or touch, by signs of areas; rounding counts as touching."""
    p, q, r, s = plane[a[:, 0]], plane[a[:, 1]], plane[b[:, 0]], plane[b[:, 1]]
    margin = _ROUNDING * np.maximum(np.abs(q - p).max(axis=1), np.abs(s - r).max(axis=1)) ** 2
    one, two = _turn(p, q, r), _turn(p, q, s)
    three, four = _turn(r, s, p), _turn(r, s, q)
    clear = np.minimum(one, two) > margin, np.maximum(one, two) < -margin
    clear += np.minimum(three, four) > margin, np.maximum(three, four) < -margin
    return ~np.logical_or.reduce(clear)


def _fold(plane: Array, a: NDArray[np.int64], b: NDArray[np.int64]) -> NDArray[np.bool_]:
    """Whether consecutive segments lie on each other, going back the way they came."""
    first = plane[a[:, 1]] - plane[a[:, 0]]
    second = plane[b[:, 1]] - plane[b[:, 0]]
    cross = first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0]
    along = np.einsum("kc,kc->k", first, second)
    return (np.abs(cross) <= _ROUNDING * np.abs(along)) & (along < 0)


def _turn(p: Array, q: Array, r: Array) -> Array:
    return (q[:, 0] - p[:, 0]) * (r[:, 1] - p[:, 1]) - (q[:, 1] - p[:, 1]) * (r[:, 0] - p[:, 0])


def _covers_once(plane: Array, sides: NDArray[np.int64]) -> bool:
    """Whether the boundary winds once around the points on the left of each of its curves."""
    joined = coo_array((np.ones(len(sides)), (sides[:, 0], sides[:, 1])), shape=(len(plane), len(plane)))
    labels = connected_components(joined, directed=False)[1][sides[:, 0]]
    for label in np.unique(labels):
        own, others = sides[labels == label], sides[labels != label]
        p, q = plane[own[:, 0]], plane[own[:, 1]]
        area = (p[:, 0] * q[:, 1] - p[:, 1] * q[:, 0]).sum()
        if (1 if area > 0 else 0) + _winding(plane[own[0, 0]], plane[others[:, 0]], plane[others[:, 1]]) != 1:
            return False
    return True


def _winding(point: Array, starts: Array, ends: Array) -> int:
    """How often closed curves wind around a point that is not on them: crossings of a ray, with their signs."""
    rises = (starts[:, 1] <= point[1]) & (ends[:, 1] > point[1])
    falls = (starts[:, 1] > point[1]) & (ends[:, 1] <= point[1])
    side = _turn(starts, ends, np.broadcast_to(point, starts.shape))
    return int(np.count_nonzero(rises & (side > 0)) - np.count_nonzero(falls & (side < 0)))
