"""Sampling the boundary of a plan, finer at bends, short sides and necks.

Edges have the wanted length wherever the plan allows it. They are shorter where a curve bends (at most `_TURN` an
edge), where a side is shorter, and where the plan is narrow, so that a neck has vertices inside it. All lengths in this
file are in units of the wanted length.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import KDTree

from ..errors import MeshError
from .outline import crossing_pairs, following_of
from .rounding import Curve, turning
from .sizes import SizeField, graded, graded_along

# Measured on a square whose corners are rounded by a tenth of its side, edges a twelfth of it: the energy with outward
# conormals is 5 % below that of fine meshes with 30°, 1.5 % with 15°.
_TURN = np.radians(15.0)
_ACROSS = 0.4  # of the width of a neck: two rows of vertices inside it
_SPACING = 0.25  # between the samples that measure the plan
_SMALLEST = 1 / 32  # bends and necks refine no further than this
MOST_ON_RIM = 50_000  # vertices
_TIP = 8.0  # at a corner sharper than about 14° the two sides count as a neck


@dataclass(frozen=True)
class Boundary:
    """The sampled boundary: `points` (B, 2), loop after loop, vertex k joined to `following[k]`.

    `loop` (B,) and `segment` (B,) give, for the edge that leaves each point, its loop and the segment of that loop as
    drawn.
    """

    points: np.ndarray
    following: np.ndarray
    loop: np.ndarray
    segment: np.ndarray


def sample(curves: list[Curve]) -> tuple[Boundary, SizeField]:
    """Sample the curves by chords as long as the size field allows, near-uniformly between fixed points.

    Where chords of different loops (or of two arms of one loop) would cross, the curves there are sampled finer.
    """
    fine = _Samples(curves)
    sizes = fine.sizes()
    for _ in range(12):
        sizes, places = fine.graded(sizes)
        _check_count(float((fine.length / sizes).sum()))
        boundary, spans = fine.boundary(sizes)
        following = boundary.points[boundary.following]
        pairs = crossing_pairs(boundary.points, following, boundary.following)
        if not len(pairs):
            break
        for k in np.unique(pairs):
            sizes[spans[k]] *= 0.5
    length = np.linalg.norm(following - boundary.points, axis=1)
    middle = (following + boundary.points) / 2
    points = np.concatenate([fine.points[places], middle])
    wanted = np.concatenate([sizes[places], np.minimum(length * 1.02, 1.0)])
    return boundary, SizeField(points, graded(points, wanted))


def _check_count(count: float) -> None:
    if count > MOST_ON_RIM:
        raise MeshError(
            f"Bends and narrow places of this plan would make about {count:.2g} vertices on the rim, and "
            f"{MOST_ON_RIM:,} are the most; widen the narrow places, or choose longer edges."
        )


class _Samples:
    """All curves cut into pieces of at most `_SPACING`, at which the plan is measured."""

    def __init__(self, curves: list[Curve]) -> None:
        cut = [_cut(curve) for curve in curves]
        counts = [len(points) for points, _, _ in cut]
        self.start = np.cumsum([0, *counts])
        self.loop = np.repeat(np.arange(len(curves)), counts)
        self.following = following_of(counts)
        self.before = np.argsort(self.following)
        self.points = np.concatenate([points for points, _, _ in cut])
        step = self.points[self.following] - self.points
        self.length = np.linalg.norm(step, axis=1)
        self.direction = step / self.length[:, None]

        def spread(values: list[np.ndarray]) -> np.ndarray:
            return np.concatenate([v[source] for v, (_, source, _) in zip(values, cut, strict=True)])

        drawn = np.concatenate([at for _, _, at in cut])
        self.segment = spread([curve.segments for curve in curves])
        self.sharp = drawn & spread([curve.sharp for curve in curves])
        self.fixed = drawn & spread([curve.fixed | _far(curve) for curve in curves])
        self.fixed[self.start[:-1]] |= ~np.logical_or.reduceat(self.fixed, self.start[:-1])
        self.bend = np.where(drawn, spread([_bend(curve) for curve in curves]), np.inf)
        self.along = np.concatenate([np.cumsum(np.append(0.0, self.length[of][:-1])) for of in self._loops()])

    def _loops(self) -> list[slice]:
        return [slice(a, b) for a, b in zip(self.start[:-1], self.start[1:], strict=True)]

    def sizes(self) -> np.ndarray:
        """The edge length that bends, sides and necks allow at each sample, at most 1."""
        refined = np.maximum(np.minimum(self.bend, _ACROSS * self._widths()), _SMALLEST)
        return np.minimum(np.minimum(1.0, refined), self._sides())

    def graded(self, sizes: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The sizes graded along the curves and across the plan, and the samples that represent them."""
        sizes = self._graded_along(sizes)
        places = self._thinned(sizes / 2)
        sizes[places] = graded(self.points[places], sizes[places])
        return self._graded_along(sizes), places

    def _graded_along(self, sizes: np.ndarray) -> np.ndarray:
        return np.concatenate([graded_along(self.length[of], sizes[of]) for of in self._loops()])

    def _thinned(self, step: np.ndarray) -> np.ndarray:
        """Samples about one `step` apart along the curves, or all samples where they lie further apart."""
        ticks = np.floor(np.cumsum(self.length / step))
        keep = np.append(True, np.diff(ticks) > 0)
        keep[self.start[:-1]] = True
        return np.flatnonzero(keep)

    def _sides(self) -> np.ndarray:
        """The edge length that divides the run between two fixed points evenly."""
        result = np.empty(len(self.points))
        for of in self._loops():
            fixed = np.flatnonzero(self.fixed[of])
            at = self.along[of][fixed]
            run = np.diff(np.append(at, at[0] + self.length[of].sum()))
            edge = run / np.maximum(1, np.ceil(run - 1e-6))
            # Before the first fixed point the index is -1: the last run, which wraps around the end of the list.
            sizes = edge[np.cumsum(self.fixed[of]) - 1]
            sizes[fixed] = np.minimum(edge, np.roll(edge, 1))
            result[of] = sizes
        return result

    def _widths(self) -> np.ndarray:
        """Width of the plan at each sample, along inward normals to the pieces that face it."""
        piece = self._thinned(np.full(len(self.points), _SPACING / 4))
        length, direction = self.length[piece], self.direction[piece]
        middle = self.points[piece] + 0.5 * length[:, None] * direction
        inward = np.column_stack([-direction[:, 1], direction[:, 0]])
        pairs = KDTree(middle).query_pairs(1.1 / _ACROSS + _SPACING, output_type="ndarray")
        pairs = np.concatenate([pairs, pairs[:, ::-1]])
        i, j = pairs[np.einsum("ij,ij->i", inward[pairs[:, 0]], inward[pairs[:, 1]]) < -0.3].T
        gap = middle[j] - middle[i]
        across = np.einsum("ij,ij->i", gap, inward[i])
        beside = np.abs(np.einsum("ij,ij->i", gap, direction[i]))
        distance = np.hypot(across, beside)
        facing = (across > 0) & (beside <= 0.6 * across + 0.5 * np.maximum(length[j], _SPACING / 4))
        facing &= ~self._same_tip(piece[i], piece[j], distance)
        width = np.full(len(self.points), np.inf)
        np.minimum.at(width, piece[i[facing]], across[facing])
        return np.minimum(width, width[self.before])

    def _same_tip(self, i: np.ndarray, j: np.ndarray, distance: np.ndarray) -> np.ndarray:
        """Whether samples i and j lie on the two sides of one corner, close to its tip: the plan is no neck there."""
        total = np.add.reduceat(self.length, self.start[:-1])[self.loop[i]]
        passed = np.concatenate([np.cumsum(self.sharp[of]) for of in self._loops()])
        corners = np.add.reduceat(self.sharp.astype(int), self.start[:-1])[self.loop[i]]
        path, between = np.abs(self.along[i] - self.along[j]), np.abs(passed[i] - passed[j])
        near = (between == 1) & (path < _TIP * distance)
        near |= (corners - between == 1) & (total - path < _TIP * distance)
        return near & (self.loop[i] == self.loop[j])

    def boundary(self, sizes: np.ndarray) -> tuple[Boundary, list[np.ndarray]]:
        """Points at equal steps of ∫ ds / size between fixed points, and the samples that each edge passes."""
        parts, spans = [], []
        for loop, of in enumerate(self._loops()):
            count = of.stop - of.start
            fixed = np.flatnonzero(self.fixed[of])
            for a, b in zip(fixed, np.append(fixed[1:], fixed[0] + count), strict=True):
                index = of.start + np.arange(a, b + 1) % count
                at, segment, ends = self._run(index, sizes, {1: 3, 2: 2}.get(len(fixed), 1))
                parts.append((at, segment, np.full(len(at), loop)))
                spans += [index[low : high + 1] for low, high in ends]
        points, segments, loops = (np.concatenate(part) for part in zip(*parts, strict=True))
        return Boundary(points, following_of(np.bincount(loops).tolist()), loops, segments), spans

    def _run(self, index: np.ndarray, sizes: np.ndarray, fewest: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Points along the run through samples `index`, without its last; segments and sample ranges of the edges.

        The size is linear along a piece of length l, from h to h + d: t edges take h (exp(t d / l) - 1) l / d of it.
        """
        length, size = self.length[index[:-1]], sizes[index]
        growth = np.diff(size) / length
        growth = np.where(np.abs(growth) < 1e-10, 1e-10, growth)
        steps = np.append(0.0, np.cumsum(np.log1p(growth * length / size[:-1]) / growth))
        count = max(fewest, int(np.ceil(steps[-1] - 1e-6)))
        ticks = np.linspace(0.0, steps[-1], 2 * count + 1)[:-1]  # every second one is the middle of an edge
        k = np.clip(np.searchsorted(steps, ticks, side="right") - 1, 0, len(length) - 1)
        reach = size[k] * np.expm1((ticks - steps[k]) * growth[k]) / growth[k]
        at = self.points[index[k]] + reach[:, None] * self.direction[index[k]]
        ends = np.column_stack([k[::2], np.append(k[2::2], len(length) - 1)])
        return at[::2], self.segment[index[k[1::2]]], ends


def _cut(curve: Curve) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Points of the curve cut into pieces of at most `_SPACING`, the source of each, whether it was drawn."""
    step = np.roll(curve.points, -1, axis=0) - curve.points
    count = np.maximum(1, np.ceil(np.linalg.norm(step, axis=1) / _SPACING - 1e-9).astype(int))
    source = np.repeat(np.arange(len(count)), count)
    part = np.arange(len(source)) - np.cumsum(np.append(0, count[:-1]))[source]
    points = curve.points[source] + (part / count[source])[:, None] * step[source]
    return points, source, part == 0


def _far(curve: Curve) -> np.ndarray:
    """Points between two segments of at least two edges each: they were drawn one by one, and stay."""
    length = np.linalg.norm(np.roll(curve.points, -1, axis=0) - curve.points, axis=1)
    return np.minimum(length, np.roll(length, 1)) >= 2.0


def _bend(curve: Curve) -> np.ndarray:
    """Length at each point over which its curve turns by `_TURN`; corners are no bends."""
    step = np.linalg.norm(np.roll(curve.points, -1, axis=0) - curve.points, axis=1)
    angle = np.where(curve.sharp, 0.0, np.abs(turning(curve.points)))
    return _TURN * 0.5 * (step + np.roll(step, 1)) / np.maximum(angle, 1e-300)
