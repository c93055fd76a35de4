"""Shells whose rim lies on lines, leans over them or meets mirrors: the spanning surface over a plan, measured."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..domain.domain import Domain
from ..errors import ConditionError, Progress
from ..gauss.boundary_data import Conditions
from ..spanning.outline import span_outline
from ..spanning.span import Span
from ..surface.placement import SPANNED_SIZES, Plane, Similarity, check_size, usual_height
from ..surface.solve import CmcSolver
from .measured import measure_shell
from .plan import Plan, Settings
from .shell import Shell

Array = NDArray[np.float64]

# Heights that differ by less than this part of the line's size are one.
_LEVEL = 1e-6
# Settings of the solve for normals.
_OF_THE_MAP = ("sites", "energy", "method", "delaunay", "averaging", "side", "degree", "shell", "count_modes")


def span_plan(
    plan: Plan,
    settings: Settings,
    conditions: Conditions,
    solver: CmcSolver,
    *,
    initial: Span | None = None,
    progress: Progress | None = None,
    intersections: bool | Callable[[], bool] = True,
) -> Shell:
    """The shell over a plan with these spanned conditions, in its place and measured; raises as `spanned`."""
    span = spanned(plan, settings, conditions, solver, initial=initial, progress=progress)
    drawn = curves_of(solver.domain, conditions) or [None] * len(solver.domain.boundary_loops)
    own = [plan.positions[loop] for loop in solver.domain.boundary_loops]
    return measure_shell(
        plan,
        settings,
        span.as_surface,
        line_plane(span),
        Similarity(),
        solver,
        outline=[loop if line is None else line for loop, line in zip(own, drawn, strict=True)],
        span=span,
        intersections=intersections,
    )


def spanned(
    plan: Plan,
    settings: Settings,
    conditions: Conditions,
    solver: CmcSolver,
    *,
    initial: Span | None = None,
    progress: Progress | None = None,
) -> Span:
    """The spanning surface of a plan's lines, leans and mirrors, with the size of the settings.

    initial: of the same plan, to continue from. Raises `ConditionError` where sides are of kinds that cannot be
    spanned, and on settings of the solve for normals.
    """
    domain = solver.domain
    check_spanned(plan, settings)
    wish: dict[str, Any] = dict([wish_of(plan, settings, domain)])
    return span_outline(
        domain,
        plan.positions,
        curves_of(domain, conditions),
        leans=_leans(conditions, settings.flip),
        mirrors=_mirrors(conditions),
        holes=settings.holes,
        corners=settings.corners,
        initial=initial,
        solver=solver,
        tolerance=settings.tolerance,
        progress=progress,
        **wish,
    )


def check_spanned(plan: Plan, settings: Settings) -> None:
    """Raise as `spanned`, before anything is searched for."""
    _check_settings(settings)
    check_size(settings.rule(), SPANNED_SIZES, "on its lines")
    if plan.initial is not None:
        raise ConditionError("A shell on lines does not start from normals; take the start out.")


def line_plane(span: Span) -> Plane:
    """The horizontal plane through the middle of the rim."""
    return Plane(span.points[span.domain.boundary_vertices].mean(axis=0), np.array([0.0, 0.0, 1.0]))


def span_report(span: Span) -> dict[str, object]:
    """The search for a span and its checks, as a table of a report; angles in degrees. Of one that is not ok the search
    alone."""
    table: dict[str, object] = {"status": span.status.value, "message": span.message, "steps": len(span.history) - 1}
    if not span.ok:
        return table
    checks = span.checks
    return table | {
        "mean_curvature": checks.mean_curvature,
        "multiplier": checks.multiplier,
        "distortion": checks.distortion,
        "drawn_distortion": checks.drawn_distortion,
        "branch": checks.branch.value,
        "leans": [
            {"asked": float(np.degrees(lean.asked)), "measured": float(np.degrees(lean.measured))}
            | {"off": float(np.degrees(lean.off)), "lowest": lean.lowest, "highest": lean.highest}
            for lean in checks.leans
        ],
    }


def wish_of(plan: Plan, settings: Settings, domain: Domain, soap_films: bool = True) -> tuple[str, float]:
    """The one number that chooses the surface; a flipped shell hangs. soap_films: whether H may be 0."""
    rule = settings.rule()
    name, number = rule.size, rule.value
    if name == "match_plan":
        name, number = usual_wish(plan.positions, plan.positions[domain.boundary_vertices], soap_films)
    return name, -number if rule.flip else number


def usual_wish(positions: Array, rim: Array, soap_films: bool = True) -> tuple[str, float]:
    """Without a size: soap films on lines with heights, H = 0, else a usual height over the mean of the rim (b, 3)."""
    is_level = np.ptp(rim[:, 2]) <= _LEVEL * np.linalg.norm(np.ptp(rim, axis=0))
    if soap_films and not is_level:
        return "mean_curvature", 0.0
    return "height", usual_height(positions, rim) + float(rim[:, 2].max() - rim[:, 2].mean())


def _leans(conditions: Conditions, hangs: bool) -> list[tuple[NDArray[np.integer], float]]:
    """Edges of each lean, and its angle; a flipped shell is the mirror image, whose normals point up all the same."""
    angles = np.pi - conditions.lean_angles if hangs else conditions.lean_angles
    return [(conditions.leans[angles == angle], float(angle)) for angle in np.unique(angles)]


def owned_edges(conditions: Conditions) -> NDArray[np.integer]:
    """Boundary edges on lines, leaning over them, and in mirrors."""
    return np.concatenate([conditions.lines, conditions.leans, conditions.mirrors])


def curves_of(domain: Domain, conditions: Conditions) -> list[Array | None] | None:
    """The curve of each boundary loop, None for one that spans its own points; None where all do."""
    if not conditions.curves:
        return None
    lines: list[Array | None] = [None] * len(domain.boundary_loops)
    for edges, curve in conditions.curves:
        mine = [k for k, loop in enumerate(domain.boundary_loop_edges) if np.isin(loop, edges).all()]
        if len(mine) > 1:
            raise ConditionError(
                f"One curve cannot take the place of {len(mine)} boundary loops; give each loop a curve of its own."
            )
        for k in mine:
            lines[k] = curve
    return lines


def _mirrors(conditions: Conditions) -> list[tuple[NDArray[np.integer], Array]]:
    """Edges and normal of each mirror."""
    if np.any(conditions.windings):
        raise ConditionError("A shell on lines has no extra turns along a mirror; take the winding out.")
    normals, of_edge = np.unique(conditions.mirror_normals, axis=0, return_inverse=True)
    return [(conditions.mirrors[of_edge.ravel() == k], normal) for k, normal in enumerate(normals)]


def is_mixed(conditions: Conditions, domain: Domain) -> bool:
    """Whether some sides are neither on lines, nor lean over them, nor meet mirrors: a span cannot meet them."""
    return not np.isin(domain.boundary_edges, owned_edges(conditions)).all()


def _check_settings(settings: Settings) -> None:
    """Raise `ConditionError` on settings that say how normals are solved for, or which sheet is placed."""
    usual = Settings()
    for name in _OF_THE_MAP:
        if getattr(settings, name) != getattr(usual, name):
            raise ConditionError(
                f'A shell on lines is found without solving for normals first; leave out "{name.replace("_", " ")}".'
            )
    if settings.sheet != "f+":
        raise ConditionError("Of a shell on lines f+ lies on them, f- is its twin; show f+.")
