"""Moduli of a plan: motions that change its conformal type, p(q) = p + Σ_k q_k field_k, and derivatives of D by q.

In corners the Dirichlet energy is D = ¼ Σ_faces Σ_k cot θ_k |f_i - f_j|², i and j the corners opposite k, and in a flat
plan cot θ_k = <a, b> / a × b with the sides a, b that leave corner k. Along linear motions numerator and denominator
are quadratic in q, so two derivatives are exact. ∂D/∂q = 0 is what conformality still lacks where the type of the plan
is not that of the surface: around holes, and between corners that stay.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ..domain.domain import Domain
from ..linalg import sum_rows

Array = NDArray[np.float64]
Int = NDArray[np.integer]


def _sides(p: Array, faces: Int) -> tuple[Array, Array]:
    """The sides (…, F, 3, 2) that leave each corner, to the next corner and to the one before; p (…, V, 2)."""
    corner = p[..., faces, :]
    return np.roll(corner, -1, axis=-2) - corner, np.roll(corner, 1, axis=-2) - corner


def _inner(a: Array, b: Array) -> Array:
    return np.einsum("...i,...i->...", a, b)


def _cross(a: Array, b: Array) -> Array:
    return a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]


@dataclass(frozen=True, eq=False)
class Motions:
    """m motions `fields` (m, V, 2) of a flat plan with `positions` (V, 2); without any the plan stays."""

    domain: Domain
    positions: Array
    fields: Array

    @property
    def count(self) -> int:
        """m."""
        return len(self.fields)

    def at(self, q: Array) -> Array:
        """(V, 2) of the plan at q (m,)."""
        return self.positions + np.einsum("k,kvi->vi", q, self.fields)

    def turned(self, q: Array) -> bool:
        """Whether a face is flat or turned over at q."""
        if not self.count:
            return False
        a, b = _sides(self.at(q), self.domain.faces)
        return bool(_cross(a[:, 0], b[:, 0]).min(initial=np.inf) <= 0.0)

    def moved(self, q: Array) -> Domain:
        """The domain at q; raises `MeshError` where a face is flat."""
        i, j = self.domain.edges.T
        points = self.at(q)
        return self.domain.with_lengths(np.linalg.norm(points[j] - points[i], axis=1))

    @cached_property
    def _field_sides(self) -> tuple[Array, Array]:
        return _sides(self.fields, self.domain.faces)

    def _quotients(self, q: Array) -> tuple[Array, Array, Array, Array]:
        """Numerators and denominators of cot θ, (F, 3), and their slopes (m, F, 3)."""
        a, b = _sides(self.at(q), self.domain.faces)
        da, db = self._field_sides
        return _inner(a, b), _cross(a, b), _inner(da, b) + _inner(a, db), _cross(da, b) + _cross(a, db)

    def weights(self, q: Array) -> Array:
        """(E,) the cotangent weights at q."""
        a, b = _sides(self.at(q), self.domain.faces)
        return self._on_edges(_inner(a, b) / _cross(a, b))

    def slopes(self, q: Array) -> Array:
        """(m, E) the derivatives of the weights."""
        n, d, dn, dd = self._quotients(q)
        return np.array([self._on_edges(each) for each in (dn - n / d * dd) / d]).reshape(self.count, -1)

    def _on_edges(self, cotans: Array) -> Array:
        edges = self.domain.face_edges
        return 0.5 * sum_rows(edges.ravel(), cotans.ravel(), len(self.domain.edge_lengths))

    def second(self, q: Array, squares: Array) -> Array:
        """(m, m) second derivatives of ½ Σ w_e squares_e by q, with the squared edges (E,) of the surface."""
        n, d, dn, dd = self._quotients(q)
        da, db = self._field_sides
        load = 0.25 * squares[self.domain.face_edges]
        cotan, slope = n / d, (dn - n / d * dd) / d
        result = np.empty((self.count, self.count))
        for k in range(self.count):
            for m in range(k + 1):
                ddn = _inner(da[k], db[m]) + _inner(da[m], db[k])
                ddd = _cross(da[k], db[m]) + _cross(da[m], db[k])
                bent = (ddn - cotan * ddd - slope[k] * dd[m] - slope[m] * dd[k]) / d
                result[k, m] = result[m, k] = float(np.einsum("ij,ij->", bent, load))
        return result
