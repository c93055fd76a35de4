"""Constrained Delaunay triangulation of a region: Delaunay, missing boundary edges recovered, the outside removed."""

from __future__ import annotations

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from scipy.spatial import Delaunay

from ..errors import MeshError


def triangulate(points: np.ndarray, edges: np.ndarray) -> np.ndarray:
    """Triangles (F, 3), counter-clockwise, of the region on the left of the directed boundary `edges` (B, 2).

    Every boundary edge is an edge of the result; every other edge is locally Delaunay, except next to recovered
    boundary edges. Points outside the region stay unused. `points (n, 2)` have about unit spacing. Raises `MeshError`
    where another boundary point lies on a boundary edge.
    """
    triangles = _delaunay(points)
    for a, b in edges[~_has_edges(triangles, edges, len(points))]:
        triangles = _put_back(points, triangles, int(a), int(b))
    return _left_of(triangles, edges, len(points))


def _delaunay(points: np.ndarray) -> np.ndarray:
    low, high = points.min(axis=0), points.max(axis=0)
    # Four far points make every boundary edge an inner one: the hull is no special case, and the outside is connected.
    middle, reach = (low + high) / 2, 2.0 * (high - low).max() + 2.0
    frame = middle + reach * np.array([[-1.1, -1.0], [1.0, -1.2], [1.3, 1.0], [-1.0, 1.1]])
    triangles = Delaunay(np.concatenate([points, frame])).simplices.astype(np.int64)
    a, b, c = np.concatenate([points, frame])[triangles].transpose(1, 0, 2)
    area = (b[:, 0] - a[:, 0]) * (c[:, 1] - a[:, 1]) - (b[:, 1] - a[:, 1]) * (c[:, 0] - a[:, 0])
    return np.where((area < 0)[:, None], triangles[:, [0, 2, 1]], triangles)


def _keys(a: np.ndarray, b: np.ndarray, count: int) -> np.ndarray:
    return a * np.int64(count + 4) + b


def _has_edges(triangles: np.ndarray, edges: np.ndarray, count: int) -> np.ndarray:
    present = _keys(triangles, np.roll(triangles, -1, axis=1), count).ravel()
    return np.isin(_keys(edges[:, 0], edges[:, 1], count), present)


def _put_back(points: np.ndarray, triangles: np.ndarray, a: int, b: int) -> np.ndarray:
    """Remove the triangles that segment a-b crosses, and triangulate both of its sides again."""
    u = points[b] - points[a]
    known = np.zeros(int(triangles.max()) + 1)
    known[: len(points)] = u[0] * (points[:, 1] - points[a, 1]) - u[1] * (points[:, 0] - points[a, 0])
    along = np.full(len(known), np.inf)
    along[: len(points)] = (points - points[a]) @ u
    tail, head = triangles, np.roll(triangles, -1, axis=1)
    side_tail, side_head = known[tail], known[head]
    ends = (tail == a) | (tail == b) | (head == a) | (head == b) | (tail >= len(points)) | (head >= len(points))
    crossed = (side_tail * side_head < 0) & ~ends
    with np.errstate(all="ignore"):
        t = along[tail] + (along[head] - along[tail]) * side_tail / (side_tail - side_head)
    crossed &= (t > 0) & (t < u @ u)
    once = crossed & (side_tail > 0)
    if not once.any() or (np.abs(t[crossed]) <= 1e-12 * (u @ u)).any():
        raise MeshError(
            f"Another boundary point lies on the boundary edge from {points[a]} to {points[b]}.", vertices=(a, b)
        )
    order = np.argsort(t[once], kind="stable")
    new: list[tuple[int, int, int]] = []
    _fill(points, a, b, _without_repeats(tail[once][order][::-1]), new)
    _fill(points, b, a, _without_repeats(head[once][order]), new)
    return np.concatenate([triangles[~crossed.any(axis=1)], np.array(new, dtype=triangles.dtype).reshape(-1, 3)])


def _without_repeats(chain: np.ndarray) -> list[int]:
    return chain[np.append(True, chain[1:] != chain[:-1])].tolist()


def _fill(points: np.ndarray, a: int, b: int, chain: list[int], new: list[tuple[int, int, int]]) -> None:
    """Triangulate the polygon a, b, chain…: on its base the triangle whose circle holds no other vertex (Anglada).

    A vertex that hangs into the polygon on one edge appears between two copies of that edge's other end.
    """
    stack = [(a, b, chain)]
    while stack:
        p, q, rest = stack.pop()
        best = -1
        for k, vertex in enumerate(rest):
            if vertex not in (p, q) and (best < 0 or _in_circle(points, p, q, rest[best], vertex)):
                best = k
        if best >= 0:
            new.append((p, q, rest[best]))
            stack.append((rest[best], q, rest[:best]))
            stack.append((p, rest[best], rest[best + 1 :]))


def _in_circle(points: np.ndarray, a: int, b: int, c: int, d: int) -> bool:
    m = points[[a, b, c]] - points[d]
    rows = np.column_stack([m, np.sum(m * m, axis=1)])
    return bool(np.linalg.det(rows) > 0)


def _left_of(triangles: np.ndarray, edges: np.ndarray, count: int) -> np.ndarray:
    """The triangles on the left of the boundary, with all triangles connected to them across other edges."""
    tail, head = triangles.ravel(), np.roll(triangles, -1, axis=1).ravel()
    face = np.repeat(np.arange(len(triangles)), 3)
    left, right = _keys(tail, head, count), _keys(head, tail, count)
    start, end = edges[:, 0], edges[:, 1]
    wall = np.isin(left, np.concatenate([_keys(start, end, count), _keys(end, start, count)]))
    order = np.argsort(left)
    at = np.minimum(np.searchsorted(left, right, sorter=order), len(left) - 1)
    twin = order[at]
    joined = ~wall & (left[twin] == right)
    graph = coo_matrix((np.ones(joined.sum()), (face[joined], face[twin[joined]])), shape=(len(triangles),) * 2)
    _, part = connected_components(graph, directed=False)
    within = np.zeros(part.max() + 1, dtype=bool)
    within[part[face[np.isin(left, _keys(start, end, count))]]] = True
    return triangles[within[part]]
