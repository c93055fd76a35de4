"""Douglas' kernel: the Dirichlet-to-Neumann map of a plan, from one harmonic measure.

For a disc whose boundary is measured by the angle φ the harmonic extension of p(φ) has the energy (Douglas 1931)

    D = 1/(4π) ∬ |p(φ) - p(ψ)|² / (4 sin² ½ (φ - ψ)) dφ dψ,

so Λ_ij = -ω_i ω_j / (4π sin² ½ (φ_i - φ_j)) with zero row sums. On another plan φ is 2π times the harmonic measure seen
from an inner point: two back-solves instead of one for each boundary vertex. The spectrum of the exact Λ against this
one lies between 1.0 and 1.7 on discs, rectangles 3 : 1 and L-shapes of 2k and 8k vertices. With holes every loop counts
as its own disc, tied to the others by ωωᵀ/2π, and ω are shares of its length.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ..gauss.dirichlet import Dirichlet

Array = NDArray[np.float64]
Int = NDArray[np.integer]

# The least angle of a rim vertex as a part of the mean one: harmonic measure nearly vanishes at corners, and edges that
# are not Delaunay may leave it below zero.
_LEAST = 1e-3


def rim_angles(dirichlet: Dirichlet, areas: Array, loops: Sequence[Int], lengths: Sequence[Array]) -> list[Array]:
    """ω of the vertices of each loop, 2π a loop. loops: places in `dirichlet.fixed`; lengths: at each vertex."""
    if len(loops) > 1:
        return [2.0 * np.pi * each / each.sum() for each in lengths]
    deepest = int(np.argmax(dirichlet.factor.solve(areas[dirichlet.unknown])))
    source = np.zeros(len(dirichlet.unknown))
    source[deepest] = 1.0
    measure = -(dirichlet.coupling.T @ dirichlet.factor.solve(source))[loops[0]]
    omega = np.maximum(measure, _LEAST * measure.mean())
    return [2.0 * np.pi * omega / omega.sum()]


def angles(omega: Array) -> Array:
    """φ (k,) in the middle of the angles ω (k,) of a loop."""
    return np.cumsum(omega) - 0.5 * omega


def douglas_kernel(omegas: Sequence[Array], loops: Sequence[Int], count: int) -> Array:
    """Λ (count, count) of rim vertices, positive semidefinite; loops: places among them."""
    kernel = np.zeros((count, count))
    for omega, loop in zip(omegas, loops, strict=True):
        phi = angles(omega)
        sine = np.sin(0.5 * (phi[:, None] - phi[None, :]))
        np.fill_diagonal(sine, 1.0)
        block = -omega[:, None] * omega[None, :] / (4.0 * np.pi * sine**2)
        np.fill_diagonal(block, 0.0)
        np.fill_diagonal(block, -block.sum(axis=1))
        if len(loops) > 1:
            block += np.outer(omega, omega) / (2.0 * np.pi)
        kernel[np.ix_(loop, loop)] = block
    return kernel
