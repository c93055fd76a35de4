"""Coordinates in which a fitted shell stands upright, whatever the orientation of its plan."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...solver.fitting.fit import Fit
from ...solver.surface.placement import Similarity

Array = NDArray[np.float64]

# Below this cosine between its normal and the vertical, a plan is a wall, not a floor.
_STEEP = 0.1


@dataclass(frozen=True, eq=False)
class Frame:
    """Coordinates in which a fit stands upright: local = linear (x - origin), linear (3, 3) orthogonal."""

    origin: Array
    linear: Array

    @classmethod
    def over(cls, positions: Array, triangles: NDArray, hanging: bool) -> Frame:
        """Heights along the vertical, downwards where the faces look down, or along the normal of a steep plan.

        A hanging shell is a standing one in a mirror.
        """
        a, b, c = (positions[triangles[:, k]] for k in range(3))
        vector = np.cross(b - a, c - a).sum(axis=0)
        normal = vector / (np.linalg.norm(vector) or 1.0)
        up = np.array([0.0, 0.0, -1.0 if normal[2] < 0 else 1.0])
        if abs(normal[2]) < _STEEP and normal.any():
            up = normal
        start = np.eye(3)[0 if abs(up[0]) < 0.9 else 1]
        first = start - (start @ up) * up
        first /= np.linalg.norm(first)
        linear = np.array([first, np.cross(up, first), -up if hanging else up])
        return cls(positions.mean(axis=0), linear)

    def inside(self, points: Array) -> Array:
        return (points - self.origin) @ self.linear.T

    def outside(self, points: Array) -> Array:
        return points @ self.linear + self.origin

    def placing(self, fit: Fit) -> Similarity:
        """The map from the points of a fit in this frame to the world."""
        return Similarity(1.0, fit.sign * self.linear.T, self.origin + fit.shift @ self.linear)

    @property
    def up(self) -> Array:
        return np.array([0.0, 0.0, 1.0]) if abs(self.linear[2, 2]) > 0.5 else self.linear[2]
