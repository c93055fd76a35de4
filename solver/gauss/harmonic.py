"""Harmonic maps into the sphere with given boundary normals: the solver and its result."""

from __future__ import annotations

from collections import OrderedDict
from copy import copy
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import scipy.sparse as sp
from numpy.typing import ArrayLike, NDArray

from ..domain.domain import Domain
from ..domain.shape import DomainLike, as_domain
from ..domain.sites import SiteGraph
from ..errors import ConditionError, Status, check_choice
from ..linalg import Factor, ReusedFactor, as_numbers
from ..signatures import checked
from . import sphere
from .admissible import Admissible, resolved
from .balance import imbalance
from .boundary_data import Conditions, check_conditions
from .dirichlet import Dirichlet
from .energies import ENERGIES, energy_on
from .initial_map import harmonic_start, leaning, wound_start
from .methods import BALANCED, METHODS, Method
from .mirror_start import side_normals
from .newton import Iterate, Minimum
from .options import MapOptions, with_options
from .problem import EnergyProblem, equal_laplacian
from .rivals import Lowest, escaped, lower, lowest_start

Array = NDArray[np.float64]

# Factors kept for as many different sets of fixed sites.
_KEPT_FACTORS = 4
# Iterations per solve above which a factor of other edge lengths is given up.
_FAR = 12
# Energy, as a part of 4π, below which a map counts as constant.
_COLLAPSED = 1e-12
# A map whose degree is off by more than this is of another class: bubbles change it by one.
_OTHER_CLASS = 0.5
# Sites of each kind in a message.
_AT = {"vertices": "vertices", "faces": "faces", "faces_and_rim": "faces and edges of the rim"}


@dataclass(frozen=True, eq=False)
class HarmonicMap:
    """A (nearly) critical point of a discrete Dirichlet energy.

    normals: (S, 3) unit vectors, at the vertices or at the faces. energy: Σ ε; ½ <LN, N> for the cotangent one.
    residual: `sqrt(A Σ |P_i (LN)_i|² / A_i)` at these normals, with the weights star in L.
    degree: signed area covered, as a part of the sphere. iterations: steps of the method.
    history: energy, residual, back-solves and step length, one line for each map reached.
    imbalance: |Σ N_i μ_i| as a part of the energy on a closed domain, where it vanishes at a critical map (paper,
        Theorem E.2); None on a domain with a boundary.
    admissible: the maps the conditions admit; its `corner_normals` are those chosen where two mirrors meet.
    """

    normals: Array
    energy: float
    residual: float
    degree: float
    status: Status
    iterations: int
    history: list[Iterate]
    admissible: Admissible
    imbalance: float | None = None

    @property
    def ok(self) -> bool:
        """Whether the map is harmonic to the tolerance."""
        return self.status is Status.CONVERGED

    @property
    def message(self) -> str:
        """How the solve ended, in a sentence."""
        return self.status.sentence

    def __repr__(self) -> str:
        steps = f"{self.iterations} step{'' if self.iterations == 1 else 's'}"
        return (
            f"HarmonicMap({len(self.normals)} normals, energy {self.energy:.6g}, degree {self.degree:.3g}, "
            f"{self.status.value} after {steps}, residual {self.residual:.1e})"
        )


