"""The objective: the weighted sum of the targets as a function of boundary normals, log of the scale, and shift."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ..gauss.sphere import dot, inner, normalize, project
from ..surface.adjoint import AdjointSolver, State, boundary_shares
from .response import Response
from .target import Partials, Shape, Target

Array = NDArray[np.float64]
Int = NDArray[np.integer]

# Residual of harmonic maps and relative accuracy of gradients during the search.
_RESIDUAL = 1e-7
_ACCURACY = 1e-6


@dataclass(frozen=True, eq=False)
class Placed:
    """A state in the world: points = scale · (g + side · N) + shift. rim (n, 3): normals at all fixed vertices."""

    state: State
    rim: Array
    scale: float
    shift: Array
    shape: Shape
    value: float = np.inf


class Objective:
    """Values and gradients of the targets; the best placed state so far, and the history of values.

    The unknown normals are those at `response.free`; at the other fixed vertices they stay as `given` (n, 3). Unknown
    ones are scaled by the root of their boundary length, so that the mesh does not matter, and lie in the plane of a
    mirror where one begins. The last four numbers of the vector are the logarithm of the scale and the shift.
    """

    def __init__(
        self,
        response: Response,
        targets: Sequence[Target],
        side: float,
        size: float,
        free_scale: bool,
        free_shift: bool,
        first: Array | None,
        given: Array | None = None,
    ) -> None:
        self.response, self.targets, self.side, self.size = response, targets, side, size
        self.extension = response.extension
        self.free_scale, self.free_shift, self.first = free_scale, free_shift, first
        self.given = self.extension.prescribed if given is None else given
        self.roots = np.sqrt(boundary_shares(self.extension.domain)[response.vertices])[:, None]
        self._planes = _mirrors_at(self.extension, response.vertices)
        self.best: Placed | None = None
        self.history: list[float] = []

    def vector(self, rim: Array, scale: float, shift: Array) -> Array:
        """The vector of normals (n, 3) at all fixed vertices, a scale and a shift (3,)."""
        return np.concatenate([(self.roots * rim[self.response.free]).ravel(), [np.log(scale)], shift / self.size])

    def __call__(self, x: Array) -> tuple[float, Array]:
        placed = self.place(x)
        total = Partials.of(placed.shape)
        for target in self.targets:
            total = total + target.partials(placed.shape).times(target.weight)
        self.history.append(total.value)
        if self.best is None or total.value < self.best.value:
            self.best = replace(placed, value=total.value)
        return total.value, self.gradient(x, placed, total)

    def place(self, x: Array) -> Placed:
        rim = self.given.copy()
        rim[self.response.free] = normalize(self._flat(x[:-4].reshape(-1, 3) / self.roots))
        state = self.extension(rim, self._predicted(rim), _RESIDUAL)
        scale, shift = float(np.exp(x[-4])), x[-3:] * self.size
        points = scale * (state.g + self.side * state.N) + shift
        domain, fixed = self.extension.domain, self.extension.fixed
        shape = Shape(domain, fixed, points, state.N, self.size, scale * state.periods)
        return Placed(state, rim, scale, shift, shape)

    def _predicted(self, rim: Array) -> Array | None:
        """Normals (V, 3) to start from: the best ones, plus the change of the boundary spread over the domain."""
        if self.best is None:
            return self.first
        return self.best.state.N + self.extension.spread(rim - self.best.rim)

    def gradient(self, x: Array, placed: Placed, total: Partials) -> Array:
        """The derivatives of a function by the vector x, from its partial derivatives."""
        by_conjugate = placed.scale * total.by_points
        by_normals = total.by_normals + self.side * by_conjugate
        by_periods = placed.scale * total.by_periods
        by_rim = self.extension.pull_back(placed.state, by_normals, by_conjugate, by_periods, _ACCURACY)
        free = self.response.free
        length = np.linalg.norm(self._flat(x[:-4].reshape(-1, 3)), axis=1, keepdims=True)
        by_rim = self._flat(project(placed.rim[free], by_rim[free]) / length)
        by_scale, by_shift = 0.0, np.zeros(3)
        if self.free_scale:
            by_scale = inner(total.by_points, placed.shape.points - placed.shift)
            by_scale += inner(total.by_periods, placed.shape.periods)
        if self.free_shift:
            by_shift = self.size * total.by_points.sum(axis=0)
        return np.concatenate([by_rim.ravel(), [by_scale], by_shift])

    def _flat(self, vectors: Array) -> Array:
        """Vectors (n, 3) at the free vertices without their parts across a mirror."""
        return vectors - dot(vectors, self._planes) * self._planes


def _mirrors_at(extension: AdjointSolver, vertices: Int) -> Array:
    """(n, 3) the unit normal of the mirror that begins at each of the vertices (n,), zero where none does."""
    conditions, planes = extension.conditions, np.zeros((extension.domain.vertex_count, 3))
    for ends in extension.domain.edges[conditions.mirrors].T:
        planes[ends] = conditions.mirror_normals
    return planes[vertices]
