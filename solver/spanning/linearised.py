"""First and second derivatives of D - 2H V + Σ cos t · W at one surface, in the coordinates (u, x, q)."""

from __future__ import annotations

from copy import copy
from dataclasses import replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from .coordinates import Form, Step
from .douglas import angles
from .gauge import moebius_fields
from .preconditioner import Preconditioner
from .problem import SpanProblem, State

Array = NDArray[np.float64]


class Linearised:
    """First and second derivatives at one state.

    dirichlet, volume: the forms of D and V. H: the multiplier that brings D' - 2H V' nearest to zero, or the given one.
    precondition: of a state nearby, or made for this one.
    """

    def __init__(
        self,
        problem: SpanProblem,
        state: State,
        mean_curvature: float | None,
        precondition: Preconditioner | None = None,
    ) -> None:
        self.problem, self.state = problem, state
        self.rim = state.rim
        self.second = problem.volume.second(state.f)
        self._slopes, self._second_moduli = self._by_moduli_twice()
        self.dirichlet, self._by_dirichlet = self._dirichlet_form()
        self.volume, self._by_volume = self.pull(self.second.gradient())
        self._pulled = [self.pull(force)[0] for force in self._slopes]
        self._choose(mean_curvature, precondition)

    def _choose(self, mean_curvature: float | None, precondition: Preconditioner | None) -> None:
        H = self._inner_multiplier() if mean_curvature is None else mean_curvature
        self.force = self._by_dirichlet - 2.0 * H * self._by_volume
        self.precondition = precondition or self._preconditioner()
        self.H = 0.5 * self.dirichlet(self.along) / self.gain if mean_curvature is None else mean_curvature

    def chosen(self, mean_curvature: float | None, precondition: Preconditioner | None) -> Linearised:
        """The same state with another H; a preconditioner is made for it if none is given."""
        other = copy(self)
        for name in ("along", "gain", "gradient"):
            vars(other).pop(name, None)
        other._choose(mean_curvature, precondition)
        return other

    def _preconditioner(self) -> Preconditioner:
        return Preconditioner(
            self.problem.kernel,
            self.rim,
            self.force,
            self._fields(),
            self._pulled,
            self._second_moduli,
            walls=self.problem.walls.second,
        )

    @cached_property
    def along(self) -> Step:
        """M V', the way to more volume."""
        return self.precondition(self.volume)

    @cached_property
    def gain(self) -> float:
        """<V', M V'>."""
        return self.volume(self.along)

    def laplacian(self, f: Array) -> Array:
        """L(q) f (V, 3)."""
        if not self.problem.motions.count:
            return np.asarray(self.problem.domain.laplacian @ f)
        along = self.problem.differences
        return np.asarray(along.T @ (self.state.weights[:, None] * (along @ f)))

    def _by_moduli_twice(self) -> tuple[list[Array], Array]:
        """L'_k f (V, 3) for each modulus, and the second derivatives (m, m) of D by them."""
        motions = self.problem.motions
        if not motions.count:
            return [], np.zeros((0, 0))
        along = self.problem.differences
        d = along @ self.state.f
        slopes, second = motions.derivatives(self.state.q, np.einsum("ij,ij->i", d, d))
        return [along.T @ (slope[:, None] * d) for slope in slopes], second

    def _dirichlet_form(self) -> tuple[Form, Array]:
        """The form of D and the walls. On the plan of the coordinates L_II⁻¹ (L f)_I is u itself."""
        forces = self.laplacian(self.state.f)
        by_q = np.array([0.5 * np.einsum("ij,ij->", self.state.f, each) for each in self._slopes])
        known = None if self.state.q.any() else self.state.u
        form, on_rim = self.pull(forces, by_q, known)
        return replace(form, x=form.x + self.problem.walls.gradient(self.state.x)), on_rim

    def _inner_multiplier(self) -> float:
        """H from the inside alone."""
        w = self.volume.lifted
        return 0.5 * float(np.einsum("ij,ij->", self.dirichlet.u, w) / np.einsum("ij,ij->", self.volume.u, w))

    def _fields(self) -> Array:
        problem = self.problem
        if not problem.has_gauge:
            return np.zeros((0, len(self.rim.owner)))
        return moebius_fields(self.rim, problem.loops[0], angles(problem.omegas[0]), problem.marks[0])

    def pull(self, forces: Array, by_q: Array | None = None, lifted: Array | None = None) -> tuple[Form, Array]:
        """The form of forces (V, 3), and the force φ (B, 3) on the rim. One back-solve, if `lifted` is not known."""
        coordinates = self.problem.coordinates
        if lifted is None:
            lifted = coordinates.lift(forces)
        on_rim = coordinates.on_rim(forces, lifted)
        by_q = np.zeros(len(self.state.q)) if by_q is None else by_q
        return Form(forces[coordinates.inside], lifted, self.rim.pull(on_rim), by_q), on_rim

    def push(self, step: Step) -> Array:
        """df (V, 3) = du + E T dx. One back-solve."""
        df = self.problem.coordinates.extend(self.rim.push(step.x))
        df[self.problem.coordinates.inside] += step.u
        return df

    @cached_property
    def gradient(self) -> Form:
        """D' - 2H V'."""
        return self.dirichlet.plus(self.volume, -2.0 * self.H)

    def hessian(self, step: Step, df: Array) -> Form:
        """(D - 2H V)'' applied to a step that moves the surface by df. One back-solve."""
        forces = self.laplacian(df) - 2.0 * self.H * self.second(df)
        for number, slope in zip(step.q, self._slopes, strict=True):
            forces += number * slope
        form, _ = self.pull(forces, self._by_moduli(step))
        walls = self.problem.walls.second @ step.x
        return replace(form, x=form.x + walls + self.rim.bend(self.force) * step.x)

    def _by_moduli(self, step: Step) -> Array:
        plain = Step(step.u, step.x, np.zeros_like(step.q))
        return np.array([b(plain) for b in self._pulled]) + self._second_moduli @ step.q

