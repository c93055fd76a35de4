"""A surface sized, placed over its plan and measured: what every way to a shell ends with."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..domain.delaunay import speed_note
from ..errors import Status
from ..fitting.fit import Fit
from ..gauss.energies import ENERGIES
from ..gauss.methods import METHODS
from ..measure.curvature import mean_curvature_of
from ..measure.report import Report, report
from ..surface.cmc_surface import SHEETS, CmcSurface
from ..surface.placement import ALIKE, PlacementError, Plane, Similarity, place, plan_frame
from ..surface.solve import CmcSolver
from .plan import Plan, Settings, matches, plan_domain, plan_warnings
from .plan_sides import measured_planes
from .solve import off_degree

Array = NDArray[np.float64]
Int = NDArray[np.int32]

# Share of the shell's area that may overhang, and degrees by which it may, before it is worth a warning: next to a
# vertical rim the faces of an ordinary mesh lean by a degree or two.
_OVERHANG = 0.01
_LEAN = 5.0


@dataclass(frozen=True, eq=False)
class Shell:
    """A shell over its plan, in world units.

    surface: what the solver gave, at H = ½. similarity: from its points to the placed ones.
    placed: points (n, 3) of "f+", "f-", "g" and "gauss"; a sheet that degenerates to a point is not in it.
    normals: unit vectors (n, 3) on each of them, on the side from which `faces` are counter-clockwise on f+
        and f-.
    source (n,): the plan's vertex of each row; faces (F, 3): rows, in the order of the plan's triangles.
        There is one row a vertex, unless the surface is cut open.
    mean_curvature (n,): of the sheet that is shown, measured, positive on a sphere; its target is in the
        report.
    message: the status in a sentence. warnings: what the user should know besides. solver: to hand in again.
    fit: where the shell was fitted to something (`fitting.fit_plan`), how near it came.
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
    warnings: list[str] = field(default_factory=list)
    solver: CmcSolver | None = None
    fit: Fit | None = None

    @property
    def converged(self) -> bool:
        """Whether the shell is what was asked for: harmonic to the tolerance, without a gap, every wish met."""
        return self.surface.status is Status.CONVERGED and (self.fit is None or self.fit.met)

    def summary(self, unit: str = "") -> str:
        """The report's summary, and how near the shell is to what it was fitted to."""
        lines = [self.report.summary(unit)]
        if self.fit is not None:
            parts = ", ".join(f"{label} {distance:.3g}" for label, distance in self.fit.distances.items())
            lines.append(f"Distances after {len(self.fit.history)} evaluations: {parts}.")
        return "\n".join(lines)


def form_surface(
    plan: Plan,
    settings: Settings,
    surface: CmcSurface,
    solver: CmcSolver,
    *,
    intersections: bool | Callable[[], bool] = True,
) -> Shell:
    """Size, place and measure a surface over its plan, as `form` does with what it has solved for."""
    check_shown(surface, settings.sheet)
    plane, similarity = place_over(plan, settings, surface)
    return finish(
        plan, settings, surface, plane, similarity, solver, outline=plan.positions, intersections=intersections
    )


def finish(
    plan: Plan,
    settings: Settings,
    surface: CmcSurface,
    plane: Plane,
    similarity: Similarity,
    solver: CmcSolver,
    *,
    outline: Array | list[Array],
    fit: Fit | None = None,
    intersections: bool | Callable[[], bool] = True,
) -> Shell:
    """Place a surface and measure it. `plane` has the vertical; `outline`: see `report`."""
    sheets = check_shown(surface, settings.sheet)
    placed, normals = placed_sheets(surface, similarity, plane, sheets)
    measured = report(
        surface,
        outline if len(surface.domain.boundary_edges) else None,
        sheet=settings.sheet,
        positions={name: placed[name] for name in sheets},
        intersections=intersections,
        up=plane.normal,
    )
    planes = measured_planes(plan, surface, similarity, placed[settings.sheet])
    measured = replace(measured, planes=planes)
    notes = plan_warnings(plan, solver.domain) + _warnings(plan, surface, settings, similarity, measured)
    if fit is not None and not fit.met:
        notes.insert(0, fit.message)
    return Shell(
        surface=surface,
        similarity=similarity,
        placed=placed,
        normals=normals,
        source=surface.source,
        faces=surface.faces,
        mean_curvature=row_curvature(surface, similarity, placed, settings.sheet),
        report=measured,
        message=measured.sentence if fit is None else fit.message,
        warnings=notes,
        solver=solver,
        fit=fit,
    )


