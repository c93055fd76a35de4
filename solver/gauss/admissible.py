"""The maps that boundary conditions admit: at each site the normal moves on the sphere, on a great circle, or not.

The degrees of freedom are 2 at a free site, 1 on a mirror and 0 where the normal is fixed, by a condition or by two
mirrors that meet. Great circles are geodesics of the sphere, so on a mirror only the projection changes.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ..domain.sites import SiteGraph
from ..errors import ConditionError, plural
from .boundary_data import Conditions
from .frames import blend, of_boundary
from .mirrors import Mirrors, MirrorSides, on_side, parallel
from .sphere import dot, normalize, tangent_axes

Array = NDArray[np.float64]
Int = NDArray[np.integer]

# A normal whose part in the mirror's plane is shorter than this has no direction there.
_SHORTEST = 1e-9


@dataclass(frozen=True, eq=False)
class Admissible:
    """The maps that boundary conditions admit on a graph.

    fixed: (n,) sorted sites, data: (n, 3) their normals. mirrors: sites held in a plane. corners: (k,) the fixed sites
    that two mirrors fix, up to sign; decided: (k,) whether the caller has chosen the sign. sides: the mirrors along
    the boundary, for every kind of site.
    """

    fixed: Int
    data: Array
    mirrors: Mirrors
    corners: Int
    decided: NDArray[np.bool_]
    sides: MirrorSides

    @property
    def corner_normals(self) -> Array:
        """(k, 3) the normals at `corners`."""
        return self.data[np.searchsorted(self.fixed, self.corners)]

    def facing(self, N: Array) -> Admissible:
        """The same with the normal at each undecided corner on the side of the map N (S, 3) there."""
        normals = self.corner_normals
        cosine = dot(normals, N[self.corners])[:, 0]
        data = self.data.copy()
        data[np.searchsorted(self.fixed, self.corners)] *= np.where((cosine < 0.0) & ~self.decided, -1.0, 1.0)[:, None]
        return replace(self, data=data)

    def pin(self, N: Array) -> Array:
        """The admissible map nearest to N (S, 3), whose rows are unit vectors."""
        pinned = self.mirrors.flatten(N)
        at, axes = self.mirrors.sites, self.mirrors.normals
        if len(at):
            lost = dot(pinned[at], pinned[at])[:, 0] < _SHORTEST**2
            pinned[at[lost]] = tangent_axes(axes[lost])[:, 0]
            pinned[at] = normalize(pinned[at])
        else:
            pinned = pinned.copy()
        pinned[self.fixed] = self.data
        return pinned


def resolved(conditions: Conditions, graph: SiteGraph, side: int = +1) -> Admissible:
    """The maps that the conditions admit on a graph; undecided corner normals are on that `side`.

    Faces that turn as one (halves of a rectangle) get one normal: the normalised sum of the prescribed ones; a mirror
    on one of them holds the others on mirrors, too. Raises `ConditionError` naming sites with three mirrors.
    """
    fixed, data = _fixed(conditions, graph)
    sides = MirrorSides.of(graph.domain, conditions, side)
    if graph.at_vertices:
        along = ~np.isin(fixed, conditions.only_vertices)
        data[along] = sides.blended(fixed[along], data[along])
    held = _Held.of(graph, sides, fixed)
    two = held.second.any(axis=1)
    normals, decided = held.corners(sides, np.flatnonzero(two), conditions.up, side)
    order = np.argsort(np.concatenate([fixed, held.sites[two]]))
    return Admissible(
        np.concatenate([fixed, held.sites[two]])[order],
        np.concatenate([data, normals])[order],
        Mirrors(held.sites[~two], held.first[~two]),
        held.sites[two],
        decided,
        sides,
    )


@dataclass(frozen=True, eq=False)
class _Held:
    """Sites (m,) on mirrors, sorted and unique, and the planes of their bodies: first and second (m, 3), the second
    zero at sites on one plane. vertices: of each site's body, the ends of the edges that put it on a mirror."""

    sites: Int
    first: Array
    second: Array
    vertices: list[Int]

    @classmethod
    def of(cls, graph: SiteGraph, sides: MirrorSides, fixed: Int) -> _Held:
        edges = sides.edges
        ends = graph.domain.edges[edges].astype(np.int64)
        if graph.at_vertices:
            sites, planes, ends = ends.ravel(), np.repeat(sides.planes[edges], 2, axis=0), ends.reshape(-1, 1)
            body_of = np.arange(graph.count)
        else:
            sites, planes, body_of = graph.owners[edges].astype(np.int64), sides.planes[edges], graph.bodies
        kept = ~np.isin(sites, fixed)
        sites, planes, ends = sites[kept], planes[kept], ends[kept]
        first, second = _two_planes(graph, sites, body_of[sites], planes)
        unique, at = np.unique(sites, return_index=True)
        first, second = first[at], second[at]
        crossed = np.flatnonzero(second.any(axis=1))
        vertices: list[Int] = [np.zeros(0, dtype=np.int64)] * len(unique)
        for row in crossed:
            vertices[row] = np.unique(ends[body_of[sites] == body_of[unique[row]]])
        return cls(unique, first, second, vertices)

    def corners(self, sides: MirrorSides, rows: Int, up: Array, side: int) -> tuple[Array, NDArray[np.bool_]]:
        """Normals (k, 3) where two planes meet, and whether the caller chose them (k,).

        They are those of the corner between the mirrors; with normals at faces, none may fit.
        """
        normals = on_side(normalize(np.cross(self.first[rows], self.second[rows])), up, side)
        decided = np.zeros(len(rows), dtype=bool)
        for k, row in enumerate(rows):
            corners = np.flatnonzero(np.isin(sides.corners, self.vertices[row]))
            fitting = corners[parallel(sides.corner_normals[corners], normals[k])]
            if fitting.size:
                normals[k], decided[k] = sides.corner_normals[fitting[0]], sides.decided[fitting[0]]
        return normals, decided


