"""Surfaces to approximate, whose mean curvature is not constant: a wavy disc and a cultural centre. Arrays only.

`make_surfaces.py` writes the second one to assets/jobs/centre.obj.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Points = NDArray[np.float64]


class Surface(NamedTuple):
    """A disc in space: plan coordinates (V, 2), places (V, 3) and triangles (F, 3)."""

    plan: Points
    points: Points
    faces: NDArray[np.int32]


def wavy_disc(disc: Points, faces: NDArray[np.int32]) -> Surface:
    """A low, wavy dome over the unit disc; its rim rises and falls three times."""
    x, y = disc.T
    r, theta = np.hypot(x, y), np.arctan2(y, x)
    z = 0.42 * (1 - r**2) + 0.20 * r**3 * np.sin(3 * theta) + 0.045 * np.sin(6.5 * x + 1) * np.cos(5.5 * y - 0.4)
    return Surface(disc, np.column_stack([x, y, z]), faces)


def cultural_centre(disc: Points, faces: NDArray[np.int32]) -> Surface:
    """A roof of 89 x 72 m, 26 m high, that stands on the ground between three arched fronts; the largest leans out.

    Over the unit disc: the harmonic extension of the rim's heights, plus a dome and two waves.
    """
    x, y = disc.T
    r, angle = np.hypot(x, y), np.arctan2(y, x)
    height = _extended(r, angle, lambda a: 26.0 * _arch(a + 0.9, 1.15) + 15.0 * _arch(a - 1.75, 0.95))
    height += _extended(r, angle, lambda a: 9.0 * _arch(a + 2.7, 0.6))
    lean = 8.7 * _extended(r, angle, lambda a: _arch(a + 0.9, 1.15))
    waves = 5.0 * _bell(x - 0.2, 0.35) * _bell(y + 0.2, 0.5) + 2.5 * _bell(x + 0.5, 0.3) * _bell(y - 0.1, 0.5)
    plan = np.column_stack([44.0 * x + lean * np.cos(0.9), 34.0 * y - lean * np.sin(0.9)])
    return Surface(plan, np.column_stack([plan, height + (11.0 + waves) * (1 - r**2)]), faces)


def _bell(t: Points, width: float) -> Points:
    return np.exp(-((t / width) ** 2))


def _arch(angle: Points, half: float) -> Points:
    """An arch: 1 at angle 0, and 0 from `half` on."""
    angle = np.abs(np.angle(np.exp(1j * angle)))
    return np.where(angle < half, np.cos(np.minimum(angle / half, 1.0) * np.pi / 2) ** 2, 0.0)


def _extended(r: Points, angle: Points, rim: Callable[[Points], Points]) -> Points:
    """The harmonic function on the disc with boundary values `rim(angle)`."""
    count, waves = 512, 24
    series = np.fft.rfft(rim(2 * np.pi * np.arange(count) / count))[:waves, None] / count
    k = np.arange(waves)[:, None]
    doubled = np.where(k > 0, 2.0, 1.0)
    return np.sum(doubled * r**k * (series * np.exp(1j * k * angle)).real, axis=0)
