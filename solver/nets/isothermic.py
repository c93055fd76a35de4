"""Isothermic coordinates: w = ∫ √q dz on the cut domain, by least squares, and how it follows whole numbers.

Lines Im w = const are curvature lines of the larger principal curvature, Re w = const of the smaller one; |dw|² =
(k1 - k2) ds². The unknowns x are w at the V vertices and the jumps c of the loop paths (`CutDomain.transfer`): they
minimise Σ ½ cot |w_j - w_i - ω|² over the half-edges of all faces. Real and imaginary part have the same matrix, and so
has every change of x under conditions `B x = b`: one factor serves all.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from ..linalg import Factor, factorize, graph_laplacian, sum_rows
from .cut import CutDomain

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
Int = NDArray[np.integer]


@dataclass(frozen=True, eq=False)
class Isothermic:
    """w of a cut domain: unknowns (V + k, 2), real and imaginary part, up to a translation.

    turn: the angle, in radians, by which the lines are turned against the curvature lines; ¼ π for normal curvature H.
    """

    cut: CutDomain
    turn: float
    factor: Factor
    unknowns: Array

    @classmethod
    def of(cls, cut: CutDomain, turn: float = 0.0) -> Isothermic:
        """Integrate e^{i turn} ω."""
        omega = cut.omega * np.exp(1j * turn)
        domain, corner = cut.domain, cut.faces
        start, end = corner[:, [1, 2, 0]].ravel(), corner[:, [2, 0, 1]].ravel()
        weights = 0.5 * domain.corner_cotans.ravel()
        n = len(cut.source)
        laplacian = graph_laplacian(np.stack([start, end], axis=1), weights, n)
        flow = weights[:, None] * np.column_stack([omega.ravel().real, omega.ravel().imag])
        divergence = sum_rows(end, flow, n) - sum_rows(start, flow, n)
        A = sp.csr_array(cut.transfer.T @ laplacian @ cut.transfer)[1:, 1:]
        factor = factorize(A)
        right = (cut.transfer.T @ divergence)[1:]
        unknowns = np.vstack([np.zeros((1, 2)), factor.solve(right)])
        return cls(cut, turn, factor, unknowns)

    @cached_property
    def values(self) -> Array:
        """w (n, 2) at the cut vertices."""
        return self.cut.transfer @ self.unknowns

    @cached_property
    def omega(self) -> Complex:
        """ω (F, 3) along the half-edges, turned like the coordinates."""
        return self.cut.omega * np.exp(1j * self.turn)

    def responses(self, conditions: Array) -> Array:
        """A⁻¹ Bᵀ (V + k, m) of conditions B (m, V + k): how x gives way to a force along each."""
        if not len(conditions):
            return np.zeros((self.unknowns.shape[0], 0))
        solved = self.factor.solve(np.ascontiguousarray(conditions[:, 1:].T))
        return np.vstack([np.zeros((1, len(conditions))), solved])
