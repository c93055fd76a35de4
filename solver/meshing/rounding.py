"""Rounding the corners of a plan.

At an unrounded corner the boundary normals jump and the mean curvature diverges. A corner is a point where the loop
turns by more than `CORNER`; other points belong to a curve drawn as a polyline, and stay.

The automatic radius of a corner is a tenth of the size of its loop, whatever the edge length, so that a finer mesh
gives the same shell more exactly; and less where its arc would take more than a quarter of an edge of the loop there,
so that a court stays a court. At sharper corners the shell has higher and narrower feet, until it passes through
itself.

A shell whose rim lies on lines (`solver.spanning`) needs arcs at re-entrant corners only.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..notes import Sentence
from .outline import Loop, crossing_pairs, following_of, inside

# Between the turns of regular polygons of 15 and of 16 sides. The splines of `spanning.curves` have one of their own,
# a higher one: there a corner too many breaks a smooth rim, while here it only gets an arc.
CORNER = np.radians(23.5)
ROUNDED = {
    "all": ("All", "All corners, for shells whose sides lean: at a sharp corner the normals jump and H diverges"),
    "re-entrant": ("Re-entrant", "Only corners that point into the plan, those of courts too; for shells on their "
                   "outline, where the other corners may stay sharp"),
    "none": ("None", "No corners: all stay sharp"),
}
"""The corners that are rounded -> label and description."""
AUTOMATIC = 0.1  # the automatic radius, as a part of the size of the loop
_OF_EDGE = 0.25  # the part of an edge that an arc of automatic radius takes at most

_STEP = np.radians(2.0)  # the step of an arc before resampling: off by 1.5e-4 of its radius
_LEAST = 1e-3  # a corner with less radius than this, in edge lengths, stays a corner


@dataclass(frozen=True)
class Curve:
    """A loop with rounded corners as a closed polyline, fine enough to be sampled by chords.

    `points (M, 2)`; `segments (M,)`: the segment of the drawn loop for the piece that leaves each point (an arc is
    split at its middle); `fixed (M,)`: points that stay vertices; `sharp (M,)`: corners that are not rounded;
    `radii (K,)`: the radius at each point of the drawn loop, 0 where it is not rounded.
    """

    name: str
    points: np.ndarray
    segments: np.ndarray
    fixed: np.ndarray
    sharp: np.ndarray
    radii: np.ndarray


def turning(points: np.ndarray) -> np.ndarray:
    """The angle (K,), in radians, by which a loop turns at each point; positive to the left."""
    ahead = np.roll(points, -1, axis=0) - points
    back = np.roll(ahead, 1, axis=0)
    return np.arctan2(back[:, 0] * ahead[:, 1] - back[:, 1] * ahead[:, 0], np.sum(back * ahead, axis=1))


def automatic_radii(points: np.ndarray) -> np.ndarray:
    """The automatic radius (K,) at each point of a loop (K, 2), 0 where it has no corner; see above."""
    turn = np.abs(turning(points))
    corners = np.flatnonzero(turn > CORNER)
    radii = np.zeros(len(points))
    if not len(corners):
        return radii
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.roll(points, -1, axis=0) - points, axis=1))])
    ahead = np.diff(along[corners], append=along[corners[0]] + along[-1])
    shorter = np.minimum(ahead, np.roll(ahead, 1))
    size = float(np.ptp(points, axis=0).max())
    radii[corners] = np.minimum(AUTOMATIC * size, _OF_EDGE * shorter / np.tan(0.5 * turn[corners]))
    return radii


def rounded_sentence(radii: np.ndarray) -> Sentence | None:
    """The number of rounded corners and their radii (R,) as a sentence; None without any."""
    if not len(radii):
        return None
    corners = f"Rounded {len(radii)} corner{'s' * (len(radii) > 1)} by"
    least, most = float(radii.min()), float(radii.max())
    if most - least <= 0.01 * most:
        return Sentence(f"{corners} {{}}.", most)
    return Sentence(f"{corners} {{}} to {{}}.", least, most)


def round_corners(loops: list[Loop], radius: float | None, corners: str = "all") -> list[Curve]:
    """Replace the corners named in `ROUNDED` by an arc of `radius`, or of the largest radius that its neighbours leave
    room for; None chooses the radius of each corner (`automatic_radii`).

    Where an arc would run into or around another part of the plan (a column in a corner), its radius is halved until
    it does not. Radius 0 keeps the corners.
    """
    radii = [_wanted(loop.points, radius, corners) for loop in loops]
    for _ in range(16):
        rounded = [_round_loop(loop, r) for loop, r in zip(loops, radii, strict=True)]
        curves = [curve for curve, _ in rounded]
        in_the_way = _crossing(curves, [corner for _, corner in rounded]) or _misplaced(loops, curves, radii)
        if not in_the_way:
            return curves
        for loop, corner in in_the_way:
            smaller = 0.5 * curves[loop].radii[corner]
            radii[loop][corner] = smaller if smaller >= _LEAST else 0.0
    return [_round_loop(loop, np.zeros(len(loop.points)))[0] for loop in loops]


def _wanted(points: np.ndarray, radius: float | None, corners: str) -> np.ndarray:
    """The radius (K,) at each point of a loop with the plan on its left, where its corner is to be rounded, else 0."""
    turn = turning(points)
    turned = {"all": np.abs(turn) > CORNER, "re-entrant": turn < -CORNER, "none": np.zeros(len(turn), dtype=bool)}
    radii = np.where(turned[corners], automatic_radii(points) if radius is None else radius, 0.0)
    return np.where(radii < _LEAST, 0.0, radii)


def _crossing(curves: list[Curve], corner_of: list[np.ndarray]) -> set[tuple[int, int]]:
    """Corners (loop, point) whose arcs cross another piece."""
    counts = [len(curve.points) for curve in curves]
    starts = np.concatenate([curve.points for curve in curves])
    ends = np.concatenate([np.roll(curve.points, -1, axis=0) for curve in curves])
    hit = crossing_pairs(starts, ends, following_of(counts)).ravel()
    loop, corner = np.repeat(np.arange(len(curves)), counts)[hit], np.concatenate(corner_of)[hit]
    return {(int(i), int(k)) for i, k in zip(loop, corner, strict=True) if k >= 0}


def _misplaced(loops: list[Loop], curves: list[Curve], radii: list[np.ndarray]) -> set[tuple[int, int]]:
    """Corners whose arcs pass a hole on the wrong side: for each such hole the nearest corner."""
    corners_nearest = set()
    for k in range(1, len(curves)):
        point = curves[k].points[:1]
        for i, curve in enumerate(curves):
            if i != k and inside(point, curve.points, np.roll(curve.points, -1, axis=0))[0] != (i == 0):
                corners = np.flatnonzero(radii[i] > 0)
                distance = np.linalg.norm(loops[i].points[corners] - point, axis=1)
                corners_nearest.add((i, int(corners[np.argmin(distance)])))
    return corners_nearest


def _round_loop(loop: Loop, radii: np.ndarray) -> tuple[Curve, np.ndarray]:
    """The rounded loop, and the corner whose arc each of its points lies on (or -1)."""
    points, turn = loop.points, turning(loop.points)
    corners = np.nonzero(radii > 0)[0].tolist()
    sharp = (np.abs(turn) > CORNER) & (radii == 0)
    if not len(corners):
        curve = Curve(loop.name, points, loop.segments, sharp | loop.keep, sharp, radii)
        return curve, np.full(len(points), -1)
    length = np.linalg.norm(np.roll(points, -1, axis=0) - points, axis=1)
    along = np.concatenate([[0.0], np.cumsum(length)])
    trim = _trims(corners, radii[corners] * np.tan(np.abs(turn[corners]) / 2), along, np.nonzero(sharp)[0])
    pieces = []
    for k, corner in enumerate(corners):
        after = corners[(k + 1) % len(corners)]
        pieces.append(_arc(loop, along, corner, trim[k]) + (corner,))
        pieces.append(_between(loop, along, sharp, (corner, trim[k]), (after, trim[(k + 1) % len(corners)])) + (-1,))
    parts = list(zip(*pieces, strict=True))
    corner_of = np.repeat(parts[4], [len(p) for p in parts[0]])
    reached = radii.copy()
    reached[corners] = trim / np.tan(np.abs(turn[corners]) / 2)
    return Curve(loop.name, *(np.concatenate(parts[i]) for i in range(4)), radii=reached), corner_of


def _trims(corners: list[int], wanted: np.ndarray, along: np.ndarray, sharp: np.ndarray) -> np.ndarray:
    """Distance from each corner to the start of its arc: as wanted, scaled down where two arcs share a short run."""
    total = along[-1]
    scale = np.ones(len(corners))
    for k, corner in enumerate(corners):
        j = (k + 1) % len(corners)
        room = (along[corners[j]] - along[corner]) % total or total
        scale_here = room / max(wanted[k] + wanted[j], 1e-300)
        for s in sharp:  # an unrounded corner in between stays where it is
            before, after = (along[s] - along[corner]) % total, (along[corners[j]] - along[s]) % total
            if before + after <= room * (1 + 1e-12):
                scale_here = min(scale_here, before / wanted[k], after / wanted[j])
        scale[[k, j]] = np.minimum(scale[[k, j]], min(1.0, scale_here * (1 - 1e-9)))
    return wanted * scale


def _at(loop: Loop, along: np.ndarray, s: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Points, unit directions and segment indices at arc lengths s."""
    s = np.mod(s, along[-1])
    k = np.clip(np.searchsorted(along, s, side="right") - 1, 0, len(loop.points) - 1)
    step = np.roll(loop.points, -1, axis=0) - loop.points
    length = np.diff(along)
    direction = step[k] / length[k, None]
    return loop.points[k] + (s - along[k])[:, None] * direction, direction, k


