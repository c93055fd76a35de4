"""Intrinsic edge flips on any triangulation, one at a time: sides glued to each other, faces that repeat a vertex.

Ten times slower than libigl. For what libigl does not do: domains whose edges are not told apart by their two vertices,
like a torus of two triangles; those with vertices that come down to two edges on the way; and telling how the new edges
run around holes and handles.
"""

from __future__ import annotations

from math import hypot, sqrt

import numpy as np
from numpy.typing import NDArray

from .domain import Domain

Array = NDArray[np.float64]
Int = NDArray[np.integer]

# An edge is left as it is when cot θ_k + cot θ_l is below zero by no more than this part of the two: with four
# vertices on a circle a flip gains nothing, and rounding would go back and forth for ever.
_ROUNDING = 1e-12


class Flips:
    """A triangulation that changes until it is Delaunay; half-edges 3 f + k as in `Domain`.

    start: the vertex (3 F,) that each half-edge runs from. edge: (3 F,). twin: (3 F,), -1 on the boundary.
    cotan: (3 F,) of the angle opposite. areas: (F,). lengths: (E,).
    forwards: (E,) the half-edge that runs as the edge does, for `carry`.
    history: of each flip the edge e, and two edges behind it that lead from where it starts now to where it ends: three
        numbers each, e, ±(first + 1), ±(second + 1), negative where an edge is walked backwards.
    """

    def __init__(self, domain: Domain) -> None:
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
        """Flip edges that are not Delaunay until there are none; their neighbours are looked at again."""
        waiting = [h for h in self.forwards if not self._is_delaunay(h)]
        while waiting:
            h = waiting.pop()
            if not self._is_delaunay(h):
                self._flip(h)
                t = self.twin[h]
                waiting += [side for side in _others(h) + _others(t) if not self._is_delaunay(side)]

    def _is_delaunay(self, h: int) -> bool:
        """cot θ_k + cot θ_l ≥ 0. An edge with one face on both of its sides is: its two angles are in one triangle."""
        t = self.twin[h]
        if t < 0:
            return True
        k, m = self.cotan[h], self.cotan[t]
        return k + m >= -_ROUNDING * (1.0 + abs(k) + abs(m))

    def _flip(self, h: int) -> None:
        """Turn the edge a → b of the faces (c, a, b), (d, b, a) into d → c of (a, d, c), (b, c, d)."""
        t, e = self.twin[h], self.edge[h]
        (bc, ca), (ad, db) = _others(h), _others(t)
        self.history += (e, self._signed(db), self._signed(bc))
        self.lengths[e], self.forwards[e] = self._diagonal(h, t), h
        # h: d → c, then c → a, a → d in the first face; t: c → d, then d → b, b → c in the second
        a, b, c, d = self.start[h], self.start[t], self.start[ca], self.start[db]
        self.start[h], self.start[t] = d, c
        old, new = (ca, ad, db, bc), (bc, ca, ad, db)
        edges, twins = [self.edge[side] for side in old], [self.twin[side] for side in old]
        firsts = [self.forwards[edge] == side for edge, side in zip(edges, old, strict=True)]
        for place, vertex, edge, twin, first in zip(new, (c, a, d, b), edges, twins, firsts, strict=True):
            self.start[place], self.edge[place] = vertex, edge
            twin = new[old.index(twin)] if twin in old else twin
            self.twin[place] = twin
            if twin >= 0:
                self.twin[twin] = place
            if first:
                self.forwards[edge] = place
        self._measure(h // 3)
        self._measure(t // 3)

    def _signed(self, h: int) -> int:
        """Its edge + 1; negative where that runs the other way."""
        return self.edge[h] + 1 if self.forwards[self.edge[h]] == h else -self.edge[h] - 1

    def _diagonal(self, h: int, t: int) -> float:
        """The other diagonal of the two triangles, laid out on both sides of h."""
        length = self.lengths[self.edge[h]]
        y, v = 2.0 * self.areas[h // 3] / length, 2.0 * self.areas[t // 3] / length
        return hypot(length - self.cotan[_others(h)[0]] * y - self.cotan[_others(t)[0]] * v, y + v)

    def _measure(self, face: int) -> None:
        """Area and cotangents from lengths, as `Domain` has them."""
        corners = (3 * face, 3 * face + 1, 3 * face + 2)
        a, b, c = (self.lengths[self.edge[corner]] for corner in corners)
        r, q, p = sorted((a, b, c))
        product = (p + (q + r)) * (r - (p - q)) * (r + (p - q)) * (p + (q - r))
        area = self.areas[face] = 0.25 * sqrt(max(product, 0.0))
        half = 0.5 * (a * a + b * b + c * c)
        for corner, side in zip(corners, (a, b, c), strict=True):
            self.cotan[corner] = (half - side * side) / (2.0 * area)

    def domain(self) -> Domain:
        """The triangulation as it is now; its edges have the numbers that they had before they were flipped."""
        faces = np.array(self.start).reshape(-1, 3)[:, [2, 0, 1]]
        face_edges = np.array(self.edge).reshape(-1, 3)
        return Domain.from_edge_lengths(faces, np.array(self.lengths)[face_edges], face_edges=face_edges)

    def carry(self, form: Int) -> Int:
        """A closed form (E, k) on the old edges, as it is on the new ones: increments of a function on the vertices,
        from the start of an edge to its end, that sum to zero around every face.
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


def _others(h: int) -> tuple[int, int]:
    """The two half-edges that follow in the face."""
    face = h - h % 3
    return face + (h + 1) % 3, face + (h + 2) % 3
