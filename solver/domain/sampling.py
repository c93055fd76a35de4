"""How fine a plan is meshed where: the size field, and the boundary sampled by it.

The length asked for holds wherever the plan allows it. It is less where a curve bends (at most `_TURN` an edge),
where a side is shorter, and where the plan is narrow (so that a neck has vertices inside it); from there it grows
by `_GROWTH` a unit of distance. All lengths in this file are in units of the length asked for.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from .outline import crossing_pairs, following_of
from .rounding import Curve, turning

_TURN = np.radians(30.0)
_GROWTH = 0.3
_ACROSS = 0.45  # of the width of a neck: two rows of vertices inside it
_SPACING = 0.25  # of the samples that measure the plan
_SMALLEST = 1 / 32  # bends and necks refine no further than this
_TIP = 8.0  # at a corner sharper than about 14° the two sides count as a neck


@dataclass(frozen=True)
class Boundary:
    """The sampled boundary: `points (B, 2)`, loop after loop, vertex k joined to `following[k]`.

    `loop (B,)` and `segment (B,)` name, for the edge that leaves each point, its loop and the segment of that loop as
    it was drawn.
    """

    points: np.ndarray
    following: np.ndarray
    loop: np.ndarray
    segment: np.ndarray


class SizeField:
    """Edge length wanted at a place: at most 1, less near the samples (`places (n, 2)`) that ask for less."""

    def __init__(self, places: np.ndarray, sizes: np.ndarray) -> None:
        small = sizes < 0.98
        self._places, self._sizes = places[small], sizes[small]
        self._tree = cKDTree(self._places) if small.any() else None

    def __call__(self, points: np.ndarray) -> np.ndarray:
        if self._tree is None:
            return np.ones(len(points))
        # The sizes at the samples already grow no faster than _GROWTH, so that a few near ones decide.
        count = min(8, len(self._places))
        distance, index = self._tree.query(points, k=count, distance_upper_bound=(1 - self._sizes.min()) / _GROWTH + 1e-9)
        sizes = np.append(self._sizes, np.inf)[index]
        reach = np.where(np.isfinite(distance), sizes + _GROWTH * distance, np.inf).reshape(len(points), count)
        return np.minimum(1.0, reach.min(axis=1))


def sample(curves: list[Curve]) -> tuple[Boundary, SizeField]:
    """Sample the curves by chords as long as the size field asks, near-uniformly between fixed points.

    Where chords of different loops (or of two arms of one loop) would cross, the curves there are sampled finer.
    """
    fine = _Fine(curves)
    sizes = fine.sizes()
    for _ in range(12):
        sizes = _graded(fine.points, sizes)
        boundary, ends = fine.boundary(sizes)
        following = boundary.points[boundary.following]
        pairs = crossing_pairs(boundary.points, following, boundary.following)
        if not len(pairs):
            break
        for k in np.unique(pairs):
            sizes[ends[k, 0] : ends[k, 1] + 1] *= 0.5
    length = np.linalg.norm(boundary.points[boundary.following] - boundary.points, axis=1)
    middle = (boundary.points[boundary.following] + boundary.points) / 2
    places, wanted = np.concatenate([fine.points, middle]), np.concatenate([sizes, np.minimum(length * 1.02, 1.0)])
    return boundary, SizeField(places, _graded(places, wanted))


class _Fine:
    """All curves cut to pieces of at most `_SPACING`: where the plan is measured."""

    def __init__(self, curves: list[Curve]) -> None:
        cut = [_cut(curve) for curve in curves]
        self.sizes_of_loops = [len(points) for points, _, _ in cut]
        self.points = np.concatenate([points for points, _, _ in cut])
        self.segment = np.concatenate([curve.segments[source] for curve, (_, source, _) in zip(curves, cut, strict=True)])
        self.start = np.cumsum([0, *self.sizes_of_loops])
        self.loop = np.repeat(np.arange(len(curves)), self.sizes_of_loops)
        self.following = following_of(self.sizes_of_loops)
        step = self.points[self.following] - self.points
        self.length = np.linalg.norm(step, axis=1)
        self.direction = step / self.length[:, None]
        original = np.concatenate([at for _, _, at in cut])
        self.sharp = original & np.concatenate([c.sharp[s] for c, (_, s, _) in zip(curves, cut, strict=True)])
        self.fixed = original & np.concatenate([c.fixed[s] | _far(c)[s] for c, (_, s, _) in zip(curves, cut, strict=True)])
        self.fixed[self.start[:-1]] |= ~np.add.reduceat(self.fixed, self.start[:-1]).astype(bool)
        bend = np.concatenate([_bend(c)[s] for c, (_, s, _) in zip(curves, cut, strict=True)])
        self.bend = np.where(original, bend, np.inf)
        self.along = np.concatenate([np.cumsum(np.r_[0.0, self._of(self.length, i)[:-1]]) for i in range(len(curves))])

    def _of(self, values: np.ndarray, loop: int) -> np.ndarray:
        return values[self.start[loop] : self.start[loop + 1]]

    def sizes(self) -> np.ndarray:
        """The length that bends, sides and necks allow at each sample, at most 1."""
        refined = np.maximum(np.minimum(self.bend, _ACROSS * self._widths()), _SMALLEST)
        return np.minimum(np.minimum(1.0, refined), self._sides())

    def _sides(self) -> np.ndarray:
        """Length of the edges that the run between two fixed points is divided into, at least."""
        result = np.empty(len(self.points))
        for first, stop in zip(self.start[:-1], self.start[1:], strict=True):
            fixed = np.nonzero(self.fixed[first:stop])[0]
            at = self.along[first + fixed]
            run = np.diff(np.append(at, at[0] + self.length[first:stop].sum()))
            edge = run / np.maximum(1, np.ceil(run - 1e-6))
            of = np.cumsum(self.fixed[first:stop]) - 1  # -1 is the run that passes the end of the list
            result[first:stop] = edge[of]
            result[first + fixed] = np.minimum(edge, np.roll(edge, 1))
        return result

    def _widths(self) -> np.ndarray:
        """Width of the plan at each piece, measured along its inward normal to pieces that face it."""
        middle = self.points + 0.5 * self.length[:, None] * self.direction
        inward = np.column_stack([-self.direction[:, 1], self.direction[:, 0]])
        pairs = cKDTree(middle).query_pairs(1.1 / _ACROSS + _SPACING, output_type="ndarray")
        pairs = np.concatenate([pairs, pairs[:, ::-1]])
        i, j = pairs[np.einsum("ij,ij->i", inward[pairs[:, 0]], inward[pairs[:, 1]]) < -0.3].T
        gap = middle[j] - middle[i]
        across = np.einsum("ij,ij->i", gap, inward[i])
        beside = np.abs(np.einsum("ij,ij->i", gap, self.direction[i]))
        facing = (across > 0) & (beside <= 0.6 * across + 0.5 * self.length[j]) & ~self._same_tip(i, j, gap)
        width = np.full(len(middle), np.inf)
        np.minimum.at(width, i[facing], across[facing])
        return np.minimum(width, width[np.argsort(self.following)])

    def _same_tip(self, i: np.ndarray, j: np.ndarray, gap: np.ndarray) -> np.ndarray:
        """Whether i and j lie on the two sides of one corner, close to its tip: there the plan is not a neck."""
        total = np.add.reduceat(self.length, self.start[:-1])[self.loop[i]]
        corners = np.concatenate([np.cumsum(self._of(self.sharp, k)) for k in range(len(self.sizes_of_loops))])
        all_corners = np.add.reduceat(self.sharp.astype(int), self.start[:-1])[self.loop[i]]
        path, between = np.abs(self.along[i] - self.along[j]), np.abs(corners[i] - corners[j])
        distance = np.linalg.norm(gap, axis=1)
        near = (between == 1) & (path < _TIP * distance)
        near |= (all_corners - between == 1) & (total - path < _TIP * distance)
        return near & (self.loop[i] == self.loop[j])

    def boundary(self, sizes: np.ndarray) -> tuple[Boundary, np.ndarray]:
        """Points at equal steps of ∫ ds / size between fixed points, and the samples (B, 2) that each edge spans."""
        points, segment, spans, loops = [], [], [], []
        for loop, (first, stop) in enumerate(zip(self.start[:-1], self.start[1:], strict=True)):
            fixed = first + np.nonzero(self.fixed[first:stop])[0]
            for a, b in zip(fixed, np.append(fixed[1:], fixed[0] + stop - first), strict=True):
                index = first + (np.arange(a, b + 1) - first) % (stop - first)
                at, seg, span = self._run(index, sizes, 3 if len(fixed) == 1 else 2 if len(fixed) == 2 else 1)
                points.append(at)
                segment.append(seg)
                spans.append(span)
                loops.append(np.full(len(at), loop))
        loop = np.concatenate(loops)
        following = following_of(np.bincount(loop).tolist())
        return Boundary(np.concatenate(points), following, loop, np.concatenate(segment)), np.concatenate(spans)

    def _run(self, index: np.ndarray, sizes: np.ndarray, fewest: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Sample the run through fine points `index`; its last point belongs to the next run."""
        length = self.length[index[:-1]]
        steps = np.r_[0.0, np.cumsum(length * 0.5 * (1 / sizes[index[:-1]] + 1 / sizes[index[1:]]))]
        count = max(fewest, int(np.ceil(steps[-1] - 1e-6)))
        ticks = np.linspace(0.0, steps[-1], 2 * count + 1)[:-1]
        k = np.clip(np.searchsorted(steps, ticks, side="right") - 1, 0, len(length) - 1)
        part = (ticks - steps[k]) / (steps[k + 1] - steps[k])
        at = self.points[index[k]] + (part * length[k])[:, None] * self.direction[index[k]]
        low, high = index[k[::2]], index[np.append(k[2::2], len(length) - 1)]
        span = np.column_stack([np.minimum(low, high), np.maximum(low, high)])
        return at[::2], self.segment[index[k[1::2]]], span


