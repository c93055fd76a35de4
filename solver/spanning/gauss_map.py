"""The Gauss map of a spanning surface: along its lines from the flux, inside harmonic; made when it is asked for."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..domain.domain import Domain
from ..gauss.boundary_data import Conditions
from ..gauss.conditions import fixed_at, mirror
from ..gauss.sphere import normalize
from .descent import Descent
from .normals import changed_normals, rim_normals, start_normals

Array = NDArray[np.float64]
Mirrors = Sequence[tuple[ArrayLike, ArrayLike]]


@dataclass(frozen=True, eq=False)
class GaussMap:
    """Unit normals N on the surface that a descent has reached.

    mirrors: sides in planes that it meets at right angles. near: points and normals (V, 3) of an earlier surface with
    the same vertices, from whose normals the harmonic map starts.
    """

    descent: Descent
    mirrors: Mirrors
    near: tuple[Array, Array] | None = None

    @cached_property
    def domain(self) -> Domain:
        """The plan of the search, as its moduli have moved it."""
        problem, q = self.descent.problem, self.descent.state.q
        return problem.motions.moved(q) if q.any() else problem.domain

    @cached_property
    def _rim(self) -> Array:
        """N (B, 3) along lines and leans, and mirrored where they end at mirrors; other rows mean nothing."""
        problem, state = self.descent.problem, self.descent.state
        rim, H = problem.coordinates.rim, self.descent.mean_curvature
        N, tangents = np.zeros((len(rim), 3)), problem.rim.tangents(state.x)
        for loop, marks in zip(problem.loops, problem.marks, strict=True):
            N[loop] = rim_normals(self.domain, state.f, H, rim[loop], tangents[loop], marks, self._given[loop])
        for across in self._across:
            n, ends = across.mirror_normals[0], self._given & np.isin(rim, self.domain.edges[across.mirrors])
            N[ends] = normalize(N[ends] - np.outer(N[ends] @ n, n))
        return N

    @property
    def _given(self) -> NDArray[np.bool_]:
        """(B,) whether N is given at a vertex of the rim."""
        rim = self.descent.problem.rim
        return rim.on_line | rim.leaning

    @cached_property
    def _across(self) -> list[Conditions]:
        return [mirror(self.domain, edges, normal) for edges, normal in self.mirrors]

    @cached_property
    def conditions(self) -> Conditions:
        """N along lines and leans, and the mirrors."""
        found = sum(self._across, Conditions(up=np.array([0.0, 0.0, 1.0])))
        given = self._given
        if not given.any():
            return found
        return found + fixed_at(self.domain, self.descent.problem.coordinates.rim[given], self._rim[given])

    @cached_property
    def normals(self) -> Array:
        """N (V, 3), on the side from which the faces run counter-clockwise."""
        problem, f, given = self.descent.problem, self.descent.state.f, self._given
        start = start_normals(self.domain, f, problem.coordinates.rim[given], self._rim[given])
        if self.near is not None and len(self.near[0]) == len(start):
            points, normals = self.near
            start = changed_normals(start, self.domain, points, normals)
        solver = problem.solver if self.domain is problem.domain else problem.solver.moved(self.domain)
        return solver.solve(self.conditions, initial=start).normals
