"""The overlay of results: gaps around holes, and the measured planes of mirrors.

A report holds world coordinates at the time of the solve. Subtracting `placed_at`, the origin of the results then,
gives their own coordinates, so that the overlay follows a result that is moved.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from . import overlay_geometry as shapes
from .overlay_layers import PLANAR, Layer, Look, arrows, wall_layers
from .rim_strip import GroupState

Array = NDArray[np.float64]

# A group whose plane now differs by more, in radians, was changed after the solve.
_SAME = 1e-3
_UP = np.array([0.0, 0.0, 1.0])


def gaps(report: dict, origin: Array) -> tuple[Array, Array]:
    """Start points and vectors (n, 3) of the gaps in a report; none if the shell is closed.

    origin: (3,) of the shell, subtracted from the points.
    """
    holes = [hole for hole in report.get("holes") or () if hole["length"] > 0.0]
    if not report.get("is_open") or not holes:
        return np.zeros((0, 3)), np.zeros((0, 3))
    return np.array([hole["at"] for hole in holes]) - origin, np.array([hole["period"] for hole in holes])


def gap_layers(report: dict, origin: Array, look: Look) -> Iterator[Layer]:
    """Arrows across the gaps."""
    yield from arrows(*gaps(report, origin), look.gaps)


def measured(report: dict, groups: tuple[GroupState, ...], rotated: bool) -> list[tuple[int, Array, float]]:
    """Uid of the group, unit normal (3,) and offset of each plane in a report whose group is unchanged.

    rotated: the shell may have been turned to match its plan, and the normals with it.
    """
    planes = []
    for plane in report.get("planes") or ():
        names = (plane["name"], plane["name"].rpartition(" ")[0])
        group = next((group for group in groups if group.name in names and group.kind == plane["kind"]), None)
        if group is None or group.kind not in PLANAR:
            continue
        normal = np.array(plane["normal"], dtype=np.float64)
        wanted = np.array(dict(group.parameters).get("normal", normal), dtype=np.float64)
        if rotated or np.linalg.norm(np.cross(normal, wanted)) <= _SAME * np.linalg.norm(wanted):
            planes.append((group.uid, normal, float(plane["offset"])))
    return planes


def plane_layers(
    planes: list[tuple[int, Array, float]], points: Array, origin: Array, length: float, look: Look
) -> Iterator[Layer]:
    """Measured planes, as large as a shell whose points (n, 3) are measured from `origin` (3,)."""
    size = float(np.linalg.norm(np.ptp(points, axis=0)))
    for uid, normal, offset in planes:
        corners = shapes.wall(points, normal, _UP, 0.1 * size, offset - float(normal @ origin))
        yield from wall_layers(corners, normal, length, look.colour(uid))
