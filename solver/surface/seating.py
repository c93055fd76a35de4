"""A piece of a surface with its sides moved exactly to where they belong, so that its copies meet without a gap.

The solver brings sides into their planes up to the error of the mesh. The last bit is done here, for the rows along
the sides only: to the nearest point of the plane, at corners of both planes. It is what averaging a row with all its
images would do.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from .cmc import CmcSurface
from .sides import SidePlane

Array = NDArray[np.float64]


def seated(surface: CmcSurface, sheet: str, planes: Sequence[SidePlane]) -> Array:
    """Points (n, 3) of "f+" or "f-" whose rows along sides lie in the planes of these, or on the sphere of a free side.

    f± of a mirror lie in the plane of g, those of a tangent side in that plane moved by ± scale along the normal.
    """
    sign = {"f+": 1.0, "f-": -1.0}[sheet]
    points = surface.sheet(sheet).copy()
    on = np.zeros((len(points), len(planes)), dtype=bool)
    for k, plane in enumerate(planes):
        on[plane.rows, k] = True
    rows = np.flatnonzero(on.any(axis=1))
    patterns, which = np.unique(on[rows], axis=0, return_inverse=True)
    for k, pattern in enumerate(patterns):
        here = rows[which.ravel() == k]
        walls = [plane for plane, is_here in zip(planes, pattern, strict=True) if is_here]
        for wall in walls:
            if wall.normal is None:
                points[here] = wall.point + sign * surface.scale * surface.normals[here]
        points[here] = _projected(
            points[here], [wall for wall in walls if wall.normal is not None], sign * surface.scale
        )
    return points


def _projected(points: Array, walls: Sequence[SidePlane], height: float) -> Array:
    if not walls:
        return points
    A = np.array([wall.normal for wall in walls])
    offsets = np.array([wall.offset + (height if wall.switches else 0.0) for wall in walls])
    return points - (points @ A.T - offsets) @ np.linalg.pinv(A).T
