"""Periods: by how much the conjugate fails to close around the holes and handles of a domain (paper, Sec. 5.3.1)."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from ..domain.sites import SiteGraph
from ..domain.topology import Homology
from ..gauss.dirichlet import Dirichlet
from .cmc import CmcSurface

Array = NDArray[np.float64]


def periods(surface: CmcSurface) -> Array:
    """Period vectors (k, 3), scaled as the surface is, one for each loop that cannot be contracted.

    The sum of tau around the loop; zero vectors mean that the surface closes.
    """
    return surface.periods


def harmonic_forms(homology: Homology, dirichlet: Callable[[NDArray[np.integer]], Dirichlet]) -> Array:
    """η (E, k): the harmonic one-forms dual to the loops of a domain, zero along its boundary.

    η = ω + dφ with ω = ±1 where the loop goes over an edge, φ = 0 on the boundary, Σ_j w_ij η_ij = 0 at every vertex
    inside. dirichlet(sites): the factored cotangent Laplacian with values given at vertices. The period of a closed
    form, as tau is where N is harmonic, is its sum along the loop and also Σ_e η_e tau_e; this one hardly depends on
    what is left of Σ tau where N is not quite harmonic.
    """
    domain = homology.domain
    jumps = homology.loops.astype(np.float64)
    graph = SiteGraph.of(domain, "vertices")
    rim = domain.boundary_vertices.astype(np.int64)
    given = rim if len(rim) else np.zeros(1, dtype=np.int64)
    source = -graph.sums(graph.weights[:, None] * jumps)
    potential = dirichlet(given).solve(source, np.zeros((len(given), jumps.shape[1])))
    i, j = domain.edges.T
    return jumps + potential[i] - potential[j]
