"""The boundary conditions of a plan: those of its groups, blended where they meet, and the default one on the rest."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..domain.domain import Domain
from ..errors import CmcError, ConditionError, listed
from ..gauss import conditions as boundary
from ..gauss.boundary_data import Conditions
from ..gauss.frames import boundary_edges, moving_average
from ..gauss.mirrors import MirrorSides
from ..linalg import as_array
from .plan import Group, Plan, Settings

Array = NDArray[np.float64]


def plan_conditions(plan: Plan, settings: Settings, domain: Domain, up: ArrayLike | None = None) -> Conditions:
    """The groups' conditions, and the default one on boundary edges in no group. up: (3,) as in `binormal`.

    Groups with the same condition act as one group where they meet. Raises `ConditionError` naming the group and its
    edges that are not on the boundary, an edge in two groups, or where every edge is free and the plan has no start.
    """
    parameters = {"tilt": settings.default_tilt} if settings.default_kind == "binormal" else {}
    default = Group("edges in no group", np.empty((0, 2), dtype=int), settings.default_kind, parameters)
    owner = np.full(len(domain.edges), -1)
    for number, group in enumerate(plan.groups):
        chosen = _group_edges(group, domain)
        _check_unowned(plan.groups, number, owner, chosen, domain)
        owner[chosen] = number
    alike: dict[object, tuple[Group, list[int]]] = {}
    for number, group in enumerate([*plan.groups, default]):
        alike.setdefault(_condition_key(group), (group, []))[1].append(number)
    owner[domain.boundary_edges[owner[domain.boundary_edges] < 0]] = len(plan.groups)
    chosen = [(group, np.flatnonzero(np.isin(owner, numbers))) for group, numbers in alike.values()]
    chosen = [(group, edges) for group, edges in chosen if len(edges)]
    how = {"against": settings.against, "up": up}
    total = Conditions()
    if settings.blend > 0.0:
        total = _blended(domain, plan.positions, chosen, settings.blend, how)
        chosen = [(group, edges) for group, edges in chosen if group.kind != "binormal"]
    for group, edges in chosen:
        total = total + _build(group, domain, plan.positions, edges, how)
    if len(plan.flipped_corners):
        total = total + _flipped(domain, total, settings.side, plan.flipped_corners)
    if total.is_empty and plan.initial is None:
        raise ConditionError(
            "All boundary edges are free, so nothing holds the tangent planes; give some edges another condition."
        )
    return total


def _blended(
    domain: Domain,
    positions: Array,
    chosen: Sequence[tuple[Group, NDArray[np.integer]]],
    width: float,
    how: dict[str, Any],
) -> Conditions:
    """One condition for all tilted groups, their tilts a moving average along the boundary."""
    tilts = np.full(len(domain.edges), np.nan)
    for group, edges in chosen:
        if group.kind == "binormal":
            tilts[edges] = group.parameters.get("tilt", 0.0)
    edges = np.flatnonzero(np.isfinite(tilts))
    return boundary.binormal(domain, positions, edges, moving_average(domain, edges, tilts[edges], width), **how)


def _flipped(domain: Domain, total: Conditions, side: int, vertices: Sequence[int]) -> Conditions:
    """The other normal at those vertices that are corners between two mirrors."""
    sides = MirrorSides.of(domain, total, side)
    chosen = np.isin(sides.corners, vertices)
    return boundary.corner(domain, sides.corners[chosen], -sides.corner_normals[chosen])


def _group_edges(group: Group, domain: Domain) -> NDArray[np.integer]:
    """Indices of the group's edges, each once."""
    pairs = np.asarray(group.edges, dtype=np.int64).reshape(-1, 2)
    try:
        return np.unique(boundary_edges(domain, pairs))
    except ConditionError as error:
        raise _in_group(group, error) from error


def _condition_key(group: Group) -> object:
    """Equal for groups with the same condition."""
    what = f'A parameter of group "{group.name}"'
    given: Mapping[str, Any] = group.parameters
    arrays = {name: as_array(value, what, ConditionError) for name, value in given.items() if value is not None}
    return group.kind, tuple(sorted((name, str(array.tolist())) for name, array in arrays.items()))


def _build(
    group: Group, domain: Domain, positions: Array, edges: NDArray[np.integer], how: dict[str, Any]
) -> Conditions:
    parameters: dict[str, Any] = how | dict(group.parameters)
    try:
        return boundary.build(group.kind, domain, positions, edges, **parameters)
    except ConditionError as error:
        raise _in_group(group, error) from error


def _in_group(group: Group, error: CmcError) -> ConditionError:
    return ConditionError(
        f'Group "{group.name}": {error}', vertices=error.vertices, edges=error.edges, faces=error.faces
    )


def _check_unowned(
    groups: Sequence[Group],
    number: int,
    owner: NDArray[np.int64],
    chosen: NDArray[np.integer],
    domain: Domain,
) -> None:
    taken = chosen[owner[chosen] >= 0]
    if len(taken):
        other = groups[int(owner[taken[0]])].name
        pair = domain.edges[taken[0]]
        raise ConditionError(
            f"The edge between vertices {listed(pair)} is in two groups, "
            f'"{other}" and "{groups[number].name}"; take it out of one of them.',
            vertices=np.unique(domain.edges[taken]),
            edges=taken,
        )
