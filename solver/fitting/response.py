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
    """The knots along a domain's free boundary vertices, and how points move when the normals there turn.

    held: sorted vertices whose normals are given and stay; free (n,): places of the others in `extension.fixed`.
    """

    def __init__(self, extension: AdjointSolver, held: Int | None = None) -> None:
        self.extension = extension
        self.held = np.zeros(0, dtype=np.int64) if held is None else held
        self.free = np.flatnonzero(~np.isin(extension.fixed, self.held))
        self._green: dict[bytes, Array] = {}

    def __reduce__(self) -> tuple[type[Response], tuple[AdjointSolver, Int]]:
        """Copies and pickles leave the matrices out; they are computed again on use."""
        return Response, (self.extension, self.held)

    def belongs(self, solver: HarmonicSolver, fixed: Int, held: Int) -> bool:
        """Whether it belongs to this solver with these vertices fixed, and with the normals of these held."""
        same = np.array_equal(self.extension.fixed, fixed) and np.array_equal(self.held, held)
        return same and self.extension.solver is solver

    @property
    def vertices(self) -> Int:
        """(n,) the vertices whose normals are free."""
        return self.extension.fixed[self.free]

    @cached_property
    def hats(self) -> sp.csr_array:
        """(n, m) the hat functions of m knots at the n free vertices; every row adds up to one."""
        return hats(self.extension.domain, self.vertices, KNOTS)

    @cached_property
    def spread(self) -> Array:
        """E (V, m): the harmonic extensions of the hat functions."""
        return self.spread_of(self.hats.toarray())

    def spread_of(self, values: Array) -> Array:
        """The harmonic extension (V, k) of values (n, k) at the free vertices, zero at the held ones."""
        at_fixed = np.zeros((len(self.extension.fixed), values.shape[1]))
        at_fixed[self.free] = values
        return self.extension.spread(at_fixed)

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
    """(n, m) piecewise linear functions along the boundary loops at `vertices` (n,), sorted, with about m <= limit
    knots.

    Knots are evenly spaced among the vertices of each run, at least three if it has so many: around a whole loop, or
    along a piece of one, with a knot at either end.
    """
    step = max(1, -(-len(vertices) // limit))
    place = np.full(domain.vertex_count, -1)
    place[vertices] = np.arange(len(vertices))
    blocks, order = [], []
    for loop in domain.boundary_loops:
        rows = place[loop]
        for run in runs(rows >= 0):
            knots = max(min(3, len(run)), len(run) // step)
            order.append(rows[run])
            blocks.append(_hats(len(run), knots, closed=len(run) == len(loop)))
    functions = sp.block_diag(blocks, format="csr")
    back = np.empty(len(vertices), dtype=np.int64)
    back[np.concatenate(order)] = np.arange(len(vertices))
    return sp.csr_array(functions)[back]


def runs(marked: NDArray[np.bool_]) -> list[Int]:
    """The places of each run of marked nodes of a ring, in order; the whole ring is one run."""
    count = len(marked)
    starts = np.flatnonzero(marked & ~np.roll(marked, 1))
    if not len(starts):
        return [np.arange(count)] if marked.all() and count else []
    ends = np.flatnonzero(marked & ~np.roll(marked, -1))
    ends = np.roll(ends, -int(np.searchsorted(ends, starts[0])))
    return [(start + np.arange((end - start) % count + 1)) % count for start, end in zip(starts, ends, strict=True)]


def _hats(count: int, knots: int, closed: bool) -> sp.csr_array:
    """(count, knots) hat functions on a ring of nodes, or on a row of them with a knot at either end."""
    at = np.arange(count) * ((knots if closed else knots - 1) / max(count if closed else count - 1, 1))
    first = np.minimum(at.astype(np.int64), knots - 1)
    along = at - first
    rows = np.tile(np.arange(count), 2)
    columns = np.concatenate([first, (first + 1) % knots])
    return sp.csr_array((np.concatenate([1.0 - along, along]), (rows, columns)), shape=(count, knots))
