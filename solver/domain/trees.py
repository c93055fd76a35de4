"""Spanning trees, and sums along them, by which closed forms are integrated."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray
from scipy.sparse.csgraph import breadth_first_order

Array = NDArray[np.float64]
Int = NDArray[np.integer]


def accumulate(parent: Int, increments: Array) -> Array:
    """Sum increments along the path to the root: `x[i] = increments[i] + x[parent[i]]`; a root is its own parent.

    By pointer jumping: log₂(depth) rounds over whole arrays. Roots add nothing.
    """
    total = np.array(increments, dtype=np.float64)
    total[parent == np.arange(len(parent))] = 0.0
    while True:
        above = parent[parent]
        total = total + total[parent]
        if (above == parent).all():
            return total
        parent = above


@dataclass(frozen=True)
class Tree:
    """A spanning tree of n nodes by breadth-first search: `parent` (n,), and the pair that leads there.

    pair: (n,), -1 at a root, which is its own parent. sign: (n,) +1 where the node is the first of its pair.
    """

    parent: Int
    pair: Int
    sign: Array

    @classmethod
    def of(cls, pairs: Int, count: int, root: int = 0) -> Tree:
        """The tree along `pairs` (m, 2) of joined nodes, which may repeat; unreachable nodes are roots, too."""
        first, second = pairs.T
        rows, cols = np.concatenate([first, second]), np.concatenate([second, first])
        adjacency = sp.csr_array((np.ones(rows.size), (rows, cols)), shape=(count, count))
        before = breadth_first_order(adjacency, root, directed=True)[1]
        pair, sign = np.full(count, -1), np.ones(count)
        for nodes, others, direction in ((first, second, 1.0), (second, first, -1.0)):
            leads = np.flatnonzero(before[nodes] == others)
            pair[nodes[leads]], sign[nodes[leads]] = leads, direction
        return cls(np.where(before < 0, np.arange(count), before), pair, sign)

    def integrate(self, form: Array) -> Array:
        """Values (n, k) of the integral of `form` (m, k), the increments `value(first) - value(second)` of the pairs;
        zero at roots.
        """
        steps = self.sign[:, None] * np.vstack([form, np.zeros((1, form.shape[1]))])[self.pair]
        return accumulate(self.parent, steps)

    def accumulated(self, steps: Array) -> Array:
        """Sums (n,) of `steps` (n,), one from the parent of each node to the node, from the root on."""
        return accumulate(self.parent, steps[:, None])[:, 0]

    def climb(self, node: int) -> tuple[Int, Array]:
        """The pairs between a node and the root, and their signs: `value(node) = Σ sign form[pair]`."""
        way = []
        while self.pair[node] >= 0:
            way.append(node)
            node = int(self.parent[node])
        return self.pair[way], self.sign[way]
