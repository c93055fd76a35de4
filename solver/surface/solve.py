"""From boundary conditions to the surfaces f± (paper, Algorithm 1)."""

from __future__ import annotations

from dataclasses import replace
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..domain.delaunay import carried_cut, intrinsic_delaunay
from ..domain.shape import DomainLike, as_domain
from ..domain.sites import SiteGraph
from ..domain.topology import CutSurface
from ..errors import ConditionError
from ..gauss.admissible import resolved
from ..gauss.boundary_data import Conditions, check_conditions
from ..gauss.harmonic import HarmonicMap, HarmonicSolver
from ..gauss.modes import index_of
from ..gauss.options import with_options
from ..signatures import checked
from .averaging import AVERAGINGS, Averaging
from .cmc_surface import CmcSurface
from .conjugate import Conjugate, Conjugation
from .options import CmcOptions, SolveOptions
from .plane_projection import VertexPlanes

Array = NDArray[np.float64]

# Periods below this part of the diameter are rounding.
_CLOSED = 1e-9


class CmcSolver:
    """Solves on one domain for many boundary conditions; factors, trees and cuts are kept.

    sites, energy, delaunay: see `solve_cmc`. A copy or a pickle has the domain and these three, and factors anew.
    """

    @checked
    def __init__(
        self, domain: DomainLike, sites: str = "vertices", energy: str = "cotan", delaunay: bool = False
    ) -> None:
        self.domain = as_domain(domain)
        self.energy = energy
        self.delaunay = delaunay
        self._carried = intrinsic_delaunay(self.domain) if delaunay else None
        solved_on = self._carried.domain if self._carried else self.domain
        self.harmonic = HarmonicSolver(solved_on, sites=sites, energy=energy)
        self.conjugation = Conjugation(self.harmonic.graph)

    def __repr__(self) -> str:
        return f"CmcSolver({self.domain!r}, sites {self.harmonic.graph.name}, energy {self.energy})"

    def __reduce__(self) -> tuple[type[CmcSolver], tuple[object, ...]]:
        return type(self), (self.domain, self.harmonic.graph.name, self.energy, self.delaunay)

    def moved(self, edge_lengths: Array) -> CmcSolver:
        """A solver for the same faces with other edge lengths (E,), as after vertices were moved.

        Much sooner ready than a new one if they were not moved far. Raises `MeshError` where a triangle inequality
        fails.
        """
        moved = object.__new__(type(self))
        moved.__dict__.update({name: value for name, value in self.__dict__.items() if name != "_sheets"})
        moved.domain = solved_on = self.domain.with_lengths(edge_lengths)
        if self.delaunay:
            moved._carried = intrinsic_delaunay(moved.domain)
            solved_on = moved._carried.domain
        moved.harmonic = self.harmonic.moved(solved_on)
        graph, is_same = moved.harmonic.graph, np.array_equal(solved_on.faces, self.harmonic.domain.faces)
        moved.conjugation = self.conjugation.moved(graph) if is_same else Conjugation(graph)
        return moved

    @with_options(SolveOptions)
    def solve(self, conditions: Conditions, options: SolveOptions) -> CmcSurface:
        """The surfaces f± under these conditions; see `solve_cmc`. max_iterations: see `HarmonicSolver.solve`."""
        return self._solve(conditions, options)

    def _solve(self, conditions: Conditions, options: SolveOptions) -> CmcSurface:
        check_conditions(conditions)
        if self._carried:
            conditions = conditions.carried(self._carried.edges)
        self._check_on_rim(conditions)
        harmonic = self.harmonic.solve_with(conditions, options)
        planes = harmonic.admissible.sides.planes
        conjugate = self.conjugation.conjugate(harmonic.normals, self.harmonic.energy, planes)
        return self._surface(harmonic, conjugate, options)

    @checked
    def index(self, conditions: Conditions, normals: ArrayLike) -> tuple[int, int]:
        """Numbers of unstable and of null modes of a map (S, 3) that is critical under these conditions."""
        if self._carried:
            conditions = conditions.carried(self._carried.edges)
        return index_of(self.harmonic, conditions, normals)

    def _check_on_rim(self, conditions: Conditions) -> None:
        """Fixed sites must lie on the boundary: elsewhere the conjugate would not close around them."""
        graph = self.harmonic.graph
        inside = np.setdiff1d(resolved(conditions, graph).fixed, graph.rim)
        if inside.size:
            where, offenders = graph.named(inside)
            raise ConditionError(
                f"Normals are prescribed inside, at {where}; a CMC surface takes them on the boundary only, since its "
                "conjugate does not close around others.",
                **offenders,
            )

    def _surface(self, harmonic: HarmonicMap, conjugate: Conjugate, options: SolveOptions) -> CmcSurface:
        graph = self.harmonic.graph
        averaging, scale = options.averaging, options.scale
        diameter = _diameter(graph, harmonic.normals, conjugate.g)
        gap = _longest(conjugate.periods)
        is_open = gap > options.period_tolerance * max(diameter, _CLOSED)  # a point has no periods
        kept = conjugate if is_open else replace(conjugate, periods=np.zeros_like(conjugate.periods))
        if not is_open and gap > _CLOSED * diameter:
            kept = self.conjugation.closed(kept)
        g, N = self._at_vertices(harmonic, kept, averaging)
        centre = g[graph.domain.boundary_vertices].mean(axis=0) if len(graph.rim) else g.mean(axis=0)
        g = g - centre
        source = np.arange(self.domain.vertex_count, dtype=np.int32)
        faces = self.domain.faces
        if is_open:
            sheets = self._sheets
            source, faces = sheets.source, sheets.faces
            g = g[source] + sheets.offsets @ conjugate.periods
        N = N[source]
        return CmcSurface(
            domain=self.domain,
            graph=graph,
            harmonic=harmonic,
            conjugate=replace(kept, periods=conjugate.periods),
            averaging=averaging,
            centre=centre,
            g=scale * g,
            f_plus=scale * (g + N),
            f_minus=scale * (g - N),
            normals=N,
            faces=faces,
            source=source,
            scale=scale,
            periods=scale * conjugate.periods,
            is_open=is_open,
        )

    @cached_property
    def _sheets(self) -> CutSurface:
        """The domain cut open, in its own triangles."""
        homology = self.conjugation.homology
        return carried_cut(self.domain, self._carried, homology) if self._carried else homology.sheets

    def _at_vertices(self, harmonic: HarmonicMap, conjugate: Conjugate, averaging: str) -> tuple[Array, Array]:
        """g and N (V, 3); where the surface is cut open, at the first cut vertex of each vertex."""
        graph, average = self.harmonic.graph, AVERAGINGS[averaging]
        N, admissible = harmonic.normals, harmonic.admissible
        if graph.at_vertices:
            given = Averaging(
                graph.domain, self.conjugation.homology, conjugate, N, admissible, self.harmonic.dirichlet
            )
            return average.conjugate(given), N
        N = average.normals(graph, N)
        mirrored = VertexPlanes.of(graph.domain, admissible.sides.planes)
        N[mirrored.vertices] = mirrored.along(N[mirrored.vertices])
        return conjugate.g[: graph.domain.vertex_count], N


