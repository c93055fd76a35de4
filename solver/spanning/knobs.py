"""The one number that chooses among the surfaces of a rim: H, the volume, the height of the crown.

The volume is the master coordinate: the surfaces of one rim, ordered by V, go through the largest H and past the half
sphere without a turn. Any other number is met by steps in V, as large as its change along the tangent tells.
"""

from __future__ import annotations

import numpy as np

from .descent import Direction, Knob
from .linearised import Linearised

# The accuracy of a number, as a part of its unit. How much V may change in one step, as a part of itself or of the cube
# of the size times the second number. Vertices
# that rise by less than this part of the most do not count.
_MET = 1e-6
_STEP = 0.5
_LEAST = 0.2
_RISES = 1e-3


class MeanCurvature(Knob):
    """H is given. Right below about 95 % of the largest H of the rim, and quickest there."""

    def __init__(self, H: float) -> None:
        self.mean_curvature = H


class HeldVolume(Knob):
    """V is that of the start."""

    mean_curvature = None


class Measured(Knob):
    """A number k has the value `wanted`; made concrete by `number` and `change_to`.

    unit: k counts as met to a millionth of it. size: of the rim, a length.
    """

    mean_curvature = None
    measures = True

    def __init__(self, wanted: float, *, unit: float, size: float) -> None:
        self.wanted, self.unit, self.size = wanted, unit, size

    def number(self, here: Linearised) -> float:
        """k here."""
        raise NotImplementedError

    def change_to(self, here: Linearised, newton: Direction, ahead: Direction) -> float:
        """The dV at which k has the wanted value, to first order."""
        raise NotImplementedError

    def off(self, here: Linearised) -> float:
        return abs(self.number(here) - self.wanted) / self.unit

    def reached(self, here: Linearised) -> bool:
        return self.off(here) <= _MET

    def volume_change(self, here: Linearised, newton: Direction, ahead: Direction) -> float:
        most = _STEP * max(abs(here.state.V), _LEAST * self.size**3)
        return float(np.clip(self.change_to(here, newton, ahead), -most, most))


class Crown(Measured):
    """The height of the highest point (`up` = 1) or of the lowest (`up` = -1) over z = 0."""

    def __init__(self, height: float, *, unit: float, size: float, up: float = 1.0) -> None:
        super().__init__(height, unit=unit, size=size)
        self.up = up

    def number(self, here: Linearised) -> float:
        return self.up * float((self.up * here.state.f[:, 2]).max())

    def change_to(self, here: Linearised, newton: Direction, ahead: Direction) -> float:
        """Where the first of the vertices that rise with V gets there."""
        z = here.state.f[:, 2] + newton.df[:, 2]
        rising = ahead.df[:, 2]
        rises = rising > _RISES * max(float(rising.max()), 0.0)
        if not rises.any():  # with leaning sides more volume may lower all of a bad start: as much as one step may
            return float(np.copysign(np.inf, self.wanted - self.number(here)))
        return self.up * float((self.up * (self.wanted - z[rises]) / rising[rises]).min())


class PastTheLargest(Measured):
    """H is given, near the largest of the rim or past it: met by way of V."""

    def __init__(self, H: float, *, size: float) -> None:
        super().__init__(H, unit=abs(H), size=size)

    def number(self, here: Linearised) -> float:
        return here.H

    def change_to(self, here: Linearised, newton: Direction, ahead: Direction) -> float:
        """What a step leaves of the gradient along V' is the change of 2 H."""
        left = 2.0 * (self.wanted - here.H) - newton.rest(here.along) / here.gain
        slope = ahead.rest(here.along) / here.gain
        return left / slope if slope else float(np.copysign(np.inf, left))
