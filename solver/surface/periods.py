"""Translations of a surface around the holes and handles of its domain."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .cmc import CmcSurface


def periods(surface: CmcSurface) -> NDArray[np.float64]:
    """Period vectors (k, 3), scaled as the surface is, one for each loop that cannot be contracted.

    The sum of tau around the loop (paper, Sec. 5.3.1); zero vectors mean that the surface closes.
    """
    return surface.periods
