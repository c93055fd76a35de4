"""Periods: the vectors by which the conjugate fails to close around holes and handles (paper, Sec. 5.3.1).

tau = N × *dN is closed where N is harmonic, so that its sum along a path of faces depends only on the ends of the path.
That sum is also one over all edges, Σ_e η_e tau_e, with a form η that is ±1 on the edges crossed by the path, plus the
differences of any potential that vanishes on the boundary. The harmonic η is the smoothest: its sum hardly depends on
the remaining Σ tau where N is not quite harmonic, nor on the path.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from ..domain.domain import Domain
from ..domain.sites import SiteGraph
from ..domain.topology import Homology
from ..gauss.dirichlet import Dirichlet
from ..signatures import checked
from .cmc_surface import CmcSurface

Array = NDArray[np.float64]
Int = NDArray[np.integer]
Factored = Callable[[Int], Dirichlet]


@checked
def periods(surface: CmcSurface) -> Array:
    """Period vectors (k, 3) at the scale of the surface, one for each loop that cannot be contracted.

    Each is the sum of tau around its loop (paper, Sec. 5.3.1); zero vectors mean that the surface closes.
    """
    return surface.periods


def harmonic_forms(homology: Homology, dirichlet: Factored) -> Array:
    """η (E, k): the harmonic one-forms dual to the loops of a domain, zero along its boundary (see `smoothed`)."""
    return smoothed(homology.domain, homology.loops, dirichlet)


def smoothed(domain: Domain, paths: Array | Int, dirichlet: Factored) -> Array:
    """η (E, k) = ω + dφ with ω the `paths` (E, k), φ = 0 on the boundary, Σ_j w_ij η_ij = 0 at every vertex inside.

    dirichlet(sites): the factored cotangent Laplacian with values given at vertices.
    """
    jumps = paths.astype(np.float64)
    graph = SiteGraph.of(domain, "vertices")
    rim = domain.boundary_vertices.astype(np.int64)
    given = rim if len(rim) else np.zeros(1, dtype=np.int64)
    source = -graph.sums(graph.weights[:, None] * jumps)
    potential = dirichlet(given).solve(source, np.zeros((len(given), jumps.shape[1])))
    i, j = domain.edges.T
    return jumps + potential[i] - potential[j]


def path_across(homology: Homology, start: int, end: int) -> Int:
    """(E,) how often a path between two boundary edges crosses each edge, from its right side to its left.

    Σ_e path_e tau_e is the boundary point of the conjugate on edge `end` minus that on `start` (paper, Fig. 7).
    """
    domain = homology.domain
    path = np.zeros(len(domain.edges), dtype=np.int64)
    for edge, sign in ((start, -1), (end, 1)):
        pairs, signs = homology.tree.climb(int(domain.edge_faces[edge, 0]))
        path[domain.interior_edges[pairs]] += sign * signs.astype(np.int64)
        path[edge] -= sign
    return path


def integrals(domain: Domain, N: Array, forms: Array) -> Array:
    """∫ tau ∧ η (k, 3) of piecewise linear normals N (V, 3) and forms η (E, k), as harmonic one-forms are.

    tau = N̄ × *∇N with the mean normal N̄ of a face. A face adds Σ ½ cot θ_e η_e N̄ × (N_j - N_i) over its edges; the
    sum along a loop has the mean of the edge in place of N̄, and the two differ by O(h²). The signs are those of the sum
    along the loops.
    """
    edges = domain.face_edges
    i, j = domain.edges.T
    change = (N[j] - N[i])[edges]  # (F, 3, 3): in the direction of the left face, like η
    mean = N[domain.faces].mean(axis=1)
    weight = 0.5 * domain.corner_cotans
    products = np.cross(mean[:, None, :], change) * weight[:, :, None]
    return np.asarray(np.einsum("fek,fex->kx", forms[edges], products))
