"""The sides of a boundary that a fit treats apart: on a line, over one, with given normals, in a mirror, free.

Where a side with given normals meets one on a line, a blend zone of the former is neither held nor on a line. Without
it the surface near the junction goes as the fourth root of the distance from there, which no mesh resolves.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ..domain.domain import Domain
from ..errors import ConditionError, plural
from ..gauss.boundary_data import Conditions
from ..gauss.mirrors import MirrorSides
from ..gauss.sphere import dot, normalize
from .response import runs

Array = NDArray[np.float64]
Int = NDArray[np.integer]

_NORMALS = ("vertex_normals", "edge_normals", "behind_normals", "corner_normals", "up")
LINE, HELD, MIRROR, FREE, LEAN = "line", "held", "mirror", "free", "lean"
# The part of a side that one of its blend zones takes at most.
_ZONE = 1.0 / 3.0
# The part of the size from a junction up to which leans are not asked for, and starts are smoothed.
NEAR = 0.05
# Radians of leans that make a start, and how even they are.
_LEANS = np.radians(45.0), np.radians(150.0)
_EVEN = np.radians(10.0)


@dataclass(frozen=True, eq=False)
class Side:
    """A run of the boundary of one kind: vertices (k,) in order, with both ends, or around a whole loop (closed).

    loop: the number of its boundary loop. parts (k,): 1 where the kind holds fully; in the blend zones of a side with
    given normals they rise from 0 at the junction. normals (k, 3): those given; of a mirror that of its plane; of a
    side that leans the level ones of the wall over its line, out of the plan. angle: at which it meets that wall.
    """

    kind: str
    loop: int
    vertices: Int
    closed: bool
    parts: Array
    normals: Array
    angle: float = 0.0

    @property
    def zone(self) -> Int:
        """The vertices of its blend zones, without the junctions."""
        return self.vertices[(self.parts > 0.0) & (self.parts < 1.0)]


@dataclass(frozen=True, eq=False)
class Sides:
    """All sides of the boundary of a domain.

    drawn: the plan (V, 3). near: the length from a junction up to which a surface that leans may do so otherwise than
    asked. given: the conditions with normals and mirrors; vertices (n,), normals (n, 3): the given normals.
    """

    all: list[Side]
    drawn: Array
    near: float
    given: Conditions
    vertices: Int
    normals: Array

    @classmethod
    def of(
        cls,
        domain: Domain,
        points: Array,
        given: Conditions,
        free: Int,
        size: float,
        blend: float,
    ) -> Sides:
        """The sides of a plan (V, 3); edges that are not in `given` or `free` are on their line.

        blend: the length of blend zones by the size. Raises `ConditionError` on an edge that is in two of them.
        """
        labels, kinds = _labels(domain, given, free)
        none = Conditions()
        given = replace(given, lines=none.lines, curves=(), leans=none.leans, lean_angles=none.lean_angles)
        vertices, normals = given.resolve()
        inside = np.setdiff1d(vertices, domain.boundary_vertices)
        if len(inside):
            raise ConditionError(
                f"Normals are given inside, at {plural('vertex', inside)}; give them along the boundary only.",
                vertices=inside,
            )
        along = ~np.isin(vertices, given.only_vertices)
        normals[along] = MirrorSides.of(domain, given).blended(vertices[along], normals[along])
        at = np.zeros((domain.vertex_count, 3))
        at[vertices] = normals
        found = []
        for number, edges in enumerate(domain.boundary_loop_edges):
            loop = domain.boundary_loops[number].astype(np.int64)
            for run in _runs(labels[edges]):
                ends = np.append(run, (run[-1] + 1) % len(loop)) if len(run) < len(loop) else run
                kind, angle, plane = kinds[labels[edges[run[0]]]]
                its = loop[ends]
                normals_there = at[its] if kind == HELD else np.tile(plane, (len(its), 1))
                side = Side(kind, number, its, len(run) == len(loop), np.ones(len(its)), normals_there, angle)
                found.append(replace(side, normals=walls(points, side)) if kind == LEAN else side)
        found = [_zoned(side, found, points, blend * size) if side.kind == HELD else side for side in found]
        return cls(found, points, NEAR * size, given, vertices, normals)

    def edges(self, side: Side) -> Int:
        """The vertex pairs (n, 2) of a side's edges."""
        ahead = np.roll(side.vertices, -1)
        pairs = np.column_stack([side.vertices, ahead])
        return pairs if side.closed else pairs[:-1]

    def start_leans(self, side: float) -> list[tuple[Int, float]]:
        """Edges and angles of the sides with given normals that nearly lean over their lines, not too steeply.

        A surface that meets the walls there is a nearer start than one with its rim on those lines. side: -1 for f-,
        whose normals are -N.
        """
        found = []
        for each in self.of_kind(HELD):
            N = side * each.normals
            angles = np.arccos(np.clip(dot(N, walls(self.drawn, each))[:, 0], -1.0, 1.0))
            angle = float(np.median(angles))
            is_even = np.abs(angles - angle).max() < _EVEN and _LEANS[0] < angle < _LEANS[1]
            if is_even and (N[:, 2] > 0.0).all():
                found.append((self.edges(each), angle))
        return found

    def of_kind(self, *kinds: str) -> Iterator[Side]:
        return (side for side in self.all if side.kind in kinds)

    def has(self, *kinds: str) -> bool:
        return any(True for _ in self.of_kind(*kinds))

    @property
    def held(self) -> Int:
        """Sorted vertices whose normals stay: those given, but for blend zones and the ends of lines."""
        freed = [side.vertices for side in self.of_kind(LINE, LEAN)] + [side.zone for side in self.of_kind(HELD)]
        return np.setdiff1d(self.vertices, np.concatenate(freed))

    @property
    def junctions(self) -> Int:
        """Sorted ends of the sides on lines and over them, which stay in their places."""
        ends = [side.vertices[[0, -1]] for side in self.of_kind(LINE, LEAN) if not side.closed]
        return np.unique(np.concatenate([np.zeros(0, dtype=np.int64), *ends]))

    def conditions(self, N: Array, *, continued: bool = False) -> Conditions:
        """The given conditions, with normals at all vertices that have one of their own.

        At first those along lines are those of N (V, 3), and in blend zones they run smoothly from these to the given
        ones. continued: N is of an earlier fit, and in blend zones it changes with the given normals beside them.
        """
        N = N if continued else self._smoothed(N)
        normals, fixed = N.copy(), [self.held]
        up = np.array([0.0, 0.0, np.sign(N[:, 2].sum()) or 1.0])
        normals[self.vertices] = self.normals
        for side in self.of_kind(LINE, LEAN):
            normals[side.vertices] = N[side.vertices]
            fixed.append(side.vertices)
        for side in self.of_kind(HELD):
            inside, full = (np.flatnonzero(np.isin(side.vertices, of)) for of in (side.zone, self.held))
            here, part = N[side.zone], side.parts[inside, None]
            change = side.normals[inside] - here
            if continued and len(full):
                nearest = full[np.abs(inside[:, None] - full).argmin(axis=1)]
                change = side.normals[nearest] - N[side.vertices[nearest]]
            normals[side.zone] = normalize(here + part * change)
            fixed.append(side.zone)
        vertices, none = np.unique(np.concatenate(fixed)), Conditions()
        return replace(
            self.given,
            up=self.given.up if self.given.up.any() else up,
            vertices=vertices,
            vertex_normals=normals[vertices],
            only_vertices=vertices,
            edges=none.edges,
            edge_normals=none.edge_normals,
            behind_normals=none.edge_normals,
        )


    def far(self, side: Side) -> NDArray[np.bool_]:
        """(k,) which vertices of a side are far from its ends."""
        if side.closed:
            return np.ones(len(side.vertices), dtype=bool)
        along = _along(self.drawn, side.vertices)
        return np.minimum(along, along[-1] - along) > self.near

    def _smoothed(self, N: Array) -> Array:
        """N (V, 3) with an even turn near each junction with a line, where that of a span is steep and rough."""
        N = N.copy()
        for side in self.of_kind(HELD, LEAN):
            for run in () if side.closed else (side.vertices, side.vertices[::-1]):
                for other in self.of_kind(LINE):
                    if run[0] in other.vertices[[0, -1]]:
                        line = other.vertices if other.vertices[0] == run[0] else other.vertices[::-1]
                        here, there = (each[_along(self.drawn, each) < self.near] for each in (run, line))
                        way = np.concatenate([here[:0:-1], there])
                        turn = np.linspace(0.0, 1.0, len(way))[:, None]
                        N[way] = normalize((1.0 - turn) * N[way[0]] + turn * N[way[-1]])
        return N