def _arc(loop: Loop, along: np.ndarray, corner: int, trim: float) -> tuple[np.ndarray, ...]:
    """The points of the arc at a corner, without its last: a circle's if both neighbours are straight that far, else a
    cubic with the tangents of the curves that it joins."""
    ends, directions, _ = _at(loop, along, along[corner] + trim * np.array([-1.0, 1.0]) * (1 - 1e-12))
    (p, q), (u, v) = ends, directions
    angle = float(np.arctan2(u[0] * v[1] - u[1] * v[0], u @ v))
    half = max(1, int(np.ceil(abs(angle) / _STEP / 2)))
    t = np.arange(2 * half) / (2 * half)
    if np.isclose(np.linalg.norm(p - loop.points[corner]), np.linalg.norm(q - loop.points[corner]), rtol=1e-6) and (
        trim <= min(np.diff(along)[corner - 1], np.diff(along)[corner]) * (1 + 1e-6)
    ):
        normal = np.array([-u[1], u[0]])
        radius = trim / np.tan(angle / 2)
        swept = t[:, None] * angle
        points = p + radius * (np.sin(swept) * u + (1 - np.cos(swept)) * normal)
    else:
        reach = np.linalg.norm(q - p) / (2 * max(np.sin(abs(angle) / 2), 1e-3)) * 4 / 3 * np.tan(abs(angle) / 4)
        reach = min(reach, trim)
        b, c, w = p + reach * u, q - reach * v, t[:, None]
        points = (1 - w) ** 3 * p + 3 * (1 - w) ** 2 * w * b + 3 * (1 - w) * w**2 * c + w**3 * q
    middle = (t + 0.5 / len(t)) * 2 - 1  # from -1 where the arc starts to 1 where it ends
    _, _, k = _at(loop, along, along[corner] + trim * middle)
    fixed = np.arange(len(t)) == half
    return points, loop.segments[k], fixed, np.zeros(len(t), dtype=bool)


def _between(
    loop: Loop, along: np.ndarray, sharp: np.ndarray, start: tuple[int, float], stop: tuple[int, float]
) -> tuple[np.ndarray, ...]:
    """The untouched run from the end of one arc to the start of the next."""
    count, total = len(loop.points), along[-1]
    first, last = along[start[0]] + start[1], along[stop[0]] - stop[1]
    last += total * (stop[0] <= start[0])
    index = np.arange(start[0] + 1, stop[0] + (count if stop[0] <= start[0] else 0))
    at = along[index % count] + total * (index >= count)
    index = index[(at > first) & (at < last)] % count
    end, _, k = _at(loop, along, np.array([first]))
    points = np.concatenate([end, loop.points[index]])
    segments = loop.segments[np.concatenate([k, index])]
    keep = np.concatenate([[False], (sharp | loop.keep)[index]])
    return points, segments, keep, np.concatenate([[False], sharp[index]])
