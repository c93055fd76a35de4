"""Sites and links: normals live at the vertices of a domain or at its faces, and are compared along links.

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

A condition along a boundary edge fixes the face behind it, whose site lies about half a triangle inside; irregular
triangles make this error rough. A third kind avoids it: *faces and rim* has one more site in the middle of each
boundary edge, half-way to the mirror image of its face, and a link from the face to it.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray
from scipy.sparse.csgraph import connected_components

from ..errors import check_choice, plural
from ..linalg import graph_laplacian, sum_rows
from .connectivity import after
from .domain import Domain

Array = NDArray[np.float64]
Int = NDArray[np.integer]

# The share of a rim site in the area of the face behind it; the residual divides by areas.
_RIM_SHARE = 0.125
# The dual weight of an edge whose triangles lie on one circle is infinite: |w| counts as at least this. Such triangles
# (halves of a rectangle, say) then turn as one.
_SMALLEST_WEIGHT = 1e-4


@dataclass(frozen=True)
class Site:
    """A kind of site, as a user interface offers it."""

    label: str
    description: str


SITES = {
    "vertices": Site("Vertices", "Normals at the vertices of the plan; the standard choice"),
    "faces": Site("Faces", "Normals at the faces of the plan; the K-Surface then has flat triangles"),
    "faces_and_rim": Site(
        "Faces and Rim", "Normals at the faces and at the rim's edges, where they are prescribed: more exact"
    ),
}


@dataclass(frozen=True, eq=False)
class LinkSubset:
    """Weights and angles of some links of a graph: all that an energy reads."""

    weights: Array
    angles: Array


@dataclass(frozen=True, eq=False)
class SiteGraph:
    """S sites and K links between them: the graph that energies, minimisers and the conjugate work on.

    name: "vertices", "faces", or "faces_and_rim", whose sites are the F faces and then the B boundary edges.
    links: (K, 2) sites. edges: (K,) the edge of the domain that a link follows or crosses. cells: (K, 2) on its left
    and its right, -1 outside; `tau = g_left - g_right`. areas: (S,), a third of the surrounding faces or the face
    itself.
    """

    name: str
    domain: Domain
    links: Int
    edges: Int
    cells: Int
    areas: Array

    @classmethod
    def of(cls, domain: Domain, name: str) -> SiteGraph:
        """The graph of that name; `ConditionError` on an unknown name."""
        check_choice(name, SITES, "kind of sites")
        if name == "vertices":
            every = np.arange(len(domain.edge_lengths))
            return cls(name, domain, domain.edges, every, domain.edge_faces, domain.vertex_areas)
        inside, rim = domain.interior_edges, domain.boundary_edges
        # seen along the link from the left face to the right one, the head of the edge is on the left
        links, cells, areas = domain.edge_faces[inside], domain.edges[inside, ::-1], domain.face_areas
        if name == "faces":
            return cls(name, domain, links, inside, cells, areas)
        behind = domain.edge_faces[rim, 0]
        outwards = np.stack([behind, len(areas) + np.arange(len(rim))], axis=1)
        shares = _RIM_SHARE * areas[behind]
        return cls(
            name,
            domain,
            np.concatenate([links, outwards]),
            np.concatenate([inside, rim]),
            np.concatenate([cells, domain.edges[rim, ::-1]]),
            np.concatenate([areas - np.bincount(behind, shares, len(areas)), shares]),
        )

    @property
    def count(self) -> int:
        """S."""
        return len(self.areas)

    @property
    def at_vertices(self) -> bool:
        """Whether sites are the vertices."""
        return self.name == "vertices"

    @property
    def cell_count(self) -> int:
        """The number of cells: faces for sites at vertices, else vertices."""
        return len(self.domain.faces) if self.at_vertices else self.domain.vertex_count

    @cached_property
    def weights(self) -> Array:
        """(K,) cotangent weights w of the edges; at faces 1 / w, negative where an edge is not Delaunay.

        1 / w is unbounded on an edge whose two triangles lie on one circle; there it is large and positive.
        """
        w = self.domain.cotan_weights[self.edges]
        if self.at_vertices:
            return w
        return 1.0 / np.where(np.abs(w) < _SMALLEST_WEIGHT, _SMALLEST_WEIGHT, w)

    @cached_property
    def angles(self) -> Array:
        """(K, 2) the angles θ_k, θ_l opposite the edge in its left and its right face; π/2 outside."""
        left, right = self.domain.half_edges[self.edges].T
        corners = self.domain.corner_angles.ravel()
        return np.stack([corners[left], np.where(right >= 0, corners[right], 0.5 * np.pi)], axis=1)

    @cached_property
    def rim(self) -> Int:
        """Sorted sites on the boundary: vertices of boundary edges, or the sites that these edges fix."""
        domain = self.domain
        return domain.boundary_vertices if self.at_vertices else np.unique(self.owners[domain.boundary_edges])

    @cached_property
    def owners(self) -> Int:
        """(E,) the site that each boundary edge fixes, the face behind it or its own; -1 inside. Not at vertices."""
        rim = self.domain.boundary_edges
        owners = np.full(len(self.domain.edge_lengths), -1)
        own = len(self.domain.faces) + np.arange(len(rim))
        owners[rim] = self.domain.edge_faces[rim, 0] if self.name == "faces" else own
        return owners

    @cached_property
    def rings(self) -> list[Int]:
        """Sites along each boundary loop, in its order, without repeats."""
        domain = self.domain
        if self.at_vertices:
            return list(domain.boundary_loops)
        return [_without_repeats(self.owners[edges]) for edges in domain.boundary_loop_edges]

    @cached_property
    def triangles(self) -> Int:
        """(n, 3) triples of sites that cover the domain, counter-clockwise: its faces, or fans around its vertices.

        Fans around boundary vertices cover only what lies between sites.
        """
        domain = self.domain
        if self.at_vertices:
            return domain.faces
        leaving, arriving = np.full((2, domain.vertex_count), -1)
        if self.name == "faces_and_rim":
            tail, head = domain.edges[domain.boundary_edges].T
            leaving[tail] = arriving[head] = self.owners[domain.boundary_edges]
        return _fans(domain, leaving, arriving)

    @cached_property
    def bodies(self) -> Int:
        """(S,) a number for each site, the same for sites that turn as one.

        Links of infinite weight join them, across edges whose two triangles lie on one circle. Not at vertices, where
        no weight is infinite.
        """
        w = self.domain.cotan_weights[self.edges]
        i, j = self.links[np.abs(w) < _SMALLEST_WEIGHT].T
        joined = sp.coo_array((np.ones(len(i)), (i, j)), shape=(self.count, self.count))
        return connected_components(joined, directed=False)[1]

    def named(self, sites: Int) -> tuple[str, dict[str, Int]]:
        """Sites as a message names them, "faces 1, 2 and edge 7", and their indices as a `CmcError` takes them.

        A site on the rim is named by its edge.
        """
        if self.at_vertices:
            return plural("vertex", sites), {"vertices": sites}
        count = len(self.domain.faces)
        faces, edges = sites[sites < count], self.domain.boundary_edges[sites[sites >= count] - count]
        words = [plural(noun, items) for noun, items in (("face", faces), ("edge", edges)) if len(items)]
        return " and ".join(words), {"faces": faces, "edges": edges}

    def subset(self, links: Int) -> LinkSubset:
        """The data of these links, for an energy."""
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

        At faces a boundary edge gets the value that makes the sum of its face zero (paper, Fig. 7, bottom), half of it
        if the face has two such edges. The other kinds have a link for every edge.
        """
        domain = self.domain
        whole = np.zeros((len(domain.edge_lengths), form.shape[1]))
        whole[self.edges] = form
        if self.name != "faces":
            return whole
        behind = domain.edge_faces[domain.boundary_edges, 0]
        count = np.bincount(behind, minlength=self.count)
        whole[domain.boundary_edges] = -(self.sums(form) / np.maximum(count, 1)[:, None])[behind]
        return whole

    def means(self, values: Array) -> Array:
        """(S, k) values (V, k) at the sites: at faces the mean of the corners, on the rim that of the edge's ends."""
        if self.at_vertices:
            return values
        domain = self.domain
        means = values[domain.faces].mean(axis=1)
        if self.name == "faces":
            return means
        return np.concatenate([means, values[domain.edges[domain.boundary_edges]].mean(axis=1)])

    def sums(self, form: Array) -> Array:
        """(S, k) sum of a form on the links (K, k) around each site, outgoing links counted positive."""
        i, j = self.links.T
        return sum_rows(i, form, self.count) - sum_rows(j, form, self.count)


def _without_repeats(items: Int) -> Int:
    """Each item once, at its first place."""
    return items[np.sort(np.unique(items, return_index=True)[1])]


def _fans(domain: Domain, leaving: Int, arriving: Int) -> Int:
    """Triangles (n, 3) of sites around each vertex: the first of its fan with every two that follow, counter-clockwise.

    leaving, arriving: (V,) the sites before the first and after the last face around a boundary vertex, -1 for none.
    """
    corner, vertex = np.arange(domain.faces.size), domain.faces.ravel()
    start = domain.fan_starts[vertex]
    # the half-edge that ends at a corner lies opposite the corner after it; beyond it is the next face of the fan
    beyond = domain.twins[after(corner)].astype(np.int64)
    following = np.where(beyond >= 0, beyond // 3, arriving[vertex])
    is_proper = (corner != start) & ((beyond < 0) | (after(beyond) != start))
    has_rim = leaving[vertex] >= 0
    first = np.where(has_rim, leaving[vertex], start // 3)
    return np.stack([first, corner // 3, following], axis=1)[(following >= 0) & (has_rim | is_proper)]


Links = SiteGraph | LinkSubset
