"""The whole way, from boundary conditions to f± (paper, Algorithm 1)."""

from __future__ import annotations

from copy import copy
from dataclasses import replace
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..domain.delaunay import carried_cut, intrinsic_delaunay
from ..domain.domain import Domain
from ..domain.sites import SiteGraph
from ..domain.topology import CutSurface
from ..errors import ConditionError, Progress, check_choice
from ..gauss.admissible import resolved
from ..gauss.boundary_data import Conditions
from ..gauss.harmonic import HarmonicMap, HarmonicSolver
from ..gauss.modes import index_of
from .averaging import AVERAGINGS, Averaging
from .cmc_surface import CmcSurface
from .conjugate import Conjugate, Conjugation
from .plane_projection import VertexPlanes

Array = NDArray[np.float64]

# Periods below this part of the diameter are rounding.
_CLOSED = 1e-9


class CmcSolver:
    """Solves on one domain for many boundary conditions: factors, trees and cuts are kept.

    sites, energy, delaunay: see `solve_cmc`.
    """

    def __init__(
        self, domain: Domain, sites: str = "vertices", energy: str = "cotan", delaunay: bool = False
    ) -> None:
        self.domain = domain
        self.delaunay = delaunay
        self._carried = intrinsic_delaunay(domain) if delaunay else None
        solved_on = self._carried.domain if self._carried else domain
        self.harmonic = HarmonicSolver(solved_on, sites=sites, energy=energy)
        self.conjugation = Conjugation(self.harmonic.graph)

    def moved(self, edge_lengths: Array) -> CmcSolver:
        """A solver for the same faces with other edge lengths (E,), as after vertices were moved.

        Much sooner ready than a new one, if they were not moved far. Raises `MeshError` where a triangle inequality
        fails.
        """
        moved = copy(self)
        moved.__dict__.pop("_sheets", None)
        moved.domain = solved_on = self.domain.with_lengths(edge_lengths)
        if self.delaunay:
            moved._carried = intrinsic_delaunay(moved.domain)
            solved_on = moved._carried.domain
        moved.harmonic = self.harmonic.moved(solved_on)
        graph, is_same = moved.harmonic.graph, np.array_equal(solved_on.faces, self.harmonic.domain.faces)
        moved.conjugation = self.conjugation.moved(graph) if is_same else Conjugation(graph)
        return moved

    def solve(
        self,
        conditions: Conditions,
        initial: ArrayLike | None = None,
        *,
        averaging: str = "galerkin",
        method: str = "newton",
        tolerance: float = 1e-6,
        max_iterations: int | None = None,
        mean_curvature: float = 0.5,
        side: int = +1,
        degree: float | None = None,
        period_tolerance: float = 1e-3,
        progress: Progress | None = None,
    ) -> CmcSurface:
        """See `solve_cmc`."""
        scale = _scale(mean_curvature)
        check_choice(averaging, AVERAGINGS, "average")
        _check_period_tolerance(period_tolerance)
        if self._carried:
            conditions = conditions.carried(self._carried.edges)
        self._check_on_rim(conditions)
        harmonic = self.harmonic.solve(
            conditions,
            initial,
            side=side,
            degree=degree,
            method=method,
            tolerance=tolerance,
            max_iterations=max_iterations,
            progress=progress,
        )
        planes = harmonic.admissible.sides.planes
        conjugate = self.conjugation.conjugate(harmonic.normals, self.harmonic.energy, planes)
        return self._surface(harmonic, conjugate, averaging, scale, period_tolerance)

    def index(self, conditions: Conditions, normals: ArrayLike) -> tuple[int, int]:
        """Numbers of unstable and of null modes of a map (S, 3) that was found under these conditions."""
        if self._carried:
            conditions = conditions.carried(self._carried.edges)
        return index_of(self.harmonic, conditions, np.asarray(normals, dtype=np.float64))

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

    def _surface(
        self,
        harmonic: HarmonicMap,
        conjugate: Conjugate,
        averaging: str,
        scale: float,
        period_tolerance: float,
    ) -> CmcSurface:
        graph = self.harmonic.graph
        diameter = _diameter(graph, harmonic.normals, conjugate.g)
        gap = _longest(conjugate.periods)
        is_open = gap > period_tolerance * max(diameter, _CLOSED)  # a point has no periods
        whole = replace(conjugate, periods=np.zeros_like(conjugate.periods) if not is_open else conjugate.periods)
        if not is_open and gap > _CLOSED * diameter:
            whole = self.conjugation.closed(whole)
        g, N = self._at_vertices(harmonic, whole, averaging)
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
            conjugate=replace(whole, periods=conjugate.periods),
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
        """g and N (V, 3); where the surface is cut open, on the first row of each vertex."""
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


