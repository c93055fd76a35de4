"""Self-intersections of a triangle mesh.

Two faces without a common vertex intersect when no axis separates them (the separating axis theorem; the plane normals,
the products of edge directions, and the in-plane normals for parallel faces suffice). Faces that touch in a point or
along an edge do not intersect, faces that lie on each other do. Two faces with one common vertex intersect when the far
edge of one goes through the other. Faces that share an edge are not tested, nor is a mesh that is a graph over a plane.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import Interrupted
from .aabb_tree import Pairs, overlapping_boxes
from .arrays import Array, Indices, points_in_space, triangles_of
from .height_field import is_graph

# Overlap along an axis, as a fraction of the two triangles' extent, below which they only touch.
_TOUCHING = 1e-9
# Pairs after which the search ends: a sheet through itself everywhere has a pair for every two faces.
_MOST = 200_000


def self_intersections(
    vertices: ArrayLike, faces: ArrayLike, is_wanted: Callable[[], bool] | None = None
) -> NDArray[np.int32]:
    """Pairs of faces that intersect, (k, 2), i < j, sorted; empty (0, 2) where the mesh is embedded.

    Where there are more than 200,000 pairs, those found by then. `vertices` (n, 3), `faces` (F, 3), any mixture of
    sizes; faces with nan or without area intersect nothing. Vertices are the same when their index is. Raises
    `MeshError` on a bad shape or index, and `Interrupted` as soon as `is_wanted`, called now and then, returns False.
    """
    points = points_in_space(vertices)
    triangles = triangles_of(faces, len(points))
    if len(triangles) == 0 or is_graph(points, triangles):
        return np.zeros((0, 2), dtype=np.int32)
    return _search(points, triangles, is_wanted or (lambda: True))


def _search(points: Array, triangles: Indices, is_wanted: Callable[[], bool]) -> NDArray[np.int32]:
    corners = points[triangles]
    normals = _normals(corners)
    corners[np.isnan(normals[:, 0])] = np.nan
    blocks = [np.zeros((0, 2), dtype=np.int64)]
    for pairs in overlapping_boxes(corners.min(axis=1), corners.max(axis=1)):
        if not is_wanted():
            raise Interrupted
        shared = _shared_vertices(triangles, pairs)
        apart, joined = pairs[shared == 0], pairs[shared == 1]
        for a, b in ((0, 1), (1, 0)):
            apart = apart[_meets_plane(corners, normals, apart[:, a], apart[:, b], +_TOUCHING)]
            joined = joined[_meets_plane(corners, normals, joined[:, a], joined[:, b], -_TOUCHING)]
        blocks.append(apart[_overlap(corners[apart[:, 0]], corners[apart[:, 1]])])
        blocks.append(joined[_pierce(points, triangles, joined)])
        if sum(map(len, blocks)) > _MOST:
            break
    pairs = np.sort(np.concatenate(blocks), axis=1)
    return pairs[np.lexsort((pairs[:, 1], pairs[:, 0]))].astype(np.int32)


def _normals(corners: Array) -> Array:
    """Unit normals (F, 3); nan where a face has no area."""
    u, v = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    normal = np.cross(u, v)
    length = np.sqrt(_square(normal))
    length[~(length > _TOUCHING * np.maximum(_square(u), _square(v)))] = np.nan
    return normal / length[:, None]


def _meets_plane(
    corners: Array, normals: Array, face: NDArray[np.int64], other: NDArray[np.int64], margin: float
) -> NDArray[np.bool_]:
    """Whether `other` is not all on one side of the plane of `face`: a quick test that few pairs pass.

    Faces that lie in the plane pass with a positive margin and fail with a negative one.
    """
    offset = corners[other] - corners[face, :1]
    heights = np.einsum("kvc,kc->kv", offset, normals[face])
    height = margin * np.abs(offset).max(axis=(1, 2))
    return (heights.min(axis=1) < height) & (heights.max(axis=1) > -height)


def _square(v: Array) -> Array:
    return np.einsum("...k,...k->...", v, v)


def _shared_vertices(triangles: Indices, pairs: Pairs) -> NDArray[np.int64]:
    a, b = triangles[pairs[:, 0]], triangles[pairs[:, 1]]
    count = np.zeros(len(pairs), dtype=np.int64)
    for i in range(3):
        for j in range(3):
            count += a[:, i] == b[:, j]
    return count


def _overlap(a: Array, b: Array) -> NDArray[np.bool_]:
    """Whether triangles a and b (k, 3, 3), pair by pair, have more than a boundary point in common."""
    alive = np.arange(len(a))
    for axis in _axes(a, b):
        direction = axis(a[alive], b[alive])
        alive = alive[~_separated(direction, a[alive], b[alive])]
    result = np.zeros(len(a), dtype=bool)
    result[alive] = True
    return result


def _axes(a: Array, b: Array) -> Iterator:
    """The candidate axes, the most successful first, as functions of the remaining pairs."""
    normals = (lambda a, b: _normal(a)), (lambda a, b: _normal(b))
    yield from normals
    for i in range(3):
        for j in range(3):
            yield lambda a, b, i=i, j=j: np.cross(_edge(a, i), _edge(b, j))
    for i in range(3):
        yield lambda a, b, i=i: np.cross(_normal(a), _edge(a, i))
        yield lambda a, b, i=i: np.cross(_normal(b), _edge(b, i))


def _edge(corners: Array, k: int) -> Array:
    """Unit directions, so that a small triangle is not mistaken for parallel edges."""
    edge = corners[:, (k + 1) % 3] - corners[:, k]
    return edge / np.sqrt(_square(edge))[:, None]


def _normal(corners: Array) -> Array:
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    return normal / np.sqrt(_square(normal))[:, None]


def _separated(axis: Array, a: Array, b: Array) -> NDArray[np.bool_]:
    """Whether the shadows on the axis (k, 3) do not overlap, or only touch.

    An axis that vanishes, or sees both triangles edge on in the same place, separates nothing.
    """
    length = np.sqrt(_square(axis))
    origin = a[:, :1]
    shadow_a = np.einsum("kc,kvc->kv", axis, a - origin)
    shadow_b = np.einsum("kc,kvc->kv", axis, b - origin)
    low_a, high_a, low_b, high_b = (
        shadow_a.min(axis=1),
        shadow_a.max(axis=1),
        shadow_b.min(axis=1),
        shadow_b.max(axis=1),
    )
    size = np.sqrt(np.maximum(_square(a - origin).max(axis=1), _square(b - origin).max(axis=1)))
    margin = _TOUCHING * length * size
    overlap = np.minimum(high_a - low_b, high_b - low_a)
    flat = np.maximum(high_a, high_b) - np.minimum(low_a, low_b) <= margin
    return (overlap <= margin) & ~flat & (length > _TOUCHING)


def _pierce(points: Array, triangles: Indices, pairs: Pairs) -> NDArray[np.bool_]:
    """Whether, for two faces with one common vertex, the far edge of either goes through the other."""
    a, b = triangles[pairs[:, 0]], triangles[pairs[:, 1]]
    i, j = np.nonzero(a[:, :, None] == b[:, None, :])[1:]
    a, b = points[_turned(a, i)], points[_turned(b, j)]
    return _through(a[:, 1], a[:, 2], b) | _through(b[:, 1], b[:, 2], a)


def _turned(faces: Indices, k: NDArray[np.int64]) -> Indices:
    """Each face cyclically, beginning with its corner k."""
    return np.take_along_axis(faces, (k[:, None] + np.arange(3)) % 3, axis=1)


def _through(p: Array, q: Array, face: Array) -> NDArray[np.bool_]:
    """Whether the segments pq cross the inside of the triangles `face` (k, 3, 3), by signs of volumes."""
    edge = q - p
    sides = np.stack([_volume(edge, face[:, k] - p, face[:, (k + 1) % 3] - p) for k in range(3)])
    tall = _volume(face[:, 1] - face[:, 0], face[:, 2] - face[:, 0], p - face[:, 0])
    deep = _volume(face[:, 1] - face[:, 0], face[:, 2] - face[:, 0], q - face[:, 0])
    size = np.sqrt(np.maximum(_square(edge), _square(face - p[:, None]).max(axis=1)))
    margin = _TOUCHING * size**3
    inside = (sides > margin).all(axis=0) | (sides < -margin).all(axis=0)
    return inside & (np.minimum(tall, deep) < -margin) & (np.maximum(tall, deep) > margin)


def _volume(a: Array, b: Array, c: Array) -> Array:
    """Six times the signed volumes (k,) of the tetrahedra with these edges (k, 3)."""
    return np.einsum("kc,kc->k", np.cross(a, b), c)
