"""Moduli of a plan: motions that change its conformal type, p(q) = p + Σ_k q_k field_k, and derivatives of D by q.

In corners the Dirichlet energy is D = ¼ Σ_faces Σ_k cot θ_k |f_i - f_j|², i and j the corners opposite k, and in a flat
plan cot θ_k = n / d, where n + i d = ā b with the sides a, b that leave corner k, as complex numbers. Along linear
motions ā b is quadratic in q, so two derivatives are exact. ∂D/∂q = 0 is what conformality still lacks where the type
of the plan is not that of the surface: around holes, and between corners that stay.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..domain.domain import Domain
from ..linalg import sum_rows

Array = NDArray[np.float64]
Int = NDArray[np.integer]
Complex = NDArray[np.complex128]

# A face is nearly flat with this part of the area that it had.
_FLAT = 1e-3


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
        """Whether a face is turned over at q, or nearly flat: D is a difference of huge numbers there."""
        if not self.count:
            return False
        return bool((_twice_areas(self._at(q)) <= _FLAT * self._twice_areas).any())

    def moved(self, q: Array) -> Domain:
        """The domain at q; raises `MeshError` where a face is flat."""
        i, j = self.domain.edges.T
        points = self.at(q)
        return self.domain.with_lengths(np.linalg.norm(points[j] - points[i], axis=1))

    @cached_property
    def _twice_areas(self) -> Array:
        return _twice_areas(self._sides[0])

    @cached_property
    def _sides(self) -> tuple[Complex, Complex, Complex]:
        """The sides that leave each corner to the next one, of the plan (3, F) and of the fields (m, 3, F); and those
        of the fields to the one before."""
        corners = self.domain.faces.T

        def sides(points: Array) -> Complex:
            z = (points[..., 0] + 1j * points[..., 1]).take(corners, axis=-1)
            return z[..., [1, 2, 0], :] - z

        moved = sides(self.fields)
        return sides(self.positions), moved, _behind(moved)

    def _at(self, q: Array) -> Complex:
        """The sides (3, F) at q."""
        plan, moved, _ = self._sides
        return plan + np.tensordot(q, moved, 1)

    def weights(self, q: Array) -> Array:
        """(E,) the cotangent weights at q."""
        a = self._at(q)
        product = a.conj() * _behind(a)
        return self._on_edges(product.real / product.imag)

    def _quotients(self, q: Array) -> tuple[Array, Array, Complex, Array]:
        """Of each corner cot θ and d (3, F), the slopes of ā b and of cot θ (m, 3, F)."""
        a, (_, moved, moved_behind) = self._at(q), self._sides
        b = _behind(a)
        product = a.conj() * b
        cotan, d = product.real / product.imag, np.ascontiguousarray(product.imag)
        slopes = moved.conj() * b + a.conj() * moved_behind
        return cotan, d, slopes, (slopes.real - cotan * slopes.imag) / d

    def slopes(self, q: Array) -> Array:
        """(m, E) the derivatives of the weights."""
        return self.derivatives(q, np.zeros(len(self.domain.edge_lengths)))[0]

    def second(self, q: Array, squares: Array) -> Array:
        """(m, m) second derivatives of ½ Σ w_e squares_e by q, with the squared edges (E,) of the surface."""
        return self.derivatives(q, squares)[1]

    def derivatives(self, q: Array, squares: Array) -> tuple[Array, Array]:
        """`slopes` and `second` at once."""
        cotan, d, products, slopes = self._quotients(q)
        _, moved, moved_behind = self._sides
        load = 0.25 * squares.take(self._opposite) / d
        bent = _pairs(moved.conj() * (load * (1.0 + 1j * cotan)), moved_behind).real
        bent -= _pairs(slopes * load, products.imag)
        on_edges = np.array([self._on_edges(each) for each in slopes]).reshape(self.count, -1)
        return on_edges, bent + bent.T

    @cached_property
    def _opposite(self) -> Int:
        """(3, F) the edges opposite each corner."""
        return np.ascontiguousarray(self.domain.face_edges.T)

    def _on_edges(self, cotans: Array) -> Array:
        return 0.5 * sum_rows(self._opposite.ravel(), cotans.ravel(), len(self.domain.edge_lengths))


def _behind(sides: Complex) -> Complex:
    """The sides (…, 3, F) that leave each corner to the one before."""
    return -sides[..., [2, 0, 1], :]


def _pairs(a: NDArray[Any], b: NDArray[Any]) -> NDArray[Any]:
    """(m, m) sums of the products of a (m, 3, F) and b (m, 3, F)."""
    return np.asarray(a.reshape(len(a), -1) @ b.reshape(len(b), -1).T)


def _twice_areas(sides: Complex) -> Array:
    """Twice the signed areas (F,) of faces with these sides (3, F)."""
    return (sides[0].conj() * _behind(sides)[0]).imag
