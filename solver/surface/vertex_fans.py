"""The fans around the vertices of a domain: corners in counter-clockwise order.

Corner `3 f + k` is corner k of face f; half-edge `3 f + k` is opposite it. The walk uses corners and half-edges, never
pairs of vertices, since two edges may join the same vertices, and a face may meet a vertex twice.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..domain.connectivity import after, before
from ..domain.domain import Domain
from ..domain.trees import accumulate

Int = NDArray[np.integer]


@dataclass(frozen=True, eq=False)
class Fans:
    """The surroundings of each vertex, counter-clockwise, one vertex after the other.

    vertices: (m,) sorted. places: (m,) a corner, or an end of a boundary edge: the start of `boundary_edges[b]` is
    place `3 F + 2 b`, its end `3 F + 2 b + 1`. A vertex on the boundary begins with the start of the edge that leaves
    it and ends with the end of the edge that arrives.
    shifts: (m, k) integers. On a domain cut open, a value v of the place's face, integrated along the tree of the
    homology, continues to all of this vertex as `v + shift @ periods`; zero on the sheet that has most of the vertex.
    """

    vertices: Int
    places: Int
    shifts: Int

    @classmethod
    def of(cls, domain: Domain, crossings: Int) -> Fans:
        """crossings: (E, k) of the domain's `Homology`; (E, 0) if nothing jumps."""
        corners = np.arange(domain.faces.size)
        vertices = domain.faces.ravel()
        steps, shifts = _walk(domain, crossings)
        shifts = _on_widest_sheet(vertices, shifts, domain.vertex_count)
        behind = domain.half_edges[domain.boundary_edges, 0]
        ends = np.stack([after(behind), before(behind)], axis=1).ravel()
        # a boundary edge that leaves comes before the first corner, one that arrives after the last
        turn = np.concatenate([steps, np.tile([-1, corners.size], len(behind))])
        places = np.concatenate([corners, corners.size + np.arange(len(ends))])
        owners = np.concatenate([vertices, vertices[ends]])
        order = np.lexsort((turn, owners))
        return cls(owners[order], places[order], np.concatenate([shifts, shifts[ends]])[order])


def _walk(domain: Domain, crossings: Int) -> tuple[Int, Int]:
    """The number of corners before each one in its fan (3 F,), and the jumps (3 F, k) crossed on the way."""
    corners = np.arange(domain.faces.size)
    leaving = before(corners)  # the half-edge from a corner to the next is opposite the previous one
    twin = domain.twins[leaving].astype(np.int64)
    starts = domain.fan_starts[domain.faces.ravel()] == corners
    parent = np.where(starts, corners, before(twin))  # the corner clockwise of each
    edge = domain.face_edges.ravel()[leaving]
    # counter-clockwise an edge that leaves is crossed from its right to its left
    sign = np.where(domain.half_edges[edge, 0] == leaving, 1, -1)
    steps = np.column_stack([np.ones_like(sign), sign[:, None] * crossings[edge]])
    walked = np.rint(accumulate(parent, steps.astype(np.float64))).astype(np.int64)
    return walked[:, 0], walked[:, 1:]


def _on_widest_sheet(vertices: Int, shifts: Int, vertex_count: int) -> Int:
    """Shifts (3 F, k) counted from the sheet on which each vertex has most of its corners.

    On a sheet with a single corner, the cells around the vertex would meet in a point only.
    """
    moved = shifts.any(axis=1)
    if not moved.any():
        return shifts
    near = np.isin(vertices, vertices[moved])
    sheets, counts = np.unique(np.column_stack([vertices[near], shifts[near]]), axis=0, return_counts=True)
    base = np.zeros((vertex_count, shifts.shape[1]), dtype=np.int64)
    ascending = np.argsort(counts, kind="stable")  # of several assignments to a vertex the last one stays
    base[sheets[ascending, 0]] = sheets[ascending, 1:]
    return shifts - base[vertices]
