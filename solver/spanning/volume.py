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


@dataclass(frozen=True, eq=False)
class SecondDerivative:
    """d ↦ V'' d at one surface: `out_i = Σ_j d_j × a_ij`, the components of a in three (V, V) matrices."""

    f: Array
    x: sp.csr_array
    y: sp.csr_array
    z: sp.csr_array
    rim: Sequence[RimVolume]

    def __call__(self, d: Array) -> Array:
        """V'' d (V, 3)."""
        return self._cone(d) + sum(_gathered(part, self.f, d) for part in self.rim)

    def gradient(self) -> Array:
        """V' (V, 3): of a form of degree k, V'' f / (k - 1)."""
        f = self.f
        return 0.5 * self._cone(f) + sum(_gathered(part, f, f) / (part.degree - 1) for part in self.rim)

    def _cone(self, d: Array) -> Array:
        by_x, by_y, by_z = self.x @ d, self.y @ d, self.z @ d
        return np.column_stack([by_z[:, 1] - by_y[:, 2], by_x[:, 2] - by_z[:, 0], by_y[:, 0] - by_x[:, 1]])


def _gathered(part: RimVolume, f: Array, d: Array) -> Array:
    """The second derivative (V, 3) of a part of the volume, applied to d."""
    return sum_rows(part.pairs.T.ravel(), np.concatenate(part.second(f, d)), len(f))


class Volume:
    """V of surfaces over the faces of one domain; the pattern of V'' is made once. rim: parts over walls and planes."""

    def __init__(self, domain: Domain, rim: Sequence[RimVolume] = ()) -> None:
        self.faces = domain.faces
        self.rim = tuple(rim)
        count = domain.vertex_count
        corners = np.append(domain.faces.ravel(), count)  # place -1, beyond the boundary, is the tip
        i, j = domain.edges.T
        left, right = corners[domain.half_edges].T
        rows, cols = np.concatenate([i, j]), np.concatenate([j, i])
        order = np.lexsort((cols, rows))
        self._ahead = np.concatenate([left, right])[order]
        self._behind = np.concatenate([right, left])[order]
        self._columns = cols[order].astype(np.int32)
        self._starts = np.concatenate([[0], np.cumsum(np.bincount(rows, minlength=count))]).astype(np.int32)
        self._shape = (count, count)

    def with_rim(self, rim: Sequence[RimVolume]) -> Volume:
        """The same with other parts over walls and planes."""
        other = copy(self)
        other.rim = tuple(rim)
        return other

    def of(self, f: Array) -> float:
        """V(f), f (V, 3)."""
        return self._cone(f) + sum(part.of(f) for part in self.rim)

    def _cone(self, f: Array) -> float:
        a, b, c = (f[self.faces[:, k]] for k in range(3))
        return float(np.einsum("ij,ij->", a, np.cross(b, c))) / 6.0

    def second(self, f: Array) -> SecondDerivative:
        """V'' at f (V, 3)."""
        tipped = np.concatenate([f, np.zeros((1, 3))])
        a = ((tipped[self._ahead] - tipped[self._behind]) / 6.0).T.copy()
        x, y, z = (sp.csr_array((row, self._columns, self._starts), shape=self._shape) for row in a)
        return SecondDerivative(f, x, y, z, self.rim)

    def first(self, f: Array) -> Array:
        """V' (V, 3) at f: a third of the area vectors around each vertex, up to terms of the tip on the boundary."""
        return self.second(f).gradient()

    def along(self, f: Array, d: Array) -> Array:
        """Coefficients (4,) of the cubic t ↦ V(f + t d), the constant one first."""
        second = self.second(f)
        first = np.einsum("ij,ij->", second.gradient(), d)
        cubic = self._cone(d) + sum(part.of(d) for part in self.rim if part.degree == 3)
        return np.array([self.of(f), first, 0.5 * np.einsum("ij,ij->", second(d), d), cubic])
