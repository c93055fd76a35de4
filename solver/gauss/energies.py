"""Edge energies of sphere-valued maps, as functions of c = <N_i, N_j> (paper, Sec. 4).

An energy is `Σ value(c)` over the edges; `star = -d value / dc` is also the Hodge star of the conjugate,
`tau_ij = star_ij N_i × N_j`; `dstar` is its derivative in c, which Newton's method needs. As functions of c
rather than of the bending angle α (c = cos α, star = ε'(α) / sin α) they are smooth where normals agree.
"""

from __future__ import annotations

from typing import Protocol

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


class EdgeEnergy(Protocol):
    """`c` and `weights` are (E,), as is every result."""

    label: str
    description: str

    def value(self, c: Array, weights: Array) -> Array: ...

    def star(self, c: Array, weights: Array) -> Array: ...

    def dstar(self, c: Array, weights: Array) -> Array: ...


class Cotan:
    """ε = ½ w |N_i - N_j|² = w (1 - c), with the cotangent weights w of the domain (paper, Eq. 6).

    The Dirichlet energy of the piecewise linear map; quadratic in N, so its star is constant.
    """

    label = "Cotangent"
    description = "Dirichlet energy of the piecewise linear map; the standard choice on triangle meshes"

    def value(self, c: Array, weights: Array) -> Array:
        return weights * (1.0 - c)

    def star(self, c: Array, weights: Array) -> Array:
        return weights + 0.0 * c

    def dstar(self, c: Array, weights: Array) -> Array:
        return 0.0 * weights * c


ENERGIES: dict[str, EdgeEnergy] = {"cotan": Cotan()}
