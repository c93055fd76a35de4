"""The one number that chooses among the surfaces of a rim: H, the volume, the height of the crown.

The volume is the master coordinate: the surfaces of one rim, ordered by V, go through the largest H and past the half
sphere without a turn. Any other number k is met by steps dV = (k₀ - k) / k' in V, with the slope k' by the secant.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .descent import Knob
from .linearised import Linearised

Array = NDArray[np.float64]

# The accuracy of a number, as a part of its unit. How much V may change in one step, as a part of itself or of the cube
# of the size times the second number.
_MET = 1e-6
_STEP = 0.5
_LEAST = 0.2
# Differences of k give a slope where they are this multiple of its noise, and those of V this part of V.
_CLEAR = 10.0
_MOVED = 1e-9
# Points within this part of the size are equally high.
_LEVEL = 1e-6


class MeanCurvature(Knob):
    """H is given. Right below about 95 % of the largest H of the rim, and quickest there."""

    def __init__(self, H: float) -> None:
        self.mean_curvature = H


class HeldVolume(Knob):
    """V is given, and the start has it."""

    mean_curvature = None

    def __init__(self, volume: float) -> None:
        self.wanted = volume

    def volume_change(self, here: Linearised, residual: float, volume: float) -> float:
        return self.wanted - volume


class Measured(Knob):
    """Any number k has the value `wanted`; made concrete by `number` and `first_slope`.

    Where the surface is not critical yet, k is uncertain by about the residual; within this noise V is kept while the
    residual falls, and no slope is taken. unit: k counts as met to a millionth of it. size: of the rim, a length;
    scale: of k, for its noise. slope: dk/dV if it is known, as from an earlier search; after the search the last one.
    """

    mean_curvature = None

    def __init__(self, wanted: float, *, unit: float, size: float, scale: float, slope: float | None = None) -> None:
        self.wanted, self.unit, self.size, self.scale, self.slope = wanted, unit, size, scale, slope
        self._last: tuple[float, float, float] | None = None

    def number(self, here: Linearised) -> float:
        """k here."""
        raise NotImplementedError

    def first_slope(self, here: Linearised) -> float:
        """dk/dV along M V'."""
        raise NotImplementedError

    def reached(self, here: Linearised, volume: float) -> bool:
        return abs(self.number(here) - self.wanted) <= _MET * self.unit

    def volume_change(self, here: Linearised, residual: float, volume: float) -> float:
        k, noise = self.number(here), residual * self.scale
        self.slope = self._secant(here, k, noise, volume)
        falls = self._last is None or noise < self._last[1]
        self._last = (k, noise, volume)
        if falls and abs(self.wanted - k) < noise:
            return 0.0
        most, rest = _STEP * max(abs(volume), _LEAST * self.size**3), self.wanted - k
        if abs(rest) < most * abs(self.slope):
            return rest / self.slope
        return float(np.copysign(most, rest * np.copysign(1.0, self.slope)))

    def _secant(self, here: Linearised, k: float, noise: float, volume: float) -> float:
        if self._last is not None:
            before, last_noise, last_volume = self._last
            moved = abs(volume - last_volume) > _MOVED * abs(last_volume)
            if moved and abs(k - before) > _CLEAR * (noise + last_noise):
                return (k - before) / (volume - last_volume)
        return self.slope if self.slope is not None else self.first_slope(here)


class Crown(Measured):
    """The height of the highest point (`up` = 1) or of the lowest (`up` = -1) over z = 0."""

    def __init__(self, height: float, *, unit: float, size: float, up: float = 1.0, slope: float | None = None) -> None:
        super().__init__(height, unit=unit, size=size, scale=size, slope=slope)
        self.up = up

    def number(self, here: Linearised) -> float:
        return self.up * float((self.up * here.state.f[:, 2]).max())

    def first_slope(self, here: Linearised) -> float:
        inside = here.problem.coordinates.inside
        heights, rising = self.up * here.state.f[inside, 2], here.push(here.along)[inside, 2]
        return float(rising[heights >= heights.max() - _LEVEL * self.size].max() / here.gain)


class PastTheLargest(Measured):
    """H is given, near the largest of the rim or past it: met by way of V."""

    def __init__(self, H: float, *, size: float, slope: float | None = None) -> None:
        super().__init__(H, unit=abs(H), size=size, scale=abs(H), slope=slope)

    def number(self, here: Linearised) -> float:
        return here.H

    def first_slope(self, here: Linearised) -> float:
        return 0.5 / here.gain
