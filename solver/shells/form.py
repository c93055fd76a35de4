"""From a plan to a shell: domain, conditions, surface, size and place, measures. Job files and Blender go this way."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Annotated

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..domain.shape import Shape
from ..errors import ConditionError, MeshError, Progress, Status
from ..fitting.fit import Fit
from ..gauss.energies import ENERGIES
from ..gauss.methods import METHODS
from ..measure.curvature import vertex_mean_curvature
from ..measure.planes import PlaneReport, measure_plane
from ..measure.report import report
from ..notes import Note
from ..signatures import checked
from ..surface.cmc_surface import SHEETS, CmcSurface
from ..surface.placement import ALIKE, PlacementError, Plane, Similarity, place, plan_frame
from ..surface.solve import CmcSolver
from ..symmetry.sides import side_cut_vertices
from .plan import Group, Plan, Settings, matches, plan_domain
from .plan_conditions import plan_conditions
from .plan_metric import at_sites, start_map
from .plan_sides import group_sides
from .second_shell import off_degree, second_shell
from .shell import Shell
from .shell_notes import shell_notes

Array = NDArray[np.float64]

__all__ = ["Group", "Plan", "Settings", "Shell", "count_modes", "form"]


PlanLike = Annotated[Plan | Shape, "form says which"]


@checked
def form(
    plan: PlanLike,
    settings: Settings | None = None,
    *,
    solver: CmcSolver | None = None,
    initial: ArrayLike | None = None,
    progress: Progress | None = None,
    intersections: bool | Callable[[], bool] = True,
) -> Shell:
    """Solve for the shell over a plan, or over a shape, size and place it, and measure it.

    solver: the `Shell.solver` of an earlier call. It is used again if it belongs to this plan and to the sites, energy
    and triangulation of the settings, which saves factoring. initial (S, 3), one normal per site: a map to start from,
    such as `surface.harmonic.normals` of an earlier shell. progress(iteration, residual) is called every step; False
    cancels. intersections=False leaves out the slowest measure; see `report`. Raises `CmcError` (`MeshError`,
    `ConditionError`, `PlacementError`) on unusable input; not converging is a status: see `Shell.ok` and `message`.
    """
    settings = settings or Settings()
    plan = Plan.from_shape(plan) if isinstance(plan, Shape) else plan
    if not isinstance(plan, Plan):
        raise MeshError(f"form takes a Plan or a Shape, not {type(plan).__name__}; read_plan reads one from a file.")
    solver = solver_for(plan, settings, solver)
    surface = solve_plan(plan, settings, solver, initial=initial, progress=progress)
    shell = place_and_measure(plan, settings, surface, solver, intersections=intersections)
    if settings.counts_modes and surface.harmonic.status is Status.CONVERGED:
        return count_modes(plan, settings, shell)
    return shell


# --- domain --------------------------------------------------------------------------------


def solver_for(plan: Plan, settings: Settings, given: CmcSolver | None) -> CmcSolver:
    """The given solver if it fits plan and settings; else a new one, on the given domain if that is the plan's."""
    known = given if given is not None and matches(given.domain, plan) else None
    sites, energy, delaunay = settings.solver_choice
    if known is not None:
        harmonic = known.harmonic
        if (harmonic.graph.name, harmonic.energy, known.delaunay) == (sites, ENERGIES[energy], delaunay):
            return known
    domain = plan_domain(plan) if known is None else known.domain
    return CmcSolver(domain, sites=sites, energy=energy, delaunay=delaunay)


# --- conditions and surface ----------------------------------------------------------------


def solve_plan(
    plan: Plan,
    settings: Settings,
    solver: CmcSolver,
    *,
    initial: ArrayLike | None = None,
    progress: Progress | None = None,
) -> CmcSurface:
    """The surface for these settings, from `initial` (S, 3) or else from the plan's own start.

    Raises `CmcError` on what cannot be solved; not converging is a status.
    """
    conditions = plan_conditions(plan, settings, solver.domain)
    if initial is None and plan.initial is not None:
        normals = start_map(plan.initial, len(plan.positions))
        initial = at_sites(solver.harmonic.graph, normals)

    def solve(start: ArrayLike | None, degree: float | None) -> CmcSurface:
        return solver.solve(conditions, start, **settings.solve_options(degree=degree, progress=progress))

    first = solve(initial, settings.degree)
    if first.status in (Status.CANCELLED, Status.COLLAPSED):
        return first
    if settings.degree is not None and off_degree(first, settings.degree):
        return second_shell(first, solver, solve, settings.degree) or first
    if settings.shell == "first":
        return first
    second = second_shell(first, solver, solve)
    if second is None:
        raise ConditionError(
            "No large bubble was found over this rim: on this mesh it shrinks to a point. Halve the edge length of the "
            "plan, or choose the first shell."
        )
    return second


# --- size and place ------------------------------------------------------------------------


def place_and_measure(
    plan: Plan,
    settings: Settings,
    surface: CmcSurface,
    solver: CmcSolver,
    *,
    intersections: bool | Callable[[], bool] = True,
) -> Shell:
    """Size, place and measure a surface over its plan: the second half of `form`."""
    check_shown(surface, settings.sheet)
    plane, similarity = place_over(plan, settings, surface)
    return measure_shell(
        plan, settings, surface, plane, similarity, solver, outline=plan.positions, intersections=intersections
    )


