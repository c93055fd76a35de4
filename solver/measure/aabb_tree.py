"""Overlapping axis-parallel boxes: a balanced tree of boxes, traversed against itself in whole arrays."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from .arrays import Array

Pairs = NDArray[np.int64]
Nodes = NDArray[np.int32]

# Pairs of tree nodes handled at once: enough to hide numpy's overhead, few enough for memory.
_BLOCK = 1 << 16


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
    root = np.zeros(1, dtype=np.int32)
    pending = [(0, root, root)]
    while pending:
        depth, a, b = pending.pop()
        a, b = _overlapping(*levels[depth], a, b)
        if depth == len(levels) - 1:
            apart = a != b
            if apart.any():
                yield np.stack([order[a[apart]], order[b[apart]]], axis=1)
            continue
        for start in range(0, len(a), _BLOCK):
            pending.append((depth + 1, *_children(a[start : start + _BLOCK], b[start : start + _BLOCK])))


def _overlapping(low: Array, high: Array, a: Nodes, b: Nodes) -> tuple[Nodes, Nodes]:
    """The pairs of nodes whose boxes, `low` and `high` (3, n), overlap: dropped axis by axis."""
    for axis in range(3):
        keep = low[axis][a] <= high[axis][b]
        keep &= low[axis][b] <= high[axis][a]
        a, b = a[keep], b[keep]
    return a, b


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
    """Boxes (3, n) of the nodes, root first; padded to a power of two with boxes that overlap nothing."""
    size = 1 << (len(low) - 1).bit_length()
    empty = np.full((3, size - len(low)), np.inf)
    levels = [(np.concatenate([low.T, empty], axis=1), np.concatenate([high.T, -empty], axis=1))]
    while levels[-1][0].shape[1] > 1:
        low, high = levels[-1]
        levels.append((np.minimum(low[:, 0::2], low[:, 1::2]), np.maximum(high[:, 0::2], high[:, 1::2])))
    return levels[::-1]


def _children(a: Nodes, b: Nodes) -> tuple[Nodes, Nodes]:
    """Pairs of children of pairs of nodes (a <= b), each unordered pair once."""
    left, right = 2 * a, 2 * b
    apart = a != b
    return (
        np.concatenate([left, left, left + 1, left[apart] + 1]),
        np.concatenate([right, right + 1, right + 1, right[apart]]),
    )
