"""Level lines of whole numbers of two coordinates, traced by their order on edges alone.

A line of family 0 runs along Im w = whole, one of family 1 along Re w = whole. It crosses each triangle in a chord
between two points on edges; points are found once for each edge, and belong to the triangles on both sides. Two chords
meet iff their ends alternate on the perimeter of the triangle. So nothing depends on rounding, and triangles that the
coordinates turn over do no harm.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from .cut import CutDomain

Array = NDArray[np.float64]
Int = NDArray[np.integer]

# The coordinate that is constant along the lines of each family.
AXIS_OF_FAMILY = (1, 0)


@dataclass(frozen=True, eq=False)
class EdgePoints:
    """Points (P,) where lines cross edges, sorted along each edge from its first vertex.

    edge, family, t: the place along the edge, in (0, 1). rank, count: its number on the edge, and how many there are.
    """

    edge: Int
    family: Int
    t: Array
    rank: Int
    count: Int


@dataclass(frozen=True, eq=False)
class Chords:
    """Pieces (C,) of lines in a face, sorted by face.

    ends: (C, 2) edge points, in the order in which the line runs; slots: (C, 2) their places on the perimeter of the
    face, in [0, 3), and barycentric: (C, 2, 3). line, position: the line, and the chord's number on it.
    """

    face: Int
    family: Int
    level: Int
    ends: Int
    slots: Array
    barycentric: Array
    line: Int
    position: Int


@dataclass(frozen=True, eq=False)
class Lines:
    """Traced lines: the family (L,) of each, whether it is closed, and its points and crossings.

    crossings: (X, 2) the chords of family 0 and 1 that meet. from_right: (X,) whether family 1 crosses family 0 from
    right to left. along: (X, 2) grows along each of the two chords.
    """

    points: EdgePoints
    chords: Chords
    family: Int
    closed: NDArray[np.bool_]
    crossings: Int
    from_right: NDArray[np.bool_]
    along: Array

    @property
    def places(self) -> Array:
        """Barycentric coordinates (X, 3) of the crossings in their faces."""
        a, b = (self.chords.barycentric[self.crossings[:, side]] for side in (0, 1))
        step, other, between = a[:, 1] - a[:, 0], b[:, 1] - b[:, 0], b[:, 0] - a[:, 0]
        size = step[:, 0] * other[:, 1] - step[:, 1] * other[:, 0]
        share = (between[:, 0] * other[:, 1] - between[:, 1] * other[:, 0]) / np.where(size == 0.0, 1.0, size)
        return a[:, 0] + np.clip(share, 0.0, 1.0)[:, None] * step


def traced(cut: CutDomain, values: Array) -> Lines:
    """The lines of values (n, 2) at the cut vertices, which are on no whole number, and change by whole ones."""
    corner = values[cut.faces]  # (F, 3, 2)
    points = _edge_points(cut, corner)
    chords = _chords(cut, corner, points)
    chords, family, closed = _walked(chords)
    return Lines(points, chords, family, closed, *_crossings(chords))


def _edge_points(cut: CutDomain, corner: Array) -> EdgePoints:
    half = cut.domain.half_edges[:, 0]
    face, k = half // 3, half % 3
    start, stop = corner[face, (k + 1) % 3], corner[face, (k + 2) % 3]
    edges, families, places = [], [], []
    for family, axis in enumerate(AXIS_OF_FAMILY):
        a, b = start[:, axis], stop[:, axis]
        first, count = _levels(a, b)
        edge = np.repeat(np.arange(len(a)), count)
        level = np.repeat(first, count) + _counted(count)
        edges.append(edge)
        families.append(np.full(len(edge), family))
        places.append((level - a[edge]) / (b - a)[edge])
    edge, family, t = np.concatenate(edges), np.concatenate(families), np.concatenate(places)
    order = np.lexsort((family, t, edge))
    edge, family, t = edge[order], family[order], t[order]
    count = np.bincount(edge, minlength=len(half))
    return EdgePoints(edge, family, t, _counted(count), count[edge])


def _levels(a: Array, b: Array) -> tuple[Int, Int]:
    """The first whole number between each two, and how many there are."""
    first = np.ceil(np.minimum(a, b)).astype(np.int64)
    return first, np.ceil(np.maximum(a, b)).astype(np.int64) - first


def _counted(count: Int) -> Int:
    """0, 1, … count - 1 for each of the counts, one after the other."""
    total = int(count.sum())
    return np.arange(total) - np.repeat(np.cumsum(count) - count, count)


def _chords(cut: CutDomain, corner: Array, points: EdgePoints) -> Chords:
    """Pairs of points of one family and level in each face."""
    halves = cut.domain.half_edges[points.edge]
    number = np.arange(len(points.edge))
    rows = []
    for side in (0, 1):
        kept = number[halves[:, side] >= 0]
        half = halves[kept, side]
        face, k = half // 3, half % 3
        t = points.t[kept]
        axis = np.asarray(AXIS_OF_FAMILY)[points.family[kept]]
        first, second = corner[face, (k + 1) % 3, axis], corner[face, (k + 2) % 3, axis]
        along = t if side == 0 else 1.0 - t
        level = np.rint(first + along * (second - first)).astype(np.int64)
        rank = points.rank[kept] if side == 0 else points.count[kept] - 1 - points.rank[kept]
        # half-edge k starts at corner k + 1, so the perimeter goes through half-edges 2, 0, 1
        slot = (k + 1) % 3 + (rank + 0.5) / points.count[kept]
        rows.append((face, points.family[kept], level, kept, slot, along))
    face, family, level, point, slot, along = (np.concatenate(column) for column in zip(*rows, strict=True))
    order = np.lexsort((slot, level, family, face))
    face, family, level, point, slot, along = (column[order] for column in (face, family, level, point, slot, along))
    corner_of = np.floor(slot).astype(np.int64)
    barycentric = np.zeros((len(face), 3))
    np.put_along_axis(barycentric, corner_of[:, None], 1.0 - along[:, None], axis=1)
    np.put_along_axis(barycentric, (corner_of[:, None] + 1) % 3, along[:, None], axis=1)
    none = np.zeros(len(face) // 2, dtype=np.int64)
    return Chords(
        face[::2], family[::2], level[::2], point.reshape(-1, 2), slot.reshape(-1, 2), barycentric.reshape(-1, 2, 3),
        none, none,
    )


def _walked(chords: Chords) -> tuple[Chords, Int, NDArray[np.bool_]]:
    """The chords with the line and the position of each, their ends turned in the direction of the line."""
    count = len(chords.face)
    ends = chords.ends.ravel()
    # the two half-chords at each point; -1 on the rim
    order = np.argsort(ends, kind="stable")
    sorted_ends = ends[order]
    beyond = np.full(2 * count, -1)
    same = np.flatnonzero(sorted_ends[1:] == sorted_ends[:-1])
    beyond[order[same]], beyond[order[same + 1]] = order[same + 1], order[same]
    opposite = beyond.tolist()
    line, position, turned = [-1] * count, [0] * count, [False] * count
    closed, family = [], []
    starts = np.flatnonzero(beyond < 0).tolist() + np.arange(2 * count).tolist()
    for start in starts:
        if line[start >> 1] >= 0:
            continue
        half, step, number = start, 0, len(closed)
        family.append(int(chords.family[start >> 1]))
        while half >= 0 and line[half >> 1] < 0:
            chord = half >> 1
            line[chord], position[chord], turned[chord] = number, step, bool(half & 1)
            half, step = opposite[half ^ 1], step + 1
        closed.append(half >= 0)
    order = np.where(np.array(turned, dtype=bool)[:, None], [[1, 0]], [[0, 1]])
    walked = replace(
        chords,
        ends=np.take_along_axis(chords.ends, order, axis=1),
        slots=np.take_along_axis(chords.slots, order, axis=1),
        barycentric=np.take_along_axis(chords.barycentric, order[:, :, None], axis=1),
        line=np.array(line, dtype=np.int64),
        position=np.array(position, dtype=np.int64),
    )
    return walked, np.array(family, dtype=np.int64), np.array(closed, dtype=bool)


def _crossings(chords: Chords) -> tuple[Int, NDArray[np.bool_], Array]:
    """Pairs (X, 2) of chords of family 0 and 1 whose ends alternate; whether 1 crosses 0 from right to left; and
    numbers (X, 2) that grow along each of the two.
    """
    every = np.arange(len(chords.face))
    zero, one = every[chords.family == 0], every[chords.family == 1]
    faces = int(chords.face.max(initial=-1)) + 1
    count1 = np.bincount(chords.face[one], minlength=faces)
    first1 = np.cumsum(count1) - count1
    pairs = count1[chords.face[zero]]
    a = np.repeat(zero, pairs)
    b = one[np.repeat(first1[chords.face[zero]], pairs) + _counted(pairs)]
    meet, from_right, along_a = _meeting(chords, a, b)
    _, _, along_b = _meeting(chords, b, a)
    crossings = np.column_stack([a, b])[meet]
    return crossings, from_right[meet], np.column_stack([along_a, along_b])[meet]


def _meeting(chords: Chords, a: Int, b: Int) -> tuple[NDArray[np.bool_], NDArray[np.bool_], Array]:
    """Whether chords b meet a, whether from its right side, and the place of the end of b on that side.

    Counter-clockwise from its start to its end, the perimeter is on the right of a chord; ends there follow each other
    as the crossings do.
    """
    stop, first, second = (
        (slots - chords.slots[a, 0]) % 3.0 for slots in (chords.slots[a, 1], chords.slots[b, 0], chords.slots[b, 1])
    )
    from_right = first < stop
    return from_right != (second < stop), from_right, np.where(from_right, first, second)