def check_shown(surface: CmcSurface, shown: str) -> list[str]:
    """The sheets that are not points; raises `PlacementError` where the one to show is not among them."""
    sheets = [name for name in SHEETS if not surface.is_degenerate(name)]
    if not sheets or surface.status is Status.COLLAPSED:
        if not len(surface.domain.boundary_edges):
            raise PlacementError(
                "All normals became the same, since nothing holds those of a closed plan; choose the method "
                f"{METHODS['critical'].label}, which stays near the initial map."
            )
        raise PlacementError(Status.COLLAPSED.sentence)
    if shown not in sheets:
        raise PlacementError(
            f"{shown} degenerates to a point for these boundary conditions, so there is no shell to place; "
            f"show {sheets[0]}, or change a tilt."
        )
    return sheets


def place_over(plan: Plan, settings: Settings, surface: CmcSurface) -> tuple[Plane, Similarity]:
    """The plane on which a surface stands over its plan, and the similarity from its points to the placed ones."""
    sheet, domain = settings.sheet, surface.domain
    vertices, weights, plane = plan_frame(plan.positions, domain, settings.ground)
    rim = np.flatnonzero(np.isin(surface.source, vertices))
    place_of = np.searchsorted(vertices, surface.source[rim])
    # The copies of a vertex along a cut share its weight.
    shared = weights[place_of] / np.bincount(place_of, minlength=len(vertices))[place_of]
    similarity = place(
        surface.sheet(sheet),
        rim,
        plan.positions[surface.source[rim]],
        shared,
        plane,
        settings.rule(),
        mean_curvature=surface.mean_curvature,
        name=sheet,
        alike=ALIKE if len(domain.boundary_edges) else np.inf,  # a closed surface is matched in size
    )
    return plane, similarity


def placed_sheets(
    surface: CmcSurface, similarity: Similarity, plane: Plane, sheets: Sequence[str]
) -> tuple[dict[str, Array], dict[str, Array]]:
    """Points (n, 3) and normals (n, 3) of the placed sheets, of "g" and of "gauss": a unit sphere where H = 0."""
    placed = {name: similarity.points(surface.sheet(name)) for name in (*sheets, "g")}
    N = similarity.directions(surface.normals)
    radius = surface.scale if np.isfinite(surface.scale) else 1.0
    placed["gauss"] = plane.origin + similarity.scale * radius * N
    return placed, {name: placed_normals(surface.normals, name, similarity) for name in placed}


def placed_normals(N: Array, sheet: str, similarity: Similarity) -> Array:
    """Normals N (n, 3) of the surface on a placed sheet, on the side from which its faces are counter-clockwise."""
    inward = (sheet == "f-") != similarity.mirrored
    return similarity.directions(-N if inward else N)


# --- measure -------------------------------------------------------------------------------


def measure_shell(
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
    """The placed and measured shell. plane: its normal is the vertical. outline: see `report`."""
    sheet = settings.sheet
    sheets = check_shown(surface, sheet)
    placed, normals = placed_sheets(surface, similarity, plane, sheets)
    measured = report(
        surface,
        outline if len(surface.domain.boundary_edges) else None,
        sheet=sheet,
        positions={name: placed[name] for name in sheets},
        intersections=intersections,
        up=plane.normal,
    )
    measured = replace(measured, planes=_planes(plan, surface, similarity, placed[sheet]))
    N = similarity.directions(surface.normals) * (1.0 if sheet == "f+" else -1.0)
    H = vertex_mean_curvature(placed[sheet], surface.faces, N)
    notes = shell_notes(plan, settings, surface, similarity, measured, placed[sheet], N)
    if fit is not None and not fit.is_met:
        notes.insert(0, Note("goal-missed", fit.message))
    return Shell(
        surface=surface,
        similarity=similarity,
        placed=placed,
        normals=normals,
        source=surface.source,
        faces=surface.faces,
        mean_curvature=np.where(np.isfinite(H), H, measured.mean_curvature),  # the target beside degenerate faces
        report=measured,
        message=measured.sentence if fit is None else fit.message,
        warnings=notes,
        solver=solver,
        fit=fit,
    )


def _planes(plan: Plan, surface: CmcSurface, similarity: Similarity, points: Array) -> tuple[PlaneReport, ...]:
    """The planes in which the mirrors and planes of the plan's groups lie on a placed sheet, points (n, 3)."""
    planes = []
    for group in plan.groups:
        if group.kind in ("mirror", "plane"):
            for side in group_sides(group, surface.domain):
                along, weights = side_cut_vertices(surface, np.asarray(side.edges))
                normal = similarity.directions(np.asarray(side.normal))
                planes.append(measure_plane(side.name, group.kind, points, along, weights, normal))
    return tuple(planes)


def count_modes(plan: Plan, settings: Settings, shell: Shell) -> Shell:
    """The shell with the unstable and null modes of its map in the report (see `modes.index_of`).

    Raises `ConditionError` where the map has not converged, since only a critical map has an index, and where a mode
    lies between the unstable and the null ones.
    """
    assert shell.solver is not None
    if shell.surface.harmonic.status is not Status.CONVERGED:
        raise ConditionError(
            "Unstable modes are counted at a converged map; let the solve reach its tolerance first."
        )
    conditions = plan_conditions(plan, settings, shell.solver.domain)
    try:
        index, nullity = shell.solver.index(conditions, shell.surface.harmonic.normals)
    except ArithmeticError as error:
        raise ConditionError(
            "The modes of this map cannot be counted: one lies between the unstable and the null ones; refine the plan."
        ) from error
    return replace(shell, report=replace(shell.report, index=index, nullity=nullity))
