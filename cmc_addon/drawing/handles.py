"""Handles in the viewport, as points and numbers: a lever at each leaning side, an arrow at the crown. Arrays only.

A handle has a tip that moves along a track as its number changes. Dragging looks for the place on the track, as seen on
the screen, that is nearest to the mouse: so the tip stays under the mouse in every view, in perspective too.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .overlay_geometry import unit_vectors
from .rim import Rim, Walk
from .rim_strip import GroupState
from .screen import Screen, nearest

Array = NDArray[np.float64]

ANGLES = {"lean": "angle", "binormal": "tilt"}
"""Kinds of groups that lean: name of the parameter with the angle."""
# Angles that may be dragged to, radians: a surface meets a wall at 8° to 160°, a free rim leans as it likes.
_RANGE = {"lean": (np.radians(8.0), np.radians(160.0)), "binormal": (-np.pi, np.pi)}
# Handles of one group at most, at its longest sides.
_SIDES = 3
# A step of the mouse turns a lever by this at most, radians, and a track has this many places.
_TURN, _PLACES = np.radians(60.0), 241
# A track of which less than this part of its length is seen is dragged by the height of the mouse instead.
_SEEN = 0.15


@dataclass(frozen=True, eq=False)
class Lever:
    """The handle of a side that leans: it stands on the rim in the tangent plane of the shell, and turns with it.

    at, along, normal (3,): the middle of the side, the unit tangent of the lever and the normal of the shell there, at
    the angle that the group has now. The lever at another angle is `along` turned about the rim.
    """

    uid: int
    name: str
    parameter: str
    angle: float
    at: Array
    along: Array
    normal: Array
    least: float
    most: float

    def tips(self, angles: Array, length: float) -> Array:
        """Points (n, 3) of the tip at angles (n,): a + l (cos δ e - sin δ N), δ from the present angle; since
        N = cos α ν + sin α u and e = dN/dα, 0 is upright and 90° lies flat over the plan."""
        turn = np.asarray(angles)[:, None] - self.angle
        return self.at + length * (np.cos(turn) * self.along - np.sin(turn) * self.normal)

    def reachable(self, last: float) -> Array:
        """Angles (n,) that one step of the mouse may reach."""
        return np.linspace(max(last - _TURN, self.least), min(last + _TURN, self.most), _PLACES)


def levers(rim: Rim) -> list[Lever]:
    """The handles of the leaning sides of a plan, in the coordinates of the rim."""
    found = []
    for group in rim.groups:
        if group.kind in ANGLES:
            mine = sorted((walk for walk in rim.walks if walk.uid == group.uid), key=lambda walk: -walk.length)
            found += [lever for walk in mine[:_SIDES] if (lever := _lever(group, walk)) is not None]
    return found


def _lever(group: GroupState, walk: Walk) -> Lever | None:
    """At the middle edge of a side; None where nothing is known there."""
    steps = np.diff(walk.points, axis=0)
    at = _front(walk) if walk.closed else _middle(steps)
    normal, tangent = walk.middles[at], unit_vectors(steps[at])
    along = unit_vectors(np.asarray(np.cross(normal, tangent), dtype=np.float64))
    if not (np.isfinite(along).all() and along.any()):
        return None
    angle, (least, most) = float(dict(group.parameters)[ANGLES[group.kind]]), _RANGE[group.kind]  # type: ignore[arg-type]
    middle = 0.5 * (walk.points[at] + walk.points[at + 1])
    return Lever(group.uid, group.name, ANGLES[group.kind], angle, middle, along, normal, least, most)


def _middle(steps: Array) -> int:
    """The edge of an open side with its middle."""
    lengths = np.linalg.norm(steps, axis=1)
    return int(np.searchsorted(np.cumsum(lengths), 0.5 * lengths.sum()).clip(max=len(steps) - 1))


def _front(walk: Walk) -> int:
    """The edge of a whole loop in front, as seen with the Y axis away from the eye, there the one in the middle."""
    middles = 0.5 * (walk.points[1:] + walk.points[:-1])
    y, size = middles[:, 1], float(np.ptp(middles, axis=0).max())
    off = np.abs(middles[:, 0] - 0.5 * (middles[:, 0].min() + middles[:, 0].max()))
    return int(np.where(y < y.min() + 0.01 * size, off, np.inf).argmin())


def snapped(value: float, step: float) -> float:
    return round(value / step) * step


# --- dragged by the mouse -------------------------------------------------------------------

def turned(lever: Lever, screen: Screen, length: float, last: float, mouse: Array) -> float:
    """The angle whose tip is nearest to the mouse (2,), in reach of the last one."""
    angles = lever.reachable(last)
    found = nearest(screen.pixels(lever.tips(angles, length)), angles, mouse)
    return last if found is None else found


def lifted(at: Array, up: Array, screen: Screen, start: Array, mouse: Array) -> float:
    """How far along the unit vector up (3,) a point (3,) is dragged, as a length, by a mouse from start to here (2,).

    Where one looks along `up`, the height of the mouse on the screen counts instead.
    """
    pixel = screen.pixel(at)
    if not pixel > 0.0:
        return 0.0
    reach = 1.0 + 2.0 * float(np.abs(mouse - start).max())
    moves = pixel * reach * np.linspace(-1.0, 1.0, _PLACES) / _SEEN
    track = screen.pixels(at + moves[:, None] * up)
    ends = screen.pixels(np.stack([at, at + 10.0 * pixel * up]))
    if not np.linalg.norm(ends[1] - ends[0]) > 10.0 * _SEEN:
        return pixel * float(mouse[1] - start[1])
    found = nearest(track, moves, track[_PLACES // 2] + mouse - start)
    return 0.0 if found is None else found


def arc(lever: Lever, length: float, angle: float) -> Array:
    """Points (n, 3) of the way of the tip from upright to an angle."""
    count = max(2, round(abs(np.degrees(angle)) / 4.0))
    return lever.tips(np.linspace(0.0, angle, count), length)
