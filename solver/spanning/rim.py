"""The rim of a spanning surface: how its vertices may slide.

A rim vertex has two numbers, one or none: it slides along a curve, up and down over one, in a plane, along a straight
line, or stays. All
numbers together are x (n,), and p(x) (B, 3) are the places of the B rim vertices. Number k moves the vertex `owner[k]`
along the tangent T_k = ∂p/∂x_k and bends it by ∂²p/∂x_k²; mixed derivatives vanish. A `Track` is a run of vertices
that slide in the same way.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..linalg import sum_rows
from .curves import SmoothCurve

Array = NDArray[np.float64]
Int = NDArray[np.integer]

# The part of a gap between neighbours on a curve that one step may close, and of the curve that a vertex may slide.
_GAP = 0.55
_FAR = 0.1


class Track(Protocol):
    """Rim vertices `vertices` (k,) that slide alike, each with `width` numbers, from `start` (k, width).

    on_line: whether they stay on a given line. given: all that the track was made of, as arrays.
    """

    vertices: Int
    width: int
    start: Array
    on_line: bool
    given: tuple[ArrayLike, ...]

    def at(self, x: Array) -> tuple[Array, Array, Array]:
        """Places (k, 3), tangents and bends (k, width, 3) at x (k, width)."""
        ...

    def limit(self, x: Array, change: Array) -> float:
        """The largest multiple of `change` (k, width) that is still a step, not a jump."""
        ...


class AlongCurve:
    """Vertices that slide along a curve in this order, from s = start.

    ends: s of held vertices before the first and behind the last, on an open curve.
    """

    width = 1
    on_line = True

    def __init__(
        self, vertices: Int, curve: SmoothCurve, start: Array, ends: tuple[float, float] | None = None
    ) -> None:
        self.vertices, self.curve, self.ends = vertices, curve, ends
        self.start = np.asarray(start, dtype=np.float64).reshape(-1, 1)
        self.given: tuple[ArrayLike, ...] = (vertices, curve.points, curve.closed, self.start, ends or ())

    def at(self, x: Array) -> tuple[Array, Array, Array]:
        points, tangents, bends = self.curve.at(x[:, 0])
        return points, tangents[:, None], bends[:, None]

    def limit(self, x: Array, change: Array) -> float:
        """No gap closes by more than a part of itself, so that vertices keep their order."""
        if not len(x):
            return np.inf
        closing = np.maximum(-self.gaps(change[:, 0], moved=True), 1e-300)
        furthest = max(float(np.abs(change).max()), 1e-300)
        with np.errstate(over="ignore"):  # gaps that do not close
            steps = _GAP * np.maximum(self.gaps(x[:, 0]), 0.0) / closing
        return min(float(steps.min()), _FAR * self.curve.length / furthest)

    def gaps(self, s: Array, *, moved: bool = False) -> Array:
        """Distances along the curve between neighbours; their changes if s are changes (`moved`)."""
        if self.ends is not None:
            return np.diff(np.concatenate([[0.0], s, [0.0]] if moved else [self.ends[:1], s, self.ends[1:]]))
        return np.diff(s, append=s[:1] + (0.0 if moved else self.curve.length))


class OverCurve:
    """Vertices that stay over a curve seen from above, from (s, z) = start (k, 2); their heights are free.

    angle: at which the surface meets the wall there, radians. ends: the rim vertices over both ends of an open curve,
    in order along the rim, one or more at each.
    """

    width = 2
    on_line = False

    def __init__(
        self, vertices: Int, curve: SmoothCurve, start: Array, angle: float, ends: tuple[Int, Int] | None = None
    ) -> None:
        self.vertices, self.curve, self.start = vertices, curve, start
        self.angle, self.ends = angle, ends
        self.given: tuple[ArrayLike, ...] = (vertices, curve.points, curve.closed, start, angle, *(ends or ()))

    def at(self, x: Array) -> tuple[Array, Array, Array]:
        points, tangents, bends = self.curve.at(x[:, 0])
        points[:, 2] = x[:, 1]
        up = np.broadcast_to([0.0, 0.0, 1.0], points.shape)
        return points, np.stack([tangents, up], axis=1), np.stack([bends, np.zeros_like(bends)], axis=1)

    def runs_back(self, x: Array) -> float:
        """The furthest that a vertex lies behind one that comes before it, or beyond an end, along the curve."""
        s = x[:, 0]
        if self.ends is None:
            s = np.concatenate([s, s[:1] + self.curve.length])
        else:
            s = np.concatenate([[0.0], s, [self.curve.length]])
        return float((np.maximum.accumulate(s) - s).max())

    def limit(self, x: Array, change: Array) -> float:
        return np.inf


class Straight:
    """Vertices that slide from `places` (k, 3) in a plane, along a line, or not at all: axes (k, 0 … 2, 3)."""

    def __init__(self, vertices: Int, places: Array, axes: Array) -> None:
        self.vertices, self.places, self.axes = vertices, places, axes
        self.width = axes.shape[1]
        self.on_line = self.width == 0
        self.start = np.zeros((len(vertices), self.width))
        self.given: tuple[ArrayLike, ...] = (vertices, places, axes)

    @classmethod
    def held(cls, vertices: Int, places: Array) -> Straight:
        """Vertices that stay at their places."""
        return cls(vertices, places, np.zeros((len(vertices), 0, 3)))

    def at(self, x: Array) -> tuple[Array, Array, Array]:
        return self.places + np.einsum("ka,kaj->kj", x, self.axes), self.axes, np.zeros_like(self.axes)

    def limit(self, x: Array, change: Array) -> float:
        return np.inf


@dataclass(frozen=True, eq=False)
class RimPoint:
    """The rim at x: its points (B, 3); of each number tangent and bend (n, 3), and the vertex owner (n,) it moves."""

    points: Array
    tangents: Array
    bends: Array
    owner: Int

    def push(self, dx: Array) -> Array:
        """T dx (B, 3)."""
        return sum_rows(self.owner, dx[:, None] * self.tangents, len(self.points))

    def pull(self, force: Array) -> Array:
        """Tᵀ force (n,), of forces (B, 3) on the rim."""
        return np.einsum("ki,ki->k", self.tangents, force[self.owner])

    def bend(self, force: Array) -> Array:
        """(n,) the second derivative of <force, p(x)> by each number."""
        return np.einsum("ki,ki->k", self.bends, force[self.owner])


class Rim:
    """All tracks of a rim of `count` vertices, each of which is on exactly one track."""

    def __init__(self, tracks: Sequence[Track], count: int) -> None:
        self.tracks = tuple(tracks)
        self.count = count
        self.owner = np.concatenate([np.repeat(track.vertices, track.width) for track in tracks]).astype(np.int64)
        self.start = np.concatenate([track.start.ravel() for track in tracks])
        self._ends = np.cumsum([track.start.size for track in tracks])

    def parts(self, x: Array) -> list[Array]:
        """The numbers x (n,) of each track, (k, width)."""
        split = np.split(x, self._ends[:-1])
        return [part.reshape(len(t.vertices), t.width) for part, t in zip(split, self.tracks, strict=True)]

    def at(self, x: Array) -> RimPoint:
        """The rim at x (n,)."""
        points = np.empty((self.count, 3))
        tangents, bends = [], []
        for track, part in zip(self.tracks, self.parts(x), strict=True):
            points[track.vertices], tangent, bend = track.at(part)
            tangents.append(tangent.reshape(-1, 3))
            bends.append(bend.reshape(-1, 3))
        return RimPoint(points, np.concatenate(tangents), np.concatenate(bends), self.owner)

    def is_like(self, other: Rim) -> bool:
        """Whether the other rim moves the same vertices by tracks of the same kinds."""
        kinds = [[(type(t), len(t.vertices), t.width) for t in rim.tracks] for rim in (self, other)]
        return kinds[0] == kinds[1] and np.array_equal(self.owner, other.owner)

    def is_same(self, other: Rim) -> bool:
        """Whether the other rim is the same in all: tracks, places and curves."""
        return self.is_like(other) and all(
            all(np.array_equal(a, b) for a, b in zip(mine.given, its.given, strict=True))
            for mine, its in zip(self.tracks, other.tracks, strict=True)
        )

    def adopted(self, other: Rim, x: Array) -> Array | None:
        """The numbers (n,) that put the vertices where x puts them on another rim with like tracks; None if unlike."""
        if not self.is_like(other):
            return None
        mine = []
        for track, its, part in zip(self.tracks, other.tracks, other.parts(x), strict=True):
            if isinstance(track, AlongCurve) and isinstance(its, AlongCurve):
                part = part * (track.curve.length / its.curve.length)
            mine.append(part.ravel())
        return np.concatenate(mine)

    def renumbered(self, other: Rim, x: Array) -> Array:
        """The numbers (n,) that leave the vertices where x puts them on another rim of the same lines and sides, from
        which some vertices now stand upright at an end of their side, or no longer do."""
        track_of, row_of = np.zeros((2, self.count), dtype=np.int64)
        for k, track in enumerate(other.tracks):
            track_of[track.vertices], row_of[track.vertices] = k, np.arange(len(track.vertices))
        points, parts, made = other.at(x).points, other.parts(x), []
        for track in self.tracks:
            part = track.start.copy()
            for row, vertex in enumerate(track.vertices.tolist()):
                before = parts[track_of[vertex]][row_of[vertex]]
                if isinstance(other.tracks[track_of[vertex]], type(track)) and len(before) == track.width:
                    part[row] = before
                elif isinstance(track, OverCurve):
                    part[row, 1] = points[vertex, 2]
                elif isinstance(track, Straight) and track.width == 1:
                    part[row] = points[vertex, 2] - track.places[row, 2]
            made.append(part.ravel())
        return np.concatenate(made)

    def limit(self, x: Array, change: Array) -> float:
        """The largest multiple of `change` (n,) that keeps the order of the vertices."""
        parts = zip(self.tracks, self.parts(x), self.parts(change), strict=True)
        return min(track.limit(*numbers) for track, *numbers in parts)

    def stretches(self, x: Array) -> tuple[float, float]:
        """The least and the greatest gap between neighbours on a curve, in parts of what they were at the start."""
        least, most = 1.0, 1.0
        for track, now in zip(self.tracks, self.parts(x), strict=True):
            if isinstance(track, AlongCurve) and len(now):
                ratio = track.gaps(now[:, 0]) / np.maximum(track.gaps(track.start[:, 0]), 1e-300)
                least, most = min(least, float(ratio.min())), max(most, float(ratio.max()))
        return least, most

    def runs_back(self, x: Array) -> float:
        """The furthest that a vertex of a leaning side lies behind the one before it, or beyond an end of the side."""
        over = [(t, part) for t, part in zip(self.tracks, self.parts(x), strict=True) if isinstance(t, OverCurve)]
        return max((track.runs_back(part) for track, part in over), default=0.0)

    @property
    def on_line(self) -> NDArray[np.bool_]:
        """(B,) which vertices lie on a given line: those that slide along it or stay."""
        return np.isin(np.arange(self.count), [v for t in self.tracks if t.on_line for v in t.vertices])

    @property
    def leaning(self) -> NDArray[np.bool_]:
        """(B,) which vertices lie over a line, at a free height, or between two such sides."""
        over = [t for t in self.tracks if isinstance(t, OverCurve)]
        ends = [v for t in over if t.ends is not None for end in t.ends for v in end]
        return np.isin(np.arange(self.count), [v for t in over for v in t.vertices] + ends)

    def tangents(self, x: Array) -> Array:
        """(B, 3) γ' at the vertices that slide along a curve; zero at the others."""
        found = np.zeros((self.count, 3))
        for track, part in zip(self.tracks, self.parts(x), strict=True):
            if isinstance(track, AlongCurve):
                found[track.vertices] = track.at(part)[1][:, 0]
        return found
