"""The exact heights at which Wente's cylinders close: the solutions of Abresch and Walter in elliptic functions.

On the flat cylinder with y along it the metric e^ω of the surface (H = 1) has tanh(ω/4) = c cn(αx) cn(βy), with the
moduli sin θ̄ around and sin θ along, c² = tan θ̄ tan θ. The period around closes if 2E = K, that is θ̄ = 65.354955°,
for any θ; between two ends, the zeros of the second factor, N turns in a plane along x = 0.
(U. Abresch, J. reine angew. Math. 374, 1987; R. Walter, Geom. Dedicata 23, 1987.)
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache

import numpy as np
from scipy.optimize import root_scalar
from scipy.special import ellipe, ellipk, elliprf, elliprj

from ..errors import ConditionError, shown
from ..limits import POSITIVE
from ..signatures import checked

# Distance of the parameter from the ends of its range, as a part of it: angles of 0.001° and 180°.
_END = 1e-10
# Relative error of the height on n columns for a quarter, _ERROR (120° / angle)^_POWER / n²: measured for angles from
# 40° to 170° on 8 to 64 columns, within a tenth.
_ERROR, _POWER = 6.1, 3.7
# The largest such error with which closing was seen to succeed.
_RESOLVED = 0.1
_FEWEST = 8


@checked
def wente_height(angle: float) -> float:
    """Height h of the cylinder of circumference 2π that closes with normals `angle` apart (radians) on its ends.

    N goes the long way between them, 2π - angle. h falls from 2.2288 at angle 0, where the bubbles become whole
    spheres, to 0 at π, where the surface becomes a straight cylinder. Raises `ConditionError` on other angles.
    """
    check_angle(angle)
    return _height_at(_parameter(float(angle)))


def discrete_height(angle: float, columns: int) -> float:
    """The approximate height on a mesh with that many columns for a quarter: larger, by an error of second order."""
    return wente_height(angle) * (1.0 + min(_error(angle) / columns**2, _RESOLVED))


def needed_columns(angle: float) -> int:
    """Columns for a quarter below which the map usually collapses: 8 at 120°, 14 at 90°, 29 at 60°, 102 at 30°."""
    return max(_FEWEST, int(np.ceil(np.sqrt(_error(angle) / _RESOLVED))))


def check_angle(angle: float) -> None:
    """Raise `ConditionError` if there is no such cylinder."""
    if isinstance(angle, (int, float, np.number)) and np.pi < angle < 180.0:
        raise ConditionError(
            f"The angle {angle:g} is more than half a turn: angles are in radians. For {angle:g}° write "
            f"np.radians({angle:g})."
        )
    if not (angle in POSITIVE and angle < np.pi):
        raise ConditionError(
            f"The normals of the two ends of a Wente cylinder differ by more than 0 and less than π radians, not by "
            f"{shown(angle)}; π/2 gives a torus of four cylinders, π/3 and 2π/3 one of six."
        )


def _error(angle: float) -> float:
    return _ERROR * (2.0 * np.pi / 3.0 / angle) ** _POWER


@lru_cache(maxsize=1)
def _around() -> float:
    """θ̄, where the period around vanishes."""
    return _root(lambda t: 2.0 * ellipe(np.sin(t) ** 2) - ellipk(np.sin(t) ** 2), 1.0, 1.3)


@lru_cache(maxsize=64)
def _parameter(angle: float) -> float:
    """θ at which N turns by 2π - angle."""
    low, high = _END * (0.5 * np.pi - _around()), (1.0 - _END) * (0.5 * np.pi - _around())
    if not _turn(low) < 2.0 * np.pi - angle < _turn(high):
        return low if angle > 0.5 * np.pi else high
    return _root(lambda t: 2.0 * np.pi - _turn(t) - angle, low, high)


def _root(function: Callable[[float], float], low: float, high: float) -> float:
    return float(root_scalar(function, bracket=(low, high), xtol=1e-15).root)


def _turn(theta: float) -> float:
    """The angle by which N turns between two ends, the integral of 2 cosh(ω/2) = 2 (1 + t²) / (1 - t²) along x = 0.

    There t = c cn, so that it is the complete integrals of the first and the third kind.
    """
    around, m = _around(), np.sin(theta) ** 2
    c2 = np.tan(theta) * np.tan(around)
    speed = 2.0 * np.sqrt(np.sin(2.0 * around) / np.sin(2.0 * (theta + around)))
    n = -c2 / (1.0 - c2)
    third = elliprf(0.0, 1.0 - m, 1.0) + n / 3.0 * elliprj(0.0, 1.0 - m, 1.0, 1.0 - n)
    return float(4.0 / speed * (2.0 / (1.0 - c2) * third - ellipk(m)))


def _height_at(theta: float) -> float:
    around = _around()
    ratio = ellipk(np.sin(theta) ** 2) / ellipk(np.sin(around) ** 2)
    return float(np.pi * ratio * np.sqrt(np.sin(2.0 * theta) / np.sin(2.0 * around)))