@with_options(CmcOptions)
def solve_cmc(domain: DomainLike, conditions: Conditions, options: CmcOptions) -> CmcSurface:
    """The constant mean curvature surfaces f± whose normals ±N take the prescribed values on the boundary.

    N is a discrete harmonic map (paper, Prop. 3.1), dg = N × *dN its conjugate (Prop. 3.2), f± = g ± N (Eq. 4).

    domain: a Domain, or a Shape. tolerance: of the residual `sqrt(A Σ |P_i (LN)_i|² / A_i)`, which has no unit.
    mean_curvature: H > 0 of the result, in 1/length; ½ is the scale of the paper.
    sites: "vertices", "faces" or "faces_and_rim": where the normals live (paper, Sec. 3 and 4; see `SiteGraph`).
    energy: a name in `ENERGIES`; "cotan" means the dual cotangent energy on faces, where "mobius" is the robust choice.
    method: a name in `METHODS`. max_iterations: of its steps, by default as many as suit it.
    delaunay: solve on the intrinsic Delaunay triangulation of the domain; the result has the domain's own vertices
        and faces.
    averaging: how g comes to the vertices, or N from the faces: "galerkin", "linear" or "area" (see `averaging`).
    initial, side, degree: where to start, see `HarmonicSolver.solve`.
    period_tolerance: on a domain with holes, periods below this part of the diameter are projected out; above it
        the surface is cut open: it has more vertices than the domain, and its status is GAP.
    progress: called as progress(iteration, residual) on every step; returning False cancels.

    Raises `ConditionError` on conditions that contradict each other or fix nothing. Not converging is a status.
    """
    solver = CmcSolver(domain, sites=options.sites, energy=options.energy, delaunay=options.delaunay)
    return solver._solve(conditions, options)


def _longest(periods: Array) -> float:
    return float(np.linalg.norm(periods, axis=1).max(initial=0.0))


def _diameter(graph: SiteGraph, N: Array, g: Array) -> float:
    """Diagonal of the larger of the two sheets, roughly: from the conjugate and the normals at the corners."""
    sites, cells = graph.incidence
    there, normals = g[cells].T, N[sites].T  # np.ptp is several times faster over whole rows
    return max(float(np.linalg.norm([np.ptp(row) for row in there + s * normals])) for s in (1, -1))
