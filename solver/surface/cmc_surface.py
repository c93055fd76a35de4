"""The result: a CMC surface as plain arrays."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ..domain.domain import Domain
from ..domain.sites import SiteGraph
from ..errors import Status, check_choice
from ..gauss.harmonic import HarmonicMap
from .averaging import AVERAGINGS
from .conjugate import Conjugate
from .dual_mesh import Complex, Corners, corner_complex, dual_complex
from .polygon_mesh import PolygonMesh

Array = NDArray[np.float64]

SHEETS = ("f+", "f-")
# A sheet smaller than this part of the other one is a point or a curve up to discretisation.
_DEGENERATE = 0.02


@dataclass(frozen=True)
class Combinatorics:
    """The polygons of a mesh of the surface, as a user interface offers them (paper, Fig. 5)."""

    label: str
    description: str
    complex: Callable[[Corners], Complex] | None = None


COMBINATORICS = {
    "primal": Combinatorics("Primal", "The faces of the plan"),
    "dual": Combinatorics(
        "Dual", "A vertex for each triangle of the plan, a polygon for each of its vertices", dual_complex
    ),
    "corner": Combinatorics(
        "Corners", "A polygon for each triangle, each edge and each vertex of the plan", corner_complex
    ),
}


@dataclass(frozen=True, eq=False)
class CmcSurface:
    """The two CMC surfaces f± = g ± N of a harmonic map, and g, in scaled units (H as asked for).

    domain: the one asked about, whose triangles the surface has. graph: the sites and links of the normals; its
    domain is another triangulation of the same, where a Delaunay one was asked for.
    harmonic, conjugate: on that graph, the conjugate at scale 1, without its periods if they were projected out.
    averaging: how g or N came to the vertices. centre: (3,) where the origin of the surface is on the conjugate.
    g, f_plus, f_minus: (n, 3); g is centred at the mean of its boundary. normals: (n, 3) unit N.
    faces: (F, 3) rows. source: (n,) the vertex of the domain each row comes from.
    scale: 1 / (2 H). periods: (k, 3) translations around the holes and handles, scaled.
    is_open: whether the surface is cut open along seams across which it jumps by the periods; then n > V.
    """

    domain: Domain
    graph: SiteGraph
    harmonic: HarmonicMap
    conjugate: Conjugate
    averaging: str
    centre: Array
    g: Array
    f_plus: Array
    f_minus: Array
    normals: Array
    faces: NDArray[np.int32]
    source: NDArray[np.int32]
    scale: float
    periods: Array
    is_open: bool

    @property
    def mean_curvature(self) -> float:
        """H of f+ with the normal N, and of f- with the normal -N."""
        return 0.5 / self.scale

    @property
    def gap(self) -> float:
        """Length of the longest period; zero on a simply connected domain."""
        return float(np.linalg.norm(self.periods, axis=1).max(initial=0.0))

    @property
    def status(self) -> Status:
        """How the solve ended; GAP where the map converged but the surface does not close."""
        harmonic = self.harmonic.status
        return Status.GAP if self.is_open and harmonic is Status.CONVERGED else harmonic

    @property
    def message(self) -> str:
        """The status as a sentence, with the numbers that matter."""
        parts = [self.harmonic.status.sentence]
        if self.harmonic.status is not Status.CONVERGED:
            parts[0] += f" (Residual {self.harmonic.residual:.1e} after {self.harmonic.iterations} steps.)"
        if self.is_open:
            parts.append(f"{Status.GAP.sentence} The gap is {self.gap:.4g} long ({_periods(self.periods)}).")
        return " ".join(parts)

    def sheet(self, name: str) -> Array:
        """Points (n, 3) of "f+", "f-", "g", or "gauss" (the normals as points of a sphere of radius `scale`)."""
        sheets = {"f+": self.f_plus, "f-": self.f_minus, "g": self.g, "gauss": self.scale * self.normals}
        check_choice(name, sheets, "sheet")
        return sheets[name]

    def as_mesh(self, sheet: str, combinatorics: str = "primal") -> PolygonMesh:
        """A sheet as a mesh with the triangles of the domain, or one of the other `COMBINATORICS` (paper, Fig. 5).

        Those are of the domain on which the normals were solved for, `graph.domain`. Where the surface is cut open,
        vertices along the seam are repeated so that every polygon is whole.
        """
        check_choice(combinatorics, COMBINATORICS, "combinatorics")
        points = self.sheet(sheet)
        complex_of = COMBINATORICS[combinatorics].complex
        if complex_of is None:
            domain = self.graph.domain
            rows = self.faces if domain is self.domain else domain.faces
            return PolygonMesh.of_triangles(points, self.faces, self.source, self.normals, domain, rows)
        mesh = complex_of(self._corners)
        g, N = self.scale * (mesh.conjugate - self.centre), self.scale * mesh.normals
        return mesh.mesh({"f+": g + N, "f-": g - N, "g": g, "gauss": N}[sheet])

    @cached_property
    def _corners(self) -> Corners:
        weights = AVERAGINGS[self.averaging].to_faces(self.graph.domain)
        at_vertices = self.normals[: self.domain.vertex_count]
        return Corners.of(self.graph, self.conjugate, self.harmonic.normals, at_vertices, weights, self.is_open)

    def is_degenerate(self, name: str) -> bool:
        """Whether a sheet has shrunk to (almost) a point: f- over a spherical f+, and the other way round."""
        largest = max(_extent(self.f_plus), _extent(self.f_minus))
        return _extent(self.sheet(name)) <= _DEGENERATE * largest


def _extent(points: Array) -> float:
    return float(np.linalg.norm(np.ptp(points, axis=0)))


def _periods(periods: Array) -> str:
    return "; ".join("({:.3g}, {:.3g}, {:.3g})".format(*p) for p in periods)