def solver_for(plan: Plan, settings: Settings, given: CmcSolver | None) -> CmcSolver:
    """The given solver if it is the one for this; else a new one, on the given one's domain if that is the plan's."""
    known = given if given is not None and matches(given.domain, plan) else None
    sites, energy, delaunay = settings.solver_choice
    if known is not None:
        harmonic = known.harmonic
        if (harmonic.graph.name, harmonic.energy, known.delaunay) == (sites, ENERGIES[energy], delaunay):
            return known
    domain = plan_domain(plan) if known is None else known.domain
    return CmcSolver(domain, sites=sites, energy=energy, delaunay=delaunay)


def check_shown(surface: CmcSurface, shown: str) -> list[str]:
    """The sheets that are no points; raises `PlacementError` where the one to show is not among them."""
    sheets = [name for name in SHEETS if not surface.is_degenerate(name)]
    if not sheets or surface.status is Status.COLLAPSED:
        if not len(surface.domain.boundary_edges):
            raise PlacementError(
                "The normals came to be all the same, as nothing holds those of a closed plan; choose the method "
                f"{METHODS['critical'].label}, which stays near the map that is given to start from."
            )
        raise PlacementError(Status.COLLAPSED.sentence)
    if shown not in sheets:
        raise PlacementError(
            f"{shown} degenerates to a point for these boundary conditions, so there is no shell to place; "
            f"show {sheets[0]}, or change a tilt."
        )
    return sheets


def place_over(plan: Plan, settings: Settings, surface: CmcSurface) -> tuple[Plane, Similarity]:
    """Size and place a surface over its plan: the plane that it stands on, and from its points to the placed ones."""
    sheet, domain = settings.sheet, surface.domain
    vertices, weights, plane = plan_frame(plan.positions, domain, settings.ground)
    rows = np.flatnonzero(np.isin(surface.source, vertices))
    place_of = np.searchsorted(vertices, surface.source[rows])
    # A vertex where the surface is cut has several rows, which share its weight.
    shared = weights[place_of] / np.bincount(place_of, minlength=len(vertices))[place_of]
    similarity = place(
        surface.sheet(sheet),
        rows,
        plan.positions[surface.source[rows]],
        shared,
        plane,
        settings.rule(),
        mean_curvature=surface.mean_curvature,
        name=sheet,
        alike=ALIKE if len(domain.boundary_edges) else np.inf,  # what is closed is matched in size
    )
    return plane, similarity


def placed_sheets(
    surface: CmcSurface, similarity: Similarity, plane: Plane, sheets: Sequence[str]
) -> tuple[dict[str, Array], dict[str, Array]]:
    """Points (n, 3) and normals (n, 3) of the placed sheets, of "g" and of "gauss"."""
    placed = {name: similarity.points(surface.sheet(name)) for name in (*sheets, "g")}
    N = similarity.directions(surface.normals)
    placed["gauss"] = plane.origin + 0.5 * similarity.scale / surface.mean_curvature * N
    return placed, {name: placed_normals(surface.normals, name, similarity) for name in placed}


def placed_normals(N: Array, sheet: str, similarity: Similarity) -> Array:
    """Normals N (n, 3) of the surface on a placed sheet, on the side from which its faces are counter-clockwise."""
    inward = (sheet == "f-") != similarity.mirrored
    return similarity.directions(-N if inward else N)