def _along(points: Array, vertices: Int) -> Array:
    """(k,) the length of the polyline through some vertices, up to each of them."""
    return np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points[vertices], axis=0), axis=1))])


def _labels(domain: Domain, given: Conditions, free: Int) -> tuple[Int, list[tuple[str, float, Array]]]:
    """(E,) the kind of each edge, an index of kinds with angles and the normals of planes."""
    planes, of_plane = np.unique(given.mirror_normals, axis=0, return_inverse=True)
    angles, of_angle = np.unique(given.lean_angles, return_inverse=True)
    none = np.zeros(3)
    kinds = [(LINE, 0.0, none), (HELD, 0.0, none), (FREE, 0.0, none), (LINE, 0.0, none)]
    kinds += [(LEAN, float(angle), none) for angle in angles] + [(MIRROR, 0.0, plane) for plane in planes]
    rim, labels = domain.boundary_edges, np.zeros(len(domain.edge_lengths), dtype=np.int64)
    at_vertices = rim[np.isin(domain.edges[rim], given.only_vertices).all(axis=1)]
    chosen = [np.union1d(given.edges, at_vertices), free, given.lines]
    chosen += [given.leans[of_angle == k] for k in range(len(angles))]
    chosen += [given.mirrors[of_plane.ravel() == k] for k in range(len(planes))]
    for label, edges in enumerate(chosen, start=1):
        twice = edges[labels[edges] > 0]
        if len(twice):
            other = kinds[labels[twice[0]]][0]
            raise ConditionError(
                f"{plural('edge', twice).capitalize()} of the boundary cannot be {_AS[kinds[label][0]]} and "
                f"{_AS[other]}; take the edges out of one of the two.",
                edges=twice,
            )
        labels[edges] = label
    labels[given.lines] = 0
    return labels, kinds


