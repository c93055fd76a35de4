"""Linear problems of a graph Laplacian with values given at some sites: factored once, solved often."""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from ..domain.sites import SiteGraph
from ..linalg import Factor, ReusedFactor, factorize

Array = NDArray[np.float64]
Int = NDArray[np.integer]


class Dirichlet:
    """`L u = f` at the unknown sites, u given at the `fixed` ones.

    L is the Laplacian of the graph with the `weights` (K,) of its links, positive semidefinite; unknown boundary
    sites get the natural condition. Where no site is fixed L is singular and L + M takes its place, with the areas of
    the sites, as parts of the whole, for M (the H¹ product). laplacian: the one with these weights, if it is at hand.
    near: the factor for the same sites on a domain with nearly the same edge lengths, which then serves here, too.
    """

    def __init__(
        self,
        graph: SiteGraph,
        weights: Array,
        fixed: Int,
        laplacian: sp.csr_array | None = None,
        near: Factor | None = None,
    ) -> None:
        self.graph = graph
        self.weights = weights
        unknown = np.ones(graph.count, dtype=bool)
        unknown[fixed] = False
        self.fixed = fixed
        self.unknown = np.flatnonzero(unknown)
        L = graph.laplacian(weights) if laplacian is None else laplacian
        if len(fixed) == 0:
            L = sp.csr_array(L + sp.diags_array(graph.areas / graph.areas.sum()))
        rows = L[self.unknown]
        self.coupling = sp.csr_array(rows[:, fixed])
        inside = sp.csr_array(rows[:, self.unknown])
        self.factor = factorize(inside) if near is None else ReusedFactor(inside, near)

    @property
    def rough(self) -> Factor:
        """The factor of L, or of what stands in for it: enough to precondition with."""
        return self.factor.factor if isinstance(self.factor, ReusedFactor) else self.factor

    def solve(self, source: Array, values: Array) -> Array:
        """All of u (S, k), from `source` f (S, k) and `values` (n, k) at the fixed sites."""
        u = np.empty_like(source)
        u[self.fixed] = values
        u[self.unknown] = self.factor.solve(source[self.unknown] - self.coupling @ values)
        return u

    def extend(self, values: Array) -> Array:
        """The harmonic extension (S, k) of `values` (n, k) at the fixed sites."""
        return self.solve(np.zeros((len(self.unknown) + len(self.fixed), values.shape[1])), values)

    def precondition(self, X: Array) -> Array:
        """L⁻¹ X (S, k), or nearly that, at the unknown sites; zero at the fixed ones."""
        if len(self.fixed) == 0:
            return self.rough.solve(X)
        Y = np.zeros_like(X)
        Y[self.unknown] = self.rough.solve(X[self.unknown])
        return Y
