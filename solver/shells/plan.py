"""The plan as it comes from a user, a mesh with groups of boundary edges, and what the solver makes of it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from ..domain.domain import Domain
from ..domain.sites import SITES
from ..errors import CmcError, ConditionError, JobError, MeshError, listed
from ..gauss import conditions as boundary
from ..gauss.boundary_data import Conditions
from ..gauss.conditions import KINDS
from ..gauss.energies import ENERGIES, energy_on
from ..gauss.frames import boundary_edges, moving_average
from ..gauss.methods import METHODS
from ..gauss.mirrors import MirrorSides
from ..surface.cmc_surface import COMBINATORICS, SHEETS
from ..surface.placement import Rule
from .plan_metric import metric_domain, start_map

Array = NDArray[np.float64]
Int = NDArray[np.int32]


SHELLS = {
    "first": "First Found",
    "bubble": "Large Bubble",
}
"""Which of the shells over one rim: the one that a solve comes to, or the other one of Theorem D.1 of the paper."""

COUNTED = ("saddle", "critical")
"""Methods after which unstable modes are counted."""


@dataclass(eq=False)
class Group:
    """Boundary edges (K, 2), vertex pairs, and their condition: kind and parameters (radians) of `KINDS`.

    goes_on: whether the shell is continued across them by `completing`; None leaves that to the kind.
    """

    name: str
    edges: NDArray[np.integer]
    kind: str = "binormal"
    parameters: Mapping[str, object] = field(default_factory=dict)
    goes_on: bool | None = None


@dataclass(eq=False)
class Plan:
    """A drawn plan: positions (V, 3) in world units, triangles (T, 3), and groups of its boundary edges.

    polygons: the faces as they were drawn, with triangle_polygons (T,) the polygon each triangle is a part
    of; only output uses them. flipped_corners: vertices between two mirrors at which the other one of
        their two normals is meant (see `conditions.mirror`); what is no such corner is left alone.
    lengths: (T, 3) side lengths of the triangles, side k opposite corner k, in place of the drawn ones; the positions
        are then only where the shell is put. initial: (V, 3) the normals that a solve starts from.
    """

    positions: Array
    triangles: NDArray[np.integer]
    polygons: Sequence[NDArray[np.integer]] | None = None
    groups: Sequence[Group] = ()
    triangle_polygons: NDArray[np.integer] | None = None
    flipped_corners: Sequence[int] = ()
    lengths: Array | None = None
    initial: Array | None = None


@dataclass
class Settings:
    """How a plan is solved and its shell placed.

    default_kind, default_tilt (radians): the condition of boundary edges in no group.
    blend: length of boundary over which the tilts of neighbouring groups flow into each other; 0: they jump.
    size, value, ground, rotate, flip: see `placement.Rule`; `sheet`, "f+" or "f-", is the one they speak of.
    combinatorics: of `COMBINATORICS`, the polygons with which the sheets are written; they are measured on triangles.
    shell: of `SHELLS`; degree and "bubble" exclude each other. A bubble is f- as a rule (see `usual_sheet`), its rim
        is drawn on the other side of the centre, and so it may always rotate.
    count_modes: report how many unstable modes the map has; always with the methods of `COUNTED`.
    The rest goes to the solver as it is: see `solve_cmc`. Raises `CmcError` on a name that is none, and on an energy
    that is not defined on the sites.
    """

    default_kind: str = "binormal"
    default_tilt: float = 0.0
    blend: float = 0.0
    size: str = "match_plan"
    value: float = 1.0
    ground: str = "lowest"
    rotate: bool = False
    flip: bool = False
    sheet: str = "f+"
    sites: str = "vertices"
    energy: str = "cotan"
    method: str = "newton"
    delaunay: bool = False
    averaging: str = "galerkin"
    tolerance: float = 1e-6
    period_tolerance: float = 1e-3
    side: int = +1
    degree: float | None = None
    combinatorics: str = "primal"
    shell: str = "first"
    count_modes: bool = False

    def __post_init__(self) -> None:
        if self.sheet not in SHEETS:
            raise JobError(f'There is no sheet "{self.sheet}"; choose f+ or f-.')
        if self.default_kind not in KINDS:
            raise JobError(f'There is no boundary condition "{self.default_kind}"; choose one of {", ".join(KINDS)}.')
        if not (np.isfinite(self.blend) and self.blend >= 0.0):
            raise JobError(f"The blend must be a length of zero or more, not {self.blend}.")
        for what, name, known in (
            ("kind of sites", self.sites, SITES),
            ("method", self.method, METHODS),
            ("combinatorics", self.combinatorics, COMBINATORICS),
            ("shell", self.shell, SHELLS),
        ):
            if name not in known:
                raise JobError(f'There is no {what} "{name}"; choose one of {", ".join(known)}.')
        if self.shell != "first" and self.degree is not None:
            raise JobError("A degree already says which shell is meant; leave it out, or the large bubble.")
        energy_on(self.energy, self.sites)
        self.rule()

    @property
    def counts_modes(self) -> bool:
        """Whether unstable modes are counted: where asked for, and where the method may end at a map that has some."""
        return self.count_modes or self.method in COUNTED

    @property
    def solver_choice(self) -> tuple[str, str, bool]:
        """What a solver is made for besides its domain: sites, energy by the name it has there, and Delaunay or not."""
        energy = energy_on(self.energy, self.sites)
        return self.sites, next(name for name, one in ENERGIES.items() if one is energy), self.delaunay

    def rule(self) -> Rule:
        """The placement part; raises `PlacementError` on a size or ground that is none."""
        return Rule(self.size, self.value, self.ground, self.rotate or self.shell == "bubble", self.flip)


def usual_sheet(shell: str) -> str:
    """The sheet that is worth showing: a bubble turns its normals against the rest, and it is f- that goes around."""
    return "f-" if shell == "bubble" else "f+"


def plan_domain(plan: Plan) -> Domain:
    """The plan's mesh as a domain, with its own edge lengths if it has them.

    Raises `MeshError` where it is none, is closed and without a start, or has no vertex inside.
    """
    if plan.initial is not None:
        start_map(plan.initial, len(plan.positions))
    if plan.lengths is None:
        domain = Domain.from_positions(plan.positions, plan.triangles)
    else:
        domain = metric_domain(plan.positions, plan.triangles, plan.lengths)
    if not len(domain.boundary_edges) and plan.initial is None:
        raise MeshError(
            "The mesh is closed: it has no boundary on which tangent planes could be prescribed; delete the faces that "
            "are not part of the plan, or give it a map to start from."
        )
    if len(domain.boundary_vertices) == domain.vertex_count:
        count = len(domain.faces)
        raise MeshError(
            f"The mesh ({count} triangle{'s' * (count > 1)}) has no vertex inside its boundary, so there is nothing to "
            "solve for; run Mesh Plan, or subdivide it."
        )
    return domain


def matches(domain: Domain, plan: Plan) -> bool:
    """Whether `domain` is the plan's: the same triangles and, to rounding, the same edge lengths."""
    if not np.array_equal(domain.faces, plan.triangles) or domain.vertex_count != len(plan.positions):
        return False
    if plan.lengths is not None:
        same = np.shape(plan.lengths) == domain.side_lengths.shape
        return same and bool(np.allclose(plan.lengths, domain.side_lengths, rtol=1e-12, atol=0.0))
    vectors = plan.positions[domain.edges[:, 1]] - plan.positions[domain.edges[:, 0]]
    return bool(np.allclose(np.linalg.norm(vectors, axis=1), domain.edge_lengths, rtol=1e-12, atol=0.0))


