"""From lines and mirrors along the boundary loops of a plan to the tracks on which rim vertices slide."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from ..errors import ConditionError
from .curves import SmoothCurve, corners, without_repeats
from .lines import best_turn, parts_of_length, starts
from .rim import AlongCurve, Straight, Track

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


def own_line(places: Int, points: Array, sharp: bool) -> Side:
    """A loop that spans its own points (n, 3); places (n,) of its vertices on the rim."""
    pins = corners(points) if sharp else np.zeros(0, dtype=np.int64)
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


def mixed_loop(places: Int, points: Array, labels: Int, planes: Sequence[Plane], sharp: bool) -> Side:
    """A loop of lines and mirrors. labels (n,) of the edge behind each vertex: `LINE`, or the index of its plane."""
    before = np.roll(labels, 1)
    joints = np.flatnonzero(labels != before)
    if not len(joints):
        return Side([_in_planes(places, points, [planes[int(labels[0])]])], joints)
    tracks: list[Track] = []
    marks = list(joints)
    for k, here in enumerate(joints):
        around = {int(before[here]), int(labels[here])}
        if LINE in around:
            tracks.append(Straight.held(places[[here]], points[[here]]))
        else:
            tracks.append(_in_planes(places[[here]], points[[here]], [planes[each] for each in sorted(around)]))
        run = _run(here, joints[(k + 1) % len(joints)], len(places))
        if labels[here] == LINE:
            pieces, pins = _line_between(places[run], points[run], sharp)
            tracks += pieces
            marks += list(run[pins])
        elif len(run) > 2:
            tracks.append(_in_planes(places[run[1:-1]], points[run[1:-1]], [planes[int(labels[here])]]))
    return Side(tracks, np.sort(np.array(marks)))


def _line_between(places: Int, points: Array, sharp: bool) -> tuple[list[Track], Int]:
    """Tracks of the vertices between the ends of an open line, and its corners among them."""
    inner = np.zeros(0, dtype=np.int64)
    if sharp and len(points) > 2:
        bends = corners(points)
        inner = bends[(bends > 0) & (bends < len(points) - 1)]
    tracks: list[Track] = [Straight.held(places[inner], points[inner])] if len(inner) else []
    stops = np.concatenate([[0], inner, [len(points) - 1]])
    for here, there in pairwise(stops.tolist()):
        piece = points[here : there + 1]
        s = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(piece, axis=0), axis=1))])
        tracks += _open_track(places[here + 1 : there], piece, s)
    return tracks, inner


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
