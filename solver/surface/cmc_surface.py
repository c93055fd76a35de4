"""The result of a solve: a CMC surface as plain arrays, and the meshes made of it."""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from ..domain.domain import Domain
from ..domain.sites import SiteGraph
from ..errors import ConditionError, Status, check_choice
from ..gauss.harmonic import HarmonicMap
from ..signatures import checked
from . import convert, notebook
from .averaging import AVERAGINGS
from .conjugate import Conjugate
from .dual_mesh import CornerValues, DualMesh, corner_mesh, dual_mesh
from .polygon_mesh import PolygonMesh

if TYPE_CHECKING:
    import trimesh

Array = NDArray[np.float64]

SHEETS = ("f+", "f-")
# A sheet smaller than this part of the other one is a point or a curve up to discretisation.
_DEGENERATE = 0.02


@dataclass(frozen=True)
class Combinatorics:
    """The polygons of a mesh of the surface, as a user interface offers them (paper, Fig. 5)."""

    label: str
    description: str
    mesh_of: Callable[[CornerValues], DualMesh] | None = None


COMBINATORICS = {
    "primal": Combinatorics("Primal", "The faces of the plan"),
    "dual": Combinatorics(
        "Dual", "A vertex for each triangle of the plan, a polygon for each of its vertices", dual_mesh
    ),
    "corner": Combinatorics(
        "Corners", "A polygon for each triangle, each edge and each vertex of the plan", corner_mesh
    ),
}


