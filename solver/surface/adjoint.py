"""The surface as a function of its boundary normals, with its differential and its adjoint (paper, Sec. 5.2, App. F).

The boundary normals N₀ determine the harmonic map N = Φ(N₀) and, by a Poisson equation, the conjugate g. With the
Hessian H of the energy at N (`gauss.problem`), I the sites that are not fixed and B the fixed ones:

    dN_I = -(P H P)⁻¹ P H_IB dN₀,    L dg = d load(N),   load = Σ_f ∫ <∇φ, N̄ × *∇N>.

A function F(N, g) then has the gradient P (F_N + load'ᵀ y)_B - H_BI μ on the boundary, with L y = F_g and
P H P μ = P (F_N + load'ᵀ y)_I: two linear solves for any number of boundary normals. Both use kept factors. Around the
holes of a domain g is without its periods Σ_e η_e tau_e (see `periods`), which are linear in the same products N_i ×
N_j.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray
from scipy.sparse.linalg import LinearOperator, minres

from ..domain.domain import Domain
from ..domain.topology import Homology
from ..errors import ConditionError
from ..gauss.admissible import resolved
from ..gauss.boundary_data import Conditions
from ..gauss.dirichlet import Dirichlet
from ..gauss.harmonic import HarmonicMap, HarmonicSolver
from ..gauss.problem import EnergyProblem, Point
from ..gauss.sphere import inner, project
from ..linalg import graph_laplacian, sum_rows
from .averaging import load_matrix
from .conjugate import cross
from .periods import harmonic_forms

Array = NDArray[np.float64]
Int = NDArray[np.integer]
Linear = Callable[[Array], Array]

_ACCURACY = 1e-8
_CG_LIMIT = 400


@dataclass(frozen=True, eq=False)
class Reached:
    """A harmonic map N (V, 3), and the energy there."""

    harmonic: HarmonicMap
    point: Point

    @property
    def N(self) -> Array:
        return self.harmonic.normals


@dataclass(frozen=True, eq=False)
class State(Reached):
    """A harmonic map and its surface at scale 1: N and g (V, 3), g centred at the mean of its boundary.

    periods: (k, 3) of the conjugate; g is without them.
    """

    g: Array
    periods: Array


class AdjointSolver:
    """The surfaces of one domain as a function of the normals at its fixed boundary vertices.

    `solver` has normals at vertices. The conditions prescribe the normals `prescribed` (n, 3) at the vertices `fixed`
    (n,), sorted; their mirrors stay. method: of the harmonic maps, see `HarmonicSolver.solve`.
    """

    def __init__(self, solver: HarmonicSolver, conditions: Conditions, method: str = "newton") -> None:
        if not solver.graph.at_vertices:
            raise ConditionError("Fitting needs normals at the vertices; solve with sites='vertices'.")
        self.solver = solver
        self.domain = solver.domain
        self.conditions = conditions
        self.method = method
        self.fixed, self.prescribed = conditions.resolve()
        admissible = resolved(conditions, solver.graph)
        self.dirichlet = solver.dirichlet(admissible.fixed)
        self.problem = EnergyProblem(solver.graph, solver.energy, self.dirichlet, mirrors=admissible.mirrors)
        self._rim = self.domain.boundary_vertices

    @cached_property
    def _poisson(self) -> Dirichlet:
        return self.solver.dirichlet(np.zeros(1, dtype=np.int64))

    @cached_property
    def load(self) -> sp.csr_array:
        return load_matrix(self.domain)

    @cached_property
    def _duals(self) -> Array:
        """(E, k) the harmonic one-forms η, whose sums with tau are the periods."""
        homology = Homology.of(self.domain)
        if homology.is_trivial:
            return np.zeros((len(self.domain.edges), 0))
        return harmonic_forms(homology, self.solver.dirichlet)

    @cached_property
    def _forms(self) -> Array:
        """(E, k) η w, whose sums with the products N_i × N_j are the periods."""
        return self._duals * self.domain.cotan_weights[:, None]

    def __call__(self, rim: Array, start: Array | None = None, tolerance: float = 1e-8) -> State:
        """The surface of the boundary normals `rim` (n, 3), from `start` (V, 3) or the solver's own start."""
        return self.at(self._solve(rim, start, tolerance))

    def reach(self, rim: Array, start: Array | None = None, tolerance: float = 1e-8) -> Reached:
        """The same without g, which needs another factor."""
        harmonic = self._solve(rim, start, tolerance)
        return Reached(harmonic, self.problem.at(harmonic.normals))

    def _solve(self, rim: Array, start: Array | None, tolerance: float) -> HarmonicMap:
        return self.solver.solve(self.given(rim), start, method=self.method, tolerance=tolerance)

    def products(self, N: Array) -> Array:
        """(E, 3) N_i × N_j; times the edge weights they are tau."""
        i, j = self.domain.edges.T
        return cross(N[i], N[j])

    def given(self, rim: Array) -> Conditions:
        """The conditions with the prescribed normals `rim` (n, 3)."""
        none = Conditions()
        return replace(
            self.conditions,
            vertices=self.fixed,
            vertex_normals=rim,
            only_vertices=self.fixed,
            edges=none.edges,
            edge_normals=none.edge_normals,
        )

    def spread(self, values: Array) -> Array:
        """The harmonic extension (V, k) of values (n, k) at the fixed vertices, zero at corners between mirrors."""
        held = np.zeros((len(self.dirichlet.fixed), values.shape[1]))
        held[np.searchsorted(self.dirichlet.fixed, self.fixed)] = values
        return self.dirichlet.extend(held)

    def at(self, harmonic: HarmonicMap) -> State:
        """The surface of a harmonic map."""
        products = self.products(harmonic.normals)
        g = self._integral(self.load @ products)
        return State(harmonic, self.problem.at(harmonic.normals), g, self._forms.T @ products)

    def _integral(self, load: Array) -> Array:
        """u (V, k) with L u = load, centred at the mean of its boundary."""
        u = self._poisson.solve(load, np.zeros((1, load.shape[1])))
        return u - u[self._rim].mean(axis=0)

    def differential(self, state: State, turned: Array) -> tuple[Array, Array]:
        """The changes (V, 3) of N and of g with tangent changes `turned` (n, 3) of the boundary normals."""
        operator = self.problem.operator(state.point)
        moved = np.zeros_like(state.N)
        moved[self.fixed] = turned
        moved = moved - self._solve_hessian(state, self.problem.project(state.N, operator(moved)))
        i, j = self.domain.edges.T
        products = cross(moved[i], state.N[j]) + cross(state.N[i], moved[j])
        return moved, self._integral(self.load @ products)

    def pull_back(
        self,
        state: State,
        by_normals: Array,
        by_conjugate: Array,
        by_periods: Array | None = None,
        accuracy: float = _ACCURACY,
    ) -> Array:
        """The gradient (n, 3), tangent at the boundary normals, of a function F(N, g, periods).

        Its partial derivatives by N and by g are (V, 3), by the periods (k, 3). accuracy: relative.
        """
        q = self.load.T @ self.pulled_integral(by_conjugate)
        if by_periods is not None and by_periods.size:
            q = q + self._forms @ by_periods
        return self.pull_products(state, q, by_normals, accuracy)

    def pull_products(
        self, state: Reached, q: Array, by_normals: Array | float = 0.0, accuracy: float = _ACCURACY
    ) -> Array:
        """The same of F(N, N_i × N_j), with its partial derivatives by N (V, 3) and by those products, q (E, 3)."""
        total = by_normals + self._pulled_products(state.N, q)
        mu = self._solve_hessian(state, self.problem.project(state.N, total), accuracy)
        back = total - self.problem.operator(state.point)(mu)
        return project(state.N[self.fixed], back[self.fixed])

    def tau_by_weights(self, state: Reached, changed: Array, accuracy: float = _ACCURACY) -> Array:
        """The change (E, 3) of tau with changes (E,) of the edge weights, for fixed boundary normals.

        The normals change by dN = -(P H P)⁻¹ P dL N.
        """
        N, domain = state.N, self.domain
        pushed = graph_laplacian(domain.edges, changed, domain.vertex_count) @ N
        moved = -self._solve_hessian(state, self.problem.project(N, pushed), accuracy)
        i, j = domain.edges.T
        turning = cross(moved[i], N[j]) + cross(N[i], moved[j])
        return changed[:, None] * self.products(N) + domain.cotan_weights[:, None] * turning

    def pulled_integral(self, by_conjugate: Array) -> Array:
        """The transpose of load ↦ g."""
        balanced = by_conjugate.copy()
        balanced[self._rim] -= by_conjugate.sum(axis=0) / len(self._rim)
        return self._poisson.solve(balanced, np.zeros((1, by_conjugate.shape[1])))

    def _pulled_products(self, N: Array, q: Array) -> Array:
        """The transpose of N ↦ N_i × N_j: <q, N_i × N_j> has the derivatives N_j × q and q × N_i."""
        i, j = self.domain.edges.T
        count = self.domain.vertex_count
        return sum_rows(i, cross(N[j], q), count) + sum_rows(j, cross(q, N[i]), count)

    def _solve_hessian(self, state: Reached, right: Array, accuracy: float = _ACCURACY) -> Array:
        """(P H P)⁻¹ right (V, 3), by conjugate gradients; by MINRES if the map is a saddle."""
        apply = self.problem.hessian(state.point)

        def precondition(X: Array) -> Array:
            return self.problem.project(state.N, self.dirichlet.precondition(X))

        x = np.zeros_like(right)
        rest, z = right, precondition(right)
        p, size = z, inner(right, z)
        goal = accuracy**2 * size
        for _ in range(_CG_LIMIT):
            if size <= goal:
                return x
            curved = apply(p)
            curvature = inner(p, curved)
            if curvature <= 0.0:
                return self._minres(state, apply, right, accuracy)
            alpha = size / curvature
            x, rest = x + alpha * p, rest - alpha * curved
            z = precondition(rest)
            size, last = inner(rest, z), size
            p = z + (size / last) * p
        return x

    def _minres(self, state: Reached, apply: Linear, right: Array, accuracy: float) -> Array:
        """MINRES needs a definite preconditioner: it leaves directions that are not admissible unchanged."""
        N, problem = state.N, self.problem

        def precondition(X: Array) -> Array:
            admissible = problem.project(N, X)
            return X - admissible + problem.project(N, self.dirichlet.precondition(admissible))

        def flat(f: Linear) -> Any:  # scipy.sparse.linalg ships no types
            operator: Any = LinearOperator
            return operator((right.size, right.size), matvec=lambda v: f(v.reshape(-1, 3)).ravel(), dtype=np.float64)

        solution, _ = minres(flat(apply), right.ravel(), M=flat(precondition), rtol=accuracy, maxiter=_CG_LIMIT)
        return solution.reshape(-1, 3)


def boundary_shares(domain: Domain) -> Array:
    """(V,) half the length of the boundary edges at each vertex, as a part of the whole."""
    lengths = np.repeat(domain.edge_lengths[domain.boundary_edges], 2)
    shares = np.bincount(domain.edges[domain.boundary_edges].ravel(), lengths, domain.vertex_count)
    return shares / shares.sum()
