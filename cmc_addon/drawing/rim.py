"""The normals that the conditions of a plan prescribe along its rim, before a solve. Arrays only.

The solver's own `plan_conditions` and `resolved` give them, blended angles included. They run on the faces along the
rim only (`rim_strip`), so that the cost grows with the length of the rim.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from ...solver.domain.sites import SiteGraph
from ...solver.errors import CmcError
from ...solver.gauss.admissible import Admissible, resolved
from ...solver.gauss.boundary_data import Conditions
from ...solver.gauss.horizon import upwards
from ...solver.shells.plan import Settings
from ...solver.shells.plan_conditions import plan_conditions
from ..bridges.mesh_bridge import PlanMesh
from .rim_strip import GroupState, Strip

Array = NDArray[np.float64]
Int = NDArray[np.integer]

NOBODY = 0
"""Uid of edges in no group."""


@dataclass(frozen=True, eq=False)
class Walk:
    """A part of a boundary loop in one group, with the plan on its left.

    points (m + 1, 3): its vertices, of a closed loop the first one again at the end. normals (m + 1, 3) at the vertices
    and middles (m, 3) at the edges: nan where nothing is prescribed. loop: number of the boundary loop.
    """

    uid: int
    points: Array
    normals: Array
    middles: Array
    closed: bool
    loop: int = 0

    @property
    def length(self) -> float:
        return float(np.linalg.norm(np.diff(self.points, axis=0), axis=1).sum())


@dataclass(frozen=True, eq=False)
class Rim:
    """The rim of a plan. lines: uid → ends (n, 2, 3) of boundary edges, known even if nothing else is.

    corners, corner_normals (k, 3): vertices between two mirrors, and the normals of the shell there. up (3,): the area
    vector of the plan. size: diagonal of the bounding box of its boundary. default_kind: as in `Leaning`.
    """

    groups: tuple[GroupState, ...]
    lines: dict[int, Array]
    size: float
    walks: tuple[Walk, ...] = ()
    corners: Array = field(default_factory=lambda: np.zeros((0, 3)))
    corner_normals: Array = field(default_factory=lambda: np.zeros((0, 3)))
    up: Array = field(default_factory=lambda: np.zeros(3))
    default_kind: str = "binormal"

    @property
    def length(self) -> float:
        return sum(walk.length for walk in self.walks)

    def group(self, uid: int) -> GroupState | None:
        return next((group for group in self.groups if group.uid == uid), None)

    @property
    def outer(self) -> Array:
        """Ends (n, 2, 3) of the edges of the outer boundary loop, the widest one; of all where loops are not known."""
        loops: dict[int, list[Array]] = {}
        for walk in self.walks:
            loops.setdefault(walk.loop, []).append(np.stack([walk.points[:-1], walk.points[1:]], axis=1))
        if not loops:
            return np.concatenate([np.zeros((0, 2, 3)), *self.lines.values()])
        found = [np.concatenate(pieces) for pieces in loops.values()]
        return max(found, key=lambda ends: _diagonal(ends.reshape(-1, 3)))

    def lies_on(self, uid: int) -> bool:
        """Whether the shell's rim lies on the edges of this group."""
        group = self.group(uid)
        return self.default_kind == "line" if group is None else group.kind == "line" and not group.is_elsewhere


@dataclass(frozen=True, eq=False)
class Drawn:
    """The part of a plan that does not depend on the conditions of its groups.

    positions (V, 3); lines and size as in `Rim`; strip: the faces along the rim, None if they are no surface.
    """

    positions: Array
    lines: dict[int, Array]
    size: float
    flipped: tuple[int, ...] = ()
    strip: Strip | None = None

    @classmethod
    def of(cls, mesh: PlanMesh, uids: Sequence[int]) -> Drawn:
        """From a mesh whose groups have these uids. Never raises for a bad mesh: unknown parts are left out."""
        owner = np.where(np.isin(mesh.groups, np.array(uids, dtype=np.int64)), mesh.groups, NOBODY)
        rim = _rim_edges(mesh)
        lines = {int(uid): mesh.positions[mesh.edges[rim[owner[rim] == uid]]] for uid in np.unique(owner[rim])}
        bare = cls(mesh.positions, lines, _diagonal(mesh.positions[mesh.edges[rim].ravel()]), mesh.flipped_corners)
        if len(mesh.starts) < 2 or not len(rim):
            return bare
        try:
            return replace(bare, strip=Strip.of(mesh, rim, owner[rim]))
        except CmcError:
            return bare


@dataclass(frozen=True)
class Leaning:
    """How the angles of groups are taken, and the kind of edges in no group: see the solver's `Settings`."""

    blend: float = 0.0
    against: str = "horizon"
    default_kind: str = "binormal"