def _two_planes(graph: SiteGraph, sites: Int, bodies: Int, planes: Array) -> tuple[Array, Array]:
    """For each entry the first plane of its body, and the first other one, or zero."""
    _, at, body = np.unique(bodies, return_index=True, return_inverse=True)
    first = planes[at][body]
    other = np.flatnonzero(~parallel(planes, first))
    with_second, at = np.unique(body[other], return_index=True)
    seconds = np.zeros((int(body.max(initial=-1)) + 1, 3))
    seconds[with_second] = planes[other[at]]
    second = seconds[body]
    third = other[~parallel(planes[other], second[other])]
    if third.size:
        where, offenders = graph.named(np.unique(sites[third]))
        raise ConditionError(
            f"Three mirrors meet at {where} and leave no normal; refine the corner, or free one of its sides.",
            **offenders,
        )
    return first, second


def _fixed(conditions: Conditions, graph: SiteGraph) -> tuple[Int, Array]:
    """Sorted fixed sites (n,) of a graph and their normals (n, 3), without those fixed by mirrors."""
    if graph.at_vertices:
        fixed, data = conditions.resolve(graph.name)
        _check_sites(fixed, graph.count, "vertex")
        of_boundary(conditions.edges, np.where(graph.domain.edge_faces[:, 1] < 0, 0, -1))
        return fixed, data
    _check_sites(conditions.faces, len(graph.domain.faces), "face")
    fixed, data = conditions.resolve(graph.name, graph.owners)
    _, first, body = np.unique(graph.bodies[fixed], return_index=True, return_inverse=True)
    _, normals = blend(fixed[first][body], data, np.ones(len(fixed)), "conditions", "face")
    return fixed, normals[np.argsort(np.argsort(fixed[first]))[body]]


def _check_sites(sites: Int, count: int, noun: str) -> None:
    bad = sites[sites >= count]
    if bad.size:
        raise ConditionError(f"The conditions fix {plural(noun, bad)}, which this domain does not have.")
