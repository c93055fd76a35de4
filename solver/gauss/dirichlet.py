"""Dirichlet problems of a graph Laplacian: values given at some sites, factored once, solved often."""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from ..domain.sites import SiteGraph
from ..linalg import Factor, ReusedFactor, factorize

Array = NDArray[np.float64]
Int = NDArray[np.integer]


class Dirichlet:
    """`L u = f` at the unknown sites, with u given at the `fixed` ones. Can be pickled and copied.

    L is the Laplacian of the graph with the `weights` (K,) of its links, positive semidefinite; unknown boundary
    sites get the natural condition. With no site fixed L is singular, and L + M takes its place (the H¹ product); M is
    the diagonal of the sites' areas, as parts of the whole. laplacian: L of all sites, if it is already known. near:
    the factor for the same sites on a domain with nearly the same edge lengths, reused as a preconditioner.
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
        """The factor of L or of a nearby matrix: enough to precondition with."""
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
        """L⁻¹ X (S, k), exactly or nearly, at the unknown sites; zero at the fixed ones."""
        if len(self.fixed) == 0:
            return self.rough.solve(X)
        Y = np.zeros_like(X)
        Y[self.unknown] = self.rough.solve(X[self.unknown])
        return Y
