"""The angle at which a leaning side of a finished surface meets the wall over its line."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..domain.domain import Domain
from ..linalg import sum_rows

Array = NDArray[np.float64]
Int = NDArray[np.integer]

# Angles are measured farther than this part of the plan's size from the ends of a side: there they run steeply.
_AWAY = 0.05
# Walls that turn by more have a corner, radians.
_CORNER = np.radians(35.0)


@dataclass(frozen=True)
class LeanCheck:
    """A leaning side, angles in radians: as asked, as measured (median) and the largest miss away from its ends; and
    its lowest and highest point over the mean height of the outer line."""

    asked: float
    measured: float
    off: float
    lowest: float
    highest: float

    @property
    def sentence(self) -> str:
        """For a person."""
        asked, measured, off = np.degrees([self.asked, self.measured, self.off])
        return (
            f"A side meets its wall at {measured:.1f}° for {asked:.1f}°, up to {off:.1f}° off away from its ends, at "
            f"heights from {self.lowest:.3g} to {self.highest:.3g}."
        )


def lean_check(domain: Domain, points: Array, normals: Array, edges: Int, angle: float, base: float) -> LeanCheck:
    """How the side of these boundary edges meets the wall over it, N · ν = cos(angle).

    points, normals (V, 3); base: the height that the side's are counted from.
    """
    pairs = domain.edges[edges]
    way = (points[pairs[:, 1]] - points[pairs[:, 0]])[:, :2]
    across = _unit(np.column_stack([way[:, 1], -way[:, 0]]))
    side, count = np.unique(pairs, return_counts=True)
    outward = sum_rows(np.searchsorted(side, pairs.T.ravel()), np.concatenate([across, across]), len(side))
    cosine = np.einsum("ij,ij->i", normals[side, :2], _unit(outward))
    off = np.arccos(np.clip(cosine, -1.0, 1.0)) - angle
    turned = np.linalg.norm(outward, axis=1) < 2.0 * np.cos(0.5 * _CORNER)
    stops = points[side[(count == 1) | turned], :2]
    gaps = np.linalg.norm(points[side, None, :2] - stops[None], axis=2).min(axis=1, initial=np.inf)
    size = float(np.linalg.norm(np.ptp(points[domain.boundary_vertices, :2], axis=0)))
    away = gaps > min(_AWAY * size, 0.5 * float(gaps.max()))
    heights = points[side, 2] - base
    return LeanCheck(
        asked=angle,
        measured=angle + float(np.median(off[away])),
        off=float(np.abs(off[away]).max()),
        lowest=float(heights.min()),
        highest=float(heights.max()),
    )


def _unit(v: Array) -> Array:
    return v / np.maximum(np.linalg.norm(v, axis=1, keepdims=True), 1e-300)
