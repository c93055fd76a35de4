"""From lines, leans and mirrors along the boundary loops of a plan to the tracks on which rim vertices slide."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from ..errors import ConditionError
from .curves import SmoothCurve, corners, without_repeats
from .lines import best_turn, parts_of_length, starts
from .rim import AlongCurve, OverCurve, Straight, Track

Array = NDArray[np.float64]
Int = NDArray[np.integer]

LINE = -1
# Planes whose normals enclose a smaller sine have no line in common.
_PARALLEL = 1e-6


@dataclass(frozen=True, eq=False)
class Side:
    """The tracks of a loop, and its marked points: places along it."""

    tracks: list[Track]
    marks: Int


def own_line(places: Int, points: Array, sharp: bool, anchors: Int) -> Side:
    """A loop that spans its own points (n, 3); places (n,) of its vertices on the rim; anchors: those that stay, along
    the loop."""
    pins = np.union1d(corners(points), anchors) if sharp else anchors
    s = parts_of_length(points)
    return Side(_along_line(places, points, s, pins, pins), pins)


def other_line(places: Int, points: Array, line: Array, sharp: bool) -> Side:
    """A loop that spans another closed line (m, 3).

    Vertices start at their parts of the length, from the place on the line that makes it most like the loop. Corners of
    the line are met by those of the loop where both have equally many, else by the vertices nearest to them.
    """
    line = without_repeats(line)
    bends = corners(line) if sharp else np.zeros(0, dtype=np.int64)
    own = corners(points)
    if len(bends) and len(bends) == len(own):
        laid = np.stack([line[np.roll(bends, -k)] for k in range(len(bends))])
        bends = np.roll(bends, -best_turn(points[own], laid)) if len(bends) > 1 else bends
        return Side(_along_line(places, line, parts_of_length(points), own, bends), own)
    curve = SmoothCurve(line, closed=True)
    choices = starts(parts_of_length(points), 1.0)
    laid = np.stack([curve.at(each * curve.length)[0] for each in choices])
    s = choices[best_turn(points, laid)]
    pins = np.array([_nearest(s, part) for part in parts_of_length(line)[bends]], dtype=np.int64)
    order = np.argsort(pins)
    if len(np.unique(pins)) < len(pins):
        raise ConditionError("The plan is too coarse for the curve: two of its corners fall on one vertex; refine it.")
    return Side(_along_line(places, line, s, pins[order], bends[order]), pins[order])


def _nearest(s: Array, part: float) -> int:
    return int(np.argmin(np.abs((s - part + 0.5) % 1.0 - 0.5)))


def _along_line(places: Int, line: Array, s: Array, pins: Int, bends: Int) -> list[Track]:
    """Tracks along a closed line, whose corners `bends` hold the vertices `pins`; s (n,): parts of its length."""
    if not len(pins):
        curve = SmoothCurve(line, closed=True)
        return [AlongCurve(places, curve, s * curve.length)]
    tracks: list[Track] = [Straight.held(places[pins], line[bends])]
    for k in range(len(pins)):
        here, there = pins[k], pins[(k + 1) % len(pins)]
        run = _run(here, there, len(places))
        piece = line[_run(bends[k], bends[(k + 1) % len(pins)], len(line))]
        tracks += _open_track(places[run[1:-1]], piece, (s[run] - s[here]) % 1.0)
    return tracks


def _run(start: int, end: int, count: int) -> Int:
    """Places from start to end around a ring of `count`, both included; all of it and back if they are one."""
    return (start + np.arange(((end - start - 1) % count) + 2)) % count


def _open_track(places: Int, line: Array, parts: Array) -> Iterator[Track]:
    """Vertices along an open line; parts: increasing, of both ends, too, in any unit; the last may have come round."""
    if not len(places):
        return
    parts = np.append(parts[:-1], parts[-1] if parts[-1] > parts[-2] else parts[-1] + 1.0)
    curve = SmoothCurve(line, closed=False)
    start = curve.length * parts[1:-1] / parts[-1]
    yield AlongCurve(places, curve, start, ends=(0.0, curve.length))


@dataclass(frozen=True, eq=False)
class Plane:
    """A mirror: its unit normal (3,), and <normal, point> of its points."""

    normal: Array
    offset: float


@dataclass(frozen=True)
class Lean:
    """A side over its line, which meets the wall over it at this angle, radians."""

    angle: float


def mixed_loop(places: Int, points: Array, labels: Int, kinds: Sequence[Plane | Lean], sharp: bool) -> Side:
    """A loop of lines, mirrors and leans. labels (n,) of the edge behind each vertex: `LINE` or an index of `kinds`."""
    before = np.roll(labels, 1)
    joints = np.flatnonzero(labels != before)
    if not len(joints):
        return _round(places, points, kinds[int(labels[0])], sharp)
    tracks: list[Track] = []
    marks = list(joints)
    for k, here in enumerate(joints):
        tracks.append(_joint(places[[here]], points[[here]], [int(before[here]), int(labels[here])], kinds))
        run = _run(here, joints[(k + 1) % len(joints)], len(places))
        kind = None if labels[here] == LINE else kinds[int(labels[here])]
        pieces, pins = _between(places[run], points[run], kind, sharp)
        tracks += pieces
        marks += list(run[pins])
    return Side(tracks, np.sort(np.array(marks)))


def _joint(place: Int, point: Array, around: Sequence[int], kinds: Sequence[Plane | Lean]) -> Straight:
    """A vertex (1,) where two kinds meet: it stays at the end of a line, else it moves along both."""
    if LINE in around:
        return Straight.held(place, point)
    found = [kinds[each] for each in sorted(around)]
    planes = [kind for kind in found if isinstance(kind, Plane)]
    if len(planes) == 2:
        return _in_planes(place, point, planes)
    if any(abs(plane.normal[2]) > _PARALLEL for plane in planes):
        raise ConditionError("A side that leans meets a mirror that is not upright; leave a line between them.")
    return _upright(place, point)


def _upright(places: Int, points: Array) -> Straight:
    """Vertices that move up and down over their points."""
    return Straight(places, points, np.repeat(np.array([[[0.0, 0.0, 1.0]]]), len(places), axis=0))


def _round(places: Int, points: Array, kind: Plane | Lean, sharp: bool) -> Side:
    """A whole loop of one kind."""
    if isinstance(kind, Plane):
        return Side([_in_planes(places, points, [kind])], np.zeros(0, dtype=np.int64))
    flat = points * [1.0, 1.0, 0.0]
    pins = corners(flat) if sharp else np.zeros(0, dtype=np.int64)
    if not len(pins):
        curve = SmoothCurve(flat, closed=True)
        return Side([OverCurve(places, curve, np.column_stack([curve.knots[:-1], points[:, 2]]), kind.angle)], pins)
    tracks: list[Track] = []
    for k, here in enumerate(pins):
        run = _run(here, pins[(k + 1) % len(pins)], len(places))
        tracks += [_upright(places[[here]], points[[here]]), *_between(places[run], points[run], kind, False)[0]]
    return Side(tracks, pins)


def _between(places: Int, points: Array, kind: Plane | Lean | None, sharp: bool) -> tuple[list[Track], Int]:
    """Tracks of the vertices between the ends of a run of one kind (None: a line), and its corners among them."""
    none = np.zeros(0, dtype=np.int64)
    if len(places) < 3 and not isinstance(kind, Lean):
        return [], none
    if isinstance(kind, Plane):
        return [_in_planes(places[1:-1], points[1:-1], [kind])], none
    inner = _inner_corners(points if kind is None else points * [1.0, 1.0, 0.0]) if sharp else none
    tracks: list[Track] = []
    if len(inner):
        hold = Straight.held if kind is None else _upright
        tracks.append(hold(places[inner], points[inner]))
    for here, there in pairwise([0, *inner.tolist(), len(points) - 1]):
        piece, spots = points[here : there + 1], places[here : there + 1]
        tracks += _line_piece(spots, piece) if kind is None else [_wall(spots, piece, kind.angle)]
    return tracks, inner


def _inner_corners(points: Array) -> Int:
    """Corners of an open polyline, without its ends."""
    if len(points) < 3:
        return np.zeros(0, dtype=np.int64)
    bends = corners(points)
    return bends[(bends > 0) & (bends < len(points) - 1)]


def _line_piece(places: Int, points: Array) -> Iterator[Track]:
    return _open_track(places[1:-1], points, SmoothCurve(points, closed=False).knots)


def _wall(places: Int, points: Array, angle: float) -> OverCurve:
    """The vertices between the ends of an open line that they stay over."""
    curve = SmoothCurve(points * [1.0, 1.0, 0.0], closed=False)
    start = np.column_stack([curve.knots, points[:, 2]])[1:-1]
    return OverCurve(places[1:-1], curve, start, angle, places[[0, -1]])


def _in_planes(places: Int, points: Array, planes: Sequence[Plane]) -> Straight:
    """Vertices that slide in one plane, or on the line of two, from the nearest point there."""
    normals = np.stack([plane.normal for plane in planes])
    if len(planes) == 2 and np.linalg.norm(np.cross(*normals)) < _PARALLEL:
        raise ConditionError(
            "Two mirrors in parallel planes meet at a vertex; make them one, or leave an edge between them."
        )
    inverse = np.linalg.pinv(normals)
    off = np.array([plane.offset for plane in planes]) - points @ normals.T
    axes = np.linalg.svd(normals)[2][len(planes) :]
    return Straight(places, points + off @ inverse.T, np.repeat(axes[None], len(places), axis=0))
