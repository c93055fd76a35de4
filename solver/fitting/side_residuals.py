"""How far each side of a fitted surface is from what was asked of it there."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..errors import plural
from ..notes import Sentence
from .curves import Curve
from .sides import HELD, LEAN, LINE, Side
from .target import Shape
from .targets import RimOnCurve
from .wall_targets import ContactAngle

Array = NDArray[np.float64]
Int = NDArray[np.integer]

# By the size: how far the rim may stay off its line beside given normals.
_LINE_MET = 3e-3
# Radians by which the surface may lean otherwise than asked.
_ANGLE_MET = np.radians(0.5)


@dataclass(frozen=True, eq=False)
class SideResidual:
    """A side of a fitted surface: kind "line", "lean", "held", "mirror" or "free", vertices (k,) in order, and
    zone (j,), those of them in blend zones.

    distance: the largest from its line; of a side that leans, seen from above; of one with given normals, how far its
    rim has drifted from its drawn line, where it may be anywhere. 0 for mirrors and free sides. angle: the largest,
    radians, between the normals and the given ones outside the blend zones, or of a side that leans between the angle
    at its wall and the wanted one, farther than a twentieth of the size from its ends.
    """

    kind: str
    vertices: Int
    zone: Int
    distance: float = 0.0
    angle: float = 0.0

    def unmet(self, size: float) -> list[str]:
        """A sentence for each thing that was asked for and is missed."""
        where = plural("vertex", self.vertices[[0, -1]]).replace(", ", " to ")
        found: list[str] = []
        if self.kind in (LINE, LEAN) and self.distance > _LINE_MET * size:
            text = (
                f"The side at {where} stays up to {{}} off its line; lean the sides with given normals less, give them "
                "more room (blend), or choose a flatter shell."
            )
            found.append(Sentence(text, self.distance))
        if self.kind == LEAN and self.angle > _ANGLE_MET:
            found.append(
                f"The side at {where} leans up to {np.degrees(self.angle):.2g}° otherwise than asked; refine the mesh, "
                "or choose an angle nearer to 90°."
            )
        return found


def side_residuals(
    sides: Sequence[Side], lines: Sequence[RimOnCurve], leans: Sequence[ContactAngle], shape: Shape, drawn: Array
) -> tuple[SideResidual, ...]:
    """Of each side. lines, leans: the targets of the sides on lines and over them, in order; drawn: the plan (V, 3)."""
    on_line, over_line = iter(lines), iter(leans)
    found = []
    for side in sides:
        distance = angle = 0.0
        if side.kind in (LINE, LEAN):
            distance = float(next(on_line).distances(shape).max())
        if side.kind == LEAN:
            angle = next(over_line).distance(shape)
        if side.kind == HELD:
            full = side.parts == 1.0
            target = RimOnCurve(Curve(drawn[side.vertices], side.closed), side.vertices)
            distance = float(target.distances(shape)[full].max(initial=0.0))
            turned = shape.normals[side.vertices[full]] - side.normals[full]
            angle = 2.0 * float(np.arcsin(np.minimum(0.5 * np.linalg.norm(turned, axis=1), 1.0)).max(initial=0.0))
        found.append(SideResidual(side.kind, side.vertices, side.zone, distance, angle))
    return tuple(found)
