"""Shape similarity: how much a CMC surface looks like a given one, regardless of size.

The conjugate of a Gauss map N_φ, harmonic or not, obeys d(g + N) = 2 H_φ dφ with the mean curvature H_φ of the surface
φ itself. A map near N_φ therefore gives a sheet near φ only where H_φ is even and of one sign: where it changes sign
the sheet folds, and nothing remains of a saddle, whose H_φ is almost zero everywhere. Yet a small change of the Gauss
map makes the sheet look like φ, since dN counts little in d(g + N) there.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from ..domain.domain import Domain
from ..gauss.sphere import inner
from ..linalg import graph_laplacian, sum_rows
from .target import Curvature, Partials, Shape, Target

Array = NDArray[np.float64]

# Mean curvature, as a part of the root mean square of the principal curvatures, below which a surface counts as
# minimal: mesh errors hide smaller ones, since f = (g + N) / 2H.
LEAST = 0.1
# Waves along the rim for which the model of the curvature holds.
_WAVES = 4


def dirichlet_matrix(domain: Domain) -> sp.csr_array:
    """L (V, V): <L u, u> = ∫ |du|²."""
    return graph_laplacian(domain.edges, domain.cotan_weights, domain.vertex_count)


def cosine(L: sp.csr_array, u: Array, v: Array) -> float:
    """Cosine of the angle between du and dv in L². For a surface and its normals: mean H over RMS curvature."""
    return inner(L @ u, v) / np.sqrt(inner(L @ u, u) * inner(L @ v, v))


@dataclass(frozen=True, eq=False)
class ShapeSimilarity(Target):
    """1 - cos(dx, dφ), φ: `points` (V, 3), and ½ (1 - (h / least)²)² where h < least = 0.1 (h as in `bending`).

    With the least distance over all sizes and shifts: 1 - cos = ½ ∫ |dx - dφ|² / ∫ |dφ|², to second order.
    """

    points: Array
    L: sp.csr_array
    label = "likeness"

    @cached_property
    def _tension(self) -> Array:
        return self.L @ self.points

    def _cosine(self, shape: Shape) -> tuple[float, Array]:
        """The cosine and its derivative by the points (V, 3)."""
        tension = self.L @ shape.points
        square = inner(tension, shape.points)
        lengths = np.sqrt(square * inner(self._tension, self.points))
        cos = inner(self._tension, shape.points) / lengths
        return cos, self._tension / lengths - (cos / square) * tension

    def partials(self, shape: Shape) -> Partials:
        cos, slope = self._cosine(shape)
        bent, turned = bending(shape.domain, self.L, shape.normals)
        lack = max(0.0, 1.0 - bent / LEAST**2)
        return Partials.of(shape, 1.0 - cos + 0.5 * lack**2, by_points=-slope, by_normals=(-lack / LEAST**2) * turned)

    def curvature(self, shape: Shape) -> Curvature:
        rim = shape.domain.boundary_vertices
        stiffness = 2.0 * np.pi * _WAVES / len(rim) / inner(self.L @ shape.points, shape.points)
        bent, turned = bending(shape.domain, self.L, shape.normals)
        rows = (Partials.of(shape, by_normals=turned / LEAST**2),) if bent < LEAST**2 else ()
        return Curvature(rim, np.broadcast_to(stiffness * np.eye(3), (len(rim), 3, 3)), rows=rows)

    def distance(self, shape: Shape) -> float:
        """√2 √(1 - cos): the root mean square of |dx - dφ|, as a part of that of |dφ|."""
        return float(np.sqrt(2.0 * max(0.0, 1.0 - self._cosine(shape)[0])))


def bending(domain: Domain, L: sp.csr_array, N: Array) -> tuple[float, Array]:
    """h² = ½ (1 + area / energy) of a map N into the sphere, and its derivative (V, 3).

    The area is counted with its sign. On a surface of mean curvature H h is H over the root mean square of its
    principal curvatures: 1 on a sphere, √½ on a cylinder, 0 on a minimal surface. N alone decides how much
    of g + N remains.
    """
    a, b, c = (N[domain.faces[:, k]] for k in range(3))
    area = 0.5 * inner(a, np.cross(b, c))
    corners = 0.5 * np.stack([np.cross(b, c), np.cross(c, a), np.cross(a, b)], axis=1)
    by_area = sum_rows(domain.faces.ravel(), corners.reshape(-1, 3), len(N))
    tension = L @ N
    energy = 0.5 * inner(tension, N)
    return 0.5 * (1.0 + area / energy), (0.5 / energy) * (by_area - (area / energy) * tension)
