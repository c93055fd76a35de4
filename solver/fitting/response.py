"""An approximate Jacobian of the surface with respect to its boundary normals.

To leading order a turn v of the boundary normals spreads harmonically and tangentially, dN = P E v with P the
projection on the tangent planes at N, and dg follows as in `adjoint`, dg = G load'(N) dN with Green's function G of the
Poisson equation. The neglected terms, mostly |dN|² of the sphere, matter only for waves as long as the whole boundary.
The response of k points to n normals takes nine products of matrices (k, V) and (V, n).

On long boundaries the turns are sums of hat functions between some of the vertices, the knots.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from ..domain.domain import Domain
from ..gauss.harmonic import HarmonicSolver
from ..surface.adjoint import AdjointSolver, State

Array = NDArray[np.float64]
Int = NDArray[np.integer]

# The largest number of knots along a boundary, and of points with a known response: the columns of both matrices.
KNOTS = 160


class Response:
    """The knots along a domain's fixed boundary vertices, and how points move when the normals there turn."""

    def __init__(self, extension: AdjointSolver) -> None:
        self.extension = extension
        self._green: dict[bytes, Array] = {}

    def __reduce__(self) -> tuple[type[Response], tuple[AdjointSolver]]:
        """Copies and pickles leave the matrices out; they are computed again on use."""
        return Response, (self.extension,)

    def belongs(self, solver: HarmonicSolver, fixed: Int) -> bool:
        """Whether it belongs to this solver with these vertices fixed."""
        return self.extension.solver is solver and np.array_equal(self.extension.fixed, fixed)

    @cached_property
    def hats(self) -> sp.csr_array:
        """(n, m) the hat functions of m knots at the n fixed vertices; every row adds up to one."""
        return hats(self.extension.domain, self.extension.fixed, KNOTS)

    @cached_property
    def spread(self) -> Array:
        """E (V, m): the harmonic extensions of the hat functions."""
        return self.extension.spread(self.hats.toarray())

    def green(self, points: Int) -> Array:
        """Gᵀ (V, k), the transpose of load ↦ g at some vertices (k,)."""
        key = points.tobytes()
        if key not in self._green:
            unit = np.zeros((self.extension.domain.vertex_count, len(points)))
            unit[points, np.arange(len(points))] = 1.0
            self._green[key] = self.extension.pulled_integral(unit)
        return self._green[key]

    def of_points(self, state: State, points: Int, side: float) -> Array:
        """(k, 3, m, 3): the derivative of g + side · N at vertices (k,) by turns, vectors in space, at the knots."""
        green, spread = self.green(points), self.spread
        tangent = np.eye(3) - state.N[:, :, None] * state.N[:, None, :]
        loads = self._loads(state.N)
        change = side * np.einsum("kab,km->kamb", tangent[points], spread[points])
        for b in range(3):
            turned = [tangent[:, d, b, None] * spread for d in range(3)]
            for a in range(3):
                # (v × N)_a, the components of N being in the loads
                d, c = (a + 1) % 3, (a + 2) % 3
                change[:, a, :, b] += green.T @ (loads[c] @ turned[d] - loads[d] @ turned[c])
        return change

    def _loads(self, N: Array) -> list[sp.csr_array]:
        """(V, V), three times: v ↦ load of v_i N_j - v_j N_i for each component of N."""
        domain = self.extension.domain
        i, j = domain.edges.T
        places = (np.tile(np.arange(len(i)), 2), np.concatenate([i, j]))
        shape = (len(i), domain.vertex_count)
        factors = (sp.csr_array((np.concatenate([n[j], -n[i]]), places), shape=shape) for n in N.T)
        return [sp.csr_array(self.extension.load @ factor) for factor in factors]


def hats(domain: Domain, vertices: Int, limit: int) -> sp.csr_array:
    """(n, m) piecewise linear functions along the boundary loops at `vertices` (n,), sorted, with m <= limit knots.

    Knots are evenly spaced among the vertices of each loop, at least three; a gap between vertices counts as an edge.
    """
    step = max(1, -(-len(vertices) // limit))
    place = np.full(domain.vertex_count, -1)
    place[vertices] = np.arange(len(vertices))
    blocks, order = [], []
    for loop in domain.boundary_loops:
        rows = place[loop]
        rows = rows[rows >= 0]
        if len(rows):
            order.append(rows)
            blocks.append(_ring(len(rows), max(min(3, len(rows)), len(rows) // step)))
    functions = sp.block_diag(blocks, format="csr")
    back = np.empty(len(vertices), dtype=np.int64)
    back[np.concatenate(order)] = np.arange(len(vertices))
    return sp.csr_array(functions)[back]


def _ring(count: int, knots: int) -> sp.csr_array:
    """(count, knots) hat functions on a ring of nodes."""
    at = np.arange(count) * (knots / count)
    first = np.minimum(at.astype(np.int64), knots - 1)
    along = at - first
    rows = np.tile(np.arange(count), 2)
    columns = np.concatenate([first, (first + 1) % knots])
    return sp.csr_array((np.concatenate([1.0 - along, along]), (rows, columns)), shape=(count, knots))
