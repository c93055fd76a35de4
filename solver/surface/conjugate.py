"""From normals to the conjugate surface g of constant Gauss curvature, dg = τ = N × *dN (paper, Prop. 3.2).

`tau_ij = star_ij N_i × N_j` is the edge of g dual to edge ij: `g_left - g_right` across i → j. Around an
interior vertex these edges close exactly when N is harmonic there. So g lives on the faces, at their
circumcentres; where the domain has holes it is integrated on the domain cut open, and jumps by a period
across each cut.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from ..domain.domain import Domain
from ..domain.sites import SiteGraph
from ..domain.topology import Homology
from ..gauss.energies import EdgeEnergy
from ..linalg import factorize, sum_rows

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Conjugate:
    """The discrete conjugate at scale 1 (H = ½), its first face at the origin.

    tau: (E, 3). g: (F, 3), one point a face. boundary_points: (B, 3), one on each of `domain.boundary_edges`,
    which complete the dual polygons of the boundary vertices (paper, Fig. 7). closure_error: the largest gap
    |Σ tau| around an interior vertex. periods: (k, 3), the jumps across the cuts of a domain with holes or
    handles.
    """

    tau: Array
    g: Array
    boundary_points: Array
    closure_error: float
    periods: Array


class Conjugation:
    """Conjugates on one domain; the tree along which they are integrated is kept."""

    def __init__(self, domain: Domain) -> None:
        self.domain = domain

    @cached_property
    def homology(self) -> Homology:
        return Homology.of(self.domain)

    def conjugate(self, N: Array, energy: EdgeEnergy) -> Conjugate:
        """Integrate tau of the unit normals N (V, 3) along a spanning tree of the faces."""
        domain = self.domain
        tau = conjugate_form(domain, N, energy)
        g = self.homology.tree.integrate(domain, tau)
        rim = domain.boundary_edges
        return Conjugate(
            tau=tau,
            g=g,
            boundary_points=g[domain.edge_faces[rim, 0]] - tau[rim],
            closure_error=_closure_error(domain, tau),
            periods=self.homology.periods(tau, g),
        )


def conjugate_form(domain: Domain, N: Array, energy: EdgeEnergy) -> Array:
    """tau (E, 3) = star N_i × N_j (paper, Eq. 9)."""
    i, j = domain.edges.T
    a, b = N[i], N[j]
    star = energy.star(np.einsum("ij,ij->i", a, b), SiteGraph.of(domain, "vertices"))
    return star[:, None] * cross(a, b)


def solve_dual_poisson(domain: Domain, N: Array) -> Array:
    """The conjugate (F, 3) of a simply connected domain by the dual Poisson equation, centred at its mean.

    Σ w*_e (g_left - g_right) = Σ N_i × N_j around every face, w* = 1/w the dual cotangent weights, with the
    natural condition along the boundary (paper, Eq. 10). Defined where no interior weight vanishes; a second
    way to g, which agrees with the integral of tau as far as N is harmonic.
    """
    inside = domain.interior_edges
    left, right = domain.edge_faces[inside].T
    i, j = domain.edges[inside].T
    dual = 1.0 / domain.cotan_weights[inside]
    n = len(domain.faces)
    signs = np.concatenate([np.ones(len(inside)), -np.ones(len(inside))])
    columns = np.concatenate([left, right])
    d = sp.csr_array((signs, (np.tile(np.arange(len(inside)), 2), columns)), shape=(len(inside), n))
    L = sp.csr_array(d.T @ (d * dual[:, None]))
    flux = d.T @ cross(N[i], N[j])
    g = np.zeros((n, 3))
    g[1:] = factorize(L[1:][:, 1:], backend="superlu").solve(flux[1:])
    return g - g.mean(axis=0)


def _closure_error(domain: Domain, tau: Array) -> float:
    """Largest |Σ_j tau_ij| around an interior vertex i."""
    i, j = domain.edges.T
    n = domain.vertex_count
    sums = sum_rows(i, tau, n) - sum_rows(j, tau, n)
    sums[domain.boundary_vertices] = 0.0
    return float(np.sqrt(np.einsum("ij,ij->i", sums, sums).max()))


def cross(a: Array, b: Array) -> Array:
    """a × b for (n, 3) arrays; several times faster than np.cross."""
    x, y, z = a.T
    u, v, w = b.T
    return np.stack([y * w - z * v, z * u - x * w, x * v - y * u], axis=1)
