"""Sides of a plan: the groups across which the shell continues, and the planes that the edges of a group suggest.

Each connected part of a group is a side of its own.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from ..domain.domain import Domain
from ..errors import ConditionError, JobError
from ..gauss.frames import boundary_edges, edge_frames
from ..symmetry.sides import Side
from .plan import Group, Plan

Array = NDArray[np.float64]
Int = NDArray[np.integer]

SIDE_KINDS = {"mirror": "mirror", "plane": "tangent", "free": "free"}
"""Kind of a group → kind of its sides on the surface."""

# Second singular value of points along a group, as a part of the first, below which they are on a straight line.
_STRAIGHT = 1e-3
# Points farther from a plane than this part of their extent are not in it.
_FLAT = 0.02


def goes_on(group: Group) -> bool:
    """Whether the shell continues across a group: by its `goes_on`, else across mirrors and planes."""
    return group.goes_on if group.goes_on is not None else group.kind in ("mirror", "plane")


def plan_sides(plan: Plan, domain: Domain, names: Sequence[str] | None = None) -> list[Side]:
    """The sides across which the shell continues: those of the groups `names`, or of all groups that `goes_on` accepts.

    Raises `JobError` on a name of no group, on a group whose kind has no rule of continuation, and without any group.
    """
    check_sides(plan.groups, names)
    sides: list[Side] = []
    for group in plan.groups:
        if goes_on(group) if names is None else group.name in names:
            sides += group_sides(group, domain)
    return sides


def check_sides(groups: Sequence[Group], names: Sequence[str] | None = None) -> None:
    """Raise `JobError` unless the shell can continue across groups `names`, or, without names, across any."""
    kinds = {group.name: group.kind for group in groups}
    for name in names or ():
        if name not in kinds:
            raise JobError(f'There is no group "{name}" to continue across; there are {", ".join(kinds) or "none"}.')
        _check_kind(name, kinds[name])
    if not (any(goes_on(group) for group in groups) if names is None else names):
        raise JobError(
            "There is no side to continue across: give a boundary group the kind Mirror or Constant plane, and solve."
        )


def _check_kind(name: str, kind: str) -> None:
    if kind not in SIDE_KINDS:
        raise JobError(f'The shell cannot continue across "{name}": it must be a mirror, a plane or free.')


def group_sides(group: Group, domain: Domain) -> list[Side]:
    """The sides of a group: its connected parts, called "name 1", "name 2", … where there are several."""
    _check_kind(group.name, group.kind)
    pairs = np.asarray(group.edges, dtype=np.int64).reshape(-1, 2)
    parts = _parts(domain, np.unique(boundary_edges(domain, pairs)))
    normal = None if group.kind == "free" else _unit(group.parameters.get("normal", (0.0, 0.0, 1.0)))
    names = [group.name] if len(parts) == 1 else [f"{group.name} {k}" for k in range(1, len(parts) + 1)]
    return [Side(name, edges, SIDE_KINDS[group.kind], normal) for name, edges in zip(names, parts, strict=True)]


def _unit(normal: object) -> Array:
    vector = np.asarray(normal, dtype=np.float64)
    vector = vector / np.abs(vector).max()  # its square may be too small for a number
    return vector / np.linalg.norm(vector)


def _parts(domain: Domain, edges: Int) -> list[Int]:
    """The connected parts of boundary edges, by their first edge."""
    if not len(edges):
        return []
    tail, head = domain.edges[edges].T
    count = domain.vertex_count
    links = coo_array((np.ones(len(edges)), (tail, head)), shape=(count, count))
    label = connected_components(links, directed=False)[1][tail]
    _, first = np.unique(label, return_index=True)
    return [edges[label == label[k]] for k in np.sort(first)]


def own_plane(domain: Domain, positions: ArrayLike, edges: ArrayLike) -> Array:
    """Normal (3,) of the plane that boundary edges of a drawn plan, positions (V, 3), suggest; out of the shell.

    Where they run straight, the plane through them that stands square on the plan, its normal pointing away from it;
    where they curve, the plane nearest to them, its normal pointing to where the faces do not look. Raises
    `ConditionError` without edges, and where they lie in no plane.
    """
    chosen = boundary_edges(domain, edges)
    if not len(chosen):
        raise ConditionError("There are no edges to take a plane from; put some into the group.")
    points = np.asarray(positions, dtype=np.float64)[np.unique(domain.edges[chosen])]
    _, s, axes = np.linalg.svd(points - points.mean(axis=0), full_matrices=False)
    along = edge_frames(domain, np.asarray(positions, dtype=np.float64), chosen)
    lengths = domain.edge_lengths[chosen]
    if len(s) < 2 or s[1] <= _STRAIGHT * s[0]:
        return _unit(lengths @ along.conormals)
    if len(s) == 3 and s[2] > _FLAT * s[0]:
        raise ConditionError("The edges of the group do not lie in a plane; split the group, or give the normal.")
    normal = axes[2] if len(s) == 3 else np.cross(axes[0], axes[1])
    return -normal if normal @ (lengths @ along.normals) > 0.0 else normal
