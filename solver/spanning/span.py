"""The result of `span_outline`: a surface of constant mean curvature on its lines, as plain arrays."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..domain.domain import Domain
from ..errors import ConditionError, Status
from ..gauss.boundary_data import Conditions
from ..notes import Note
from ..signatures import checked
from ..surface import convert, notebook
from ..surface.cmc_surface import CmcSurface
from ..surface.polygon_mesh import PolygonMesh
from ..surface.solve import CmcSolver
from .checks import Checks, checks_of
from .descent import Descent, Iterate
from .gauss_map import GaussMap, Mirrors
from .search import Found
from .setting import Lines
from .verdict import SpanStatus, judged, largest_sentence

if TYPE_CHECKING:
    import trimesh

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Asked:
    """What a span was asked to be: the plan as drawn, its lines, sides in planes and at angles, with
    boundary edges; mean_curvature: the wanted one, if that was given. solver: of the plan, if there is one."""

    plan: Domain
    lines: Lines
    mirrors: Mirrors
    leans: Sequence[tuple[ArrayLike, float]]
    mean_curvature: float | None
    solver: CmcSolver | None


@dataclass(frozen=True, eq=False, repr=False)
class Span:
    """A surface that spans its lines.

    points (V, 3). faces (F, 3). mean_curvature: H, with its sign. curve_parameters: the numbers of the rim's vertices.
    history: one line for each step. asked: what it was made for. The domain, normals and other sheets are made when
    they are first asked for.
    """

    points: Array
    faces: NDArray[np.int32]
    mean_curvature: float
    curve_parameters: Array
    status: SpanStatus
    message: str
    history: list[Iterate]
    kept: Found = field(repr=False)
    asked: Asked = field(repr=False)
    gauss: GaussMap = field(repr=False)

    @property
    def ok(self) -> bool:
        """Whether this is the surface that was asked for."""
        return self.status is SpanStatus.CONVERGED

    @cached_property
    def positions(self) -> Array:
        """(V, 2|3) of the plan, with its moduli adapted."""
        return self._descent.problem.motions.at(self._descent.state.q)[: len(self.points)]

    @cached_property
    def domain(self) -> Domain:
        """That of the plan with its moduli adapted: the surface is conformal to it."""
        if self.asked.plan.vertex_count == self.gauss.domain.vertex_count:
            return self.gauss.domain
        i, j = self.asked.plan.edges.T  # the search had vertices of its own
        return self.asked.plan.with_lengths(np.linalg.norm(self.positions[j] - self.positions[i], axis=1))

    @property
    def conditions(self) -> Conditions:
        """The boundary conditions of the normals."""
        return self.gauss.conditions

    @cached_property
    def normals(self) -> Array:
        """(V, 3) unit, on the side from which the faces run counter-clockwise: a harmonic map whose boundary values
        are those of the surface."""
        return self.gauss.normals[: len(self.points)]

    @property
    def has_normals(self) -> bool:
        """Whether the normals have been made."""
        return "normals" in self.__dict__

    @property
    def _descent(self) -> Descent:
        return self.kept.descent

    @property
    def corners(self) -> NDArray[np.integer]:
        """Vertices (k,) of the rim that stay where lines have corners, and where kinds of sides meet."""
        problem = self._descent.problem
        rim = problem.coordinates.rim
        return np.unique(np.concatenate([rim[loop[at]] for loop, at in zip(problem.loops, problem.marks, strict=True)]))

    @property
    def g(self) -> Array | None:
        """The parallel surface of constant Gauss curvature, f - N / 2H; None where H = 0."""
        return None if self.mean_curvature == 0.0 else self.points - 0.5 / self.mean_curvature * self.normals

    @property
    def f_minus(self) -> Array | None:
        """The twin, f - N / H, of mean curvature H with the normals -N; None where H = 0."""
        return None if self.mean_curvature == 0.0 else self.points - 1.0 / self.mean_curvature * self.normals

    @cached_property
    def checks(self) -> Checks:
        """What was measured on it: distortion, H by its area, crossings, angles of leaning sides."""
        return checks_of(
            self._descent,
            self.points,
            self.normals,
            self.domain,
            self.asked.plan,
            [(np.asarray(edges), angle) for edges, angle in self.asked.leans],
            self.asked.lines.base,
            self.asked.mean_curvature is not None,
            self.asked.lines.notes,
        )

    @property
    def warnings(self) -> list[Note]:
        """What is not as it should be, each with its code. Of a span that is not ok that is enough: its `checks` are of
        another surface."""
        if not self.ok:
            return [Note("not-converged", self.message), *self.asked.lines.notes]
        return list(self.checks.notes)

    @checked
    def harmonic(self, solver: CmcSolver | None = None) -> CmcSurface:
        """The paper's surface with the boundary normals of this one, moved to where it is nearest.

        Its rim comes near to the lines; `distance` of the two says how near. Where H < 0 it is reflected in a point, so
        that its scale 1 / (2 H) is negative. Raises `ConditionError` where H = 0.
        """
        if self.mean_curvature == 0.0:
            raise ConditionError("A surface of mean curvature 0 has no harmonic surface beside it; choose H ≠ 0.")
        found = self._solved(solver)
        shift = (self.points - found.f_plus).mean(axis=0)
        return replace(
            found,
            centre=found.centre - shift / found.scale,
            g=found.g + shift,
            f_plus=found.f_plus + shift,
            f_minus=found.f_minus + shift,
        )

    @checked
    def distance(self, solver: CmcSolver | None = None) -> float:
        """The largest distance of a point from that of the paper's surface, see `harmonic`."""
        return float(np.linalg.norm(self.points - self.harmonic(solver).f_plus, axis=1).max())

    def _solved(self, solver: CmcSolver | None = None) -> CmcSurface:
        """The surface of the normals, closed, at the scale 1 / (2 H), or 1 where H = 0."""
        H = self.mean_curvature or 0.5
        solver = solver or self._solver()
        found = solver.solve(self.conditions, initial=self.normals, mean_curvature=abs(H), period_tolerance=np.inf)
        if H > 0.0:
            return found
        return replace(found, g=-found.g, f_plus=-found.f_plus, f_minus=-found.f_minus, scale=-found.scale)

    def _solver(self) -> CmcSolver:
        """That of the plan, moved with it, or a new one."""
        near = self.asked.solver
        if near is None or near.delaunay or near.energy != "cotan" or not near.harmonic.graph.at_vertices:
            return CmcSolver(self.domain)
        if not np.array_equal(near.domain.faces, self.domain.faces):
            return CmcSolver(self.domain)
        return near if near.domain is self.domain else near.moved(self.domain.edge_lengths)

    @checked
    def sheet(self, name: str = "f+") -> Array:
        """Points (V, 3) of this surface, "f+", or of "f-", "g" and "gauss", see `CmcSurface.sheet`."""
        return self.as_surface.sheet(name)

    @cached_property
    def as_surface(self) -> CmcSurface:
        """The same with the fields of a `CmcSurface`: f+ is this surface, with its exact rim.

        `report` and `complete` take a span for it. Where H = 0 its scale is infinite, and f- and g are this surface,
        too. A span that is not ok counts as stalled.
        """
        solved, points, none = self._solved(), self.points, np.zeros((0, 3))
        status = Status.CONVERGED if self.ok else Status.STALLED
        solved = replace(solved, harmonic=replace(solved.harmonic, status=status), is_open=False)
        if self.mean_curvature == 0.0:
            return replace(solved, g=points, f_plus=points, f_minus=points, scale=np.inf, periods=none)
        scale = solved.scale
        g = points - scale * self.normals
        centre = solved.centre - (points - solved.f_plus).mean(axis=0) / scale
        return replace(solved, centre=centre, g=g, f_plus=points, f_minus=g - scale * self.normals, periods=none)

    @checked
    def as_mesh(self, sheet: str = "f+", combinatorics: str = "primal") -> PolygonMesh:
        """A sheet as a mesh of polygons, see `CmcSurface.as_mesh`."""
        return self.as_surface.as_mesh(sheet, combinatorics)

    @checked
    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the triangles as OBJ, PLY, STL or GLB, by the suffix; raises `JobError` where that fails."""
        convert.save_mesh(path, self.points, self.faces, self.normals)

    def to_trimesh(self) -> trimesh.Trimesh:
        """The surface as a `trimesh.Trimesh` with its normals."""
        return convert.to_trimesh(self.points, self.faces, self.normals)

    def __repr__(self) -> str:
        size = f"{len(self.points)} vertices, {len(self.faces)} faces"
        return f"Span({size}, H = {self.mean_curvature:.4g}, {self.status.value} after {len(self.history) - 1} steps)"

    def _repr_html_(self) -> str:
        """Numbers, and a picture where matplotlib is installed."""
        numbers: dict[str, Any] = {
            "mean curvature H": f"{self.mean_curvature:.4g}",
            "vertices, faces": f"{len(self.points)}, {len(self.faces)}",
            "size": " × ".join(f"{extent:.4g}" for extent in np.ptp(self.points, axis=0)),
            "status": f"{self.status.value} after {len(self.history) - 1} steps",
        }
        return notebook.table("Span", numbers, notebook.picture(self.points, self.faces))


def finished(found: Found, asked: Asked, initial: Span | None = None) -> Span:
    """The span at the end of a search. initial: where it started."""
    descent = found.descent
    status, message = judged(descent, asked.lines.is_drawn)
    if found.largest is not None and asked.mean_curvature is not None:
        status, message = SpanStatus.NO_SURFACE, largest_sentence(asked.mean_curvature, found.largest)
    near = (initial.points, initial.normals) if initial is not None and initial.has_normals else None
    return Span(
        points=descent.state.f[: asked.plan.vertex_count] + asked.lines.centre,
        faces=asked.plan.faces,
        mean_curvature=descent.mean_curvature,
        curve_parameters=descent.state.x,
        status=status,
        message=message,
        history=descent.history,
        kept=found,
        asked=asked,
        gauss=GaussMap(descent, asked.mirrors, near),
    )
