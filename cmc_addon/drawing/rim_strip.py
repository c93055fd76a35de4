"""The faces along the rim of a plan as a domain, which is all that boundary conditions need.

Its boundary edges, the faces behind them, the angles around their vertices and their neighbours within two edges, to
which As Drawn fits a surface, are those of the whole plan.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...solver.domain import connectivity
from ...solver.domain.domain import Domain
from ...solver.io.polygons import triangulate_polygons
from ...solver.shells.plan import Group, Plan
from ...solver.shells.plan_metric import side_lengths
from ..bridges.mesh_bridge import PlanMesh

Array = NDArray[np.float64]
Int = NDArray[np.integer]


@dataclass(frozen=True)
class GroupState:
    """A boundary group as plain values that compare; kind: the solver's name; parameters: (name, value) pairs.

    is_elsewhere: its rim lies on a chosen curve, not on its edges.
    """

    uid: int
    name: str
    kind: str
    parameters: tuple[tuple[str, object], ...] = ()
    is_elsewhere: bool = False


@dataclass(frozen=True, eq=False)
class Strip:
    """Two rings of faces along the rim, as a domain whose first `rim_count` vertices are those of the rim, in order.

    vertices (n,): their indices in the plan. uids (E,): groups of the edges, -1 on edges off the rim.
    """

    domain: Domain
    points: Array
    vertices: Int
    rim_count: int
    uids: Int

    @classmethod
    def of(cls, mesh: PlanMesh, rim: Int, owner: Int) -> Strip:
        """Raises `CmcError` if the faces are no surface."""
        on_rim = np.zeros(len(mesh.positions), dtype=bool)
        on_rim[mesh.edges[rim]] = True
        triangles = _triangles_of(mesh, _touching(mesh, _near(mesh, on_rim)))
        inside = np.setdiff1d(triangles, np.flatnonzero(on_rim))
        vertices = np.concatenate([np.flatnonzero(on_rim), inside])
        place = np.full(len(mesh.positions), -1, dtype=np.int32)
        place[vertices] = np.arange(len(vertices))
        faces, points = place[triangles], mesh.positions[vertices]
        domain = _as_domain(faces, points, _own_lengths(mesh, triangles, place))
        count = len(vertices) - len(inside)
        return cls(domain, points, vertices, count, _uids(domain, place[mesh.edges[rim]], owner, count))

    @property
    def up(self) -> Array:
        """½ ∮ x × dx, the area vector of the whole plan."""
        tail, head = self.points[self.domain.edges[self.uids >= 0]].swapaxes(0, 1)
        return 0.5 * np.cross(tail, head).sum(axis=0)

    def as_plan(self, groups: Sequence[GroupState]) -> Plan:
        """The strip as a plan with these groups; where it ends inside the real plan it is free."""
        edges = self.domain.edges
        inner = self.domain.boundary_edges[self.uids[self.domain.boundary_edges] < 0]
        own = [Group(g.name, edges[self.uids == g.uid], *_normals_of(g)) for g in groups]
        return Plan(self.points, self.domain.faces, groups=[*own, Group("", edges[inner], "free")])


def _normals_of(group: GroupState) -> tuple[str, dict[str, object]]:
    """Kind and parameters of a condition on the normals alone: a rim over its line leans nearly as a free one does."""
    parameters = dict(group.parameters)
    if group.kind == "lean":
        return "binormal", {"tilt": parameters.get("angle", 0.0)}
    return ("free", {}) if group.kind == "line" else (group.kind, parameters)


def _touching(mesh: PlanMesh, vertices: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """(P,) polygons with one of the vertices (V,)."""
    return np.logical_or.reduceat(vertices[mesh.corners], mesh.starts[:-1])


def _near(mesh: PlanMesh, vertices: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """(V,) all vertices of the polygons with one of the vertices (V,)."""
    near = vertices.copy()
    near[mesh.corners[np.repeat(_touching(mesh, vertices), np.diff(mesh.starts))]] = True
    return near


def _triangles_of(mesh: PlanMesh, polygons: NDArray[np.bool_]) -> Int:
    """Triangles, in the plan's numbering, of some of its polygons (P,)."""
    step = -1 if mesh.mirrored else 1
    bounds = zip(mesh.starts[:-1][polygons].tolist(), mesh.starts[1:][polygons].tolist(), strict=True)
    return triangulate_polygons(mesh.positions, [mesh.corners[a:b][::step] for a, b in bounds])[0]


def _own_lengths(mesh: PlanMesh, triangles: Int, place: Int) -> Array | None:
    """Side lengths (T, 3) of a plan with its own edge lengths."""
    if mesh.lengths is None:
        return None
    near = (place[mesh.edges] >= 0).all(axis=1)
    return side_lengths(triangles, mesh.edges[near], mesh.lengths[near])


def _as_domain(faces: NDArray[np.int32], points: Array, sides: Array | None) -> Domain:
    """A domain without the check for a connected surface: the strip may touch itself where it ends."""
    face_edges = connectivity.edges_by_vertex_pairs(faces, len(points))
    edges = connectivity.pair_half_edges(faces, face_edges)
    if sides is None:
        lengths = np.linalg.norm(points[edges.edges[:, 1]] - points[edges.edges[:, 0]], axis=1)
    else:
        lengths = np.bincount(face_edges.ravel(), sides.ravel()) / np.bincount(face_edges.ravel())
    return Domain(faces, edges.face_edges, lengths)


def _uids(domain: Domain, pairs: Int, owner: Int, rim_count: int) -> Int:
    """Groups (E,) of the edges of a strip from those of the rim edges, pairs (n, 2); -1 elsewhere."""
    count = len(domain.edges)
    uids = np.full(count, -1, dtype=np.int64)
    rim = domain.boundary_edges[(domain.edges[domain.boundary_edges] < rim_count).all(axis=1)]
    keys, known = (np.sort(p, axis=1).astype(np.int64) @ [rim_count, 1] for p in (pairs, domain.edges[rim]))
    order = np.argsort(keys)
    uids[rim] = owner[order[np.searchsorted(keys[order], known).clip(max=len(keys) - 1)]]
    return uids