def prescribed_rim(drawn: Drawn, groups: Sequence[GroupState], leaning: Leaning = Leaning(), side: int = 1) -> Rim:
    """The rim of a plan, with the normals that its groups prescribe; never raises for a bad group.

    Groups that are invalid by themselves are left out, then the vertices at which groups contradict each other.
    """
    bare = Rim(tuple(groups), drawn.lines, drawn.size, default_kind=leaning.default_kind)
    strip = drawn.strip
    if strip is None:
        return bare
    held = _held(strip, groups, leaning, side, drawn.flipped)
    at = held.corners[held.corners < strip.rim_count]
    return replace(
        bare,
        walks=tuple(_walks(strip, held)),
        corners=strip.points[at],
        corner_normals=held.normals[at],
        up=strip.up,
    )


def _rim_edges(mesh: PlanMesh) -> Int:
    """Boundary edges; in a mesh without faces, an outline still to be meshed, all of them."""
    return np.flatnonzero(mesh.boundary) if len(mesh.starts) > 1 else np.arange(len(mesh.edges))


def _diagonal(points: Array) -> float:
    finite = points[np.isfinite(points).all(axis=1)]
    return float(np.linalg.norm(np.ptp(finite, axis=0))) if len(finite) else 0.0


# --- the prescribed normals -----------------------------------------------------------------------

@dataclass(frozen=True, eq=False)
class _Held:
    """Normals (n, 3) at vertices and (E, 3) in the middle of edges, nan where free; corners between two mirrors."""

    normals: Array
    middles: Array
    corners: Int


def _held(
    strip: Strip, groups: Sequence[GroupState], leaning: Leaning, side: int, flipped: Sequence[int]
) -> _Held:
    normals, middles = (np.full((n, 3), np.nan) for n in (len(strip.points), len(strip.domain.edges)))
    conditions, left_out = _conditions(strip, groups, leaning)
    admissible = None if conditions is None else _admissible(strip, conditions, side)
    if conditions is None or admissible is None:
        return _Held(normals, middles, np.zeros(0, dtype=np.int64))
    normals[admissible.fixed] = admissible.data
    corners = admissible.corners
    normals[corners[np.isin(strip.vertices[corners], flipped)]] *= -1.0
    middles[conditions.edges] = conditions.edge_normals
    bad = np.isin(strip.uids, left_out)
    middles[bad] = np.nan
    normals[np.setdiff1d(strip.domain.edges[bad], strip.domain.edges[(strip.uids >= 0) & ~bad])] = np.nan
    return _Held(normals, middles, corners)


def _walks(strip: Strip, held: _Held) -> list[Walk]:
    """The boundary loops of a plan, divided where the group changes."""
    walks = []
    loops = zip(strip.domain.boundary_loops, strip.domain.boundary_loop_edges, strict=True)
    for number, (loop, edges) in enumerate(loops):
        uids = strip.uids[edges]
        if (uids < 0).any():
            continue
        starts = np.flatnonzero(uids != np.roll(uids, 1))
        first = int(starts[0]) if len(starts) else 0
        loop, edges, uids = (np.roll(array, -first) for array in (loop, edges, uids))
        ends = [*(starts[1:] - first).tolist(), len(edges)]
        for start, end in zip([0, *ends], ends, strict=False):
            at = np.append(loop, loop[0])[start : end + 1]
            closed = len(starts) == 0
            middles = held.middles[edges[start:end]]
            walks.append(Walk(int(uids[start]), strip.points[at], held.normals[at], middles, closed, number))
    return walks


def _conditions(
    strip: Strip, groups: Sequence[GroupState], leaning: Leaning
) -> tuple[Conditions | None, list[int]]:
    """The conditions of the groups, and the uids of the groups left out as invalid."""
    default_kind = "free" if leaning.default_kind == "line" else leaning.default_kind
    settings = Settings(blend=leaning.blend, against=leaning.against, default_kind=default_kind)
    try:
        return _on_strip(strip, groups, settings), []
    except CmcError:
        pass
    sound = [group for group in groups if _is_sound(strip, group)]
    left_out = [group.uid for group in groups if group not in sound]
    try:
        return _on_strip(strip, sound, settings), left_out
    except CmcError:
        return None, left_out


def _on_strip(strip: Strip, groups: Sequence[GroupState], settings: Settings) -> Conditions:
    """With the area vector of the whole plan, which the strip alone may get wrong."""
    conditions = plan_conditions(strip.as_plan(groups), settings, strip.domain, upwards(strip.up))
    return replace(conditions, up=strip.up) if conditions.up.any() else conditions


def _is_sound(strip: Strip, group: GroupState) -> bool:
    """Whether a group is valid by itself; a free group prescribes nothing and always is."""
    if group.kind == "free" or not (strip.uids == group.uid).any():
        return True
    try:
        plan_conditions(strip.as_plan([group]), Settings(), strip.domain)
    except CmcError:
        return False
    return True


def _admissible(strip: Strip, conditions: Conditions, side: int) -> Admissible | None:
    """The conditions resolved at the vertices; vertices with a contradiction stay free."""
    graph = SiteGraph.of(strip.domain, "vertices")
    for _ in range(2):
        try:
            return resolved(conditions, graph, side)
        except CmcError as error:
            bad = np.isin(conditions.vertices, error.vertices)
            conditions = replace(
                conditions,
                vertices=conditions.vertices[~bad],
                vertex_normals=conditions.vertex_normals[~bad],
            )
    return None