_AS = {
    LINE: "on a line",
    HELD: "held by given normals",
    MIRROR: "in a mirror",
    FREE: "free",
    LEAN: "leaning over a line",
}


def _runs(labels: Int) -> list[Int]:
    """The places of each run of equal labels around a loop."""
    return [run for label in np.unique(labels) for run in runs(labels == label)]


def walls(points: Array, side: Side) -> Array:
    """(k, 3) the level normals, out of the plan, of the wall over a side; the plan is on the left. Zero where the side
    stands upright, or turns back on itself: there is no wall."""
    way = points[side.vertices]
    ahead = np.roll(way, -1, axis=0) - way
    behind = np.roll(ahead, 1, axis=0)
    if not side.closed:
        ahead[-1], behind[0] = behind[-1], ahead[0]
    along = _level(ahead) + _level(behind)
    return _level(np.column_stack([along[:, 1], -along[:, 0], np.zeros(len(along))]))


def _level(X: Array) -> Array:
    """The level directions of X, row by row; zero where it has none."""
    level = X * [1.0, 1.0, 0.0]
    return level / np.maximum(np.sqrt(dot(level, level)), 1e-300)


def _zoned(side: Side, all_sides: Sequence[Side], points: Array, zone: float) -> Side:
    """A side with given normals with its blend zones, next to lines."""
    if side.closed:
        return side
    along = _along(points, side.vertices)
    length = min(zone, _ZONE * along[-1])
    parts = np.ones(len(along))
    on_line = np.concatenate([[-1], *(each.vertices for each in all_sides if each.kind in (LINE, LEAN))])
    for end, far in ((side.vertices[0], along), (side.vertices[-1], along[-1] - along)):
        if end in on_line:
            t = np.clip(far / max(length, 1e-300), 0.0, 1.0)
            parts = np.minimum(parts, t * t * (3.0 - 2.0 * t))
    return replace(side, parts=parts)


def opposite(conditions: Conditions) -> Conditions:
    """The same conditions for the opposite map, -N: those of f- as a sheet of its own."""
    turned = {name: -getattr(conditions, name) for name in _NORMALS}
    return replace(conditions, **turned)
