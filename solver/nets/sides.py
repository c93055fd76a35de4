"""Sides of the boundary that are curvature lines themselves: mirrors, planes that the surface meets at one angle.

There one coordinate of w is constant along the rim, and the rim can be a line of the net. The boundary is divided at
the corners of the domain and where paths of the cut end.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from .cut import CutDomain
from .hopf import HopfDifferential
from .sheets import layout

Array = NDArray[np.float64]
Int = NDArray[np.integer]

# Turns of the boundary from this angle on are corners, in radians.
CORNER = np.radians(25.0)
# A side is a curvature line if it departs from the direction of one by at most this, root mean square, in radians.
_ALONG = np.radians(1.5)
# …and if it has this many edges.
_LEAST = 3


@dataclass(frozen=True, eq=False)
class LineSide:
    """A side along which coordinate `axis` of w is constant: its cut vertices (k,) in order, and its edges (k - 1,)."""

    axis: int
    cut_vertices: Int
    edges: Int

    def mean(self, transfer: sp.csr_array) -> Array:
        """The row of conditions: the mean of w over the side, from the unknowns."""
        return np.asarray(transfer[self.cut_vertices].mean(axis=0)).ravel()


def corner_vertices(hopf: HopfDifferential) -> Int:
    """Boundary vertices at which the boundary of the domain turns by at least `CORNER`, inwards or outwards."""
    domain = hopf.domain
    angles = np.bincount(domain.faces.ravel(), domain.corner_angles.ravel(), domain.vertex_count)
    rim = domain.boundary_vertices
    return rim[np.abs(np.pi - angles[rim]) >= CORNER]


def line_sides(hopf: HopfDifferential, cut: CutDomain, known: Int | None = None) -> list[LineSide]:
    """The sides that are curvature lines. known: (E,) the side of each boundary edge that certainly is one, or -1."""
    domain = hopf.domain
    known = np.full(len(domain.edge_lengths), -1) if known is None else known
    is_corner = np.zeros(domain.vertex_count, dtype=bool)
    is_corner[corner_vertices(hopf)] = True
    square = _rim_squares(hopf)
    found = []
    for loop in domain.boundary_loop_edges:
        for edges in _pieces(domain.edges[loop], loop, is_corner, known, cut):
            size = np.abs(square[edges])
            off = 0.5 * np.angle(square[edges] * [[1.0], [-1.0]])  # from lines of family 0 and of family 1
            apart = np.sqrt((off**2 @ size) / size.sum())
            nearest = int(np.argmin(apart))
            if known[edges[0]] >= 0 or (len(edges) >= _LEAST and apart[nearest] <= _ALONG):
                found.append(LineSide(1 - nearest, _cut_vertices(cut, edges), edges))
    return found


def _rim_squares(hopf: HopfDifferential) -> NDArray[np.complex128]:
    """q dz² (E,) along boundary edges, q in their middle."""
    domain = hopf.domain
    half = domain.half_edges[:, 0]
    face, k = half // 3, half % 3
    z = layout(domain)
    side = z[face, (k + 2) % 3] - z[face, (k + 1) % 3]
    q = 0.5 * (hopf.at_corners[face, (k + 1) % 3] + hopf.at_corners[face, (k + 2) % 3])
    return q * side**2


def _pieces(ends: Int, loop: Int, is_corner: NDArray[np.bool_], known: Int, cut: CutDomain) -> list[Int]:
    """The edges of a loop, divided at corners, between known sides and where the cut vertex of a vertex changes."""
    starts, stops = _edge_cut_vertices(cut, loop)
    other = known[loop] != np.roll(known[loop], 1)
    breaks = np.flatnonzero(is_corner[ends[:, 0]] | other | (starts != np.roll(stops, 1)))
    if not breaks.size:
        return [loop]
    return np.split(np.roll(loop, -breaks[0]), breaks[1:] - breaks[0])


def _edge_cut_vertices(cut: CutDomain, edges: Int) -> tuple[Int, Int]:
    """Start and end of boundary edges as cut vertices."""
    half = cut.domain.half_edges[edges, 0]
    face, k = half // 3, half % 3
    return cut.faces[face, (k + 1) % 3], cut.faces[face, (k + 2) % 3]


def _cut_vertices(cut: CutDomain, edges: Int) -> Int:
    starts, stops = _edge_cut_vertices(cut, edges)
    return starts if stops[-1] == starts[0] else np.append(starts, stops[-1])
