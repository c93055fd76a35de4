"""Linear problems of the scalar Laplacian with values given at some sites: factored once, solved often."""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from ..linalg import Sparse, factorize

Array = NDArray[np.float64]
Int = NDArray[np.integer]


class Dirichlet:
    """`L u = f` at the unknown sites, u given at the `fixed` ones, of which there is at least one.

    Unknown boundary sites get the natural condition. L: (S, S) positive semidefinite, of one component.
    """

    def __init__(self, L: Sparse, fixed: Int) -> None:
        unknown = np.ones(L.shape[0], dtype=bool)
        unknown[fixed] = False
        self.fixed = fixed
        self.unknown = np.flatnonzero(unknown)
        rows = L[self.unknown]
        self.L = sp.csr_array(rows[:, self.unknown])
        self.coupling = sp.csr_array(rows[:, fixed])
        self.fixed_block = sp.csr_array(L[fixed][:, fixed])
        self.factor = factorize(self.L)

    def solve(self, source: Array, values: Array) -> Array:
        """All of u (S, k), from `source` f (S, k) and `values` (n, k) at the fixed sites."""
        u = np.empty_like(source)
        u[self.fixed] = values
        u[self.unknown] = self.factor.solve(source[self.unknown] - self.coupling @ values)
        return u

    def extend(self, values: Array) -> Array:
        """The harmonic extension (S, k) of `values` (n, k) at the fixed sites."""
        return self.solve(np.zeros((len(self.unknown) + len(self.fixed), values.shape[1])), values)