def row_curvature(surface: CmcSurface, similarity: Similarity, placed: dict[str, Array], sheet: str) -> Array:
    """(n,) area-weighted mean of the measured H of the faces around each row of "f+" or "f-"; the
    target where there is none."""
    points, faces = placed[sheet], surface.faces
    N = similarity.directions(surface.normals)
    H = mean_curvature_of(points, faces, N if sheet == "f+" else -N)
    a, b, c = (points[faces[:, k]] for k in range(3))
    areas = np.where(np.isfinite(H), np.linalg.norm(np.cross(b - a, c - a), axis=1), 0.0)
    weights = np.repeat(areas, 3)
    total = np.bincount(faces.ravel(), weights, len(points))
    sums = np.bincount(faces.ravel(), np.repeat(areas * np.nan_to_num(H), 3), len(points))
    target = surface.mean_curvature / similarity.scale
    return np.divide(sums, total, out=np.full(len(points), target), where=total > 0)


def _warnings(
    plan: Plan, surface: CmcSurface, settings: Settings, similarity: Similarity, measured: Report
) -> list[str]:
    notes = []
    if surface.status is not Status.CONVERGED:
        notes.append(measured.sentence)
    has_rim = bool(len(surface.domain.boundary_edges))
    if settings.size == "match_plan" and similarity.likeness < ALIKE and has_rim:
        notes.append(
            f"The boundary of {settings.sheet} does not follow the drawn outline, so its size alone is "
            "matched; allow it to rotate, or size it by span, rise or radius."
        )
    if settings.degree is not None and off_degree(surface, settings.degree):
        notes.append(
            f"The normals have degree {surface.harmonic.degree:.3g}, not {settings.degree:g} as asked for: a map of "
            "that degree was not found on this mesh; refine it, or ask for another."
        )
    slow = speed_note(surface.domain) if settings.delaunay else None
    if slow is not None:
        notes.append(slow)
    shown = measured.shown
    twin = "f-" if measured.sheet == "f+" else "f+"
    if twin not in measured.sheets:
        notes.append(f"{twin} degenerates to a point for these boundary conditions and is left out.")
    if shown.intersections is not None and shown.intersections.count:
        owner = plan.triangle_polygons
        pair = [int(i if owner is None else owner[i]) for i in shown.intersections.pairs[0]]
        notes.append(
            f"{shown.name} goes through itself: {shown.intersections.count} pairs of faces cross, the "
            f"first of them {pair[0]} and {pair[1]}."
        )
    leaning = None if surface.domain.genus else shown.overhang  # half of every tube overhangs
    if leaning is not None and leaning.area_share > _OVERHANG and leaning.largest_lean > _LEAN:
        notes.append(
            f"{100 * leaning.area_share:.0f} % of {shown.name} overhangs: its faces lean out past the vertical, by up "
            f"to {leaning.largest_lean:.0f}°."
        )
    return notes


def sheet_polygons(
    polygons: Sequence[ArrayLike], triangle_polygons: ArrayLike, triangles: ArrayLike, faces: ArrayLike
) -> tuple[list[Int], Int]:
    """The plan's polygons in the rows of a surface, and the polygon each of them is of.

    triangles (F, 3) are the plan's and faces (F, 3) the rows of their corners. A polygon that the cut of an
    open surface runs through falls into its triangles.
    """
    owner, drawn, rows = (np.asarray(array) for array in (triangle_polygons, triangles, faces))
    if np.array_equal(drawn, rows):
        return [np.asarray(p, dtype=np.int32) for p in polygons], np.arange(len(polygons), dtype=np.int32)
    order = np.argsort(owner, kind="stable")
    parts = np.split(order, np.searchsorted(owner[order], np.arange(1, len(polygons))))
    found: list[Int] = []
    index: list[int] = []
    for number, (polygon, part) in enumerate(zip(polygons, parts, strict=True)):
        row_of = dict(zip(drawn[part].ravel().tolist(), rows[part].ravel().tolist(), strict=True))
        whole = len(set(rows[part].ravel().tolist())) == len(row_of)
        pieces = [[row_of[v] for v in np.asarray(polygon).tolist()]] if whole else rows[part].tolist()
        found += [np.array(piece, dtype=np.int32) for piece in pieces]
        index += [number] * len(pieces)
    return found, np.array(index, dtype=np.int32)