@dataclass(frozen=True, eq=False)
class CmcSurface:
    """The two CMC surfaces f± = g ± N of a harmonic map, and g, at the scale of the mean curvature H.

    domain: as given; the surface has its triangles. graph: the sites and links of the normals, whose domain is the
    intrinsic Delaunay triangulation where the solve used it.
    harmonic, conjugate: on that graph, the conjugate at scale 1, without its periods if they were projected out.
    averaging: how g or N came to the vertices. centre: (3,) where the origin of the surface is on the conjugate.
    g, f_plus, f_minus: (n, 3); g is centred at the mean of its boundary. normals: (n, 3) unit N.
    faces: (F, 3) cut vertices. source: (n,) the vertex of the domain that each cut vertex comes from.
    scale: 1 / (2 H). periods: (k, 3) translations around the holes and handles, scaled.
    is_open: whether the surface is cut open along seams across which it jumps by the periods; then n > V. Where it is
    not, cut vertices are the vertices of the domain.
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

    def __repr__(self) -> str:
        gap = f", gap {self.gap:.3g}" if self.is_open else ""
        size = f"{len(self.g)} vertices, {len(self.faces)} faces"
        numbers = f"H = {self.mean_curvature:.4g}, energy {self.harmonic.energy:.6g}"
        return f"CmcSurface({size}, {numbers}, {self.status.value}{gap})"

    def _repr_html_(self) -> str:
        """Numbers, and a picture of f+ where matplotlib is installed."""
        harmonic = self.harmonic
        numbers = {
            "mean curvature H": f"{self.mean_curvature:.4g}",
            "vertices, faces": f"{len(self.g)}, {len(self.faces)}",
            "size of f+": " × ".join(f"{extent:.4g}" for extent in np.ptp(self.f_plus, axis=0)),
            "energy, degree": f"{harmonic.energy:.6g}, {round(harmonic.degree, 6) + 0.0:.4g}",
            "residual": f"{harmonic.residual:.1e} after {harmonic.iterations} steps",
            "status": self.status.value,
        }
        if self.is_open:
            numbers["gap"] = f"{self.gap:.4g}"
        return notebook.table("CmcSurface", numbers, notebook.picture(self.f_plus, self.faces))

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
    def ok(self) -> bool:
        """Whether the map converged and the surface closes around holes and handles."""
        return self.status is Status.CONVERGED

    @property
    def message(self) -> str:
        """The status as a sentence, with the numbers that matter."""
        if not self.is_open:
            return self.outcome
        return f"{self.outcome} {Status.GAP.sentence} The gap is {self.gap:.4g} long ({_periods(self.periods)})."

    @property
    def outcome(self) -> str:
        """The status of the map as a sentence."""
        harmonic = self.harmonic
        if harmonic.status is Status.CONVERGED:
            return harmonic.status.sentence
        return f"{harmonic.status.sentence} (Residual {harmonic.residual:.1e} after {harmonic.iterations} steps.)"

    def sheet(self, name: str) -> Array:
        """Points (n, 3) of "f+", "f-", "g", or "gauss" (the normals as points of a sphere of radius `scale`)."""
        check_choice(name, ("f+", "f-", "g", "gauss"), "sheet")
        if name == "gauss" and not np.isfinite(self.scale):
            raise ConditionError("A surface of mean curvature 0 has no sphere of its size; take its normals.")
        sheets = {"f+": self.f_plus, "f-": self.f_minus, "g": self.g}
        return self.scale * self.normals if name == "gauss" else sheets[name]

    def sheet_normals(self, name: str) -> Array:
        """Unit normals (n, 3) of a sheet, for which H is positive: N, and -N on f-."""
        check_choice(name, ("f+", "f-", "g", "gauss"), "sheet")
        return -self.normals if name == "f-" else self.normals

    @checked
    def save(self, path: str | os.PathLike[str], sheet: str = "f+", combinatorics: str = "primal") -> None:
        """Write a sheet as OBJ, PLY, STL or GLB, by the suffix of `path`; see `as_mesh` and `convert.save_mesh`."""
        mesh = self.as_mesh(sheet, combinatorics)
        convert.save_mesh(path, mesh.vertices, mesh.polygons, -mesh.normals if sheet == "f-" else mesh.normals)

    @checked
    def to_trimesh(self, sheet: str = "f+") -> trimesh.Trimesh:
        """A sheet as a `trimesh.Trimesh` with its normals."""
        return convert.to_trimesh(self.sheet(sheet), self.faces, self.sheet_normals(sheet))

    @checked
    def to_pyvista(self, sheet: str = "f+") -> Any:
        """A sheet as a `pyvista.PolyData` with its normals; raises `CmcError` where pyvista is not installed."""
        return convert.to_pyvista(self.sheet(sheet), self.faces, self.sheet_normals(sheet))

    @checked
    def to_meshio(self, sheet: str = "f+") -> Any:
        """A sheet as a `meshio.Mesh` with its normals; raises `CmcError` where meshio is not installed."""
        return convert.to_meshio(self.sheet(sheet), self.faces, self.sheet_normals(sheet))

    @checked
    def as_mesh(self, sheet: str, combinatorics: str = "primal") -> PolygonMesh:
        """A sheet as a mesh with the triangles of the domain, or one of the other `COMBINATORICS` (paper, Fig. 5).

        Those are polygons of the domain that carries the normals, `graph.domain`. Where the surface is cut open,
        vertices along the seam are repeated so that every polygon is whole.
        """
        check_choice(combinatorics, COMBINATORICS, "combinatorics")
        points = self.sheet(sheet)
        mesh_of = COMBINATORICS[combinatorics].mesh_of
        if mesh_of is None:
            domain = self.graph.domain
            cut_faces = self.faces if domain is self.domain else domain.faces
            return PolygonMesh.of_triangles(points, self.faces, self.source, self.normals, domain, cut_faces)
        mesh = mesh_of(self._corners)
        g, N = self.scale * (mesh.conjugate - self.centre), self.scale * mesh.normals
        return mesh.mesh({"f+": g + N, "f-": g - N, "g": g, "gauss": N}[sheet])

    @cached_property
    def _corners(self) -> CornerValues:
        weights = AVERAGINGS[self.averaging].to_faces(self.graph.domain)
        at_vertices = self.normals[: self.domain.vertex_count]
        return CornerValues.of(self.graph, self.conjugate, self.harmonic.normals, at_vertices, weights, self.is_open)

    def is_degenerate(self, name: str) -> bool:
        """Whether a sheet has shrunk to (almost) a point: f- over a spherical f+, and the other way round."""
        largest = max(_extent(self.f_plus), _extent(self.f_minus))
        return _extent(self.sheet(name)) <= _DEGENERATE * largest


@runtime_checkable
class SurfaceResult(Protocol):
    """A result that has a surface, such as a `Span`."""

    @property
    def as_surface(self) -> CmcSurface: ...


SurfaceLike = CmcSurface | SurfaceResult


def as_surface(given: SurfaceLike) -> CmcSurface:
    """The surface itself, or that of a result which has one."""
    return given if isinstance(given, CmcSurface) else given.as_surface


def _extent(points: Array) -> float:
    return float(np.linalg.norm(np.ptp(points, axis=0)))


def _periods(periods: Array) -> str:
    return "; ".join("({:.3g}, {:.3g}, {:.3g})".format(*p) for p in periods)
