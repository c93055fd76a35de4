"""The energy of sphere-valued maps as an optimisation problem: values, gradients, Hessians, residuals.

E(N) = Σ_links ε(c_ij) with |N_i| = 1, some of the normals fixed. With L the graph Laplacian of the weights
star_ij = -dε/dc, G = LN is the gradient in R³ (paper, Eq. 14: critical means that G_i is parallel to N_i), and with
λ_i = <N_i, G_i> and the differences u_ij = N_i - N_j the Hessian on tangent vectors is

    d ↦ P ((L - λ) d - Σ dstar u <u, d_i - d_j>),

P being the projection on the tangent planes of the sites that are not fixed; on a mirror, on the tangent of its great
circle, which is a geodesic and so adds nothing to the Hessian.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from ..domain.sites import SiteGraph
from .dirichlet import Dirichlet
from .energies import EdgeEnergy
from .mirrors import Mirrors
from .sphere import dot, inner, project

Array = NDArray[np.float64]

# Where star changes by a larger part, the change of energy is taken as a difference of two values.
_SMOOTH = 1e-3


@dataclass(frozen=True, eq=False)
class Point:
    """A map N (S, 3) and the energy's value and derivatives there.

    L: (S, S) the Laplacian with the weights star. gradient: G (S, 3). tangent: PG (S, 3), zero at fixed sites.
    c, star: (K,) of the links; None for a quadratic energy.
    """

    N: Array
    L: sp.csr_array
    gradient: Array
    tangent: Array
    c: Array | None
    star: Array | None
    energy: float
    residual: float


def equal_laplacian(graph: SiteGraph, energy: EdgeEnergy) -> sp.csr_array:
    """L at equal normals; for a quadratic energy, L at every map."""
    return graph.laplacian(energy.star(np.ones(len(graph.links)), graph))


@dataclass(frozen=True, eq=False)
class EnergyProblem:
    """An energy on a graph, with normals fixed at some sites and held in the planes of mirrors at others.

    dirichlet: the fixed sites, and the factor that preconditions. laplacian: `equal_laplacian`, if already known.
    """

    graph: SiteGraph
    energy: EdgeEnergy
    dirichlet: Dirichlet
    laplacian: sp.csr_array | None = None
    mirrors: Mirrors = field(default_factory=Mirrors.none)

    @cached_property
    def _constant_laplacian(self) -> sp.csr_array:
        return equal_laplacian(self.graph, self.energy) if self.laplacian is None else self.laplacian

    def at(self, N: Array) -> Point:
        """The energy at N (S, 3). With opposite neighbours it may be infinite, and is then not differentiated."""
        c: Array | None = None
        star: Array | None = None
        L = self._constant_laplacian if self.energy.quadratic else None
        if L is None:
            i, j = self.graph.links.T
            # from the difference, which keeps the digits of small angles
            u = N[i] - N[j]
            c = 1.0 - 0.5 * dot(u, u)[:, 0]
            star = self.energy.star(c, self.graph)
            if not np.isfinite(star).all():
                zero = np.zeros_like(N)
                return Point(N, self._constant_laplacian, zero, zero, c, star, np.inf, np.inf)
            L = self.graph.laplacian(star)
        gradient = L @ N
        tangent = self.project(N, gradient)
        energy = 0.5 * inner(N, gradient) if c is None else float(self.energy.value(c, self.graph).sum())
        return Point(N, L, gradient, tangent, c, star, energy, self._residual(tangent))

    def project(self, N: Array, X: Array) -> Array:
        """The admissible part of X (S, 3) at N: tangent to the sphere, in the mirrors' planes, zero at fixed sites."""
        admissible = project(N, X)
        admissible[self.dirichlet.fixed] = 0.0
        return self.mirrors.flatten(admissible)

    def _residual(self, tangent: Array) -> float:
        """sqrt(A Σ |P_i G_i|² / A_i): the L² norm of N × (d*dN) on the domain scaled to unit area."""
        areas = self.graph.areas
        return float(np.sqrt(areas.sum() * np.sum(dot(tangent, tangent)[:, 0] / areas)))

    def hessian(self, point: Point) -> Callable[[Array], Array]:
        """The Hessian at a map, as a function of admissible (S, 3)."""
        operator = self.operator(point)
        return lambda d: self.project(point.N, operator(d))

    def operator(self, point: Point) -> Callable[[Array], Array]:
        """The Hessian before projection, of any tangent (S, 3): how the tangent parts of LN change, fixed or not."""
        N, L = point.N, point.L
        multiplier = dot(N, point.gradient)
        bending = self.bending(point)
        if bending is None:
            return lambda d: L @ d - multiplier * d
        rows, dstar = bending
        columns = sp.csr_array(rows.T)

        def apply(d: Array) -> Array:
            bent = columns @ (dstar * (rows @ d.ravel()))
            return L @ d - multiplier * d - bent.reshape(-1, 3)

        return apply

    def bending(self, point: Point) -> tuple[sp.csr_array, Array] | None:
        """U (K, 3 S), which takes d to <u_ij, d_i - d_j>, and dstar (K,); None where the energy is quadratic."""
        if point.c is None:
            return None
        links, count = self.graph.links, self.graph.count
        u = point.N[links[:, 0]] - point.N[links[:, 1]]
        columns = (3 * links[:, :, None].astype(np.int64) + np.arange(3)).reshape(len(links), 6)
        starts = np.arange(0, 6 * len(links) + 1, 6)
        data = np.concatenate([u, -u], axis=1)
        rows = sp.csr_array((data.ravel(), columns.ravel(), starts), shape=(len(links), 3 * count))
        return rows, self.energy.dstar(point.c, self.graph)

    def change(self, before: Point, after: Point) -> float:
        """E(after) - E(before), accurate when it is far below the rounding of E.

        For a quadratic energy it is ½ <N' - N, G' + G>. For others each link adds -½ (star + star') (c' - c) where its
        star hardly changes, and the difference of its values elsewhere.
        """
        if before.c is None or after.c is None or before.star is None or after.star is None:
            return 0.5 * inner(after.N - before.N, after.gradient + before.gradient)
        if not np.isfinite(after.energy):
            return np.inf
        i, j = self.graph.links.T
        moved = after.N - before.N
        dc = (dot(moved[i], after.N[j]) + dot(before.N[i], moved[j]))[:, 0]
        mean = 0.5 * (before.star + after.star)
        smooth = np.abs(after.star - before.star) <= _SMOOTH * np.abs(mean)
        values = self.energy.value(after.c, self.graph) - self.energy.value(before.c, self.graph)
        return float(np.where(smooth, -mean * dc, values).sum())
