"""The closing map: from boundary normals and moduli to the sums that must vanish, and its derivatives.

The sums of `closing_conditions` are linear in tau of the harmonic map that the normals N₀ determine on the domain of
the moduli q. The gradient of each by N₀ takes one equation with the Hessian of the energy, and the derivative by each
of q one equation (implicit function theorem; paper, Sec. 5.3.3 and Appendix F).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..domain.domain import Domain
from ..gauss.admissible import resolved
from ..gauss.boundary_data import Conditions
from ..gauss.harmonic import HarmonicSolver
from ..surface.adjoint import AdjointSolver, Reached
from .closing_conditions import ClosingConditions
from .moduli import Moduli

Array = NDArray[np.float64]

# Residual up to which a map counts as harmonic.
HARMONIC = 1e-6
# Relative accuracy of derivatives.
_ACCURACY = 1e-5
# Cosine up to which a normal counts as lying in the plane of a mirror.
_ALONG = 1e-6


@dataclass(frozen=True, eq=False)
class Place:
    """A point of the search: moduli q (m,) and prescribed normals rim (n, 3), the map there, and the sums left.

    forms: (E, m) of the closing conditions. sums: (K,). lengths: of each condition. size, area: of f+ at scale 1.
    """

    q: Array
    rim: Array
    extension: AdjointSolver
    reached: Reached
    forms: Array
    sums: Array
    lengths: Array
    size: float
    area: float

    @property
    def domain(self) -> Domain:
        return self.extension.domain

    @property
    def is_harmonic(self) -> bool:
        """Whether the map here is harmonic; past a fold of the moduli none is."""
        return self.reached.harmonic.residual <= HARMONIC

    @property
    def gap(self) -> float:
        """The longest period or distance as a part of the size."""
        return float(self.lengths.max()) / self.size


class ClosingMap:
    """(N₀, q) ↦ the sums that must vanish. fixed: (n,) the vertices with prescribed normals, first: (n, 3) the normals
    there at the beginning. method: of the harmonic maps."""

    def __init__(
        self, conditions: Conditions, closing: ClosingConditions, moduli: Moduli, method: str = "newton"
    ) -> None:
        self.conditions, self.closing, self.moduli, self.method = conditions, closing, moduli, method
        self._extension = AdjointSolver(HarmonicSolver(moduli.first), conditions, method)
        self._forms = self._forms_on(self._extension)
        self._q = np.zeros(len(moduli.names))
        self.fixed = self._extension.fixed
        admissible = resolved(conditions, self._extension.solver.graph)
        self.first = admissible.data[np.searchsorted(admissible.fixed, self.fixed)]
        self._planes = admissible.sides.planes

    def at(self, q: Array, rim: Array, start: Array | None, tolerance: float) -> Place:
        """The place at normals (n, 3) and moduli (m,), its map from a `start` (V, 3) to a residual.

        Raises `MeshError` where the moduli turn a face over.
        """
        extension, forms = self._on(q)
        reached = extension.reach(rim, start, tolerance)
        tau = extension.domain.cotan_weights[:, None] * extension.products(reached.N)
        sums = self.closing.sums(forms, tau)
        area = 2.0 * reached.point.energy + 8.0 * np.pi * reached.harmonic.degree
        size = self._size(extension.domain, reached.N, tau)
        return Place(q, rim, extension, reached, forms, sums, self.closing.lengths(sums), size, area)

    def by_normals(self, place: Place) -> Array:
        """(K, 3 n) the derivatives by the prescribed normals."""
        weights = place.domain.cotan_weights[:, None]
        pulls = [weights * self.closing.by_tau(place.forms, k) for k in range(len(place.sums))]
        rows = [place.extension.pull_products(place.reached, pull, accuracy=_ACCURACY) for pull in pulls]
        return np.stack([row.ravel() for row in rows])

    def by_moduli(self, place: Place) -> Array:
        """(K, m) the derivatives by the moduli, the map following."""
        changes = [
            place.extension.tau_by_weights(place.reached, column, _ACCURACY)
            for column in self.moduli.weights(place.q).T
        ]
        return np.stack([self.closing.sums(place.forms, change) for change in changes], axis=1)

    def lines(self, rim: Array) -> tuple[Array, NDArray[np.bool_]]:
        """Directions (n, 3) in which normals (n, 3) at the ends of mirrors may turn, staying in their planes; zero
        between two mirrors. And which of the normals (n,) are such."""
        lines, held = np.zeros_like(rim), np.zeros(len(rim), dtype=bool)
        domain = self.moduli.first
        on = np.flatnonzero(self._planes.any(axis=1) & np.isin(domain.edges, self.fixed).any(axis=1))
        for edge in on:
            for row in np.flatnonzero(np.isin(self.fixed, domain.edges[edge])):
                along = np.cross(self._planes[edge], rim[row])
                if abs(self._planes[edge] @ rim[row]) > _ALONG:
                    continue  # not meant to lie in it
                if held[row] and np.linalg.norm(np.cross(along, lines[row])) > _ALONG:
                    along = np.zeros(3)
                lines[row], held[row] = along, True
        return lines, held

    def _on(self, q: Array) -> tuple[AdjointSolver, Array]:
        """The last one is kept: its factors serve as long as the domain stays."""
        if not np.array_equal(q, self._q):
            self._extension = AdjointSolver(HarmonicSolver(self.moduli.domain(q)), self.conditions, self.method)
            self._forms, self._q = self._forms_on(self._extension), q
        return self._extension, self._forms

    def _forms_on(self, extension: AdjointSolver) -> Array:
        return self.closing.forms(extension.solver.dirichlet, extension.domain)

    def _size(self, domain: Domain, N: Array, tau: Array) -> float:
        """Approximate diagonal of f+: from the conjugate on the faces and the normals at their corners."""
        g = self.closing.homology.integrate(tau)
        return float(np.linalg.norm(np.ptp(np.repeat(g, 3, axis=0) + N[domain.faces.ravel()], axis=0)))
