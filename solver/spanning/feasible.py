"""Wishes for leaning sides that no surface can meet, found before the search.

At a corner with the inner angle 2α between two walls a surface that meets them at t₁ and t₂ stays bounded only where
t₁ + t₂ >= 180° - 2α, and likewise for 180° - t (Concus and Finn). Upward forces balance: H pulls with 2H · area on the
plan, a leaning side with cos t · length, and lines can hold at most their length.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ..errors import ConditionError
from .boundary import Lean, Plane
from .curves import enclosed, turns

Array = NDArray[np.float64]
Int = NDArray[np.integer]

# Angles that differ by less are equal, radians.
_SLACK = np.radians(0.5)


def check_corners(loop: Int, points: Array, labels: Int, kinds: Sequence[Plane | Lean]) -> None:
    """Raise `ConditionError` at a corner between two walls where both angles are too steep, or too flat.

    points (n, 3) along the loop of vertices (n,); labels (n,): of the edge behind each, an index of `kinds` or -1.
    """
    flat = points * [1.0, 1.0, 0.0]
    ahead = np.roll(flat, -1, axis=0) - flat
    left = np.cross(np.roll(ahead, 1, axis=0), ahead)[:, 2] > 0.0
    before = np.roll(labels, 1)
    for k in np.flatnonzero(left & (turns(flat) > _SLACK) & (labels >= 0) & (before >= 0)):
        meeting = [kind for kind in (kinds[int(before[k])], kinds[int(labels[k])]) if isinstance(kind, Lean)]
        if len(meeting) < 2:
            continue
        least = float(turns(flat)[k])  # 180° - 2α
        total = sum(kind.angle for kind in meeting)
        if min(total, 2.0 * np.pi - total) < least - _SLACK:
            raise ConditionError(
                f"Two sides that lean meet at a corner of {180 - np.degrees(least):.0f}° (vertex {loop[k]}); there "
                f"both angles together must be at least {np.degrees(least):.0f}°, so each at least "
                f"{0.5 * np.degrees(least):.0f}°. Make them flatter, or round the corner.",
                vertices=[int(loop[k])],
            )


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
