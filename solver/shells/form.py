"""From a plan to a shell: domain, conditions, surface, size and place, measures. Job files and Blender go this way."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Annotated, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..domain.domain import Domain
from ..domain.shape import Shape
from ..errors import ConditionError, MeshError, Progress, Status
from ..fitting.fit import Fit
from ..gauss.boundary_data import Conditions
from ..gauss.energies import ENERGIES
from ..signatures import checked
from ..spanning.span import Span
from ..surface.cmc_surface import CmcSurface
from ..surface.placement import ALIKE, FREE_SIZES, Plane, Similarity, check_size, place, plan_frame
from ..surface.solve import CmcSolver
from .close import Closing, check_closing, closed
from .measured import check_shown, measure_shell
from .mixed import mixed_plan
from .plan import Group, Plan, Settings, matches, plan_domain
from .plan_conditions import plan_conditions
from .plan_metric import at_sites, start_map
from .second_shell import off_degree, second_shell
from .shell import Shell
from .span import check_spanned, is_mixed, span_plan

Array = NDArray[np.float64]

__all__ = ["Group", "Plan", "Settings", "Shell", "count_modes", "form"]


PlanLike = Annotated[Plan | Shape, "form says which"]


@checked
def form(
    plan: PlanLike,
    settings: Settings | None = None,
    *,
    solver: CmcSolver | None = None,
    initial: ArrayLike | Span | Fit | None = None,
    progress: Progress | None = None,
    intersections: bool | Callable[[], bool] = True,
) -> Shell:
    """The shell over a plan, or over a shape, in its size and place, and measured.

    Where its sides are on lines, lean over them or are mirrors, it is spanned (`span_outline`) and stands on the
    drawing; where other sides have given normals, or none, it is fitted to both (`fit_outline`); without lines and
    leans it is solved for its normals, sized and placed by the settings, and with `Settings.close` then closed around
    its holes, as the least change of normals or places of holes allows.

    solver: the `Shell.solver` of an earlier call. It is used again if it belongs to this plan and to the sites, energy
    and triangulation of the settings, which saves factoring. initial (S, 3), one normal per site: a map to start from,
    such as `surface.harmonic.normals` of an earlier shell; or the `Shell.span` or `fit` of one on lines.
    progress(iteration, residual) is called every step; False cancels. intersections=False leaves out the slowest
    measure; see `report`.
    Raises `CmcError` (`MeshError`, `ConditionError`, `PlacementError`) on unusable input; not converging is a status:
    see `Shell.ok` and `message`.
    """
    settings = settings or Settings()
    plan = Plan.from_shape(plan) if isinstance(plan, Shape) else plan
    if not isinstance(plan, Plan):
        raise MeshError(f"form takes a Plan or a Shape, not {type(plan).__name__}; read_plan reads one from a file.")
    solver = solver_for(plan, settings, solver)
    conditions = check_plan(plan, settings, solver.domain)
    if conditions.is_spanned:
        if not (initial is None or isinstance(initial, (Span, Fit))):
            raise ConditionError("A shell on lines continues from the span of an earlier one, not from normals.")
        how: dict[str, Any] = {"progress": progress, "intersections": intersections}
        if is_mixed(conditions, solver.domain):
            return mixed_plan(plan, settings, solver, initial=initial if isinstance(initial, Fit) else None, **how)
        last = initial.span if isinstance(initial, Fit) else initial
        return span_plan(plan, settings, conditions, solver, initial=last, **how)
    if isinstance(initial, (Span, Fit)):
        initial = initial.normals if isinstance(initial, Span) else initial.surface.harmonic.normals
    surface = solve_plan(plan, settings, solver, initial=initial, progress=progress)
    closing = None if settings.close is None else closed(plan, settings, surface, settings.close, progress)
    shell = place_and_measure(plan, settings, surface, solver, closing=closing, intersections=intersections)
    if settings.counts_modes and surface.harmonic.status is Status.CONVERGED:
        return count_modes(plan, settings, shell)
    return shell


def check_plan(plan: Plan, settings: Settings, domain: Domain) -> Conditions:
    """The conditions of a plan; raises `CmcError` where they or the settings do not fit each other."""
    conditions = plan_conditions(plan, settings, domain)
    if conditions.is_spanned:
        check_spanned(plan, settings)
    else:
        check_size(settings.rule(), FREE_SIZES, "free")
        check_closing(plan, settings, domain)
    return conditions


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
    closing: Closing | None = None,
    intersections: bool | Callable[[], bool] = True,
) -> Shell:
    """Size, place and measure a surface over its plan, or the one that closes: the second half of `form`."""
    if closing is not None:
        plan, surface = closing.plan, closing.result.surface
    check_shown(surface, settings.sheet)
    plane, similarity = place_over(plan, settings, surface)
    return measure_shell(
        plan,
        settings,
        surface,
        plane,
        similarity,
        solver,
        outline=plan.positions,
        closing=closing,
        intersections=intersections,
    )


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
    solver, conditions = shell.solver, plan_conditions(plan, settings, shell.solver.domain)
    if shell.closing is not None:
        solver, conditions = CmcSolver(shell.surface.domain), shell.closing.result.conditions
    try:
        index, nullity = solver.index(conditions, shell.surface.harmonic.normals)
    except ArithmeticError as error:
        raise ConditionError(
            "The modes of this map cannot be counted: one lies between the unstable and the null ones; refine the plan."
        ) from error
    return replace(shell, report=replace(shell.report, index=index, nullity=nullity))
