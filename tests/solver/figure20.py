"""The experiment of the paper's Figure 20: is the identity of the sphere recovered on poor triangles?

A fair measurement has to hold some normals. Harmonic maps of degree one are the Möbius transformations of the sphere
and all have the same energy; on a mesh the energies differ a little, the identity is a saddle among them, and a plain
minimiser slides away to a constant (paper, Sec. 5.3.4). So four faces, the corners of a tetrahedron, keep their
normals: three already tell one Möbius transformation from all others. The start is the identity at the circumcentres of
the faces, their own normals; the error is the angle to it, without any alignment, averaged over the area.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from solver import Domain, HarmonicMap, HarmonicSolver, Status, conditions
from tests.solver import meshes

Array = NDArray[np.float64]

ASPECTS = (1, 2, 4, 10, 25, 60)
JITTER = 0.06
PINS = np.array([[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]]) / np.sqrt(3.0)


@dataclass(frozen=True)
class Recovery:
    """A sphere, its own normals (F, 3), and the map recovered from them; errors (F,) and their mean, in degrees."""

    points: Array
    domain: Domain
    identity: Array
    harmonic: HarmonicMap

    @property
    def errors(self) -> Array:
        cosines = np.einsum("ij,ij->i", self.harmonic.normals, self.identity)
        return np.degrees(np.arccos(np.clip(cosines, -1.0, 1.0)))

    @property
    def error(self) -> float:
        return float(np.average(self.errors, weights=self.domain.face_areas))

    @property
    def is_lost(self) -> bool:
        return self.harmonic.status is not Status.CONVERGED or self.error > 20.0

    @property
    def not_delaunay(self) -> float:
        """The share of edges that are not Delaunay."""
        return float(np.mean(self.domain.cotan_weights < 0.0))


def sphere(n: int, aspect: float) -> tuple[Array, NDArray[np.int64]]:
    """The sphere of this aspect ratio; the first of the row is as regular as can be."""
    return meshes.rings(n, aspect, JITTER if aspect > 1 else 0.0)


def recover(points: Array, faces: NDArray[np.int64], energy: str, method: str = "newton") -> Recovery:
    """Minimise from the identity, four faces held; after 60 steps it counts as not converged."""
    domain = Domain.from_positions(points, faces)
    identity = meshes.face_normals(points, domain.faces)
    pins = np.argmax(identity @ PINS.T, axis=0)
    held = conditions.fixed_at_faces(domain, pins, identity[pins])
    solver = HarmonicSolver(domain, sites="faces", energy=energy)
    return Recovery(points, domain, identity, solver.solve(held, initial=identity, method=method, max_iterations=60))
