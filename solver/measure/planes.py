"""How well sides of a placed sheet lie in planes, so that they can be built against a wall, a floor or a ceiling."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .summary import number, percent

Array = NDArray[np.float64]


@dataclass(frozen=True)
class PlaneReport:
    """The plane normal · x = offset of a side of a sheet, in world units, and how far the side is from it.

    kind: "mirror", where the sheet meets the plane at right angles, or "plane", where it touches it.
    error: the largest distance of its vertices from the plane. relative: as a part of the diagonal of the sheet.
    """

    name: str
    kind: str
    normal: tuple[float, float, float]
    offset: float
    error: float
    relative: float

    def line(self, unit: str = "") -> str:
        """A sentence for a person."""
        x, y, z = (f"{0.0 if abs(part) < 5e-7 else part:.4g}" for part in self.normal)
        verb = "meets" if self.kind == "mirror" else "touches"
        return (
            f'"{self.name}" {verb} the plane ({x}, {y}, {z}) · x = {number(self.offset, unit)} within '
            f"{self.error:.2g}{' ' + unit if unit else ''} ({percent(self.relative)} of the size)."
        )


def measure_plane(
    name: str, kind: str, points: Array, side: NDArray[np.integer], weights: Array, normal: Array
) -> PlaneReport:
    """How far a `side`, indices (m,) of points (n, 3), is from a plane with that unit normal; weights add to 1."""
    heights = points[side] @ normal
    offset = float(weights @ heights)
    error = float(np.abs(heights - offset).max())
    size = float(np.linalg.norm(np.ptp(points, axis=0)))
    x, y, z = (float(part) for part in normal)
    return PlaneReport(name, kind, (x, y, z), offset, error, error / size)