def plan_conditions(plan: Plan, settings: Settings, domain: Domain) -> Conditions:
    """The groups' conditions, and the default one on boundary edges in no group.

    Where groups of one condition meet, they are as one group. Raises `ConditionError` naming the group and
    the edges that are not on the boundary, an edge in two groups, or that every edge is free and there is no start.
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
    total = Conditions()
    if settings.blend > 0.0:
        total = _blended(domain, plan.positions, chosen, settings.blend)
        chosen = [(group, edges) for group, edges in chosen if group.kind != "binormal"]
    for group, edges in chosen:
        total = total + _build(group, domain, plan.positions, edges)
    if len(plan.flipped_corners):
        total = total + _flipped(domain, total, settings.side, plan.flipped_corners)
    if total.is_empty and plan.initial is None:
        raise ConditionError(
            "All boundary edges are free, so nothing holds the tangent planes; give some of them another condition."
        )
    return total


def _blended(
    domain: Domain, positions: Array, chosen: Sequence[tuple[Group, NDArray[np.integer]]], width: float
) -> Conditions:
    """One condition for all tilted groups, their tilts a moving average along the boundary."""
    tilts = np.full(len(domain.edges), np.nan)
    for group, edges in chosen:
        if group.kind == "binormal":
            tilts[edges] = group.parameters.get("tilt", 0.0)
    edges = np.flatnonzero(np.isfinite(tilts))
    return boundary.binormal(domain, positions, edges, moving_average(domain, edges, tilts[edges], width))


def _flipped(domain: Domain, total: Conditions, side: int, vertices: Sequence[int]) -> Conditions:
    """The other normal at those of the vertices that are corners between two mirrors."""
    sides = MirrorSides.of(domain, total, side)
    chosen = np.isin(sides.corners, vertices)
    return boundary.corner(domain, sides.corners[chosen], -sides.corner_normals[chosen])


def _group_edges(group: Group, domain: Domain) -> NDArray[np.integer]:
    """Indices of the group's edges, as often as they are listed once."""
    pairs = np.asarray(group.edges, dtype=np.int64).reshape(-1, 2)
    try:
        return np.unique(boundary_edges(domain, pairs))
    except ConditionError as error:
        raise _in_group(group, error) from error


def _condition_key(group: Group) -> object:
    """Equal for groups with the same condition."""
    return group.kind, tuple(sorted((name, str(np.asarray(v).tolist())) for name, v in group.parameters.items()))


def _build(group: Group, domain: Domain, positions: Array, edges: NDArray[np.integer]) -> Conditions:
    try:
        return boundary.build(group.kind, domain, positions, edges, **dict(group.parameters))
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


def plan_warnings(plan: Plan, domain: Domain) -> list[str]:
    """What is likely not meant: groups without edges, a plan whose faces look down."""
    notes = [f'Group "{group.name}" has no edges.' for group in plan.groups if not np.size(group.edges)]
    a, b, c = (plan.positions[domain.faces[:, k]] for k in range(3))
    areas = 0.5 * np.cross(b - a, c - a)
    if areas[:, 2].sum() < -0.5 * np.linalg.norm(areas, axis=1).sum():
        notes.append("The plan's faces look down, so the shell hangs below it; flip their normals, or flip the shell.")
    return notes
