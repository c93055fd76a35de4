"""The volume of the cone over a surface, V(f) = 1/6 Σ_faces det(f_a, f_b, f_c), with two derivatives.

V is a cubic form: V' = ½ V''(f) f and V = ⅓ <V', f>. Seen from vertex i its derivative is 1/6 Σ f_b × f_c over the
faces (i, b, c); so an edge i → j with the faces (i, j, l) on its left and (j, i, r) on its right contributes to V''

    (V'' d)_i += d_j × (f_l - f_r) / 6,    (V'' d)_j -= d_i × (f_l - f_r) / 6,

and on the boundary f_r = 0, the tip of the cone. A vertex that slides along the boundary curve changes V at second
order in the edge length only: the volume between two surfaces through one curve does not depend on the tip.
"""

from __future__ import annotations

from collections.abc import Sequence
from copy import copy
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from ..domain.domain import Domain
from ..linalg import sum_rows
from .walls import RimVolume

Array = NDArray[np.float64]
Int = NDArray[np.integer]

# From the values of a cubic at -1, 0, 1, 2 to its coefficients, the constant one first.
_CUBIC = np.array([[0.0, 6.0, 0.0, 0.0], [-2.0, -3.0, 6.0, -1.0], [3.0, -6.0, 3.0, 0.0], [-1.0, 3.0, -3.0, 1.0]]) / 6.0


@dataclass(frozen=True, eq=False)
class SecondDerivative:
    """d ↦ V'' d at one surface: `out_i = Σ_j d_j × a_ij`, the components of a one below the other (3V, V)."""

    f: Array
    a: sp.csr_array
    rim: Sequence[RimVolume]

    def __call__(self, d: Array) -> Array:
        """V'' d (V, 3)."""
        return self._cone(d) + sum(_gathered(part, self.f, d) for part in self.rim)

    def gradient(self) -> Array:
        """V' (V, 3): of a form of degree k, V'' f / (k - 1)."""
        f = self.f
        return 0.5 * self._cone(f) + sum(_gathered(part, f, f) / (part.degree - 1) for part in self.rim)

    def _cone(self, d: Array) -> Array:
        by_x, by_y, by_z = (self.a @ d).reshape(3, -1, 3)
        out = np.empty_like(d)
        np.subtract(by_z[:, 1], by_y[:, 2], out=out[:, 0])
        np.subtract(by_x[:, 2], by_z[:, 0], out=out[:, 1])
        np.subtract(by_y[:, 0], by_x[:, 1], out=out[:, 2])
        return out


def _gathered(part: RimVolume, f: Array, d: Array) -> Array:
    """The second derivative (V, 3) of a part of the volume, applied to d."""
    return sum_rows(part.pairs.T.ravel(), np.concatenate(part.second(f, d)), len(f))


class Volume:
    """V of surfaces over the faces of one domain; the pattern of V'' is made once. rim: parts over walls and planes."""

    def __init__(self, domain: Domain, rim: Sequence[RimVolume] = ()) -> None:
        self._corners = np.ascontiguousarray(domain.faces.T)
        self.rim = tuple(rim)
        count = domain.vertex_count
        corners = np.append(domain.faces.ravel(), count)  # place -1, beyond the boundary, is the tip
        i, j = domain.edges.T
        left, right = corners[domain.half_edges].T
        rows, columns = np.concatenate([i, j]), np.concatenate([j, i])
        order = np.argsort(rows, kind="stable")
        self._ahead = np.concatenate([left, right])[order]
        self._behind = np.concatenate([right, left])[order]
        ends = np.cumsum(np.tile(np.bincount(rows, minlength=count), 3))
        starts, columns = np.concatenate([[0], ends]), np.tile(columns[order], 3)
        self._pattern = sp.csr_array((np.zeros(len(columns)), columns, starts), shape=(3 * count, count))

    def with_rim(self, rim: Sequence[RimVolume]) -> Volume:
        """The same with other parts over walls and planes."""
        other = copy(self)
        other.rim = tuple(rim)
        return other

    def of(self, f: Array) -> float:
        """V(f), f (V, 3)."""
        return self._cone(f) + sum(part.of(f) for part in self.rim)

    def _cone(self, f: Array) -> float:
        a, b, c = np.ascontiguousarray(f.T).take(self._corners, axis=1).transpose(1, 0, 2)  # each (3, F)
        across = [a[k - 2] * b[k - 1] - a[k - 1] * b[k - 2] for k in range(3)]
        return sum(float(normal @ c[k]) for k, normal in enumerate(across)) / 6.0

    def second(self, f: Array) -> SecondDerivative:
        """V'' at f (V, 3)."""
        tipped = np.zeros((3, len(f) + 1))
        np.multiply(f.T, 1.0 / 6.0, out=tipped[:, :-1])
        a = copy(self._pattern)
        a.data = (tipped.take(self._ahead, axis=1) - tipped.take(self._behind, axis=1)).ravel()
        return SecondDerivative(f, a, self.rim)

    def first(self, f: Array) -> Array:
        """V' (V, 3) at f: a third of the area vectors around each vertex, up to terms of the tip on the boundary."""
        return self.second(f).gradient()

    def along(self, f: Array, d: Array) -> Array:
        """Coefficients (4,) of the cubic t ↦ V(f + t d), the constant one first."""
        scale = float(np.abs(f).max()) / max(float(np.abs(d).max()), 1e-300)  # so that four values say all
        values = np.array([self.of(f + t * scale * d) for t in (-1.0, 0.0, 1.0, 2.0)])
        return _CUBIC @ values / scale ** np.arange(4.0)