def _cut(curve: Curve) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Points of the curve cut to pieces of at most `_SPACING`, the piece each lies on, whether it was a point before."""
    step = np.roll(curve.points, -1, axis=0) - curve.points
    count = np.maximum(1, np.ceil(np.linalg.norm(step, axis=1) / _SPACING - 1e-9).astype(int))
    source = np.repeat(np.arange(len(count)), count)
    first = np.cumsum(np.r_[0, count[:-1]])
    part = np.arange(len(source)) - first[source]
    points = curve.points[source] + (part / count[source])[:, None] * step[source]
    return points, source, part == 0


def _far(curve: Curve) -> np.ndarray:
    """Points between two long segments: they were drawn one by one, and stay."""
    length = np.linalg.norm(np.roll(curve.points, -1, axis=0) - curve.points, axis=1)
    return np.minimum(length, np.roll(length, 1)) >= 1.0


def _bend(curve: Curve) -> np.ndarray:
    """Length at each point over which its curve turns by `_TURN`; corners are no bends."""
    step = np.linalg.norm(np.roll(curve.points, -1, axis=0) - curve.points, axis=1)
    angle = np.where(curve.sharp, 0.0, np.abs(turning(curve.points)))
    return _TURN * 0.5 * (step + np.roll(step, 1)) / np.maximum(angle, 1e-300)


def _graded(places: np.ndarray, sizes: np.ndarray) -> np.ndarray:
    """The largest sizes below `sizes` that grow by no more than `_GROWTH` a unit of distance."""
    result = sizes.copy()
    small = np.nonzero(sizes < 0.98)[0]
    if len(small):
        reach = (1 - sizes[small].min()) / _GROWTH
        near = cKDTree(places).sparse_distance_matrix(cKDTree(places[small]), reach, output_type="ndarray")
        np.minimum.at(result, near["i"], sizes[small][near["j"]] + _GROWTH * near["v"])
    return result
