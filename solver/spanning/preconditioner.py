"""M, the inverse of the energy's Hessian at H = 0: L_II for u, the Douglas kernel for x, a Schur complement for q.

    S = (T_k · T_l) Λ_kl + diag(φ · γ''),   z_u = L_II⁻¹ g_u,   z_x = S⁻¹ g_x  orthogonal to the Möbius fields C.

Moduli couple to both by b_k = the form of L'_k f, and are eliminated: S_q = D_qq - bᵀ M b.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import LinAlgError, cho_factor, cho_solve

from ..linalg import Sparse
from .coordinates import Form, Step
from .rim import RimPoint

Array = NDArray[np.float64]

# Bends that make S indefinite are dropped and this part of its mean diagonal takes their place.
_SHIFT = 1e-3
# Least curvature of the energy by a modulus, as a part of its own second derivative.
_LEAST_MODULUS = 1e-2


class Preconditioner:
    """M at one surface. kernel: Λ (B, B). force: φ (B, 3) on the rim. fields: C (k, n). moduli: b_k; second: D_qq.

    walls: (n, n), sparse: second derivatives of the walls' energy by the numbers of the rim.
    """

    def __init__(
        self,
        kernel: Array,
        rim: RimPoint,
        force: Array,
        fields: Array,
        moduli: Sequence[Form],
        second: Array,
        walls: Sparse,
    ) -> None:
        self._fields = fields
        self._factor = _factored(kernel, rim, force, fields, walls)
        self._across = self._slide(fields.T) if len(fields) else np.zeros((len(rim.owner), 0))  # S⁻¹ Cᵀ
        self._gauge = np.linalg.inv(fields @ self._across) if len(fields) else np.zeros((0, 0))
        self._moduli: list[Step] = []
        self._schur = np.zeros((0, 0))
        if len(moduli):
            steps = [self._without_moduli(b) for b in moduli]
            coupling = np.array([[b(step) for step in steps] for b in moduli])
            schur = second - 0.5 * (coupling + coupling.T)
            self._schur = _positive(schur, np.diag(second))
            self._moduli = steps

    def __call__(self, form: Form) -> Step:
        """M applied to a linear form."""
        step = self._without_moduli(form)
        if self._moduli:
            rest = form.q - [_value(form, each) for each in self._moduli]
            q = np.linalg.solve(self._schur, rest)
            step = Step(step.u, step.x, q)
            for number, each in zip(q, self._moduli, strict=True):
                step = step.plus(Step(each.u, each.x, np.zeros_like(q)), -number)
        return step

    def _without_moduli(self, form: Form) -> Step:
        x = self._slide(form.x)
        if len(self._fields):
            x = x - self._across @ (self._gauge @ (self._fields @ x))
        return Step(form.lifted, x, np.zeros_like(form.q))

    def _slide(self, x: Array) -> Array:
        return cho_solve(self._factor, x, check_finite=False) if len(x) else x


def _value(form: Form, step: Step) -> float:
    """The form without its part by q."""
    return float(np.einsum("ij,ij->", form.u, step.u) + form.x @ step.x)


def _factored(kernel: Array, rim: RimPoint, force: Array, fields: Array, walls: Sparse) -> Any:  # scipy ships no types
    """Cholesky factor of S, made positive where it is not."""
    owner = rim.owner
    if not len(owner):
        return np.zeros((0, 0)), False
    matrix = kernel[np.ix_(owner, owner)] * (rim.tangents @ rim.tangents.T)
    bend = rim.bend(force)
    size = float(np.mean(np.diag(matrix)))
    matrix += walls.toarray() + size * fields.T @ fields
    for diagonal in (bend, np.maximum(bend, 0.0) + _SHIFT * size):
        try:
            return cho_factor(matrix + np.diag(diagonal), check_finite=False)
        except LinAlgError:
            continue
    values, vectors = np.linalg.eigh(matrix + np.diag(bend))
    return cho_factor((vectors * np.maximum(np.abs(values), _SHIFT * size)) @ vectors.T, check_finite=False)


def _positive(schur: Array, diagonal: Array) -> Array:
    """The matrix with its eigenvalues made positive, in the units of `diagonal`."""
    scale = np.sqrt(np.maximum(np.abs(diagonal), 1e-300))
    values, vectors = np.linalg.eigh(schur / np.outer(scale, scale))
    made: Array = np.maximum(np.abs(values), _LEAST_MODULUS)
    return (vectors * made) @ vectors.T * np.outer(scale, scale)
