"""The shell over a plan: a surface in world units, with its normals, its faces and its report."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import CmcError, Status
from ..fitting.fit import Fit
from ..measure.report import Report
from ..notes import Note
from ..signatures import checked
from ..spanning.span import Span
from ..surface import convert, notebook
from ..surface.cmc_surface import CmcSurface
from ..surface.placement import Similarity
from ..surface.solve import CmcSolver
from .close import Closing
from .gaps import HoleGap, surface_gaps

if TYPE_CHECKING:
    import trimesh

Array = NDArray[np.float64]
Int = NDArray[np.int32]

# Edge lengths that agree to this part are those of one plan.
_SAME_PLAN = 1e-6


@dataclass(frozen=True, eq=False, repr=False)
class Shell:
    """A shell over its plan, in world units: n vertices, one for each of the plan's, and copies of those along cuts.

    surface: the solver's, at H = ½ (a fit's in world size). similarity: from its points to the placed ones.
    placed: points (n, 3) of "f+", "f-", "g" and "gauss"; a sheet that degenerates to a point is left out, and
        f- and g where H = 0.
    normals: unit vectors (n, 3) on each of them, on the side from which `faces` are counter-clockwise on f+
        and f-.
    source (n,): the plan's vertex behind each vertex; faces (F, 3): in the order of the plan's triangles.
    mean_curvature (n,): measured on the sheet that is shown, positive on a sphere; its target is in the report.
    message: the status in a sentence. warnings: what else the user should know, each with a code (`solver.notes`).
    solver: for the next call of `form`.
    fit: of a fitted shell (`fit_plan`), how near it came. span: of a shell on lines, the surface as it was found.
    closing: of a shell that `Settings.close` closed, what changed for that.
    """

    surface: CmcSurface
    similarity: Similarity
    placed: dict[str, Array]
    normals: dict[str, Array]
    source: Int
    faces: Int
    mean_curvature: Array
    report: Report
    message: str
    warnings: list[Note] = field(default_factory=list)
    solver: CmcSolver | None = None
    fit: Fit | None = None
    span: Span | None = None
    closing: Closing | None = None

    @property
    def ok(self) -> bool:
        """Whether the map is harmonic to the tolerance, the surface has no gap, and a fit meets its goals."""
        return self.surface.status is Status.CONVERGED and (self.fit is None or self.fit.is_met)

    @property
    def closed(self) -> bool:
        """Whether there is no gap around a hole or handle of the plan."""
        return not self.surface.is_open

    @property
    def gaps(self) -> list[HoleGap]:
        """The gap around each hole, or of each period of a plan with handles; of length 0 where the shell closes."""
        return surface_gaps(self.surface, self.similarity, self.points())

    @property
    def adapted_plan(self) -> Array | None:
        """Where the shell has moved its plan, a shell on lines to corners and holes, another to close: positions (V, 2)
        of that plan, to which the shell is conformal; None where it is conformal to the drawn one."""
        if self.closing is not None and self.closing.moved:
            return self.closing.plan.positions[:, :2]
        if self.span is None or self.solver is None:
            return None
        lengths, drawn = self.span.domain.edge_lengths, self.solver.domain.edge_lengths
        return None if np.allclose(lengths, drawn, rtol=_SAME_PLAN) else self.span.positions[:, :2]

    @checked
    def points(self, sheet: str | None = None) -> Array:
        """A placed sheet (n, 3), by default the shown one; raises `CmcError` on a sheet the shell does not have."""
        name = sheet or self.report.sheet
        if name not in self.placed:
            raise CmcError(f'The shell has no sheet "{name}"; it has {", ".join(self.placed)}.')
        return self.placed[name]

    @checked
    def save(self, path: str | os.PathLike[str], sheet: str | None = None) -> None:
        """Write a sheet's triangles as OBJ, PLY, STL or GLB, by the suffix; raises `JobError` where that fails."""
        convert.save_mesh(path, self.points(sheet), self.faces, self.normals[sheet or self.report.sheet])

    @checked
    def to_trimesh(self, sheet: str | None = None) -> trimesh.Trimesh:
        """A sheet as a `trimesh.Trimesh` with its normals."""
        return convert.to_trimesh(self.points(sheet), self.faces, self.normals[sheet or self.report.sheet])

    @checked
    def summary(self, unit: str = "") -> str:
        """The report's summary, and how near a fitted shell came, how a shell was closed, or the checks of a span."""
        lines = [self.report.summary(unit)]
        if self.fit is not None:
            parts = ", ".join(f"{label} {distance:.3g}" for label, distance in self.fit.distances.items())
            lines.append(f"Distances after {len(self.fit.history)} evaluations: {parts}.")
        elif self.span is not None and self.span.ok:
            lines += self.span.checks.lines
        elif self.message not in lines[0] and self.message not in self.warnings:
            lines.append(self.message)
        return "\n".join(lines)

    def __repr__(self) -> str:
        size = f"span {self.report.shown.span:.4g}, rise {self.report.shown.rise:.4g}"
        mesh = f"{len(self.source)} vertices, {len(self.faces)} faces"
        return f"Shell({self.report.sheet}: {mesh}, {size}, H = {self.report.mean_curvature:.4g}, {self._status})"

    def _repr_html_(self) -> str:
        """Numbers, and a picture of the sheet that is shown where matplotlib is installed."""
        shown = self.report.shown
        numbers = {
            "sheet": self.report.sheet,
            "vertices, faces": f"{len(self.source)}, {len(self.faces)}",
            "span, rise": f"{shown.span:.4g}, {shown.rise:.4g}",
            "area": f"{shown.area:.4g}",
            "mean curvature H": f"{self.report.mean_curvature:.4g}",
            "status": self._status,
            **{f"warning {number}": note for number, note in enumerate(self.warnings, start=1)},
        }
        return notebook.table("Shell", numbers, notebook.picture(self.points(), self.faces))

    @property
    def _status(self) -> str:
        goals = "" if self.fit is None else ", goals met" if self.fit.is_met else ", goals not met"
        return self.report.status + goals


def sheet_polygons(
    polygons: Sequence[ArrayLike], triangle_polygons: ArrayLike, triangles: ArrayLike, faces: ArrayLike
) -> tuple[list[Int], Int]:
    """The plan's polygons on the cut vertices of a surface, and the index (P,) of each among the plan's.

    triangles (F, 3): the plan's; faces (F, 3): the cut vertices at their corners. A polygon that the cut of an open
    surface runs through falls into its triangles.
    """
    owner, drawn, cut = (np.asarray(array) for array in (triangle_polygons, triangles, faces))
    if np.array_equal(drawn, cut):
        return [np.asarray(p, dtype=np.int32) for p in polygons], np.arange(len(polygons), dtype=np.int32)
    order = np.argsort(owner, kind="stable")
    parts = np.split(order, np.searchsorted(owner[order], np.arange(1, len(polygons))))
    on_surface: list[Int] = []
    index: list[int] = []
    for number, (polygon, part) in enumerate(zip(polygons, parts, strict=True)):
        copy_of = dict(zip(drawn[part].ravel().tolist(), cut[part].ravel().tolist(), strict=True))
        whole = len(set(cut[part].ravel().tolist())) == len(copy_of)
        pieces = [[copy_of[v] for v in np.asarray(polygon).tolist()]] if whole else cut[part].tolist()
        on_surface += [np.array(piece, dtype=np.int32) for piece in pieces]
        index += [number] * len(pieces)
    return on_surface, np.array(index, dtype=np.int32)
