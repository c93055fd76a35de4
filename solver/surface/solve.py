"""The whole way, from boundary conditions to f± (paper, Algorithm 1)."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..domain.domain import Domain
from ..errors import ConditionError, plural
from ..gauss.conditions import Conditions
from ..gauss.harmonic import HarmonicMap, HarmonicSolver
from ..gauss.minimise import Progress
from .cmc import CmcSurface
from .conjugate import Conjugate, Conjugation
from .offsets import AVERAGINGS, Averaging

Array = NDArray[np.float64]


class CmcSolver:
    """Solves on one domain for many boundary conditions: factors, trees and cuts are kept."""

    def __init__(self, domain: Domain, sites: str = "vertices", energy: str = "cotan") -> None:
        self.domain = domain
        self.harmonic = HarmonicSolver(domain, sites=sites, energy=energy)
        self.conjugation = Conjugation(domain)

    def solve(
        self,
        conditions: Conditions,
        initial: ArrayLike | None = None,
        *,
        averaging: str = "galerkin",
        method: str = "newton",
        tolerance: float = 1e-6,
        max_iterations: int = 200,
        mean_curvature: float = 0.5,
        side: int = +1,
        degree: float | None = None,
        period_tolerance: float = 1e-3,
        progress: Progress | None = None,
    ) -> CmcSurface:
        """See `solve_cmc`."""
        scale = _scale(mean_curvature)
        if averaging not in AVERAGINGS:
            raise ConditionError(f"There is no average {averaging!r}; known are {', '.join(AVERAGINGS)}.")
        self._check_sites(conditions)
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
        conjugate = self.conjugation.conjugate(harmonic.normals, self.harmonic.energy)
        return self._surface(conditions, harmonic, conjugate, averaging, scale, period_tolerance)

    def _check_sites(self, conditions: Conditions) -> None:
        inside = np.setdiff1d(conditions.sites, self.domain.boundary_vertices)
        if inside.size:
            raise ConditionError(
                f"Normals are prescribed inside, at {plural('vertex', inside)}; a CMC surface takes them on the "
                "boundary only, since its conjugate does not close around other prescribed vertices.",
                vertices=inside,
            )

    def _surface(
        self,
        conditions: Conditions,
        harmonic: HarmonicMap,
        conjugate: Conjugate,
        averaging: str,
        scale: float,
        period_tolerance: float,
    ) -> CmcSurface:
        domain, homology = self.domain, self.conjugation.homology
        is_open = not homology.is_trivial and (
            _longest(conjugate.periods) > period_tolerance * _diameter(domain, harmonic.normals, conjugate.g)
        )
        sheets = homology.sheets if is_open else None
        g = AVERAGINGS[averaging].of(
            Averaging(
                domain=domain,
                homology=homology,
                conjugate=conjugate,
                N=harmonic.normals,
                fixed=np.unique(conditions.sites),
                dirichlet=self.harmonic.dirichlet,
                periods=conjugate.periods if is_open else np.zeros_like(conjugate.periods),
            )
        )
        g = g - g[domain.boundary_vertices].mean(axis=0)
        source = np.arange(domain.vertex_count, dtype=np.int32)
        faces = domain.faces
        if sheets is not None:
            source, faces = sheets.source, sheets.faces
            g = g[source] + sheets.offsets @ conjugate.periods
        N = harmonic.normals[source]
        return CmcSurface(
            domain=domain,
            harmonic=harmonic,
            conjugate=conjugate,
            g=scale * g,
            f_plus=scale * (g + N),
            f_minus=scale * (g - N),
            faces=faces,
            source=source,
            scale=scale,
            periods=scale * conjugate.periods,
            is_open=is_open,
        )


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
    averaging: how g comes to the vertices: "galerkin", "linear" or "area" (see `offsets`).
    initial, side, degree: where to start, see `HarmonicSolver.solve`.
    period_tolerance: on a domain with holes, periods below this part of the diameter are projected out; above it
        the surface is cut open, has more rows than the domain has vertices, and says so in its status.
    progress: called as progress(iteration, residual) on every Newton step; returning False cancels.

    Raises `ConditionError` on conditions that contradict each other or fix nothing. Not converging is a status.
    """
    if delaunay:
        raise ConditionError("Intrinsic Delaunay triangulation is not available yet; pass delaunay=False.")
    return CmcSolver(domain, sites=sites, energy=energy).solve(
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
    if not (np.isfinite(mean_curvature) and mean_curvature > 0.0):
        raise ConditionError(f"The mean curvature must be a positive number, not {mean_curvature}.")
    return 0.5 / mean_curvature


def _longest(periods: Array) -> float:
    return float(np.linalg.norm(periods, axis=1).max(initial=0.0))


def _diameter(domain: Domain, N: Array, g: Array) -> float:
    """Diagonal of the larger of the two sheets, roughly: from the conjugate and the normals on the faces."""
    on_faces = N[domain.faces].mean(axis=1)
    return max(float(np.linalg.norm(np.ptp(g + s * on_faces, axis=0))) for s in (1, -1))
