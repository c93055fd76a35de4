"""Harmonic maps into the sphere with given boundary normals: the solver and its result."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..domain.domain import Domain
from ..errors import ConditionError, Status
from ..linalg import as_numbers
from . import sphere
from .conditions import Conditions
from .dirichlet import Dirichlet
from .energies import ENERGIES
from .initial import harmonic_start, wound_start
from .minimise import METHODS, DirichletProblem, Iterate, Progress

Array = NDArray[np.float64]

SITES = ("vertices",)
# Factors kept for as many different sets of fixed sites.
_KEPT_FACTORS = 4
# Energy, as a part of 4π, below which a map counts as constant.
_COLLAPSED = 1e-12


@dataclass(frozen=True, eq=False)
class HarmonicMap:
    """A (nearly) critical point of the Dirichlet energy.

    normals: (S, 3) unit vectors. energy: ½ <LN, N>. residual: `sqrt(A Σ |P_i (LN)_i|² / A_i)` at these
    normals.
    degree: signed area covered, as a part of the sphere. iterations: Newton steps taken.
    history: energy, residual, back-solves and step length, one line for each map reached.
    """

    normals: Array
    energy: float
    residual: float
    degree: float
    status: Status
    iterations: int
    history: list[Iterate]


class HarmonicSolver:
    """Solves on one domain for many boundary conditions; factors are kept, keyed by the set of fixed sites."""

    def __init__(self, domain: Domain, sites: str = "vertices", energy: str = "cotan") -> None:
        _check_name("sites", sites, SITES)
        _check_name("energy", energy, ENERGIES)
        self.domain = domain
        self.energy = ENERGIES[energy]
        self._factors: OrderedDict[bytes, Dirichlet] = OrderedDict()

    def dirichlet(self, fixed: NDArray[np.integer]) -> Dirichlet:
        """The factored Laplacian with values given at the `fixed` sites."""
        key = np.asarray(fixed, dtype=np.int64).tobytes()
        if key not in self._factors:
            self._factors[key] = Dirichlet(self.domain.laplacian, fixed)
            if len(self._factors) > _KEPT_FACTORS:
                self._factors.popitem(last=False)
        self._factors.move_to_end(key)
        return self._factors[key]

    def solve(
        self,
        conditions: Conditions,
        initial: ArrayLike | None = None,
        *,
        side: int = +1,
        degree: float | None = None,
        method: str = "newton",
        tolerance: float = 1e-6,
        max_iterations: int = 200,
        progress: Progress | None = None,
    ) -> HarmonicMap:
        """A harmonic map with the prescribed normals, from `initial` (S, 3) or from a start of its own.

        `side` ±1 chooses between the two sides of data that lie in one plane; `degree` asks for a homotopy class.
        There may be many harmonic maps for the same boundary: the result is the one reached, to be judged by its
        energy, degree and status. Raises `ConditionError` when nothing, or everything, is fixed.
        """
        _check_name("method", method, METHODS)
        fixed, data = self._fixed(conditions)
        dirichlet = self.dirichlet(fixed)
        start = self._start(dirichlet, data, conditions.up, initial, side, degree)
        problem = _problem(self.domain, dirichlet, data)
        found = METHODS[method](
            problem,
            start[dirichlet.unknown],
            tolerance=tolerance,
            max_iterations=max_iterations,
            progress=progress,
        )
        normals = start
        normals[dirichlet.unknown] = found.X
        return HarmonicMap(
            normals,
            found.history[-1].energy,
            found.residual,
            sphere.degree(normals, self.domain.faces),
            self._status(normals, dirichlet, found.status, found.history[-1].energy),
            len(found.history) - 1,
            found.history,
        )

    def _fixed(self, conditions: Conditions) -> tuple[NDArray[np.integer], Array]:
        fixed, data = conditions.resolve()
        if len(fixed) == 0:
            raise ConditionError(
                "Nothing fixes the normals: every boundary edge is free, and the only minimiser is constant; "
                "prescribe normals along some edges."
                if len(self.domain.boundary_edges)
                else "The mesh is closed: it has no boundary along which normals could be prescribed."
            )
        if fixed[-1] >= self.domain.vertex_count:
            raise ConditionError(f"The conditions fix vertex {fixed[-1]}, which this domain does not have.")
        if len(fixed) == self.domain.vertex_count:
            raise ConditionError(
                f"All {len(fixed)} vertices are fixed and none is left to solve for; subdivide the mesh, "
                "so that it has vertices inside."
            )
        return fixed, data

    def _start(
        self,
        dirichlet: Dirichlet,
        data: Array,
        up: Array,
        initial: ArrayLike | None,
        side: int,
        degree: float | None,
    ) -> Array:
        if side not in (1, -1):
            raise ConditionError(f"The side must be +1 or -1, not {side}.")
        if degree is not None and not np.isfinite(degree):
            raise ConditionError(f"The degree must be a finite number, not {degree}.")
        if initial is None:
            start = harmonic_start(self.domain, dirichlet, data, up, side)
        else:
            start = _as_unit(initial, self.domain.vertex_count)
            start[dirichlet.fixed] = data
        return start if degree is None else wound_start(self.domain, dirichlet, start, degree)

    def _status(self, normals: Array, dirichlet: Dirichlet, status: Status, energy: float) -> Status:
        """What the solver said, unless the map itself says worse."""
        if status is Status.CANCELLED:
            return status
        if energy < 4.0 * np.pi * _COLLAPSED:
            return Status.COLLAPSED
        is_fixed = np.zeros(self.domain.vertex_count, dtype=bool)
        is_fixed[dirichlet.fixed] = True
        i, j = self.domain.edges[~is_fixed[self.domain.edges].all(axis=1)].T
        torn = np.einsum("ij,ij->i", normals[i], normals[j]).min() < 0.0
        return Status.UNDER_RESOLVED if torn else status


def _problem(domain: Domain, dirichlet: Dirichlet, data: Array) -> DirichletProblem:
    return DirichletProblem(
        L=dirichlet.L,
        load=dirichlet.coupling @ data,
        areas=domain.vertex_areas[dirichlet.unknown],
        total_area=domain.area,
        constant=0.5 * sphere.inner(data, dirichlet.fixed_block @ data),
        factor=dirichlet.factor,
    )


def _as_unit(initial: ArrayLike, count: int) -> Array:
    given = as_numbers(initial, "The normals of an initial map", ConditionError)
    if given.shape != (count, 3):
        raise ConditionError(f"The initial map must have shape ({count}, 3), not {given.shape}.")
    length = np.linalg.norm(given, axis=1)
    bad = np.flatnonzero(~(np.isfinite(length) & (length > 1e-9)))
    if bad.size:
        raise ConditionError(f"The initial map is zero or not finite at vertex {bad[0]}.", vertices=bad)
    return given / length[:, None]


def _check_name(what: str, name: str, known: Iterable[str]) -> None:
    names = list(known)
    if name not in names:
        raise ConditionError(f"There is no {what} {name!r}; known are {', '.join(names)}.")
