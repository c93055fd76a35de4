"""Wishes for leaning sides that no surface can meet, found before the search.

At a corner with the inner angle 2α between two walls a surface that meets them at t₁ and t₂ stays bounded only where
t₁ + t₂ >= 180° - 2α, and likewise for 180° - t (Concus and Finn). Upward forces balance: H pulls with 2H · area on the
plan, a leaning side with cos t · length, and lines can hold at most their length.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from ..errors import ConditionError
from ..notes import Note
from .boundary import Lean, Plane
from .curves import enclosed, turns

Array = NDArray[np.float64]
Int = NDArray[np.integer]

# Angles that differ by less are equal, radians.
_SLACK = np.radians(0.5)
# Arcs of a radius below this part of the outline's smaller extent are corners that are rounded a little: there two
# steep sides have a surface, but it goes far down (at 40° round a right angle by 0.5 to 0.8 of the extent).
_ROUND = 0.1


def check_corners(loop: Int, points: Array, labels: Int, kinds: Sequence[Plane | Lean], extent: float) -> list[Note]:
    """Notes on rounded corners between two walls where both angles are too steep, or too flat, for a sharp one.

    Raises `ConditionError` at sharp ones. points (n, 3) along the loop of vertices (n,); labels (n,): of the edge
    behind each, an index of `kinds` or -1. extent: of the outline.
    """
    notes = []
    for first, last, turn in _leaning_corners(points * [1.0, 1.0, 0.0], labels, _ROUND * extent):  # turn: 180° - 2α
        meeting = [kinds[int(label)] for label in (labels[first - 1], labels[last])]
        angles = [kind.angle for kind in meeting if isinstance(kind, Lean)]
        total = sum(angles)
        if len(angles) < 2 or min(total, 2.0 * np.pi - total) >= turn - _SLACK:
            continue
        least, vertex = float(np.degrees(turn)), int(loop[first])
        way, flatter = ("down", "flatter") if total < np.pi else ("up", "steeper")
        both = f"Two sides that lean meet at a corner of {180 - least:.0f}° (vertex {vertex})"
        if first == last:
            raise ConditionError(
                f"{both}; there both angles together must be at least {least:.0f}°, so each at least "
                f"{0.5 * least:.0f}°. Make them flatter, or round the corner."
                if total < np.pi
                else f"{both}; there both angles together must be at most {360 - least:.0f}°, so each at most "
                f"{180 - 0.5 * least:.0f}°. Make them steeper, or round the corner.",
                vertices=[vertex],
            )
        text = f"{both}, rounded a little; sharp it would not do with these angles, and the rim goes far {way} there."
        notes.append(Note("steep-corner", f"{text} Make them {flatter}, or round the corner more."))
    return notes


def _leaning_corners(points: Array, labels: Int, radius: float) -> Iterator[tuple[int, int, float]]:
    """Left turns of a loop (n, 3) between walls: the first and the last vertex of each, and the turn, radians.

    Turns along an arc of a radius below the given one are one corner.
    """
    ahead = np.roll(points, -1, axis=0) - points
    left = np.cross(np.roll(ahead, 1, axis=0), ahead)[:, 2] > 0.0
    turn, lengths, count = turns(points), np.linalg.norm(ahead, axis=1), len(points)
    bent = left & (turn > _SLACK) & (labels >= 0) & (np.roll(labels, 1) >= 0)
    joined = bent & np.roll(bent, -1) & (lengths < radius * (turn + np.roll(turn, -1)))
    for first in np.flatnonzero(bent & ~np.roll(joined, 1)).tolist():
        run = first + np.arange(1 + int(np.argmin(np.roll(joined, -first))))
        total = float(turn[run % count].sum())
        if lengths[run[:-1] % count].sum() < radius * total:
            yield first, int(run[-1]) % count, total


def check_balance(H: float, loops: Sequence[Array], weights: Sequence[Array], on_line: Sequence[Array]) -> None:
    """Raise `ConditionError` where lines cannot hold what mean curvature H and the leaning sides pull.

    loops: points (n, 3) of each, the outer one first; of the edge behind each point weights (n,) cos t, 0 if it does
    not lean, and on_line (n,), 1 on a line, else 0.
    """
    lengths = [np.linalg.norm((np.roll(p, -1, axis=0) - p)[:, :2], axis=1) for p in loops]
    area = abs(sum(enclosed(p) for p in loops))
    walls = sum(float(w @ length) for w, length in zip(weights, lengths, strict=True))
    held = sum(float(o @ length) for o, length in zip(on_line, lengths, strict=True))
    if walls and abs(2.0 * H * area - walls) >= held:
        raise ConditionError(
            f"Mean curvature {H:.4g} and the leaning sides pull more than the sides on lines can hold; between "
            f"{(walls - held) / (2.0 * area):.4g} and {(walls + held) / (2.0 * area):.4g} there may be a surface."
        )
