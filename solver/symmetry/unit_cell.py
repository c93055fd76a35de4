"""Compact unit cells: one copy of each class, chosen so that as many seams as possible are joined.

Breadth-first copies are a unit cell of a group with translations, too, but a ragged one: it may cut tubes lengthwise
where whole halves would do. Each copy may be moved by translations of the group. The copies nearest to a point form a
cell (Wigner and Seitz); the points tried are those where planes of the piece meet.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from .isometries import CopySet, Isometry
from .sides import SidePlane

Array = NDArray[np.float64]

# Copies are moved by up to this many times each vector of the basis.
_REACH = 2
# Points are moved by this part of the shortest translation, in a direction without symmetry, to avoid ties.
_ASIDE = np.array([3.1e-3, 1.7e-3, 0.9e-3])
# Larger cells are left as they are.
_MOST = 128
# A cell is better if its joined seams are larger by this part.
_BETTER = 1e-6


def compact(
    copies: Sequence[Isometry],
    lattice: Array,
    seams: Sequence[tuple[Isometry, float]],
    middles: dict[int, Array],
    planes: Sequence[SidePlane],
    tolerance: float,
) -> list[Isometry]:
    """The same classes of copies, moved by integer combinations of `lattice` (k, 3) so that most of their seams meet.

    seams: steps across them, and the weight of each. middles: the centres of the sheets 1 and -1. planes: of the sides.
    The first copy stays where it is.
    """
    if not len(lattice) or len(copies) > _MOST:
        return list(copies)
    best, most = list(copies), joined(copies, seams, tolerance)
    aside = np.linalg.norm(lattice, axis=1).min() * _ASIDE
    steps = [np.asarray(at) - _REACH for at in np.ndindex(*[2 * _REACH + 1] * len(lattice))]
    shifts = np.array(steps) @ lattice
    centres = np.array([copy.points(middles[copy.sheet]) for copy in copies])
    for point in meeting_points(planes, middles[1]):
        apart = np.linalg.norm(centres[:, None] + shifts - (point + aside), axis=2)
        moves = shifts[np.argmin(apart, axis=1)]
        moves = moves - moves[0]
        moved = [replace(copy, translation=copy.translation + by) for copy, by in zip(copies, moves, strict=True)]
        size = joined(moved, seams, tolerance)
        if size > (1.0 + _BETTER) * most:
            best, most = moved, size
    return best


def joined(copies: Sequence[Isometry], seams: Sequence[tuple[Isometry, float]], tolerance: float) -> float:
    """The total weight of the seams across which there is a copy."""
    known = CopySet(tolerance)
    for copy in copies:
        known.add(copy)
    return sum(size for copy in copies for step, size in seams if known.index(copy.then(step)) >= 0)


def meeting_points(planes: Sequence[SidePlane], near: Array) -> list[Array]:
    """For every plane, and every two that are not parallel, their point nearest to `near` (3,)."""
    walls = [plane for plane in planes if plane.normal is not None]
    points = [plane.point for plane in planes if plane.normal is None]
    for group in [[wall] for wall in walls] + [list(pair) for pair in combinations(walls, 2)]:
        A = np.array([wall.normal for wall in group])
        if np.linalg.matrix_rank(A, tol=1e-2) == len(group):
            miss = np.array([wall.offset for wall in group]) - A @ near
            points.append(near + np.linalg.pinv(A) @ miss)
    return points
