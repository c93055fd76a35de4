"""Exact lines: level lines of w that need not close, followed from face to face across the cuts.

In each face w is linear, and a point on an edge has a value on both of its sides; a line goes on at the value of the
other side. Lines start at whole numbers along the rim and along paths between loops, unless another one has come near.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree

from .cut import CutDomain
from .field import LineField
from .places import points_at
from .tracing import AXIS_OF_FAMILY

Array = NDArray[np.float64]
Int = NDArray[np.integer]

# A start is left out where a line of its family is nearer than this part of the local side.
_NEAR = 0.5
# A line that has crossed this many edges for each edge across the domain winds for ever.
_TURNS = 20.0


def followed(field: LineField) -> tuple[list[int], list[bool], list[Int], list[Array]]:
    """Families, whether closed, faces (k,) and barycentric places (k, 3) of the points of each line."""
    cut = field.coordinates.isothermic.cut
    corner = field.coordinates.values[cut.faces]
    walker = _Walker(cut, corner)
    families, closed, faces, places = [], [], [], []
    for family, axis in enumerate(AXIS_OF_FAMILY):
        known = np.zeros((0, 3))
        for half, t in _starts(cut, corner[..., axis]):
            f, b = _place(half, t)
            point = points_at(field.sheet, f, b)[0]
            side = field.coordinates.spacings[axis] / np.sqrt(2.0 * field.half_difference(f, b)[0])
            if len(known) and KDTree(known).query(point)[0] < _NEAR * side:
                continue
            is_closed, f, b = walker.line(axis, half, t)
            if len(f) < 2:
                continue
            known = np.vstack([known, _dense(points_at(field.sheet, f, b), 0.2 * side)])
            families.append(family)
            closed.append(is_closed)
            faces.append(f)
            places.append(b)
    return families, closed, faces, places


def _dense(points: Array, step: float) -> Array:
    """Points along a polyline, at most `step` apart."""
    lengths = np.linalg.norm(np.diff(points, axis=0), axis=1)
    count = np.maximum(np.ceil(lengths / step).astype(np.int64), 1)
    first = np.repeat(np.arange(len(count)), count)
    share = (np.arange(count.sum()) - np.repeat(np.cumsum(count) - count, count)) / count[first]
    return points[first] + share[:, None] * (points[first + 1] - points[first])


def _place(half: int, t: float) -> tuple[Int, Array]:
    place = np.zeros((1, 3))
    place[0, (half % 3 + 1) % 3], place[0, (half % 3 + 2) % 3] = 1.0 - t, t
    return np.array([half // 3]), place


def _starts(cut: CutDomain, corner: Array) -> list[tuple[int, float]]:
    """Half-edges and places in (0, 1) along them, where w is whole: on the rim, and on the cut."""
    domain = cut.domain
    loop_path = (cut.source >= 0) & (np.bincount(cut.source, minlength=domain.vertex_count)[cut.source] > 1)
    left = domain.half_edges[:, 0]
    face, k = left // 3, left % 3
    a, b = corner[face, (k + 1) % 3], corner[face, (k + 2) % 3]
    ends = cut.faces[face, (k + 1) % 3], cut.faces[face, (k + 2) % 3]
    on_rim = domain.edge_faces[:, 1] < 0
    on_path = ~on_rim & loop_path[ends[0]] & loop_path[ends[1]]
    found = []
    for kept in (on_rim, on_path):
        for e in np.flatnonzero(kept & (np.ceil(np.minimum(a, b)) < np.maximum(a, b))).tolist():
            for level in range(int(np.ceil(min(a[e], b[e]))), int(np.ceil(max(a[e], b[e])))):
                t = (level - a[e]) / (b[e] - a[e])
                if 1e-6 < t < 1.0 - 1e-6:
                    found.append((int(left[e]), float(t)))
    return found


class _Walker:
    def __init__(self, cut: CutDomain, corner: Array) -> None:
        self.values = corner.tolist()
        self.twins = cut.domain.twins.tolist()
        self.most = int(_TURNS * np.sqrt(len(corner)))

    def line(self, axis: int, half: int, t: float) -> tuple[bool, Int, Array]:
        """Both ways from a point on a half-edge: whether the line closes, its faces and barycentric places."""
        ahead, closed = self._walk(axis, half, t)
        behind: list[tuple[int, float]] = []
        if not closed and self.twins[half] >= 0:
            behind, _ = self._walk(axis, self.twins[half], 1.0 - t)
        way = behind[:0:-1] + ahead
        places = [_place(*one) for one in way]
        return closed, np.concatenate([f for f, _ in places]), np.concatenate([b for _, b in places])

    def _walk(self, axis: int, half: int, t: float) -> tuple[list[tuple[int, float]], bool]:
        """Half-edges entered, with the place along each; through the last one the line leaves, or it closes."""
        start, way = (half, t), [(half, t)]
        crossed: dict[int, list[float]] = {}
        while len(way) < self.most:
            face, k = divmod(half, 3)
            v = [corner[axis] for corner in self.values[face]]
            level = (1.0 - t) * v[(k + 1) % 3] + t * v[(k + 2) % 3]
            # the line leaves on the side on which the third corner is not
            top = v[k]
            first = (v[(k + 2) % 3] - level) * (top - level) <= 0.0
            out, a, b = ((k + 1) % 3, v[(k + 2) % 3], top) if first else ((k + 2) % 3, top, v[(k + 1) % 3])
            if a == b:
                break
            t = min(max((level - a) / (b - a), 1e-9), 1.0 - 1e-9)
            half = self.twins[3 * face + out]
            if half < 0:
                way.append((3 * face + out, t))
                break
            t = 1.0 - t
            size = abs(b - a)
            if half == start[0] and abs(t - start[1]) * size < 1e-3:
                return way, True
            if any(abs(t - other) * size < _NEAR for other in crossed.get(half, [])):
                break
            crossed.setdefault(half, []).append(t)
            way.append((half, t))
        return way, False
