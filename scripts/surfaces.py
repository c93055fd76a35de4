"""Surfaces that have no constant mean curvature, to be approximated: a wavy disc and a cultural centre. Arrays only.

.venv/bin/python scripts/surfaces.py      writes assets/jobs/centre.obj
"""

from __future__ import annotations

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
    """A low dome over the unit disc whose rim goes up and down three times, and in waves all over."""
    x, y = disc.T
    r, theta = np.hypot(x, y), np.arctan2(y, x)
    z = 0.42 * (1 - r**2) + 0.20 * r**3 * np.sin(3 * theta) + 0.045 * np.sin(6.5 * x + 1) * np.cos(5.5 * y - 0.4)
    return Surface(disc, np.column_stack([x, y, z]), faces)


def cultural_centre(disc: Points, faces: NDArray[np.int32]) -> Surface:
    """A roof of 80 x 64 m in two waves, the higher one leaning out over its front.

    The unit disc is the ground plan. The roof comes down to the ground in folds between three arched fronts, of which
    the two larger ones lie at the ends of the waves.
    """
    x, y = disc.T
    r, angle = np.hypot(x, y), np.arctan2(y, x)
    high = 6.0 * _bell(x - 0.4 - 0.3 * y, 0.45) * _bell(y, 0.7) * (1 - r**4) + 13.0 * _front(r, angle + 0.25, 0.45)
    low = 2.0 * _bell(x + 0.45 + 0.25 * y, 0.35) * _bell(y + 0.1, 0.6) * (1 - r**4)
    low += 7.0 * _front(r, angle - 2.6, 0.45) + 6.0 * _front(r, angle + 2.0, 0.4)
    z = 13.0 * (1 - r**2) + high + low
    plan = np.column_stack([40.0 * x, 32.0 * y])
    return Surface(plan, np.column_stack([plan[:, 0] + 0.3 * high, plan[:, 1], z]), faces)


def _bell(t: Points, width: float) -> Points:
    return np.exp(-((t / width) ** 2))


def _front(r: Points, angle: Points, width: float) -> Points:
    """An arch of height one at the rim about angle zero, which flows into the roof behind."""
    return r**4 * np.exp((np.cos(angle) - 1.0) / width**2)
