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
from ..gauss.conditions import fixed_at, mirror
from ..gauss.harmonic import HarmonicSolver
from ..gauss.sphere import normalize
from ..notes import Note
from ..signatures import checked
from ..surface import convert, notebook
from ..surface.cmc_surface import CmcSurface
from ..surface.polygon_mesh import PolygonMesh
from ..surface.solve import CmcSolver
from .checks import Checks, checks_of
from .descent import Iterate
from .normals import changed_normals, rim_normals, start_normals
from .problem import SpanProblem, State
from .search import Found
from .setting import Lines
from .verdict import SpanStatus, judged, largest_sentence

if TYPE_CHECKING:
    import trimesh

Array = NDArray[np.float64]
Mirrors = Sequence[tuple[ArrayLike, ArrayLike]]


@dataclass(frozen=True, eq=False)
class Asked:
    """What a span was asked to be: the plan as drawn, its lines, sides in planes and at angles, with boundary edges;
    mean_curvature: the wanted one, if that was given."""

    plan: Domain
    lines: Lines
    mirrors: Mirrors
    leans: Sequence[tuple[ArrayLike, float]]
    mean_curvature: float | None


@dataclass(frozen=True, eq=False, repr=False)
class Span:
    """A surface that spans its lines.

    points: (V, 3). faces: (F, 3). mean_curvature: H, with its sign. curve_parameters: the numbers of the rim's
    vertices. history: one line for each step. asked: what it was made for. near: the points and normals of an earlier
    span, which its normals are near to. What the search does not need (its plan, normals, checks) is worked out where
    it is asked for.
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
    near: tuple[Array, Array] | None = field(default=None, repr=False)

    @property
    def ok(self) -> bool:
        """Whether this is the surface that was asked for."""
        return self.status is SpanStatus.CONVERGED

    @property
    def corners(self) -> NDArray[np.integer]:
        """Vertices (k,) of the rim that stay where lines have corners, and where kinds of sides meet."""
        problem = self.kept.descent.problem
        rim = problem.coordinates.rim
        return np.unique(np.concatenate([rim[loop[at]] for loop, at in zip(problem.loops, problem.marks, strict=True)]))

    @cached_property
    def domain(self) -> Domain:
        """The plan's, with its moduli adapted: the surface is conformal to it."""
        plan, searched = self.asked.plan, self._searched
        if plan.vertex_count == searched.vertex_count:
            return searched
        i, j = plan.edges.T  # the search had vertices of its own
        return plan.with_lengths(np.linalg.norm(self.positions[j] - self.positions[i], axis=1))

    @cached_property
    def positions(self) -> Array:
        """(V, 2) of that plan."""
        descent = self.kept.descent
        return descent.problem.motions.at(descent.state.q)[: len(self.points)]

    @property
    def conditions(self) -> Conditions:
        """The normals along lines and leans, and the mirrors."""
        return self._boundary[0]

    @cached_property
    def normals(self) -> Array:
        """(V, 3) unit, on the side from which the faces run counter-clockwise: a harmonic map whose boundary values are
        those of the surface."""
        conditions, start = self._boundary
        if self.near is not None and len(self.near[0]) == len(start):
            start = changed_normals(start, self._searched, *self.near)
        return self._solver.solve(conditions, initial=start).normals[: len(self.points)]

    @cached_property
    def _searched(self) -> Domain:
        """The domain of the search, as it was at its end."""
        problem, q = self.kept.descent.problem, self.kept.descent.state.q
        return problem.motions.moved(q) if q.any() else problem.domain

    @cached_property
    def _solver(self) -> HarmonicSolver:
        """On that domain, with the factors of the search."""
        problem = self.kept.descent.problem
        return problem.solver if self._searched is problem.domain else problem.solver.moved(self._searched)

    @cached_property
    def _boundary(self) -> tuple[Conditions, Array]:
        descent = self.kept.descent
        return _conditions(self._searched, descent.problem, descent.state, self.mean_curvature, self.asked.mirrors)

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
            self.kept.descent,
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
        if solver is None:
            solver = CmcSolver.with_factors(self._solver) if self.domain is self._searched else CmcSolver(self.domain)
        found = solver.solve(
            self.conditions, initial=self.normals, mean_curvature=abs(H), period_tolerance=np.inf
        )
        if H > 0.0:
            return found
        return replace(found, g=-found.g, f_plus=-found.f_plus, f_minus=-found.f_minus, scale=-found.scale)

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


def finished(found: Found, plan: Domain, asked: Asked, initial: Span | None = None) -> Span:
    """The span at the end of a search over the faces of `plan`, which may be laid anew. initial: where it started."""
    descent = found.descent
    status, message = judged(descent, asked.lines.is_drawn)
    if found.largest is not None and asked.mean_curvature is not None:
        status, message = SpanStatus.NO_SURFACE, largest_sentence(asked.mean_curvature, found.largest)
    return Span(
        points=descent.state.f[: plan.vertex_count] + asked.lines.centre,
        faces=plan.faces,
        mean_curvature=descent.mean_curvature,
        curve_parameters=descent.state.x,
        status=status,
        message=message,
        history=descent.history,
        kept=found,
        asked=asked,
        near=(initial.points, initial.normals) if initial is not None and "normals" in vars(initial) else None,
    )


def _conditions(
    domain: Domain, problem: SpanProblem, state: State, H: float, mirrors: Mirrors
) -> tuple[Conditions, Array]:
    """The normals along lines and leans, and the mirrors; and a start (V, 3) for the harmonic map."""
    rim = problem.coordinates.rim
    N = np.zeros((len(rim), 3))
    tangents = problem.rim.tangents(state.x)
    given = problem.rim.on_line | problem.rim.leaning
    for loop, marks in zip(problem.loops, problem.marks, strict=True):
        N[loop] = rim_normals(domain, state.f, H, rim[loop], tangents[loop], marks, given[loop])
    conditions = Conditions(up=np.array([0.0, 0.0, 1.0]))
    for edges, normal in mirrors:
        across = mirror(domain, edges, normal)
        n, ends = across.mirror_normals[0], given & np.isin(rim, domain.edges[across.mirrors])
        N[ends] = normalize(N[ends] - np.outer(N[ends] @ n, n))
        conditions = conditions + across
    if given.any():
        conditions = conditions + fixed_at(domain, rim[given], N[given])
    return conditions, start_normals(domain, state.f, rim[given], N[given])
