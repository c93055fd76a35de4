"""The crown of a shell, and what its height says about the number that sizes it. Arrays only.

Over a circle of radius a, a cap of height h has H = 2 h / (a² + h²) and the volume π h (3 a² + h²) / 6. Other plans
follow the same laws nearly, from the number and the height that they have: enough to drag by.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from ...solver.surface.placement import FREE_SIZES, RISES, SPANNED_SIZES

Array = NDArray[np.float64]

# Vertices this part as far from the rim as the farthest one may be the crown of a shell on lines.
_INSIDE = 0.6
# Heights below this part of the plan's half extent are none.
_FLAT = 1e-3
# A shell with a free rim is not dragged lower than this part of its height.
_LOWEST = 0.05


@dataclass(frozen=True, eq=False)
class Crown:
    """The place that is dragged, and what it is measured by.

    at (3,): the crown. height: over the mean height of the outer line, negative where the shell hangs; of a shell with
    a free rim from its lowest to its highest point. half: half the smaller extent of the outer line.
    """

    at: Array
    height: float
    half: float
    is_spanned: bool


def crown_of(points: Array, rim: Array, outer: Array, is_spanned: bool) -> Crown | None:
    """The crown of a shell with these points (n, 3) over a plan with these rim points (k, 3); None without an extent.

    outer (m, 2, 3): ends of the edges of its outer line.
    On lines: the point farthest from the height of the rim, well inside, and in the middle where all is flat.
    """
    half = 0.5 * float(np.ptp(outer[..., :2], axis=(0, 1)).min()) if len(outer) else 0.0
    known = points[np.isfinite(points).all(axis=1)]
    if not half > 0.0 or not len(known):
        return None
    if not is_spanned:
        return Crown(known[known[:, 2].argmax()], float(np.ptp(known[:, 2])), half, False)
    base = float(np.average(outer[..., 2].mean(axis=1), weights=np.linalg.norm(outer[:, 1] - outer[:, 0], axis=1)))
    depth = cKDTree(rim[:, :2]).query(known[:, :2])[0]
    inside = known[depth >= _INSIDE * depth.max()]
    heights = inside[:, 2] - base
    if np.abs(heights).max() > _FLAT * half:
        best = int(np.abs(heights).argmax())
        return Crown(inside[best], float(heights[best]), half, True)
    return Crown(known[depth.argmax()], 0.0, half, True)


def number_at(crown: Crown, size: str, number: float, moved: float, flip: bool = False) -> tuple[str, float]:
    """The size, as the solver names it, and its number with the crown `moved` up; number: the present one.

    "match_plan", which has no number, becomes "rise", and so does a size that this shell cannot have.
    """
    known = SPANNED_SIZES if crown.is_spanned else FREE_SIZES
    if size == "match_plan" or size not in known:
        size, number = "rise", (-1.0 if flip and crown.is_spanned else 1.0) * crown.height / crown.half
    if crown.is_spanned:
        sign = -1.0 if flip else 1.0
        number = _on_lines(size, number, sign * crown.height, sign * moved, crown.half)
    else:
        number = _scaled(size, number, crown.height, moved)
    return size, float(np.clip(number, RISES.least, RISES.most)) if size == "rise" else number


def _on_lines(size: str, number: float, height: float, moved: float, half: float) -> float:
    if size == "rise":
        return number + moved / half
    if size == "height":
        return number + moved
    law = {"volume": _cap_volume, "mean_curvature": _cap_curvature}[size]
    now, wanted = law(height, half), law(height + moved, half)
    same = abs(height) > _FLAT * half and number * height > 0.0
    return number / now * wanted if same else number + wanted - now


def _cap_volume(height: float, radius: float) -> float:
    return np.pi * height * (3.0 * radius**2 + height**2) / 6.0


def _cap_curvature(height: float, radius: float) -> float:
    """Of a half sphere where the height is more than its radius: H has a largest value."""
    height = float(np.clip(height, -radius, radius))
    return 2.0 * height / (radius**2 + height**2)


def _scaled(size: str, number: float, height: float, moved: float) -> float:
    """A shell with a free rim grows as a whole."""
    if not height > 0.0:
        return number
    factor = max(1.0 + moved / height, _LOWEST)
    return number / factor if size == "mean_curvature" else number * factor
