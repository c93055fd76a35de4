"""Intrinsic edge flips on any triangulation, one at a time: sides glued to each other, faces that repeat a vertex.

Twenty times slower than libigl, and for the few domains that libigl cannot do: those whose edges are not told apart by
their two vertices, like a torus of two triangles, and those with vertices that come down to two edges on the way.
"""

from __future__ import annotations

from math import hypot, sqrt

import numpy as np
from numpy.typing import NDArray

from .domain import Domain

Array = NDArray[np.float64]

# An edge is left as it is when cot θ_k + cot θ_l is below zero by no more than this part of the two: with four
# vertices on a circle a flip gains nothing, and rounding would go back and forth for ever.
_ROUNDING = 1e-12


class Flips:
    """A triangulation that changes; half-edges 3 f + k as in `Domain`.

    start: vertex (3 F,) that each half-edge runs from. edge: (3 F,). sides: the one or two half-edges of each edge.
    lengths: of the edges.
    """

    def __init__(self, domain: Domain) -> None:
        self.start: list[int] = domain.faces[:, [1, 2, 0]].ravel().tolist()
        self.edge: list[int] = domain.face_edges.ravel().tolist()
        self.lengths: list[float] = domain.edge_lengths.tolist()
        self.sides: list[list[int]] = [[] for _ in self.lengths]
        for half_edge, edge in enumerate(self.edge):
            self.sides[edge].append(half_edge)

    def run(self) -> Domain:
        """Flip edges that are not Delaunay until there are none; their neighbours are looked at again."""
        waiting = list(range(len(self.sides)))
        queued = [True] * len(waiting)
        while waiting:
            e = waiting.pop()
            queued[e] = False
            if self._is_delaunay(e):
                continue
            for neighbour in self._flip(e):
                if not queued[neighbour]:
                    queued[neighbour] = True
                    waiting.append(neighbour)
        return self._domain()

    def _is_delaunay(self, e: int) -> bool:
        """cot θ_k + cot θ_l ≥ 0. An edge with one face on both of its sides is: its two angles are in one triangle."""
        if len(self.sides[e]) == 1:
            return True
        k, m = (self._cotan(h) for h in self.sides[e])
        return k + m >= -_ROUNDING * (1.0 + abs(k) + abs(m))

    def _cotan(self, h: int) -> float:
        x, y, length = self._apex(h)
        return (x * (x - length) + y * y) / (length * y)

    def _apex(self, h: int) -> tuple[float, float, float]:
        """The corner opposite h where h runs from the origin along the x-axis: x, y > 0; and the length of h."""
        a, b, c = (self.lengths[self.edge[side]] for side in _around(h))
        x = (a * a + c * c - b * b) / (2.0 * a)
        r, q, p = sorted((a, b, c))  # twice the area is ½ √product (Kahan), as in Domain.face_areas
        product = (p + (q + r)) * (r - (p - q)) * (r + (p - q)) * (p + (q - r))
        return x, 0.5 * sqrt(max(product, 0.0)) / a, a

    def _flip(self, e: int) -> set[int]:
        """Turn the edge a → b of the faces (c, a, b), (d, b, a) into d → c of (a, d, c), (b, c, d); returns the edges
        around."""
        h, t = self.sides[e]
        x, y, length = self._apex(h)
        u, v, _ = self._apex(t)
        self.lengths[e] = hypot(length - u - x, v + y)
        (_, bc, ca), (_, ad, db) = _around(h), _around(t)
        a, b, c, d = self.start[h], self.start[t], self.start[ca], self.start[db]
        bc_edge, ca_edge, ad_edge, db_edge = (self.edge[side] for side in (bc, ca, ad, db))
        # h: d → c, then c → a, a → d in the first face; t: c → d, then d → b, b → c in the second
        moved = {ca: bc, ad: ca, db: ad, bc: db}
        for edge in {bc_edge, ca_edge, ad_edge, db_edge}:
            self.sides[edge] = [moved.get(side, side) for side in self.sides[edge]]
        for side, start, edge in (
            (h, d, e), (bc, c, ca_edge), (ca, a, ad_edge),
            (t, c, e), (ad, d, db_edge), (db, b, bc_edge),
        ):  # fmt: skip
            self.start[side], self.edge[side] = start, edge
        return {bc_edge, ca_edge, ad_edge, db_edge}

    def _domain(self) -> Domain:
        faces = np.array(self.start).reshape(-1, 3)[:, [2, 0, 1]]
        face_edges = np.array(self.edge).reshape(-1, 3)
        return Domain.from_edge_lengths(faces, np.array(self.lengths)[face_edges], face_edges=face_edges)


def _around(h: int) -> tuple[int, int, int]:
    """A half-edge, the next one of its face, and the one after that."""
    face = h - h % 3
    return h, face + (h + 1) % 3, face + (h + 2) % 3
