"""Shells with their rim on lines along some sides and with given normals along others: one fit, measured.

Lines ask where the rim is, the other kinds ask for tangent planes there; both cannot be had next to where they meet, so
given normals fade out over a blend zone there (see `fit_outline`).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..domain.domain import Domain
from ..errors import Progress
from ..fitting.fit import Fit
from ..fitting.outline import fit_outline
from ..gauss.boundary_data import Conditions
from ..surface.placement import Plane, Similarity
from ..surface.solve import CmcSolver
from .measured import measure_shell
from .plan import Group, Plan, Settings
from .plan_conditions import plan_conditions
from .shell import Shell
from .span import owned_edges, wish_of

Array = NDArray[np.float64]

# Evaluations of a fit. Shells that meet what was asked take 20 to 90; more bring hopeless ones no nearer.
_EVALUATIONS = 120
_UP = np.array([0.0, 0.0, 1.0])
_MIRROR = np.diag([1.0, 1.0, -1.0])


def mixed_plan(
    plan: Plan,
    settings: Settings,
    solver: CmcSolver,
    *,
    initial: Fit | None = None,
    progress: Progress | None = None,
    intersections: bool | Callable[[], bool] = True,
) -> Shell:
    """The shell over a plan with lines along some sides and given normals along others, in its place and measured."""
    fit = fitted(plan, settings, solver, initial=initial, progress=progress)
    similarity = fit_similarity(fit, settings)
    return measure_shell(
        plan,
        settings,
        fit.surface,
        fit_plane(fit, solver, similarity),
        similarity,
        solver,
        outline=None,
        fit=fit,
        intersections=intersections,
    )


def fitted(
    plan: Plan,
    settings: Settings,
    solver: CmcSolver,
    *,
    initial: Fit | None = None,
    progress: Progress | None = None,
) -> Fit:
    """The fit for a plan whose conditions are mixed. A flipped shell is found as the mirror image of one that stands.

    initial: of the same plan, to continue from.
    """
    plan = _mirrored(plan) if settings.flip else plan
    conditions = plan_conditions(plan, settings, solver.domain)
    wish: dict[str, Any] = dict([wish_of(plan, replace(settings, flip=False), solver.domain, soap_films=False)])
    return fit_outline(
        solver.domain,
        plan.positions,
        held=conditions,
        free=_free(solver.domain, conditions),
        initial=initial,
        max_evaluations=_EVALUATIONS,
        solver=solver,
        progress=progress,
        **wish,
    )


def fit_similarity(fit: Fit, settings: Settings) -> Similarity:
    """From the points of the fit's surface to those of the shell."""
    linear = _MIRROR if settings.flip else np.eye(3)
    return Similarity(1.0, fit.sign * linear, linear @ fit.shift)


def fit_plane(fit: Fit, solver: CmcSolver, similarity: Similarity) -> Plane:
    """The horizontal plane through the middle of the shell's rim."""
    rim = np.isin(fit.surface.source, solver.domain.boundary_vertices)
    return Plane(similarity.points(fit.surface.sheet("f+"))[rim].mean(axis=0), _UP)


def sides_report(groups: Sequence[Group], fit: Fit) -> list[dict[str, object]]:
    """How far each side is from what was asked of it, for a report; angles in degrees."""
    return [
        {
            "name": _name(groups, side.vertices),
            "kind": side.kind,
            "distance": side.distance,
            "angle": float(np.degrees(side.angle)),
            "zone": len(side.zone),
        }
        for side in fit.sides
    ]


def _name(groups: Sequence[Group], vertices: NDArray[np.integer]) -> str:
    """The group of a side by one of its edges, or ""."""
    middle = len(vertices) // 2
    pair = sorted(vertices[middle - 1 : middle + 1].tolist())
    for group in groups:
        if (np.sort(np.asarray(group.edges).reshape(-1, 2), axis=1) == pair).all(axis=1).any():
            return group.name
    return ""


def _mirrored(plan: Plan) -> Plan:
    """The plan upside down, with its curves; planes and mirrors stay as they are, since the shell is turned back."""
    groups = [
        replace(group, parameters={**group.parameters, "curve": np.asarray(group.parameters["curve"]) @ _MIRROR})
        if group.parameters.get("curve") is not None
        else group
        for group in plan.groups
    ]
    return replace(plan, positions=plan.positions @ _MIRROR, groups=groups)


def _free(domain: Domain, conditions: Conditions) -> NDArray[np.integer]:
    """Boundary edges with no condition at all."""
    held = domain.boundary_edges[np.isin(domain.boundary_edges, conditions.edges)]
    return np.setdiff1d(domain.boundary_edges, np.concatenate([held, owned_edges(conditions)]))
