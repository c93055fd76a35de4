"""Limits of numbers and sizes: each is written once, beside what it limits or here, and named in the message.

A number is zero or from `SMALLEST` to `LARGEST` in size, so that its squares and cubes are numbers, too.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from .errors import CmcError, ConditionError, shown

SMALLEST, LARGEST = 1e-30, 1e30
MOST_VERTICES = 1_000_000
"""Vertices of a plan that is made here; more is nearly always a mistake in the units."""
EXTREME = 1e-6
"""Part of a plan's size below which, and above whose inverse, no shell is one over this plan."""


@dataclass(frozen=True)
class Range:
    """The numbers from `least` to `most`, whole ones only if `whole`. `str` says it: "a whole number from 1 to 9"."""

    least: float = -LARGEST
    most: float = LARGEST
    whole: bool = False

    def __contains__(self, value: object) -> bool:
        kinds = (int, np.integer) if self.whole else (int, float, np.number)
        if not isinstance(value, kinds) or isinstance(value, (bool, np.bool_, complex, np.complexfloating)):
            return False
        return bool(self.least <= value <= self.most and (value == 0 or abs(value) >= SMALLEST))

    def __str__(self) -> str:
        kind = "whole number" if self.whole else "positive number," if self.least > 0.0 else "number"
        if self.least == -self.most:
            tiny = f", 0 or at least {SMALLEST:g}" if self.most == LARGEST else ""
            return f"a {kind} of at most {shown(self.most)} in size{tiny}"
        return f"a {kind} from {shown(self.least)} to {shown(self.most)}"


NUMBERS = Range()
COUNT = Range(1, 100_000, whole=True)
"""Steps, evaluations, columns: whatever work is repeated."""
POSITIVE = Range(SMALLEST)
NOT_NEGATIVE = Range(0.0)
TOLERANCE = Range(1e-15, 1.0)
"""Of a residual: below it rounding is larger, above it any normals will do."""


def check_number(
    value: Any, what: str, within: Range = NOT_NEGATIVE, error: type[CmcError] = ConditionError
) -> None:
    """Raise `error`, naming `what` and the range, on a value that is no number `within` it."""
    if value not in within:
        raise error(f"The {what} must be {within}, not {shown(value)}.")
