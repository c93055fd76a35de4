"""The unknowns (u, x, q) of a spanning surface, and linear forms on them.

    f = u + E p(x),   u = 0 on the rim,   E = harmonic extension.

u (I, 3) lives at the inner vertices, x (n,) are the numbers of the rim, q (m,) the moduli of the plan. A slide of the
rim moves the inside along; in these variables the energy of a minimal surface decouples, and its Hessian is L ⊗ 1 for u
and Tᵀ Λ T plus bends for x (Λ the Dirichlet-to-Neumann map). A force G (V, 3) on the vertices is the form

    G_u = G_I,   G_x = Tᵀ (G_B + Eᵀ G_I) = Tᵀ φ,   φ = G_B - L_BI w,   w = L_II⁻¹ G_I,

so one back-solve gives both φ and w, which is G_u as the preconditioner wants it. E and L_II belong to the plan at
q = 0.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..gauss.dirichlet import Dirichlet

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Step:
    """A change of u (I, 3), x (n,) and q (m,)."""

    u: Array
    x: Array
    q: Array

    def plus(self, other: Step, factor: float = 1.0) -> Step:
        """self + factor · other."""
        return Step(self.u + factor * other.u, self.x + factor * other.x, self.q + factor * other.q)

    def times(self, factor: float) -> Step:
        return Step(factor * self.u, factor * self.x, factor * self.q)


@dataclass(frozen=True, eq=False)
class Form:
    """A linear form: its components by u (I, 3), x (n,) and q (m,), and `lifted` = L_II⁻¹ of the first."""

    u: Array
    lifted: Array
    x: Array
    q: Array

    def plus(self, other: Form, factor: float = 1.0) -> Form:
        """self + factor · other."""
        return Form(
            self.u + factor * other.u,
            self.lifted + factor * other.lifted,
            self.x + factor * other.x,
            self.q + factor * other.q,
        )

    def __call__(self, step: Step) -> float:
        """The value on a step."""
        inner = np.einsum("ij,ij->", self.u, step.u)
        return float(inner + np.einsum("i,i->", self.x, step.x) + np.einsum("i,i->", self.q, step.q))


class Coordinates:
    """Harmonic extension and its transpose on one domain; counts the back-solves of three columns."""

    def __init__(self, dirichlet: Dirichlet) -> None:
        self.dirichlet = dirichlet
        self.inside, self.rim = dirichlet.unknown, dirichlet.fixed
        self._back = dirichlet.coupling.T.tocsr()
        self.solves = 0

    def lift(self, forces: Array) -> Array:
        """L_II⁻¹ of the inner rows of forces (V, 3)."""
        self.solves += 1
        return self.dirichlet.factor.solve(forces[self.inside])

    def extend(self, rim: Array) -> Array:
        """E applied to places or changes (B, 3) of the rim: (V, 3)."""
        self.solves += 1
        full = np.empty((len(self.inside) + len(self.rim), 3))
        full[self.rim] = rim
        full[self.inside] = -self.dirichlet.factor.solve(self.dirichlet.coupling @ rim)
        return full

    def on_rim(self, forces: Array, lifted: Array) -> Array:
        """φ (B, 3), the force on the rim with that of the inside carried to it."""
        return forces[self.rim] - self._back @ lifted
