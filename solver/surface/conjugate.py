"""From normals to the conjugate surface g of constant Gauss curvature, dg = τ = N × *dN (paper, Prop. 3.2 and 4.2).

`tau = star N_i × N_j` is the edge of g that runs between the two cells beside a link, `g_left - g_right`. Around a
site the edges close exactly when N is harmonic there: they are orthogonal to N_i, so g has planar polygons with the
normals N. With normals at vertices g lives on the faces, at their circumcentres, as a dual polygon mesh; with normals
at faces it lives on the vertices, as a triangle mesh. Where the domain has holes it is integrated on the domain cut
open, and jumps by a period across each cut.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ..domain.connectivity import after, before
from ..domain.domain import Domain
from ..domain.sites import SiteGraph
from ..domain.topology import Homology
from ..domain.trees import Tree
from ..gauss.dirichlet import Dirichlet
from ..gauss.energies import EdgeEnergy
from .plane_projection import VertexPlanes

Array = NDArray[np.float64]
Int = NDArray[np.integer]


@dataclass(frozen=True, eq=False)
class Conjugate:
    """The discrete conjugate at scale 1 (H = ½), its first cell at the origin.

    tau: (E, 3). With normals at vertices g: (F, 3), one point for each face, and boundary_points: (B, 3), one on each
    of `domain.boundary_edges`, which complete the dual polygons of the boundary vertices (paper, Fig. 7). With normals
    at faces g: (n, 3), one point for each vertex, or for each cut vertex of a domain with holes (`Homology.sheets`),
    and no boundary points. closure_error: the largest |Σ tau| around an interior site. periods: (k, 3), the jumps
    across the cuts of a domain with holes or handles.
    """

    tau: Array
    g: Array
    boundary_points: Array
    closure_error: float
    periods: Array

    def __repr__(self) -> str:
        return f"Conjugate({len(self.g)} points, {len(self.periods)} periods, closure error {self.closure_error:.1e})"


class Conjugation:
    """Conjugates on one domain; the trees along which they are integrated are kept."""

    def __init__(self, graph: SiteGraph) -> None:
        self.graph = graph
        self.domain = graph.domain

    def moved(self, graph: SiteGraph) -> Conjugation:
        """The same on a domain that differs only in its edge lengths, with the same trees and cuts."""
        moved = Conjugation(graph)
        known = ("homology", "_vertex_tree")
        moved.__dict__.update({name: self.__dict__[name] for name in known if name in self.__dict__})
        return moved

    @cached_property
    def homology(self) -> Homology:
        return Homology.of(self.domain)

    def conjugate(self, N: Array, energy: EdgeEnergy, planes: Array | None = None) -> Conjugate:
        """Integrate tau of the unit normals N (S, 3).

        planes: (E, 3) normals of the mirrors along boundary edges, zero on others.
        """
        tau = conjugate_form(self.graph, N, energy)
        error = _closure_error(self.graph, tau)
        if self.graph.at_vertices:
            return self._on_faces(tau, error)
        planes = np.zeros((len(self.domain.edge_lengths), 3)) if planes is None else planes
        return self._on_vertices(self.graph.completed(tau), N, error, planes)

    def _on_faces(self, tau: Array, error: float) -> Conjugate:
        g = self.homology.integrate(tau)
        rim = self.domain.boundary_edges
        points = g[self.domain.edge_faces[rim, 0]] - tau[rim]
        return Conjugate(tau, g, points, error, self.homology.periods(tau, g))

    def _on_vertices(self, tau: Array, N: Array, error: float, planes: Array) -> Conjugate:
        domain, homology = self.domain, self.homology
        cut_faces = domain.faces if homology.is_trivial else homology.sheets.faces
        g = self._vertex_tree.integrate(self._along_sides(tau))
        if self.graph.name == "faces":
            g, tau = unfold_ears(domain, cut_faces, g, tau, N, planes)
        periods = np.zeros((0, 3))
        if not homology.is_trivial:
            sheets = homology.sheets
            copies = np.arange(domain.vertex_count, len(sheets.source))
            jumps = g[copies] - g[sheets.source[copies]]
            periods = np.linalg.lstsq(sheets.offsets[copies].astype(np.float64), jumps, rcond=None)[0]
        return Conjugate(tau, g, np.zeros((0, 3)), error, periods)

    @cached_property
    def _vertex_tree(self) -> Tree:
        """A tree of the vertices along the sides of the faces; of the cut vertices, if the domain is cut open."""
        homology = self.homology
        cut_faces = self.domain.faces if homology.is_trivial else homology.sheets.faces
        pairs = np.stack([cut_faces[:, [2, 0, 1]], cut_faces[:, [1, 2, 0]]], axis=2).reshape(-1, 2)
        return Tree.of(pairs, int(cut_faces.max()) + 1)

    def _along_sides(self, tau: Array) -> Array:
        """(3 F, 3) from the start of each half-edge to its end."""
        half_edges = np.arange(self.domain.faces.size)
        edges = self.domain.face_edges.ravel()
        sign = np.where(self.domain.half_edges[edges, 0] == half_edges, 1.0, -1.0)
        return sign[:, None] * tau[edges]

    def closed(self, conjugate: Conjugate) -> Conjugate:
        """The conjugate without its periods: the exact part of tau (Hodge decomposition, paper, Remark 4).

        g minimises Σ weight |dg - tau|² over the edges between its cells; it has one point for each cell.
        """
        if self.homology.is_trivial:
            return conjugate
        tau = conjugate.tau
        if self.graph.at_vertices:
            g = self._exact(tau[self.domain.interior_edges], "faces")
            rim = self.domain.boundary_edges
            points = g[self.domain.edge_faces[rim, 0]] - tau[rim]
            return replace(conjugate, g=g, boundary_points=points)
        return replace(conjugate, g=self._exact(-tau, "vertices"))

    def _exact(self, differences: Array, cells: str) -> Array:
        """Values on `cells`, the sites of the dual graph, from `value(i) - value(j)` along its links (K, 3)."""
        graph = SiteGraph.of(self.domain, cells)
        weights = np.abs(graph.weights)
        anchor = np.zeros(1, dtype=np.int64)
        source = graph.sums(weights[:, None] * differences)
        return Dirichlet(graph, weights, anchor).solve(source, np.zeros((1, 3)))


def conjugate_form(graph: SiteGraph, N: Array, energy: EdgeEnergy) -> Array:
    """tau (K, 3) = star N_i × N_j on the links (paper, Eq. 9 and 14), zero where star is infinite."""
    i, j = graph.links.T
    a, b = N[i], N[j]
    star = energy.star(np.einsum("ij,ij->i", a, b), graph)
    star[~np.isfinite(star)] = 0.0  # opposite normals; the status says that the map is not resolved
    return star[:, None] * cross(a, b)


def _closure_error(graph: SiteGraph, tau: Array) -> float:
    """Largest |Σ_j tau_ij| around an interior site i."""
    sums = graph.sums(tau)
    sums[graph.rim] = 0.0
    return float(np.sqrt(np.einsum("ij,ij->i", sums, sums).max()))


def cross(a: Array, b: Array) -> Array:
    """a × b for (n, 3) arrays; several times faster than np.cross."""
    x, y, z = a.T
    u, v, w = b.T
    return np.stack([y * w - z * v, z * u - x * w, x * v - y * u], axis=1)


def unfold_ears(domain: Domain, cut_faces: Int, g: Array, tau: Array, N: Array, planes: Array) -> tuple[Array, Array]:
    """g (n, 3) and tau (E, 3) with the tips of ears where the affine map of the neighbouring face puts them.

    The ear and its neighbour are laid out in the plane; the map of the neighbour's triangle to g is continued to the
    tip, which is then moved into the plane through its two neighbours that is orthogonal to N (F, 3), and into those of
    the mirrors beside it: planes (E, 3), their normals or zero. cut_faces: (F, 3) the index into g of each corner.
    """
    base = _bases(domain)
    if not len(base):
        return g, tau
    across = domain.twins[base].astype(np.int64)
    corners = cut_faces.ravel()
    tip, start = corners[base], corners[after(base)]
    # the other face walks the common edge backwards
    a, b, far = (g[corners[corner]] for corner in (before(across), after(across), across))
    along, away = _coordinates(domain, base, across)
    point = along[:, None] * (b - a) + away[:, None] * (far - a)
    # the tip relative to `start`; the sides beside it end at the two ends of the base
    to_start, to_other = (domain.face_edges.ravel()[side] for side in (before(base), after(base)))
    other = corners[before(base)]
    normals = np.concatenate([N[base // 3], planes[to_start], planes[to_other]])
    zero = np.zeros(len(tip))
    offsets = np.concatenate([zero, zero, np.einsum("ij,ij->i", g[other] - g[start], planes[to_other])])
    at = VertexPlanes(tip, np.tile(np.arange(len(tip)), 3), normals, np.zeros(0, dtype=np.int64))
    g, tau = g.copy(), tau.copy()
    g[tip] = g[start] + at.nearest(point, offsets)
    for side in (after(base), before(base)):
        tau[domain.face_edges.ravel()[side]] = g[corners[before(side)]] - g[corners[after(side)]]
    return g, tau


def _bases(domain: Domain) -> Int:
    """The inner half-edge of each ear; its number is also that of the tip, the corner opposite."""
    outside = (domain.twins < 0).reshape(-1, 3)
    ears = np.flatnonzero(outside.sum(axis=1) == 2)
    return 3 * ears + np.argmin(outside[ears], axis=1)


def _coordinates(domain: Domain, base: Int, across: Int) -> tuple[Array, Array]:
    """The tip as `along (b - a) + away (far - a)`, where the edge a → b has the tip on its left, `far` on its right."""
    x, y = _apex(domain, base)
    from_b, depth = _apex(domain, across)
    away = -y / depth
    return x - away * (1.0 - from_b), away


def _apex(domain: Domain, half_edge: Int) -> tuple[Array, Array]:
    """The corner opposite a half-edge: its foot along it, from 0 to 1, and its height, in units of its length."""
    cotans = domain.corner_cotans.ravel()
    first, second = cotans[after(half_edge)], cotans[before(half_edge)]
    return first / (first + second), 1.0 / (first + second)
