"""Balanced maps: the centre of mass of the normals, weighted with their Dirichlet energy, vanishes.

∫ N μ = 0 with μ = <dN ∧ *dN> (paper, Sec. 5.3.4 and Theorem E.1); discretely Σ N_i μ_i = 0 with μ_i = <(LN)_i, N_i>
(Theorem E.2). At a critical map (LN)_i = μ_i N_i wherever nothing holds N, so that the sum is that of LN, which is zero
on a closed domain; along a boundary it is the flux out of it.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .problem import EnergyProblem
from .sphere import dot

Array = NDArray[np.float64]


def imbalance(problem: EnergyProblem, N: Array) -> Array:
    """Σ N_i μ_i (3,) of a map N (S, 3), as a part of its energy; zero at critical maps of closed domains."""
    point = problem.at(N)
    density = dot(N, point.gradient)
    return np.asarray((density * N).sum(axis=0) / max(point.energy, 1e-300))
