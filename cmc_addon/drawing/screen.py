"""Points of the world as places on the screen. Arrays only."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Screen:
    """What a view shows. matrix (4, 4): from the world to clip space; width, height: pixels of the region."""

    matrix: Array
    width: float
    height: float

    def pixels(self, points: Array) -> Array:
        """Places (n, 2) of points (n, 3) of the world, from the lower left; nan behind the eye."""
        clip = np.column_stack([points, np.ones(len(points))]) @ self.matrix.T
        depth = np.where(clip[:, 3] > 0.0, clip[:, 3], np.nan)
        return 0.5 * (clip[:, :2] / depth[:, None] + 1.0) * [self.width, self.height]

    def pixel(self, point: Array) -> float:
        """The length in the world of a pixel at a point (3,), parallel to the screen; nan behind the eye."""
        depth = float(self.matrix[3] @ [*point, 1.0])
        across = 0.5 * self.width * float(np.linalg.norm(self.matrix[0, :3]))
        return depth / across if depth > 0.0 else np.nan


def nearest(track: Array, values: Array, mouse: Array) -> float | None:
    """The value at the place of a track, points (n, 2) with values (n,), that is nearest to the mouse (2,).

    Between two points it is interpolated. None where nothing of the track is known.
    """
    part, off = _onto(track, mouse)
    if not np.isfinite(off).any():
        return None
    best = int(np.nanargmin(off))
    return float(values[best] + part[best] * (values[best + 1] - values[best]))


def distance(track: Array, mouse: Array) -> float:
    """Pixels from the mouse (2,) to a polyline, points (n, 2); infinite where nothing of it is known."""
    off = _onto(track, mouse)[1]
    return float(np.nanmin(off)) if np.isfinite(off).any() else np.inf


def _onto(track: Array, mouse: Array) -> tuple[Array, Array]:
    """For each piece of a polyline the nearest place, as a part of it, and its distance from the mouse."""
    start, step = track[:-1], np.diff(track, axis=0)
    size = np.einsum("ij,ij->i", step, step)
    part = np.divide(np.einsum("ij,ij->i", mouse - start, step), size, out=np.zeros(len(size)), where=size > 0.0)
    part = part.clip(0.0, 1.0)
    return part, np.linalg.norm(start + part[:, None] * step - mouse, axis=1)
