"""Plans solved by the operator: points and extent of a result."""

from __future__ import annotations

import bpy

# isort: split
import numpy as np

from .scenes import activate, positions

FINISHED = {"FINISHED"}


def solved(plan, role="f_plus", **settings) -> np.ndarray:
    """World points of a result after a solve."""
    activate(plan)
    assert bpy.ops.cmc.solve(**settings) == FINISHED
    return positions(getattr(plan.cmc, role))


def extent(points: np.ndarray) -> np.ndarray:
    return np.ptp(points, axis=0)
