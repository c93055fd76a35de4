"""Targets of sides that end at walls: leaning against an upright one over their line, or mirrored in a plane."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..surface.adjoint import boundary_shares
from .target import Curvature, Partials, Shape, Target
from .targets import diagonal

Array = NDArray[np.float64]
Int = NDArray[np.integer]


@dataclass(frozen=True, eq=False)
class ContactAngle(Target):
    """½ ∮ (N · ν - cos t)² along a side, the boundary having length one.

    vertices (n,), outward (n, 3): the level normals ν of the wall there, out of the plan. angle: t in radians, 0
    upright. side: -1 for f-, whose normals are -N.
    """

    vertices: Int
    outward: Array
    angle: float
    side: float = 1.0
    label = "contact angle"

    def partials(self, shape: Shape) -> Partials:
        shares = boundary_shares(shape.domain)[self.vertices]
        miss = self.side * self._cosines(shape) - np.cos(self.angle)
        by_normals = np.zeros_like(shape.normals)
        by_normals[self.vertices] = (self.side * shares * miss)[:, None] * self.outward
        return Partials.of(shape, 0.5 * float(np.sum(shares * miss**2)), by_normals=by_normals)

    def curvature(self, shape: Shape) -> Curvature:
        """Each component alone, as much as all of them."""
        shares = np.zeros(len(shape.normals))
        shares[self.vertices] = boundary_shares(shape.domain)[self.vertices]
        return Curvature(stiffness=diagonal(shares))

    def distances(self, shape: Shape) -> Array:
        """(n,) radians between the angle at each vertex and the wanted one."""
        return np.abs(np.arccos(np.clip(self.side * self._cosines(shape), -1.0, 1.0)) - self.angle)

    def distance(self, shape: Shape) -> float:
        """The largest of them."""
        return float(self.distances(shape).max(initial=0.0))

    def _cosines(self, shape: Shape) -> Array:
        return np.einsum("ij,ij->i", shape.normals[self.vertices], self.outward)


@dataclass(frozen=True, eq=False)
class InPlane(Target):
    """½ ∮ <x - p, n>² along a side over the size squared, the boundary having length one: a mirror stays in its plane.

    vertices (k,); place p (3,) and unit normal n (3,) of the plane.
    """

    vertices: Int
    place: Array
    normal: Array
    label = "mirror plane"

    def partials(self, shape: Shape) -> Partials:
        weights = boundary_shares(shape.domain)[self.vertices] / shape.size**2
        miss = self._misses(shape)
        by_points = np.zeros_like(shape.points)
        by_points[self.vertices] = (weights * miss)[:, None] * self.normal
        return Partials.of(shape, 0.5 * float(np.sum(weights * miss**2)), by_points)

    def curvature(self, shape: Shape) -> Curvature:
        weights = boundary_shares(shape.domain)[self.vertices] / shape.size**2
        return Curvature(self.vertices, weights[:, None, None] * np.outer(self.normal, self.normal))

    def distance(self, shape: Shape) -> float:
        return float(np.abs(self._misses(shape)).max())

    def _misses(self, shape: Shape) -> Array:
        return (shape.points[self.vertices] - self.place) @ self.normal
