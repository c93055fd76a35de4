"""The Galerkin equation of the conjugate along mirrors, where g may move within their planes.

Along a mirror g is first a linear fit, second order but rough: the mean curvature of two triangles at a corner can be
off by half at every mesh size. The conforming solution on the surface continued by reflection solves
`P (L g - load) = 0`, P being the projection on the displacements that keep every vertex in its planes. It takes few
steps of conjugate gradients, since the equation holds inside already.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..domain.domain import Domain
from ..gauss.admissible import Admissible
from ..gauss.dirichlet import Dirichlet
from ..gauss.sphere import inner
from .plane_projection import VertexPlanes

Array = NDArray[np.float64]
Int = NDArray[np.integer]

# The residual at which to stop, as a part of the first one, which is of the order of the mesh's error: after 15 to 25
# steps, measured on honeycombs of 281 to 3899 vertices.
_ENOUGH = 1e-3
_MOST_STEPS = 60


class MirrorGalerkin:
    """The Galerkin equation at the vertices that mirrors leave free in their planes."""

    def __init__(self, domain: Domain, admissible: Admissible, dirichlet: Dirichlet) -> None:
        """dirichlet: with values given at the fixed sites, the preconditioner; elsewhere it is the diagonal."""
        self.L = domain.laplacian
        self.weights = self.L.diagonal()[:, None]
        self.dirichlet = dirichlet
        self.at = VertexPlanes.of(domain, admissible.sides.planes)
        held = np.zeros(domain.vertex_count, dtype=bool)
        held[admissible.fixed] = True
        ends = domain.edges[domain.boundary_edges]
        self.given = np.unique(ends[held[ends].all(axis=1)])
        self.single = np.setdiff1d(admissible.fixed, self.given)

    def run(self, load: Array, g: Array) -> Array:
        """g (V, 3) moved to where `P (L g - load)` vanishes, within its planes and fixed where it is given."""
        residual = self._project(load - self.L @ g)
        step = self._precondition(residual)
        direction, product = step, inner(residual, step)
        enough = _ENOUGH**2 * product
        for _ in range(_MOST_STEPS):
            if product <= enough:
                break
            bent = self._project(self.L @ direction)
            length = product / inner(direction, bent)
            g = g + length * direction
            residual = residual - length * bent
            step = self._precondition(residual)
            before, product = product, inner(residual, step)
            direction = step + (product / before) * direction
        return g

    def _project(self, X: Array) -> Array:
        X = X.copy()
        X[self.at.vertices] = self.at.nearest(X[self.at.vertices], np.zeros(len(self.at.places)))
        X[self.given] = 0.0
        return X

    def _precondition(self, X: Array) -> Array:
        Y = self.dirichlet.precondition(X)
        Y[self.single] = X[self.single] / self.weights[self.single]
        return self._project(Y)