def solve_cmc(
    domain: Domain,
    conditions: Conditions,
    *,
    sites: str = "vertices",
    energy: str = "cotan",
    method: str = "newton",
    averaging: str = "galerkin",
    delaunay: bool = False,
    tolerance: float = 1e-6,
    mean_curvature: float = 0.5,
    initial: ArrayLike | None = None,
    side: int = +1,
    degree: float | None = None,
    period_tolerance: float = 1e-3,
    progress: Progress | None = None,
) -> CmcSurface:
    """The constant mean curvature surfaces f± whose normals ±N take the prescribed values on the boundary.

    N is a discrete harmonic map (paper, Prop. 3.1), dg = N × *dN its conjugate (Prop. 3.2), f± = g ± N (Eq. 4).

    tolerance: of the residual `sqrt(A Σ |P_i (LN)_i|² / A_i)`, which does not depend on units.
    mean_curvature: H > 0 of the result, in 1/length; ½ is the scale of the paper.
    sites: "vertices", "faces" or "faces_and_rim": where the normals live (paper, Sec. 3 and 4; see `SiteGraph`).
    energy: a name in `ENERGIES`; "cotan" means the dual cotangent energy on faces, where "mobius" is the robust choice.
    method: a name in `METHODS`. delaunay: solve on the intrinsic Delaunay triangulation of the domain;
        the result is carried back to its vertices and has its faces.
    averaging: how g comes to the vertices, or N from the faces: "galerkin", "linear" or "area" (see `offsets`).
    initial, side, degree: where to start, see `HarmonicSolver.solve`.
    period_tolerance: on a domain with holes, periods below this part of the diameter are projected out; above it
        the surface is cut open, has more rows than the domain has vertices, and says so in its status.
    progress: called as progress(iteration, residual) on every step; returning False cancels.

    Raises `ConditionError` on conditions that contradict each other or fix nothing. Not converging is a status.
    """
    return CmcSolver(domain, sites=sites, energy=energy, delaunay=delaunay).solve(
        conditions,
        initial,
        averaging=averaging,
        method=method,
        tolerance=tolerance,
        mean_curvature=mean_curvature,
        side=side,
        degree=degree,
        period_tolerance=period_tolerance,
        progress=progress,
    )


def _scale(mean_curvature: float) -> float:
    if not (_is_number(mean_curvature) and mean_curvature > 0.0):
        raise ConditionError(f"The mean curvature must be a positive number, not {mean_curvature!r}.")
    return 0.5 / mean_curvature


def _check_period_tolerance(value: float) -> None:
    if not (isinstance(value, (int, float, np.number)) and value >= 0.0):  # infinite: whatever the gap, close it
        raise ConditionError(f"The tolerance of periods must be a part of the diameter, 0 or more, not {value!r}.")


def _is_number(value: object) -> bool:
    return isinstance(value, (int, float, np.number)) and bool(np.isfinite(value))


def _longest(periods: Array) -> float:
    return float(np.linalg.norm(periods, axis=1).max(initial=0.0))


def _diameter(graph: SiteGraph, N: Array, g: Array) -> float:
    """Diagonal of the larger of the two sheets, roughly: from the conjugate and the normals at the corners."""
    sites, cells = graph.incidence
    there, normals = g[cells].T, N[sites].T  # extents of whole rows are found several times faster than of columns
    return max(float(np.linalg.norm([np.ptp(row) for row in there + s * normals])) for s in (1, -1))
