"""Boundary data for a start along mirrors: normals between the ends of a side, where they are known.

On a mirror side N moves along the great circle orthogonal to ν. Between two known ends it turns evenly, by the smaller
angle plus the winding's full turns; between opposite ends by half a turn, as on a convex side if ν points out of f+.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..domain.sites import SiteGraph
from ..errors import ConditionError, listed
from .admissible import Admissible
from .boundary_data import Conditions
from .frames import blend
from .mirrors import MirrorSides, parallel
from .sphere import tangent_axes

Array = NDArray[np.float64]
Int = NDArray[np.integer]

# Ends are opposite when their angle is within this of half a turn, in radians.
_OPPOSITE = 1e-6
# A normal whose part orthogonal to ν is shorter than this has no angle about ν.
_SHORTEST = 1e-3
# The middle of a side is below a plan when its cosine with "up" is less than minus this.
_UPRIGHT = 0.05


@dataclass(frozen=True, eq=False)
class _Run:
    """Consecutive mirror edges (k,) of one plane, in boundary order, and their vertices (k + 1,); a whole loop repeats
    its first vertex at the end. start, end: the known normals there, or None."""

    edges: Int
    vertices: Int
    axis: Array
    winding: int
    start: Array | None
    end: Array | None

    def angle(self, side: int, up: Array, leans: bool) -> tuple[Array, float] | None:
        """The first normal and the angle about the axis to the last; None without a known end or a winding."""
        turns = 2.0 * np.pi * self.winding
        if self.start is not None and self.end is not None:
            return self.start, turns + self._between(self.start, self.end, side, up, leans)
        if self.winding == 0:
            return None
        if self.end is not None:
            return self.end, turns  # a whole number of turns ends where it starts
        return self.start if self.start is not None else tangent_axes(self.axis[None])[0, 0], turns

    def _between(self, first: Array, last: Array, side: int, up: Array, leans: bool) -> float:
        angle = float(np.arctan2(np.cross(self.axis, first) @ last, first @ last))
        is_tie = abs(angle) > np.pi - _OPPOSITE
        if is_tie:
            angle = -np.pi * side
        elif self.winding or not leans:
            return angle
        middle = _turned(first, self.axis, np.array([0.5 * angle]))[0]
        is_below = side * float(middle @ up) < -_UPRIGHT * np.linalg.norm(up)
        return angle - 2.0 * np.pi * np.sign(angle) if is_below else angle


def side_normals(
    admissible: Admissible, conditions: Conditions, graph: SiteGraph, side: int, leans: bool = False
) -> tuple[Int, Array]:
    """Sorted sites (n,) on mirrors, and normals (n, 3) there that turn evenly between the known ends of each side.

    Sides with no known end and no winding are left out. leans: whether the data lean away from the side ±1 of the
    plan, so that the middle of every mirror must lie on that side.
    """
    domain, sites, normals = graph.domain, [], []
    for run in _runs(admissible.sides, _known(admissible.sides, conditions)):
        turn = run.angle(side, conditions.up, leans)
        if turn is None:
            continue
        lengths = domain.edge_lengths[run.edges]
        ends = np.concatenate([[0.0], np.cumsum(lengths)])
        if graph.at_vertices:
            at, place = run.vertices, ends
        else:
            at, place = graph.owners[run.edges], ends[1:] - 0.5 * lengths
        sites.append(at)
        normals.append(_turned(turn[0], run.axis, turn[1] * place / ends[-1]))
    if not sites:
        return np.zeros(0, dtype=np.int64), np.zeros((0, 3))
    unique, at = np.unique(np.concatenate(sites), return_index=True)
    free = ~np.isin(unique, admissible.fixed)
    return unique[free], np.concatenate(normals)[at[free]]


def _known(sides: MirrorSides, conditions: Conditions) -> Array:
    """(V, 3) the normals at boundary vertices that conditions or two mirrors fix; zero elsewhere."""
    known = np.zeros((sides.domain.vertex_count, 3))
    known[sides.corners] = sides.corner_normals
    vertices, normals = blend(
        conditions.vertices, conditions.vertex_normals, np.ones(len(conditions.vertices)), "conditions"
    )
    known[vertices] = normals
    return known


def _runs(sides: MirrorSides, known: Array) -> Iterator[_Run]:
    domain = sides.domain
    for vertices, edges in zip(domain.boundary_loops, domain.boundary_loop_edges, strict=True):
        planes = sides.planes[edges]
        held = planes.any(axis=1)
        breaks = known[vertices].any(axis=1) | (held != np.roll(held, 1))
        breaks |= held & np.roll(held, 1) & ~parallel(planes, np.roll(planes, 1, axis=0))
        starts = np.flatnonzero(breaks)
        if not len(starts):
            if held.all():
                yield _run(sides, edges, np.append(vertices, vertices[0]), known)
            continue
        shift = int(starts[0])
        vertices, edges = np.roll(vertices, -shift), np.roll(edges, -shift)
        closed = np.append(vertices, vertices[0])
        for first, last in zip(starts - shift, np.append(starts[1:] - shift, len(edges)), strict=True):
            if sides.planes[edges[first]].any():
                yield _run(sides, edges[first:last], closed[first : last + 1], known)


def _run(sides: MirrorSides, edges: Int, vertices: Int, known: Array) -> _Run:
    axis, windings = sides.planes[edges[0]], np.unique(sides.windings[edges])
    if len(windings) > 1:
        raise ConditionError(
            f"The mirror side from vertex {vertices[0]} to vertex {vertices[-1]} has the windings {listed(windings)}; "
            "give it a single one.",
            edges=edges,
        )
    start, end = (_flat(known[vertices[k]], axis) for k in (0, -1))
    return _Run(edges, vertices, axis, int(windings[0]), start, end)


def _flat(normal: Array, axis: Array) -> Array | None:
    """The direction of the part of a normal orthogonal to the axis; None if it is unknown, or along the axis."""
    flat = normal - (normal @ axis) * axis
    length = float(np.linalg.norm(flat))
    return flat / length if length > _SHORTEST else None


def _turned(normal: Array, axis: Array, angles: Array) -> Array:
    """A normal orthogonal to the axis, turned about it by each of the angles (n,)."""
    return np.cos(angles)[:, None] * normal + np.sin(angles)[:, None] * np.cross(axis, normal)
