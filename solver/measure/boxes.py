"""Which axis-parallel boxes overlap: a balanced tree of boxes, walked against itself in whole arrays."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from .arrays import Array

Pairs = NDArray[np.int64]

# Pairs of tree nodes looked at together: enough to make numpy's overhead small, little enough for memory.
_BLOCK = 1 << 20


def overlapping_boxes(low: Array, high: Array) -> Iterator[Pairs]:
    """Yield blocks of pairs (k, 2), i != j, each once, of boxes that overlap or touch; `low`, `high` (n, 3).

    Boxes of any mixture of sizes; boxes with nan overlap nothing. Time grows like n log n plus the number of
    pairs.
    """
    usable = np.flatnonzero(np.isfinite(low).all(axis=1) & np.isfinite(high).all(axis=1))
    if len(usable) < 2:
        return
    order = usable[_tree_order(0.5 * (low[usable] + high[usable]))]
    levels = _levels(low[order], high[order])
    pending = [(0, np.zeros((1, 2), dtype=np.int64))]
    while pending:
        depth, pairs = pending.pop()
        lows, highs = levels[depth]
        a, b = pairs[:, 0], pairs[:, 1]
        pairs = pairs[((lows[a] <= highs[b]) & (lows[b] <= highs[a])).all(axis=1)]
        if depth == len(levels) - 1:
            pairs = pairs[pairs[:, 0] != pairs[:, 1]]
            if len(pairs):
                yield order[pairs]
            continue
        for start in range(0, len(pairs), _BLOCK):
            pending.append((depth + 1, _children(pairs[start : start + _BLOCK])))


def _tree_order(centres: Array) -> NDArray[np.int64]:
    """Order in which halving the list again and again gives compact halves: median splits, level by level."""
    count = len(centres)
    order = np.arange(count)
    size = 1 << (count - 1).bit_length()
    while size > 1:
        group = np.arange(count) // size
        starts = np.arange(0, count, size)
        sorted_centres = centres[order]
        extent = np.maximum.reduceat(sorted_centres, starts) - np.minimum.reduceat(sorted_centres, starts)
        key = sorted_centres[np.arange(count), extent.argmax(axis=1)[group]]
        order = order[np.lexsort((key, group))]
        size //= 2
    return order


def _levels(low: Array, high: Array) -> list[tuple[Array, Array]]:
    """Boxes of the nodes, root first; filled up to a power of two with boxes that overlap nothing."""
    size = 1 << (len(low) - 1).bit_length()
    empty = np.full((size - len(low), 3), np.inf)
    levels = [(np.concatenate([low, empty]), np.concatenate([high, -empty]))]
    while len(levels[-1][0]) > 1:
        low, high = levels[-1]
        levels.append((np.minimum(low[0::2], low[1::2]), np.maximum(high[0::2], high[1::2])))
    return levels[::-1]


def _children(pairs: Pairs) -> Pairs:
    """Pairs of children of pairs of nodes (i <= j), each unordered pair once."""
    left, right = 2 * pairs[:, 0], 2 * pairs[:, 1]
    apart = pairs[:, 0] != pairs[:, 1]
    return np.concatenate(
        [
            np.column_stack([left, right]),
            np.column_stack([left, right + 1]),
            np.column_stack([left + 1, right + 1]),
            np.column_stack([left[apart] + 1, right[apart]]),
        ]
    )
