"""The Möbius gauge: changes of the rim's parametrisation that leave the surface as it is.

A disc has three conformal automorphisms more than the identity. They move the boundary angle φ by 1, cos φ and sin φ,
so the rim by these times dp/dφ: directions in which the energy is flat. Steps are taken orthogonal to them. Fields that
move a marked point (see `plan_fields`) are out: two marked points leave one field, three none.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .rim import RimPoint

Array = NDArray[np.float64]
Int = NDArray[np.integer]

# Singular values below this part of the largest are zero.
_RANK = 1e-9


def moebius_fields(rim: RimPoint, loop: Int, phi: Array, marks: Int) -> Array:
    """(k, n) orthonormal fields, k <= 3, in the rim's numbers.

    loop (m,): rim vertices along the outer loop, phi (m,) their angles; marks: places of marked points along it.
    """
    basis = angle_fields(phi, marks)
    ahead = np.roll(phi, -1)
    behind = np.roll(phi, 1)
    ahead[-1] += 2.0 * np.pi
    behind[0] -= 2.0 * np.pi
    points = rim.points[loop]
    speed = np.zeros_like(rim.points)  # dp/dφ
    speed[loop] = (np.roll(points, -1, axis=0) - np.roll(points, 1, axis=0)) / (ahead - behind)[:, None]
    fields = np.zeros((len(rim.points), basis.shape[1]))
    fields[loop] = basis
    squares = np.maximum(np.einsum("ki,ki->k", rim.tangents, rim.tangents), 1e-300)
    along = rim.pull(speed) / squares
    rows = (along[:, None] * fields[rim.owner]).T
    _, size, right = np.linalg.svd(rows, full_matrices=False)
    return right[size > _RANK * size.max(initial=0.0)]


def angle_fields(phi: Array, marks: Int) -> Array:
    """(m, k) the combinations of 1, cos φ, sin φ at the angles phi (m,) that vanish at the places `marks`."""
    basis = np.column_stack([np.ones_like(phi), np.cos(phi), np.sin(phi)])
    return basis @ _vanishing(basis[marks])


def _vanishing(values: Array) -> Array:
    """(3, k) combinations of three functions that vanish where they take the `values` (m, 3)."""
    if not len(values):
        return np.eye(3)
    _, size, right = np.linalg.svd(values, full_matrices=True)
    rank = int(np.sum(size > 1e-6 * size.max(initial=1e-300)))
    return right[rank:].T
