"""Averages that bring g and N to the same points, so that f± = g ± N can be formed (paper, Sec. 3).

With normals at vertices g is known on the faces, at their circumcentres, and averaged to the vertices by

galerkin: the conforming solution of min Σ_f A_f |∇g - τ_f|² with τ_f = N̄ × *∇N on each face; first order in H.
linear: a linear fit around each vertex to the values at circumcentres; first order in H.
area: the area-weighted mean of the paper (Eq. 11), which does not converge on irregular meshes.

With normals at faces it is N that is averaged to the vertices, by the linear fit (galerkin has no equation to solve
there) or by the mean of Eq. 11. Values at vertices are averaged to the faces with the barycentric weights of their
circumcentres, or by Eq. 12.

On a domain with holes all of them work on the cover: values across a cut are shifted by its period. Along mirrors the
results are moved exactly into the plane of the conjugate's boundary points (see `plane_projection`).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from ..domain.connectivity import after, before
from ..domain.domain import Domain
from ..domain.sites import SiteGraph
from ..domain.topology import Homology
from ..gauss.admissible import Admissible
from ..gauss.dirichlet import Dirichlet
from ..gauss.sphere import dot, normalize
from ..linalg import sum_rows
from .conjugate import Conjugate, cross
from .mirror_galerkin import MirrorGalerkin
from .plane_projection import VertexPlanes
from .vertex_fit import face_fit_weights, fit_weights

Array = NDArray[np.float64]
Int = NDArray[np.integer]

# A mean of normals shorter than this has no direction.
_SHORTEST = 1e-9


@dataclass(frozen=True, eq=False)
class Averaging:
    """The input of an average: the conjugate, the normals and their conditions, the cuts, and factors.

    dirichlet(sites): the factored Laplacian with values given at `sites`; for the sites of held normals it exists
    already, from the solve or its start.
    """

    domain: Domain
    homology: Homology
    conjugate: Conjugate
    N: Array
    admissible: Admissible
    dirichlet: Callable[[Int], Dirichlet]


def galerkin(a: Averaging) -> Array:
    """g (V, 3) at the first cut vertex of each vertex, from `L g = Σ_f ∫ <∇φ_i, τ_f - ∇(offsets)>`.

    On a simply connected domain the factor of the normals serves again: g is fitted linearly at the vertices where
    they were held, and solved for at the others. With holes, or if no boundary edge was held, one vertex is fitted and
    the whole Laplacian factored. A single vertex held among free ones is solved for like them: a value given at one
    point would be a spike.
    """
    load = _galerkin_load(a.domain, a.N)
    if a.conjugate.periods.any():
        load = load - _offset_load(a.domain, a.homology, a.conjugate.periods)
    held = _held(a)
    g = a.dirichlet(held).solve(load, _fitted(a, held))
    if len(a.admissible.sides.edges) == 0:
        return g
    return MirrorGalerkin(a.domain, a.admissible, a.dirichlet(a.admissible.fixed)).run(load, g)


def _held(a: Averaging) -> Int:
    """Vertices (n,) at which g is given: the ends of edges along which the normals are held, or the first vertex."""
    has_mirrors = len(a.admissible.sides.edges) > 0
    if a.homology.is_trivial or has_mirrors:
        is_held = np.zeros(a.domain.vertex_count, dtype=bool)
        is_held[a.admissible.fixed] = is_held[a.admissible.mirrors.sites] = True
        ends = a.domain.edges[a.domain.boundary_edges]
        ends = ends[is_held[ends].all(axis=1)]
        if len(ends):
            return np.unique(ends).astype(np.int64)
    return np.zeros(1, dtype=np.int64)


def linear(a: Averaging) -> Array:
    """g (V, 3) by a linear fit to the conjugate at circumcentres and boundary points around each vertex."""
    return _fitted(a, np.arange(a.domain.vertex_count))


def area(a: Averaging) -> Array:
    """g (V, 3) as the area-weighted mean of the conjugate on the faces around each vertex (paper, Eq. 11)."""
    return _in_planes(a, np.arange(a.domain.vertex_count), _mean(a, _area_weights(a.domain)))


def _area_weights(domain: Domain) -> sp.csr_array:
    """(V, 3 F) weights of the corners around each vertex, which sum to one."""
    vertices = domain.faces.ravel()
    areas = np.repeat(domain.face_areas, 3)
    weights = areas / np.bincount(vertices, areas, domain.vertex_count)[vertices]
    shape = (domain.vertex_count, len(vertices))
    return sp.csr_array((weights, (vertices, np.arange(len(vertices)))), shape=shape)


def fitted_normals(graph: SiteGraph, N: Array) -> Array:
    """Unit normals (V, 3) from those of the faces (S, 3), by a linear fit at circumcentres around each vertex.

    Sites on the rim are at the midpoints of their edges; without them the fit extrapolates to the boundary, by half a
    triangle.
    """
    domain, count = graph.domain, len(graph.domain.faces)
    if graph.name == "faces":
        return _unit(domain, N, face_fit_weights(domain) @ N)
    corners, ends = fit_weights(domain, np.arange(domain.vertex_count))
    inside, outside = np.repeat(N[:count], 3, axis=0), np.repeat(N[count:], 2, axis=0)
    return _unit(domain, N, np.asarray(corners @ inside + ends @ outside, dtype=np.float64))


def mean_normals(graph: SiteGraph, N: Array) -> Array:
    """Area-weighted means (V, 3) of the normals of the faces (S, 3) around each vertex (paper, Eq. 11), made unit."""
    of_faces = N[: len(graph.domain.faces)]
    return _unit(graph.domain, N, _area_weights(graph.domain) @ np.repeat(of_faces, 3, axis=0))


def _unit(domain: Domain, N: Array, means: Array) -> Array:
    """Means (V, 3) of the normals N around each vertex, made unit; where they cancel, the normal of one face there."""
    cancel = dot(means, means) < _SHORTEST**2
    return normalize(np.where(cancel, N[domain.fan_starts // 3], means))


def circumcentres(domain: Domain) -> Array:
    """Barycentric coordinates (F, 3) of the circumcentres, ½ cot θ_k (cot θ_i + cot θ_j).

    The one of an obtuse corner is negative: the circumcentre lies beyond the opposite edge.
    """
    a, b, c = domain.corner_cotans.T
    return 0.5 * np.stack([a * (b + c), b * (c + a), c * (a + b)], axis=1)


def vertex_shares(domain: Domain) -> Array:
    """A_v / Σ A_v over the corners of each face, (F, 3), with the barycentric areas A_v (paper, Eq. 12)."""
    areas = domain.vertex_areas[domain.faces]
    return areas / areas.sum(axis=1, keepdims=True)


@dataclass(frozen=True)
class Average:
    """An average as a user interface offers it.

    conjugate: g (V, 3), from normals at vertices. normals: N (V, 3), from normals at faces. to_faces: weights (F, 3)
    of the corners of each face.
    """

    label: str
    description: str
    conjugate: Callable[[Averaging], Array]
    normals: Callable[[SiteGraph, Array], Array]
    to_faces: Callable[[Domain], Array]


AVERAGINGS = {
    "galerkin": Average(
        "Galerkin", "Conforming solve; converges on every mesh", galerkin, fitted_normals, circumcentres
    ),
    "linear": Average(
        "Linear fit", "Fit at circumcentres; converges on every mesh", linear, fitted_normals, circumcentres
    ),
    "area": Average(
        "Area",
        "The paper's averages (Eq. 11 and 12): less exact, and rough on irregular meshes",
        area,
        mean_normals,
        vertex_shares,
    ),
}


def _galerkin_load(domain: Domain, N: Array) -> Array:
    """Σ_f ∫ <∇φ_i, τ> (V, 3): with c_k = N_{k+1} × N_{k+2}, a face adds ½ (c_k - mean of c) to its corner k.

    Only the normals enter: τ is conformally invariant.
    """
    i, j = domain.edges.T
    along = cross(N[i], N[j])  # in the direction of the left face; the opposite for the right one
    load = np.zeros((domain.vertex_count, 3))
    left = domain.half_edges[:, 0]
    sums = np.zeros((len(domain.faces), 3))
    for k in range(3):
        e = domain.face_edges[:, k]
        products = np.where((left[e] == 3 * np.arange(len(sums)) + k)[:, None], along[e], -along[e])
        sums += products
        load += sum_rows(domain.faces[:, k], products, domain.vertex_count)
    for k in range(3):
        load -= sum_rows(domain.faces[:, k], sums / 3.0, domain.vertex_count)
    return 0.5 * load


def load_matrix(domain: Domain) -> sp.csr_array:
    """(V, E) the matrix that takes the products N_i × N_j of the edges to Σ_f ∫ <∇φ, τ> (see `galerkin`)."""
    half_edges = np.arange(domain.faces.size)
    edges = domain.face_edges.ravel()
    sign = np.where(domain.half_edges[edges, 0] == half_edges, 0.5, -0.5)
    corners = np.concatenate([half_edges, half_edges, after(half_edges), before(half_edges)])
    values = np.concatenate([sign, -sign / 3.0, -sign / 3.0, -sign / 3.0])
    shape = (domain.vertex_count, len(domain.edge_lengths))
    return sp.csr_array(sp.coo_array((values, (domain.faces.ravel()[corners], np.tile(edges, 4))), shape=shape))


def _offset_load(domain: Domain, homology: Homology, periods: Array) -> Array:
    """Σ_f ∫ <∇φ_i, ∇(offset of the corners)> (V, 3)."""
    sheets = homology.sheets
    shift = (sheets.offsets @ periods)[sheets.faces]
    half_cotans = 0.5 * domain.corner_cotans
    load = np.zeros((domain.vertex_count, 3))
    for k in range(3):
        i, j = (k + 1) % 3, (k + 2) % 3
        pull = half_cotans[:, k, None] * (shift[:, i] - shift[:, j])
        load += sum_rows(domain.faces[:, i], pull, domain.vertex_count)
        load -= sum_rows(domain.faces[:, j], pull, domain.vertex_count)
    return load


def _fitted(a: Averaging, vertices: Int) -> Array:
    """g (n, 3) at sorted vertices by the linear fit, moved into the planes of mirrors."""
    return _in_planes(a, vertices, _mean(a, *fit_weights(a.domain, vertices)))


def _in_planes(a: Averaging, vertices: Int, g: Array) -> Array:
    """Values (n, 3) at sorted vertices, those on mirrors in the planes of the boundary points beside them."""
    if not len(a.admissible.sides.edges):
        return g
    planes = a.admissible.sides.planes.copy()
    chosen = np.zeros(a.domain.vertex_count, dtype=bool)
    chosen[vertices] = True
    planes[~chosen[a.domain.edges].all(axis=1)] = 0.0
    at = VertexPlanes.of(a.domain, planes)
    if not len(at.vertices):
        return g
    rim = np.searchsorted(a.domain.boundary_edges, at.edges)
    is_head = a.domain.edges[at.edges, 1] == at.vertices[at.places]
    ends = a.conjugate.boundary_points[rim] - _shift(a)[_rim_corners(a.domain)[2 * rim + is_head]]
    mirrored = np.searchsorted(vertices, at.vertices)
    g[mirrored] = at.nearest(g[mirrored], dot(ends, at.normals)[:, 0])
    return g


def _mean(a: Averaging, corners: sp.csr_array, ends: sp.csr_array | None = None) -> Array:
    """Weighted mean (n, 3) of the conjugate at the corners (n, 3 F) and at the ends of boundary edges (n, 2 B).

    Every face is moved to the sheet of the first cut vertex at the corner; boundary points go with the face behind
    them.
    """
    shift = _shift(a)
    mean: Array = corners @ (np.repeat(a.conjugate.g, 3, axis=0) - shift)
    if ends is None:
        return mean
    return mean + ends @ (np.repeat(a.conjugate.boundary_points, 2, axis=0) - shift[_rim_corners(a.domain)])


def _shift(a: Averaging) -> Array:
    """(3 F, 3) from the sheet of the first cut vertex at each corner to that of its face."""
    if not a.conjugate.periods.any():
        return np.zeros((a.domain.faces.size, 3))
    sheets = a.homology.sheets
    return (sheets.offsets @ a.conjugate.periods)[sheets.faces.ravel()]


def _rim_corners(domain: Domain) -> Int:
    """(2 B,) the corners at the start and the end of each boundary edge, in the face behind it."""
    behind = domain.half_edges[domain.boundary_edges, 0]
    return np.stack([after(behind), before(behind)], axis=1).ravel()
