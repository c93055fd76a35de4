"""From the conjugate on the faces to g on the vertices, so that f± = g ± N share the triangles of the domain.

Three averages, by name:

galerkin: the conforming solution of min Σ_f A_f |∇g - τ_f|² with τ_f = N̄ × *∇N on each face; first order in
H.
linear: a linear fit around each vertex to the values at circumcentres; first order in H.
area: the area-weighted mean of the paper (Eq. 11), which does not converge on irregular meshes.

On a domain with holes all three are taken on the cover: values across a cut are shifted by its period.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from ..domain.domain import Domain
from ..domain.topology import Homology
from ..gauss.dirichlet import Dirichlet
from ..linalg import sum_rows
from .conjugate import Conjugate, cross
from .fit import fit_weights

Array = NDArray[np.float64]
Int = NDArray[np.integer]


@dataclass(frozen=True, eq=False)
class Averaging:
    """What an average may use: the conjugate, the normals and where they are fixed, the cuts, and kept factors.

    dirichlet(sites) is the factored Laplacian with values given at `sites`; for the `fixed` ones it is at hand, since
    the normals were solved with it.
    """

    domain: Domain
    homology: Homology
    conjugate: Conjugate
    N: Array
    fixed: Int
    dirichlet: Callable[[Int], Dirichlet]
    periods: Array  # (k, 3): those of the conjugate, or zeros to project them out

    @property
    def keeps_periods(self) -> bool:
        return bool(self.periods.any())


def galerkin(a: Averaging) -> Array:
    """g (V, 3) on the first rows of the cut surface, from `L g = Σ_f ∫ <∇φ_i, τ_f - ∇(offsets)>`.

    On a simply connected domain the factor of the normals serves again: g is fitted linearly at the fixed
    vertices and solved for at the others. With holes, one vertex is held and the whole Laplacian factored.
    """
    load = _galerkin_load(a.domain, a.N)
    if a.homology.is_trivial:
        faces, rim = fit_weights(a.domain, a.fixed)
        fitted = faces @ a.conjugate.g
        fitted += rim @ a.conjugate.boundary_points
        return a.dirichlet(a.fixed).solve(load, fitted)
    if a.keeps_periods:
        load = load - _offset_load(a.domain, a.homology, a.periods)
    anchor = np.zeros(1, dtype=np.int64)
    return a.dirichlet(anchor).solve(load, np.zeros((1, 3)))


def linear(a: Averaging) -> Array:
    """g (V, 3) by a linear fit to the conjugate at circumcentres and boundary points around each vertex."""
    faces, rim = fit_weights(a.domain, np.arange(a.domain.vertex_count))
    return _on_the_cover(a, faces) + rim @ a.conjugate.boundary_points + _rim_offsets(a, rim)


def area(a: Averaging) -> Array:
    """g (V, 3) as the area-weighted mean of the conjugate on the faces around each vertex (paper, Eq. 11)."""
    domain = a.domain
    face = np.repeat(np.arange(len(domain.faces)), 3)
    totals = np.bincount(domain.faces.ravel(), domain.face_areas[face], domain.vertex_count)
    weights = domain.face_areas[face] / totals[domain.faces.ravel()]
    shape = (domain.vertex_count, len(domain.faces))
    return _on_the_cover(a, sp.csr_array((weights, (domain.faces.ravel(), face)), shape=shape))


@dataclass(frozen=True)
class Average:
    """An average as a user interface offers it; `of` gives g (V, 3)."""

    label: str
    description: str
    of: Callable[[Averaging], Array]


AVERAGINGS = {
    "galerkin": Average("Galerkin", "Conforming solve; converges on every mesh", galerkin),
    "linear": Average("Linear fit", "Fit at circumcentres; converges on every mesh", linear),
    "area": Average("Area", "The paper's average (Eq. 11); does not converge on irregular meshes", area),
}


def _galerkin_load(domain: Domain, N: Array) -> Array:
    """Σ_f ∫ <∇φ_i, τ> (V, 3): with c_k = N_{k+1} × N_{k+2}, a face adds ½ (c_k - mean of c) to its corner k.

    Only the normals enter: τ is conformally invariant.
    """
    i, j = domain.edges.T
    along = cross(N[i], N[j])  # as the left face walks the edge; its other face sees the opposite
    load = np.zeros((domain.vertex_count, 3))
    left = domain.edge_faces[:, 0]
    sums = np.zeros((len(domain.faces), 3))
    for k in range(3):
        e = domain.face_edges[:, k]
        products = np.where((left[e] == np.arange(len(sums)))[:, None], along[e], -along[e])
        sums += products
        load += sum_rows(domain.faces[:, k], products, domain.vertex_count)
    for k in range(3):
        load -= sum_rows(domain.faces[:, k], sums / 3.0, domain.vertex_count)
    return 0.5 * load


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


def _on_the_cover(a: Averaging, weights: sp.csr_array) -> Array:
    """Average face values (V, F) around each vertex, every face brought to the sheet of the vertex's first row."""
    mean = weights @ a.conjugate.g
    if not a.conjugate.periods.size:
        return mean
    sheets = a.homology.sheets
    shift = sheets.offsets[sheets.faces] @ a.conjugate.periods
    matrix = weights.tocoo()
    corner = np.argmax(a.domain.faces[matrix.col] == matrix.row[:, None], axis=1)
    moved = matrix.data[:, None] * shift[matrix.col, corner]
    np.subtract.at(mean, matrix.row, moved)
    return mean


def _rim_offsets(a: Averaging, rim: sp.csr_array) -> Array:
    """What `_on_the_cover` does for faces, for boundary points: their sheet is that of the face behind them."""
    moved = np.zeros((a.domain.vertex_count, 3))
    if a.conjugate.periods.size:
        sheets = a.homology.sheets
        matrix = rim.tocoo()
        face = a.domain.edge_faces[a.domain.boundary_edges[matrix.col], 0]
        corner = np.argmax(a.domain.faces[face] == matrix.row[:, None], axis=1)
        shift = sheets.offsets[sheets.faces[face, corner]] @ a.conjugate.periods
        np.subtract.at(moved, matrix.row, matrix.data[:, None] * shift)
    return moved
