"""The lines that a surface spans: one closed polyline for each boundary loop, and where its vertices start on it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..domain.domain import Domain
from ..errors import ConditionError
from ..linalg import as_numbers, out_of_range
from .curves import enclosed

Array = NDArray[np.float64]
Int = NDArray[np.integer]

# A line narrower than this part of its length is straight.
_STRAIGHT = 1e-9
# Places tried for the first vertex of a loop on a curve that was drawn elsewhere.
_STARTS = 256


def boundary_lines(
    domain: Domain, points: Array, given: ArrayLike | Sequence[ArrayLike | None] | None
) -> tuple[list[Array], int, list[bool]]:
    """A closed line (m, 3) for each of `domain.boundary_loops`, the index of the outer one, and which are the loops
    themselves.

    given: None, a line for the outer loop, or a list with one for each loop, None for its own. Lines run as the
    loops do, seen from above. Raises `ConditionError` where they do not fit the domain.
    """
    own = [points[loop] for loop in domain.boundary_loops]
    for loop, line in zip(domain.boundary_loops, own, strict=True):
        _check_apart(loop, line)
    areas = [enclosed(line) for line in own]
    outer = int(np.argmax(np.abs(areas)))
    if given is None:
        for line in own:
            _check_bent(line, "The boundary of the plan")
        return own, outer, [True] * len(own)
    if not isinstance(given, (list, tuple)) or not _are_lines(given):
        lines = [_as_line(given, areas[k]) if k == outer else line for k, line in enumerate(own)]  # pyright: ignore[reportArgumentType]
        return lines, outer, [k != outer for k in range(len(own))]
    if len(given) != len(own):
        raise ConditionError(f"The plan has {len(own)} boundary loops, so {len(given)} curves do not fit it.")
    lines = [mine if line is None else _as_line(line, area) for line, area, mine in zip(given, areas, own, strict=True)]
    return lines, outer, [line is None for line in given]


def _are_lines(given: Sequence[ArrayLike | None]) -> bool:
    """Whether these are lines, and not the points of one."""
    try:
        return len(given) > 0 and (given[0] is None or np.ndim(given[0]) >= 2)
    except ValueError:  # the first one is ragged, so it is no point
        return True


def _as_line(given: ArrayLike, direction: float) -> Array:
    """The points of a curve (m, 3), the way round that `direction` has as a sign; 0 keeps it."""
    line = as_numbers(given, "The points of the curve", ConditionError)
    if line.ndim != 2 or line.shape[1] not in (2, 3) or len(line) < 3 or len(out_of_range(line)[0]):
        raise ConditionError("The curve must be three or more points (m, 3), finite numbers, in order.")
    if not np.ptp(line, axis=0).any():
        raise ConditionError("All points of the curve are in one place; draw it around the plan.")
    _check_bent(line, "The curve")
    if line.shape[1] == 2:
        line = np.column_stack([line, np.zeros(len(line))])
    return line[::-1] if enclosed(line) * direction < 0.0 else line


def _check_apart(loop: Int, line: Array) -> None:
    """Raise `ConditionError` where neighbours on a boundary loop are in one place."""
    twice = np.flatnonzero((line == np.roll(line, -1, axis=0)).all(axis=1))
    if len(twice):
        pair = [int(loop[twice[0]]), int(loop[(twice[0] + 1) % len(loop)])]
        raise ConditionError(
            f"Vertices {pair[0]} and {pair[1]} of the boundary are in one place; merge them by distance, or move one.",
            vertices=pair,
        )


def _check_bent(line: Array, what: str) -> None:
    """Raise `ConditionError` on a line that encloses nothing, since it is straight."""
    wide = np.linalg.svd(line - line.mean(axis=0), compute_uv=False)
    if wide[1] <= _STRAIGHT * wide[0]:
        raise ConditionError(f"{what} is straight, so it encloses no surface; draw it around the plan.")


def parts_of_length(points: Array) -> Array:
    """(m,) the part of the length of a closed line that lies before each of its points."""
    lengths = np.linalg.norm(np.roll(points, -1, axis=0) - points, axis=1)
    return (np.cumsum(lengths) - lengths) / lengths.sum()


def best_turn(own: Array, at: Array) -> int:
    """Which of the rows of `at` (k, n, 3), each a way to lay n points on a curve, is most like the points `own` (n, 3)
    seen from above, whatever their places and sizes."""
    mine = _centred(own[None])
    return int(np.argmin(np.sum((_centred(at) - mine) ** 2, axis=(1, 2))))


def _centred(points: Array) -> Array:
    flat = points[..., :2] - points[..., :2].mean(axis=1, keepdims=True)
    return flat / np.sqrt(np.mean(flat**2, axis=(1, 2), keepdims=True))


def starts(parts: Array, length: float) -> Array:
    """(_STARTS, n) places on a curve of this length, of points at these parts (n,) of it, from many first places."""
    turns = np.arange(_STARTS) / _STARTS
    return (parts[None, :] + turns[:, None]) * length
