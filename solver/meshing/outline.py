"""The outline of a plan as closed loops of points, and the checks on them.

A loop is `(K, 2)` points; segment k joins point k and point k + 1, the last one closes the loop. The first loop is the
outer outline, the others are holes. Messages number points and segments within their loop; the `vertices` and `edges`
of an error count through all loops, the outline first, the holes in their order.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial import KDTree

from ..errors import MeshError, listed
from ..linalg import check_near, out_of_range, reach_of_place

_NARROW = 1e-9  # of the plan's size: a loop no wider has no area
_SPIKE = np.radians(0.5)  # a sharper point encloses no usable area


@dataclass(frozen=True)
class Loop:
    """One checked loop with the interior of the plan on its left: the outline counter-clockwise, holes clockwise.

    `points` (K, 2); `segments` (K,): the number, in the input loop, of the segment that leaves each point; `keep` (K,)
    marks points that must stay vertices of a mesh.
    """

    name: str
    points: np.ndarray
    segments: np.ndarray
    keep: np.ndarray

    @property
    def lengths(self) -> np.ndarray:
        """Of the segments, (K,)."""
        return np.linalg.norm(np.roll(self.points, -1, axis=0) - self.points, axis=1)

    def in_units(self, origin: np.ndarray, unit: float) -> Loop:
        """The loop relative to `origin`, in lengths of `unit`."""
        return replace(self, points=(self.points - origin) / unit)


def check_loops(
    outline: np.ndarray, holes: Sequence[np.ndarray] = (), keep: Sequence[Sequence[int]] = ()
) -> list[Loop]:
    """Check outline and holes, and orient them so that the plan lies on the left of every segment.

    A repeated last point is dropped. `keep[i]` lists points of loop i that must stay vertices of a mesh. Raises
    `MeshError` for fewer than three points, NaN, repeated points, spikes, no area, loops that cross themselves or each
    other, and holes outside the outline or inside other holes.
    """
    names = ["the outline"] + [f"hole {k}" for k in range(len(holes))]
    given: list[np.ndarray] = []
    starts = [0]  # in the numbering of the input, where a loop may repeat its first point
    for points, name in zip([outline, *holes], names, strict=True):
        given.append(_as_points(points, name, starts[-1]))
        starts.append(starts[-1] + len(points))
    check_near(given[0], "The outline")
    size = float(np.ptp(given[0], axis=0).max())
    _check_repeated(given, names, starts)
    for points, name, start in zip(given, names, starts, strict=False):
        _check_width(points, name, start, size)
        _check_spikes(points, name, start)
    _check_crossings(given, names, starts)
    _check_nesting(given, names, starts)
    if len(keep) > len(given):
        raise MeshError(f"Points to keep are listed for {len(keep)} loops; the plan has {len(given)}.")
    kept = [np.asarray(list(k), dtype=np.int64) for k in keep] + [np.zeros(0, np.int64)] * (len(given) - len(keep))
    return [_oriented(p, n, k, 1 if i == 0 else -1) for i, (p, n, k) in enumerate(zip(given, names, kept, strict=True))]


def signed_area(points: np.ndarray) -> float:
    """Area enclosed by one loop (shoelace formula); negative for a clockwise one.

    Relative to the first point, so that a plan far from the origin loses no digits.
    """
    p = points - points[0]
    q = np.roll(p, -1, axis=0)
    return 0.5 * float(np.sum(p[:, 0] * q[:, 1] - p[:, 1] * q[:, 0]))


def inside(points: np.ndarray, starts: np.ndarray, ends: np.ndarray) -> np.ndarray:
    """Whether points (n, 2) lie inside the region bounded by segments `starts` → `ends` (m, 2), by the even-odd rule.

    Points are sorted by height once, so the cost is that of the crossings, not n × m. Points on a segment may count as
    inside or outside.
    """
    order = np.argsort(points[:, 1], kind="stable")
    x, y = points[order, 0], points[order, 1]
    low = np.searchsorted(y, np.minimum(starts[:, 1], ends[:, 1]), side="left")
    high = np.searchsorted(y, np.maximum(starts[:, 1], ends[:, 1]), side="left")
    segment = np.repeat(np.arange(len(starts)), high - low)
    point = _ranges(low, high - low)
    a, d = starts[segment], (ends - starts)[segment]
    crossing = a[:, 0] + (y[point] - a[:, 1]) * d[:, 0] / np.where(d[:, 1] == 0, 1.0, d[:, 1])
    odd = np.bincount(point[crossing > x[point]], minlength=len(points)) % 2 == 1
    result = np.empty(len(points), dtype=bool)
    result[order] = odd
    return result


def crossing_pairs(starts: np.ndarray, ends: np.ndarray, following: np.ndarray) -> np.ndarray:
    """Pairs (P, 2) of segments that cross or touch, except segment k and `following[k]`, which share a point."""
    left = np.minimum(starts[:, 0], ends[:, 0])
    right = np.maximum(starts[:, 0], ends[:, 0])
    order = np.argsort(left, kind="stable")
    last = np.searchsorted(left[order], right[order], side="right")
    count = np.maximum(last - np.arange(len(order)) - 1, 0)
    hits = [np.zeros((0, 2), dtype=np.int64)]
    for block in np.array_split(np.arange(len(order)), 1 + int(count.sum()) // 2_000_000):
        i = order[np.repeat(block, count[block])]
        j = order[_ranges(block + 1, count[block])]
        low, high = np.minimum(starts[:, 1], ends[:, 1]), np.maximum(starts[:, 1], ends[:, 1])
        near = (low[i] <= high[j]) & (low[j] <= high[i]) & (following[i] != j) & (following[j] != i)
        i, j = i[near], j[near]
        hit = _meet(starts[i], ends[i], starts[j], ends[j])
        hits.append(np.column_stack([np.minimum(i, j), np.maximum(i, j)])[hit])
    pairs = np.concatenate(hits)
    return pairs[np.lexsort((pairs[:, 1], pairs[:, 0]))]


def following_of(sizes: Sequence[int]) -> np.ndarray:
    """The segment after each segment, for loops of these sizes, one after the other."""
    starts = np.cumsum([0, *sizes])[:-1]
    return np.concatenate([s + (np.arange(n) + 1) % n for s, n in zip(starts, sizes, strict=True)])


def _ranges(first: np.ndarray, count: np.ndarray) -> np.ndarray:
    """The count[k] integers first[k], first[k] + 1, … for every k, one after the other."""
    return np.repeat(first - np.concatenate([[0], np.cumsum(count)[:-1]]), count) + np.arange(count.sum())


def _meet(a: np.ndarray, b: np.ndarray, c: np.ndarray, d: np.ndarray) -> np.ndarray:
    """Whether segments a-b and c-d have a common point, row by row, within rounding."""

    def side(p: np.ndarray, q: np.ndarray, r: np.ndarray) -> np.ndarray:
        u, v = q - p, r - p
        area = u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]
        rounding = 1e-13 * (np.abs(u).sum(1) + np.abs(v).sum(1)) ** 2
        return np.where(np.abs(area) <= rounding, 0.0, np.sign(area))

    one, two, three, four = side(a, b, c), side(a, b, d), side(c, d, a), side(c, d, b)
    overlap = np.all((np.minimum(a, b) <= np.maximum(c, d)) & (np.minimum(c, d) <= np.maximum(a, b)), axis=1)
    return overlap & (one * two <= 0) & (three * four <= 0)


def _as_points(points: np.ndarray, name: str, start: int) -> np.ndarray:
    try:
        array = np.array(points, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise MeshError(f"The points of {name} are not numbers; give one (x, y) a point.") from error
    if array.ndim != 2 or array.shape[1] != 2:
        raise MeshError(f"The points of {name} have shape {array.shape}; give one (x, y) a point, shape (K, 2).")
    bad, what = out_of_range(array)
    if len(bad):
        raise MeshError(
            f"Point {listed(bad)} of {name} is {what}; delete it, or move it to a place.", vertices=start + bad
        )
    if len(array) > 1 and np.array_equal(array[0], array[-1]):
        array = array[:-1]
    if len(array) < 3:
        raise MeshError(f"{name} has {len(array)} points; a closed loop needs three or more.".capitalize())
    return array


def _check_repeated(given: list[np.ndarray], names: list[str], numbers: list[int]) -> None:
    """Raise `MeshError` on points in one place, of one loop or of two: no triangle fits between them."""
    reach = reach_of_place(given[0])
    tree = KDTree(np.concatenate(given) - given[0][0])
    near = np.flatnonzero(np.asarray(tree.query(tree.data, k=2)[0])[:, 1] <= reach)
    if len(near):
        one = int(near[0])  # one pair of perhaps thousands in one place
        other = min(k for k in tree.query_ball_point(tree.data[one], reach) if k != one)
        first = np.cumsum([0] + [len(points) for points in given])
        i, j = (int(np.searchsorted(first, k, side="right")) - 1 for k in (one, other))
        a, b = one - int(first[i]), other - int(first[j])
        text = f"Points {a} and {b} of {names[i]}" if i == j else f"Point {a} of {names[i]} and point {b} of {names[j]}"
        raise MeshError(
            f"{text} are within a millionth of the plan's size of each other; merge them by distance, or move one.",
            vertices=(numbers[i] + a, numbers[j] + b),
        )


def _check_width(points: np.ndarray, name: str, start: int, size: float) -> None:
    """Raise `MeshError` if all points lie on one line. (Loops that cross themselves have their own message.)"""
    if np.linalg.svd(points - points.mean(axis=0), compute_uv=False)[1] <= _NARROW * size:
        raise MeshError(
            f"{name.capitalize()} encloses no area, its points lie on one line; draw it around the plan.",
            vertices=range(start, start + len(points)),
        )


def _check_spikes(points: np.ndarray, name: str, start: int) -> None:
    back = np.roll(points, 1, axis=0) - points
    ahead = np.roll(points, -1, axis=0) - points
    angle = np.abs(np.arctan2(back[:, 0] * ahead[:, 1] - back[:, 1] * ahead[:, 0], np.sum(back * ahead, axis=1)))
    spikes = np.nonzero(angle < _SPIKE)[0]
    if len(spikes):
        raise MeshError(
            f"Point {listed(spikes)} of {name} is a spike: its two segments fold back on each other; "
            "delete it or open its angle.",
            vertices=start + spikes,
        )


def _check_crossings(given: list[np.ndarray], names: list[str], numbers: list[int]) -> None:
    centre = given[0].mean(axis=0)
    starts = np.concatenate(given) - centre
    ends = np.concatenate([np.roll(points, -1, axis=0) for points in given]) - centre
    pairs = crossing_pairs(starts, ends, following_of([len(points) for points in given]))
    if not len(pairs):
        return
    first = np.cumsum([0] + [len(points) for points in given])
    owner = np.searchsorted(first, pairs, side="right") - 1
    segments = pairs - first[owner]
    offsets = np.asarray(numbers)[owner]
    (one, two), (here, there) = segments[0], owner[0]
    more = f" ({len(pairs)} such pairs)" if len(pairs) > 1 else ""
    if here == there:
        text = f"{names[here]} crosses or touches itself: its segments {one} and {two} meet{more}"
    else:
        text = f"{names[here]} and {names[there]} cross or touch: segment {one} meets segment {two}{more}"
    count = np.array([len(points) for points in given])[owner]
    ends = np.stack([segments, (segments + 1) % count]) + offsets
    raise MeshError(
        text[0].upper() + text[1:] + "; pull them apart.",
        vertices=np.unique(ends),
        edges=np.unique(segments + offsets),
    )


def _check_nesting(given: list[np.ndarray], names: list[str], numbers: list[int]) -> None:
    """Raise `MeshError` on misplaced holes. Loops that do not cross are nested or apart: one point of each decides."""
    for k in range(1, len(given)):
        point = given[k][:1]
        for j, other in enumerate(given):
            if j == k or inside(point, other, np.roll(other, -1, axis=0))[0] == (j == 0):
                continue
            way_out = "lies outside the outline" if j == 0 else f"lies inside {names[j]}"
            raise MeshError(
                f"{names[k].capitalize()} {way_out}; delete it or move it.",
                vertices=range(numbers[k], numbers[k] + len(given[k])),
            )


def _oriented(points: np.ndarray, name: str, keep: np.ndarray, sign: int) -> Loop:
    count = len(points)
    wrong = keep[(keep < 0) | (keep >= count)]
    if len(wrong):
        raise MeshError(f"Point {listed(wrong)} to keep is not a point of {name}, which has {count}.")
    kept = np.zeros(count, dtype=bool)
    kept[keep] = True
    index = np.arange(count)
    if signed_area(points) * sign > 0:
        return Loop(name, points, index, kept)
    # Reversed from point 0 on, so that a loop keeps its first point.
    back = -index % count
    return Loop(name, points[back], (back - 1) % count, kept[back])
