"""Where normals live: at the vertices of a domain or at its faces, and along which links they are compared.

The graph of one kind is the dual of that of the other (paper, Sec. 3 and 4). A *site* carries a normal, a
*link* joins two neighbouring sites and crosses one edge of the triangulation, and the *cells* on the two sides of a
link carry the conjugate surface:

    sites      links                     cells       weight of a link
    vertices   every edge, i → j         faces       w_ij = ½ (cot θ_k + cot θ_l)
    faces      every interior edge,      vertices    w*_ij = 1 / w_ij
               from the left face to
               the right one

Around a site the links cross a closed ring of cells, except along the boundary, where the ring is closed by one
point on each boundary edge (sites at vertices) or by the boundary edges themselves (at faces; paper, Fig. 7).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from ..errors import ConditionError
from ..linalg import graph_laplacian, sum_rows
from .connectivity import after
from .domain import Domain

Array = NDArray[np.float64]
Int = NDArray[np.integer]

# The dual weight of an edge whose triangles lie on one circle is infinite: w counts as this much at least. Such
# triangles (halves of a rectangle, say) then turn as one.
_SMALLEST_WEIGHT = 1e-6


@dataclass(frozen=True)
class Site:
    """A kind of site, as a user interface offers it."""

    label: str
    description: str


SITES = {
    "vertices": Site("Vertices", "Normals at the vertices of the plan; the standard choice"),
    "faces": Site("Faces", "Normals at the faces of the plan; the conjugate surface then has flat triangles"),
}


@dataclass(frozen=True, eq=False)
class LinkSubset:
    """Some links of a graph, as far as an energy sees them."""

    weights: Array
    angles: Array


@dataclass(frozen=True, eq=False)
class SiteGraph:
    """S sites and K links between them; what the energies, the minimisers and the conjugate see of a domain.

    name: "vertices" or "faces". links: (K, 2) sites. edges: (K,) the edge of the domain that a link follows or
    crosses. cells: (K, 2) on its left and its right, -1 outside; `tau = g_left - g_right`. areas: (S,), a third of
    the surrounding faces or the face itself.
    """

    name: str
    domain: Domain
    links: Int
    edges: Int
    cells: Int
    areas: Array

    @classmethod
    def of(cls, domain: Domain, name: str) -> SiteGraph:
        """The graph named "vertices" or "faces"; `ConditionError` on any other name."""
        if name not in SITES:
            raise ConditionError(f"There is no sites {name!r}; known are {', '.join(SITES)}.")
        if name == "vertices":
            every = np.arange(len(domain.edge_lengths))
            return cls(name, domain, domain.edges, every, domain.edge_faces, domain.vertex_areas)
        inside = domain.interior_edges
        # seen along the link from the left face to the right one, the head of the edge is on the left
        return cls(name, domain, domain.edge_faces[inside], inside, domain.edges[inside, ::-1], domain.face_areas)

    @property
    def count(self) -> int:
        return len(self.areas)

    @property
    def at_vertices(self) -> bool:
        return self.name == "vertices"

    @property
    def cell_count(self) -> int:
        return len(self.domain.faces) if self.at_vertices else self.domain.vertex_count

    @cached_property
    def weights(self) -> Array:
        """(K,) cotangent weights w of the edges; at faces 1 / w, negative where an edge is not Delaunay.

        1 / w has no limit on an edge whose two triangles lie on one circle; there it is large and positive.
        """
        w = self.domain.cotan_weights[self.edges]
        if self.at_vertices:
            return w
        return 1.0 / np.where(np.abs(w) < _SMALLEST_WEIGHT, _SMALLEST_WEIGHT, w)

    @cached_property
    def angles(self) -> Array:
        """(K, 2) θ_k, θ_l, the corners opposite the edge in its left and its right face; π/2 outside."""
        left, right = self.domain.half_edges[self.edges].T
        corners = self.domain.corner_angles.ravel()
        return np.stack([corners[left], np.where(right >= 0, corners[right], 0.5 * np.pi)], axis=1)

    @cached_property
    def rim(self) -> Int:
        """Sorted sites on the boundary: vertices of boundary edges, or the faces behind them."""
        domain = self.domain
        return domain.boundary_vertices if self.at_vertices else np.unique(domain.edge_faces[domain.boundary_edges, 0])

    @cached_property
    def rings(self) -> list[Int]:
        """Sites along each boundary loop, in its order, none twice."""
        domain = self.domain
        if self.at_vertices:
            return list(domain.boundary_loops)
        return [_without_repeats(domain.edge_faces[edges, 0]) for edges in domain.boundary_loop_edges]

    @cached_property
    def triangles(self) -> Int:
        """(n, 3) triples of sites that cover the domain, counter-clockwise: its faces, or fans around its vertices.

        At faces the half of each boundary triangle that lies outside of the fans is left out.
        """
        return self.domain.faces if self.at_vertices else _fans(self.domain)

    def subset(self, links: Int) -> LinkSubset:
        return LinkSubset(self.weights[links], self.angles[links])

    def laplacian(self, weights: Array) -> sp.csr_array:
        """(S, S) symmetric: `<LN, N> = Σ_links weight |N_i - N_j|²`."""
        return graph_laplacian(self.links, weights, self.count)

    @property
    def incidence(self) -> tuple[Int, Int]:
        """A site and a cell (3 F,) at each corner `3 f + k`, those of a vertex and its face."""
        faces, vertices = np.repeat(np.arange(len(self.domain.faces)), 3), self.domain.faces.ravel()
        return (vertices, faces) if self.at_vertices else (faces, vertices)

    def completed(self, form: Array) -> Array:
        """A form (E, k) on all edges from one on the links (K, k), its sums around sites on the boundary closed.

        At vertices links are edges. At faces a boundary edge gets what makes the sum of its face zero (paper, Fig. 7,
        bottom): a half each where a face has two.
        """
        if self.at_vertices:
            return form
        domain = self.domain
        whole = np.zeros((len(domain.edge_lengths), form.shape[1]))
        whole[self.edges] = form
        behind = domain.edge_faces[domain.boundary_edges, 0]
        count = np.bincount(behind, minlength=self.count)
        whole[domain.boundary_edges] = -(self.sums(form) / np.maximum(count, 1)[:, None])[behind]
        return whole

    def sums(self, form: Array) -> Array:
        """(S, k) sum of a form on the links (K, k) around each site, outgoing links counted positive."""
        i, j = self.links.T
        return sum_rows(i, form, self.count) - sum_rows(j, form, self.count)


def _without_repeats(items: Int) -> Int:
    """Each item once, where it comes first."""
    return items[np.sort(np.unique(items, return_index=True)[1])]


def _fans(domain: Domain) -> Int:
    """Triangles (n, 3) of faces around each vertex: the first face of its fan with every two that follow.

    Half-edges that end at a vertex lead from each face around it to the next, counter-clockwise.
    """
    twins = domain.twins.astype(np.int64)
    corner = np.arange(domain.faces.size)
    # the half-edge that ends at corner k lies opposite corner k + 1; beyond it is the next face around the vertex
    beyond = twins[after(corner)]
    following = np.where(beyond >= 0, after(beyond), -1)
    first = domain.fan_starts[domain.faces.ravel()]
    proper = (following >= 0) & (corner != first) & (following != first)
    return np.stack([first[proper], corner[proper], following[proper]], axis=1) // 3


Links = SiteGraph | LinkSubset
