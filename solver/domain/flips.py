"""Intrinsic edge flips, one at a time, on any triangulation: glued sides and faces that repeat a vertex included.

They cover what libigl, about four times as fast, does not: several edges between the same two vertices, as on a torus
of two triangles; vertices left with two edges on the way; and how the new edges run around holes and handles.
"""

from __future__ import annotations

from math import hypot, sqrt

import numpy as np
from numpy.typing import NDArray

from ..errors import MeshError, listed
from .domain import Domain

Array = NDArray[np.float64]
Int = NDArray[np.integer]

# An edge is not flipped when cot θ_k + cot θ_l is below zero by no more than this part of the two: with four vertices
# on a circle a flip gains nothing, and rounding could flip it back and forth for ever.
_ROUNDING = 1e-12


class Flips:
    """A triangulation whose edges are flipped until it is Delaunay; half-edges 3 f + k as in `Domain`.

    next: (3 F,) the half-edge that follows in the face. start: (3 F,) the vertex each starts from. edge: (3 F,).
    twin: (3 F,), -1 on the boundary. cotan: (3 F,) of the angle opposite. areas: (F,). lengths: (E,).
    forwards: (E,) the half-edge in the direction of the edge, for `carry`.
    history: three numbers a flip: the edge e, and a path of two edges from its new start to its new end, ±(first + 1)
        and ±(second + 1), negative where an edge is walked backwards.

    Raises `MeshError` where a new triangle has no area in double precision.
    """

    def __init__(self, domain: Domain) -> None:
        corners = np.arange(domain.faces.size).reshape(-1, 3)
        self.next: list[int] = corners[:, [1, 2, 0]].ravel().tolist()
        self.start: list[int] = domain.faces[:, [1, 2, 0]].ravel().tolist()
        self.edge: list[int] = domain.face_edges.ravel().tolist()
        self.twin: list[int] = domain.twins.tolist()
        self.cotan: list[float] = domain.corner_cotans.ravel().tolist()
        self.areas: list[float] = domain.face_areas.tolist()
        self.lengths: list[float] = domain.edge_lengths.tolist()
        self.forwards: list[int] = domain.half_edges[:, 0].tolist()
        self.history: list[int] = []
        self._run()

    def _run(self) -> None:
        """Flip edges until all have cot θ_k + cot θ_l ≥ 0; the sides around a flipped edge are checked again.

        An edge with the same face on both sides is Delaunay: its two angles are in one triangle.
        """
        twin, cotan = self.twin, self.cotan
        waiting = self.forwards.copy()
        while waiting:
            h = waiting.pop()
            t = twin[h]
            if t >= 0:
                k, m = cotan[h], cotan[t]
                if k + m < 0.0 and k + m < -_ROUNDING * (1.0 + abs(k) + abs(m)):
                    waiting += self._flip(h, t)

    def _flip(self, h: int, t: int) -> tuple[int, int, int, int]:
        """Flip the edge a → b of the faces (c, a, b), (d, b, a) to d → c of (c, a, d), (d, b, c).

        The edge moves from h and t to the places after them, and their sides move across: a → d to h, b → c to t.
        Returns the four sides of the two faces; the other two stay in place.
        """
        start, edge, e = self.start, self.edge, self.edge[h]
        bc, ad = self.next[h], self.next[t]
        ca, db = self.next[bc], self.next[ad]
        self.history += (e, self._signed(db), self._signed(bc))
        self.lengths[e] = self._diagonal(h, t, bc, ad)
        self._move(ad, h)  # one after the other: these two may be glued to each other
        self._move(bc, t)
        start[bc], start[ad] = start[db], start[ca]
        edge[bc] = edge[ad] = e
        self.twin[bc], self.twin[ad] = ad, bc
        self.forwards[e] = bc
        self._measure(h, bc, ca)
        self._measure(t, ad, db)
        return h, ca, t, db

    def _move(self, h: int, place: int) -> None:
        """Move the half-edge h to another place that starts from the same vertex."""
        e, t = self.edge[h], self.twin[h]
        self.edge[place], self.twin[place] = e, t
        if t >= 0:
            self.twin[t] = place
        if self.forwards[e] == h:
            self.forwards[e] = place

    def _signed(self, h: int) -> int:
        """Its edge + 1; negative where the edge runs the other way."""
        e = self.edge[h]
        return e + 1 if self.forwards[e] == h else -e - 1

    def _diagonal(self, h: int, t: int, bc: int, ad: int) -> float:
        """The length of the other diagonal of the two triangles, laid out on both sides of h."""
        length = self.lengths[self.edge[h]]
        y, v = 2.0 * self.areas[h // 3] / length, 2.0 * self.areas[t // 3] / length
        return hypot(length - self.cotan[bc] * y - self.cotan[ad] * v, y + v)

    def _measure(self, i: int, j: int, k: int) -> None:
        """Area and cotangents of a face from its lengths, by the formulas of `Domain`."""
        lengths, edge, cotan = self.lengths, self.edge, self.cotan
        a, b, c = lengths[edge[i]], lengths[edge[j]], lengths[edge[k]]
        r, q, p = sorted((a, b, c))
        product = (p + (q + r)) * (r - (p - q)) * (r + (p - q)) * (p + (q - r))
        if product <= 0.0:
            raise _too_thin(self.start[i], self.start[j], self.start[k])
        area = self.areas[i // 3] = 0.25 * sqrt(product)
        half, twice = 0.5 * (a * a + b * b + c * c), 2.0 * area
        cotan[i], cotan[j], cotan[k] = (half - a * a) / twice, (half - b * b) / twice, (half - c * c) / twice

    def domain(self) -> Domain:
        """The present triangulation; edges keep their numbers through flips."""
        faces = np.array(self.start).reshape(-1, 3)[:, [2, 0, 1]]
        face_edges = np.array(self.edge).reshape(-1, 3)
        return Domain.from_edge_lengths(faces, np.array(self.lengths)[face_edges], face_edges=face_edges)

    def carry(self, form: Int) -> Int:
        """A closed form (E, k) carried from the old edges to the new ones: increments of a function on the vertices,
        from the start of an edge to its end, which sum to zero around every face.
        """
        flips = list(zip(self.history[0::3], self.history[1::3], self.history[2::3], strict=True))
        columns = np.zeros(form.T.shape, dtype=form.dtype)
        for column, values in zip(columns, form.T.tolist(), strict=True):
            for e, first, second in flips:
                values[e] = (values[first - 1] if first > 0 else -values[-first - 1]) + (
                    values[second - 1] if second > 0 else -values[-second - 1]
                )
            column[:] = values
        # a Domain's edge runs as its half-edge with the lower number
        forwards = np.array(self.forwards)
        backwards = (np.array(self.twin)[forwards] >= 0) & (np.array(self.twin)[forwards] < forwards)
        return np.where(backwards[:, None], -columns.T, columns.T)


def _too_thin(*vertices: int) -> MeshError:
    corners = np.unique(vertices)
    return MeshError(
        f"Some faces are so thin that rounding makes them flat (flipping edges leads to vertices {listed(corners)}); "
        "dissolve degenerate faces there, or solve without the intrinsic Delaunay triangulation.",
        vertices=corners,
    )
