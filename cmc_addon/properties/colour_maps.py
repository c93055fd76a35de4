"""Colours of numbers: two ramps, and the range of numbers that each ramp spans.

Both ramps read well with any kind of colour vision, and as far as possible in grey: the sequential one darkens evenly
from its first colour to its last; the diverging one darkens evenly from its light middle to either end, blue and
orange. Colours are sRGB; Blender stores linear ones.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial import KDTree

Array = NDArray[np.float64]

_SEQUENTIAL = np.array(
    [
        (0.976, 0.956, 0.745),
        (0.740, 0.880, 0.580),
        (0.410, 0.785, 0.580),
        (0.150, 0.650, 0.620),
        (0.130, 0.490, 0.640),
        (0.170, 0.320, 0.580),
        (0.210, 0.150, 0.400),
    ]
)
_DIVERGING = np.array(
    [
        (0.085, 0.290, 0.600),
        (0.200, 0.455, 0.760),
        (0.500, 0.680, 0.870),
        (0.930, 0.930, 0.910),
        (0.890, 0.600, 0.310),
        (0.735, 0.375, 0.080),
        (0.510, 0.205, 0.020),
    ]
)
RAMPS = {"sequential": _SEQUENTIAL, "diverging": _DIVERGING}
"""Name of a ramp -> its colours (k, 3), sRGB, evenly spaced, interpolated linearly."""

NOT_KNOWN = (0.72, 0.72, 0.72)
"""Colour (sRGB) of a missing number."""

# Number of distinct colours of a ramp.
_STEPS = 2047

# The range leaves out this part of the numbers at either end: corners and poor faces are outliers.
_FAR = 0.02


@dataclass(frozen=True)
class Range:
    """The numbers that a ramp spans.

    low, high: its ends. centre: the number in the middle of a diverging ramp, None for a sequential one. Numbers beyond
    an end have its colour; below, above: whether any are.
    """

    low: float
    high: float
    centre: float | None = None
    below: bool = False
    above: bool = False

    @property
    def ramp(self) -> str:
        return "sequential" if self.centre is None else "diverging"

    def places(self, values: ArrayLike) -> Array:
        """Positions of numbers on the ramp, 0 to 1. A diverging ramp is equally steep on both sides of its centre."""
        numbers = np.clip(np.asarray(values, dtype=np.float64), self.low, self.high)
        if self.centre is None:
            return (numbers - self.low) / ((self.high - self.low) or 1.0)
        reach = max(self.high - self.centre, self.centre - self.low)
        return 0.5 + 0.5 * (numbers - self.centre) / (reach or 1.0)

    def colours(self, values: ArrayLike) -> Array:
        """sRGB colours (n, 3) of numbers (n,)."""
        numbers = np.asarray(values, dtype=np.float64)
        known = np.isfinite(numbers)
        table = RAMPS[self.ramp]
        knots = np.linspace(0.0, 1.0, len(table))
        places = self.places(np.where(known, numbers, self.low))
        colours = np.stack([np.interp(places, knots, channel) for channel in table.T], axis=-1)
        return np.where(known[..., None], colours, NOT_KNOWN)

    def linear_colours(self, values: ArrayLike) -> NDArray[np.float32]:
        """Linear colours with alpha (n, 4) of numbers (n,), as Blender stores them; from a table, for speed."""
        numbers = np.asarray(values, dtype=np.float64)
        known = np.isfinite(numbers)
        places = self.places(np.where(known, numbers, self.low))
        return _table(self.ramp)[np.where(known, np.rint(places * _STEPS), _STEPS + 1).astype(np.int32)]

    def faded_colours(self, values: ArrayLike, points: ArrayLike, width: float) -> NDArray[np.float32]:
        """The same for numbers known at some of the points (n, 3) only: each colour fades out over `width`, so that a
        rim shows on a fine mesh, too."""
        colours, numbers, places = self.linear_colours(values), np.asarray(values), np.asarray(points)
        known = np.isfinite(numbers)
        if known.all() or not known.any():
            return colours
        query = KDTree(places[known]).query(places[~known], distance_upper_bound=width)
        away, nearest = (np.asarray(each) for each in query)
        near = np.isfinite(away)
        share = (1.0 - away[near] / width)[:, None]
        rows = np.flatnonzero(~known)[near]
        colours[rows] += (share * (colours[known][nearest[near]] - colours[rows])).astype(np.float32)
        return colours

    def ticks(self) -> list[float]:
        """The numbers beside the ramp: its ends, and its centre or its middle."""
        middle = 0.5 * (self.low + self.high) if self.centre is None else self.centre
        near = 0.1 * (self.high - self.low)
        inside = [middle] if self.low + near < middle < self.high - near else []
        return [self.low, *inside, self.high]


@lru_cache
def _table(ramp: str) -> NDArray[np.float32]:
    """Linear colours (k, 4) of a ramp, evenly spaced, and the colour of a missing number."""
    low, centre = 0.0, 0.5 if ramp == "diverging" else None
    srgb = Range(low, 1.0, centre).colours([*np.linspace(0.0, 1.0, _STEPS + 1), np.nan])
    return np.column_stack([linear(srgb), np.ones(len(srgb))]).astype(np.float32)


def linear(colours: ArrayLike) -> Array:
    """Linear light from sRGB."""
    c = np.asarray(colours, dtype=np.float64)
    return np.where(c <= 0.04045, c / 12.92, ((c + 0.055) / 1.055) ** 2.4)


# --- ranges --------------------------------------------------------------------------------

def fit_about(values: ArrayLike, centre: float, least: float) -> Range:
    """A diverging range, equally wide on both sides of a centre; each side at least `least`."""
    known = _known(values)
    reach = float(np.quantile(np.abs(known - centre), 1.0 - _FAR)) if len(known) else 0.0
    reach = max(reach, least)
    return _range_of(known, centre - reach, centre + reach, centre)


def fit_around_zero(values: ArrayLike) -> Range:
    """A diverging range about zero that ends with the numbers: half of the ramp if all have one sign."""
    known = _known(values)
    low, high = (float(q) for q in np.quantile(known, [_FAR, 1.0 - _FAR])) if len(known) else (0.0, 0.0)
    low, high = min(low, 0.0), max(high, 0.0)
    return _range_of(known, low, high if high > low else low + 1.0, 0.0)


def fit_from(values: ArrayLike, low: float, least: float) -> Range:
    """A sequential range from `low`, at least `least` wide."""
    known = _known(values)
    high = float(np.quantile(known, 1.0 - _FAR)) if len(known) else low
    return _range_of(known, low, max(high, low + least), None)


def fixed_range(values: ArrayLike, low: float, high: float, centre: float | None) -> Range:
    """The range that the user sets; reversed ends are swapped, and an empty range is widened a little."""
    low, high = min(low, high), max(low, high)
    if high - low <= 1e-6 * max(abs(low), abs(high)):
        high = low + (1e-3 * abs(low) or 1.0)
    if centre is not None and not low <= centre <= high:
        centre = 0.5 * (low + high)
    return _range_of(_known(values), low, high, centre)


def _known(values: ArrayLike) -> Array:
    numbers = np.asarray(values, dtype=np.float64).ravel()
    return numbers[np.isfinite(numbers)]


def _range_of(known: Array, low: float, high: float, centre: float | None) -> Range:
    slack = 1e-6 * (high - low)
    beyond = bool(len(known)) and known.min() < low - slack, bool(len(known)) and known.max() > high + slack
    return Range(low, high, centre, bool(beyond[0]), bool(beyond[1]))


def decimals(numbers: list[float]) -> int:
    """Decimals that separate these numbers to a tenth of their distances."""
    ordered = sorted(set(numbers))
    gaps = [b - a for a, b in pairwise(ordered)]
    least = min(gaps, default=abs(ordered[0]) if ordered else 1.0)
    return 0 if least <= 0.0 else max(0, min(9, 1 - math.floor(math.log10(least))))