class HarmonicSolver:
    """Solves on one domain for many boundary conditions; factors are kept, keyed by the set of fixed sites.

    sites: a name in `SITES`. energy: a name in `ENERGIES` that is defined there. A used solver can be pickled and
    copied: the copy factors again.
    """

    @checked
    def __init__(self, domain: DomainLike, sites: str = "vertices", energy: str = "cotan") -> None:
        self.domain = as_domain(domain)
        self.graph = SiteGraph.of(self.domain, sites)
        self.energy = energy_on(energy, sites)
        self._factors: OrderedDict[bytes, Dirichlet] = OrderedDict()
        self._near: dict[bytes, Factor] = {}

    def __repr__(self) -> str:
        energy = next(name for name, one in ENERGIES.items() if one is self.energy)
        return f"HarmonicSolver({self.domain!r}, sites {self.graph.name}, energy {energy})"

    def moved(self, domain: DomainLike) -> HarmonicSolver:
        """The same solver on another domain.

        Where that has the same faces and nearly the same edge lengths, and normals live at vertices, the factors are
        reused as preconditioners.
        """
        domain = as_domain(domain)
        moved = copy(self)
        for name in ("_weights", "_laplacian"):
            moved.__dict__.pop(name, None)
        moved.domain, moved.graph = domain, SiteGraph.of(domain, self.graph.name)
        moved._factors, moved._near = OrderedDict(), {}
        if self.graph.at_vertices and np.array_equal(domain.faces, self.domain.faces):
            moved._near = {key: one.rough for key, one in self._factors.items() if not _is_far(one.factor)}
        return moved

    @cached_property
    def _weights(self) -> Array:
        """Weights (K,) of the Laplacian for starts and preconditioning: star at equal normals.

        At vertices this is the Laplacian of piecewise linear functions, positive whatever the signs of its weights.
        The dual one is not, so its weights are made positive.
        """
        star = self.energy.star(np.ones(len(self.graph.links)), self.graph)
        return star if self.graph.at_vertices else np.abs(star)

    @cached_property
    def _laplacian(self) -> sp.csr_array | None:
        """The Laplacian of a quadratic energy, the same at every map; None for other energies."""
        return equal_laplacian(self.graph, self.energy) if self.energy.quadratic else None

    def dirichlet(self, fixed: NDArray[np.integer]) -> Dirichlet:
        """The factored Laplacian with values given at the `fixed` sites."""
        key = np.asarray(fixed, dtype=np.int64).tobytes()
        if key not in self._factors:
            laplacian = self._laplacian if self.graph.at_vertices else None
            self._factors[key] = Dirichlet(self.graph, self._weights, fixed, laplacian, self._near.pop(key, None))
            if len(self._factors) > _KEPT_FACTORS:
                self._factors.popitem(last=False)
        self._factors.move_to_end(key)
        return self._factors[key]

    @with_options(MapOptions)
    def solve(self, conditions: Conditions, options: MapOptions) -> HarmonicMap:
        """A harmonic map with the prescribed normals, from `initial` (S, 3) or from a start made here.

        side: ±1, the choice between the two sides of coplanar data, between minimisers of nearly equal energy, and at
        corners between mirrors (see `conditions.mirror`). degree: selects a homotopy class. method: a name in
        `METHODS`, or a `Method`; max_iterations: the limit of its steps, by default its own. Balanced conditions have
        their own method (`balance.balanced`). Along the boundary, free sites get the natural condition ∂N/∂ν = 0.
        Of several minimisers the result is the lowest that a coarse copy of the domain shows (`rivals`). With
        `initial`, `degree` or mirrors it is the one reached; judge it by energy, degree and status. Not converging is
        a status, not an error. Raises `ConditionError` when all sites are fixed, or none is (not even by two mirrors
        that meet) and there is no initial map.
        """
        return self.solve_with(conditions, options)

    def solve_with(self, conditions: Conditions, options: MapOptions) -> HarmonicMap:
        """The same with the options as one object."""
        check_conditions(conditions)
        method = _method(options.method, conditions.is_balanced)
        admissible = self._admissible(conditions, options.side)
        lowest = self._lowest_start(admissible, conditions, options) if method.minimises else None
        admissible, start = self._chosen_start(admissible, conditions, options, lowest)
        dirichlet = self.dirichlet(admissible.fixed)
        problem = EnergyProblem(self.graph, self.energy, dirichlet, self._laplacian, admissible.mirrors)
        limits: dict[str, Any] = {"tolerance": options.tolerance, "progress": options.progress}
        steps = {} if options.max_iterations is None else {"max_iterations": options.max_iterations}
        minimum = method.of(problem, start, **limits, **steps)
        if lowest is not None and not lowest.is_sure and minimum.status is not Status.CANCELLED:
            usual = self._usual_start(admissible, conditions, options.side)
            if usual is not None:
                minimum = lower(minimum, method.of(problem, usual, **limits, **steps))
        if lowest is not None and minimum.status in (Status.CONVERGED, Status.STALLED):
            minimum = escaped(problem, minimum, conditions.up, options.side, **limits)
        return self._map(problem, minimum, admissible, options.degree)

    def _admissible(self, conditions: Conditions, side: int) -> Admissible:
        """The maps that the conditions admit; raises where there is but one."""
        admissible = resolved(conditions, self.graph, side)
        if len(admissible.fixed) == self.graph.count:
            raise ConditionError(
                f"All normals are fixed, at {self.graph.count} {_AT[self.graph.name]}, so none is unknown; "
                f"subdivide the mesh, so that it has {_AT[self.graph.name]} inside."
            )
        return admissible

    def _chosen_start(
        self, admissible: Admissible, conditions: Conditions, options: MapOptions, lowest: Lowest | None
    ) -> tuple[Admissible, Array]:
        """The admissible maps, whose corner normals face an initial map, and the map (S, 3) to start from."""
        if lowest is not None:
            held, start = admissible.fixed, admissible.pin(lowest.start)
        elif options.initial is None:
            held, start = self._start(admissible, conditions, options.side)
        else:
            given = _as_unit(options.initial, self.graph)
            admissible = admissible.facing(given)
            held, start = np.union1d(admissible.fixed, admissible.mirrors.sites), admissible.pin(given)
        if options.degree is not None:
            start = admissible.pin(wound_start(self.dirichlet(held), start, options.degree))
        return admissible, start

    def _map(
        self, problem: EnergyProblem, minimum: Minimum, admissible: Admissible, wanted: float | None
    ) -> HarmonicMap:
        """What a minimiser reached, as a result; wanted: the degree asked for."""
        normals = admissible.pin(minimum.N)  # steps of length zero leave rounding
        degree = sphere.degree(normals, self.graph.triangles)
        status = self._status(normals, problem.dirichlet, minimum)
        if wanted is not None and status is Status.CONVERGED and abs(degree - wanted) > _OTHER_CLASS:
            status = Status.OTHER_DEGREE
        return HarmonicMap(
            normals,
            minimum.history[-1].energy,
            minimum.residual,
            degree,
            status,
            len(minimum.history) - 1,
            minimum.history,
            admissible,
            None if len(self.domain.boundary_edges) else float(np.linalg.norm(imbalance(problem, normals))),
        )

    def _lowest_start(self, admissible: Admissible, conditions: Conditions, options: MapOptions) -> Lowest | None:
        """A start near the lowest of several minimisers; None where there is but one, or the options choose."""
        if options.initial is not None or options.degree is not None or conditions.is_balanced:
            return None
        if len(conditions.mirrors) or conditions.faces.size:  # the coarse mesh has no place for these
            return None
        if not len(admissible.fixed) or sphere.fits_in_hemisphere(admissible.data):
            return None
        return lowest_start(self.graph, conditions, options.side, self._vertex_problem)

    def _vertex_problem(self, domain: Domain, conditions: Conditions) -> EnergyProblem:
        """The cotangent energy at the vertices of another domain."""
        solver = HarmonicSolver(domain)
        fixed, _ = conditions.resolve()
        return EnergyProblem(solver.graph, solver.energy, solver.dirichlet(fixed), solver._laplacian)

    def _start(self, admissible: Admissible, conditions: Conditions, side: int) -> tuple[NDArray[np.integer], Array]:
        """A blend of the fixed normals and those along mirrors: the sites of these, and a map (S, 3)."""
        up = conditions.up
        leans = leaning(admissible.data, up, side) is not None
        if len(conditions.mirrors):
            sites, normals = side_normals(admissible, conditions, self.graph, side, leans)
        else:
            sites, normals = np.zeros(0, dtype=np.int64), np.zeros((0, 3))
        held = np.concatenate([admissible.fixed, sites])
        if not len(held):
            raise ConditionError(self._nothing(admissible))
        order = np.argsort(held)
        data = np.concatenate([admissible.data, normals])[order]
        start = harmonic_start(self.dirichlet(held[order]), data, up, side)
        return held[order], admissible.pin(start)

    def _usual_start(self, admissible: Admissible, conditions: Conditions, side: int) -> Array | None:
        """The start of `_start`; None where the boundary normals cancel inside."""
        try:
            return self._start(admissible, conditions, side)[1]
        except ConditionError:
            return None

    def _nothing(self, admissible: Admissible) -> str:
        """Why no start exists, as a message."""
        if len(admissible.mirrors.sites):
            return (
                "The mirrors fix no normal, since no two in different planes meet, so a start is missing; "
                "prescribe normals along some edges, or give an initial map or a winding."
            )
        if not len(self.domain.boundary_edges):
            return (
                "The mesh is closed: it has no boundary along which normals could be prescribed; give an initial map."
            )
        return (
            "Nothing fixes the normals: every boundary edge is free, and the only minimiser is constant; "
            "prescribe normals along some edges, or give an initial map."
        )

    def _status(self, normals: Array, dirichlet: Dirichlet, minimum: Minimum) -> Status:
        """The status of the minimiser, unless the map collapsed or is under-resolved."""
        status = minimum.status
        if status is Status.CANCELLED:
            return status
        is_fixed = np.zeros(self.graph.count, dtype=bool)
        is_fixed[dirichlet.fixed] = True
        i, j = self.graph.links.T
        c = np.einsum("ij,ij->i", normals[i], normals[j])
        if float(np.abs(self._weights * (1.0 - c)).sum()) < 4.0 * np.pi * _COLLAPSED:
            return Status.COLLAPSED
        # More than 90° apart, where a link does not join two prescribed normals; those may be so, but not opposite.
        torn = c[~(is_fixed[i] & is_fixed[j])].min(initial=1.0) < 0.0 or np.isinf(minimum.history[-1].energy)
        return Status.UNDER_RESOLVED if torn else status


def _is_far(factor: Factor) -> bool:
    """Whether a reused factor is a poor preconditioner here, or has not been tried."""
    return isinstance(factor, ReusedFactor) and (factor.iterations is None or factor.iterations > _FAR)


def _method(method: str | Method, is_balanced: bool) -> Method:
    if isinstance(method, Method):
        return method
    check_choice(method, METHODS, "method")
    if not is_balanced:
        return METHODS[method]
    if method != "newton":
        raise ConditionError(f"Balanced maps have a method of their own; leave out method={method!r}.")
    return BALANCED


def _as_unit(initial: ArrayLike, graph: SiteGraph) -> Array:
    given = as_numbers(initial, "The normals of an initial map", ConditionError)
    if given.shape != (graph.count, 3):
        raise ConditionError(
            f"The initial map must have shape ({graph.count}, 3), a normal for each of the {_AT[graph.name]}, not "
            f"{given.shape}."
        )
    length = np.linalg.norm(given, axis=1)
    bad = np.flatnonzero(~(np.isfinite(length) & (length > 1e-9)))
    if bad.size:
        where, offenders = graph.named(bad)
        raise ConditionError(f"The initial map is zero or not finite at {where}.", **offenders)
    return given / length[:, None]
