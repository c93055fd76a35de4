"""Inverse problems: the boundary normals whose surface comes nearest to what is wanted."""

from .bubbles import Bubble, wente, wente_start
from .closing import Closing, close_periods
from .fit import Fit, FitStatus, Start, fit
from .gauss_map import fit_gauss_map
from .holes import hole
from .moduli import Moduli, tube, tubes
from .outline import fit_outline
from .ring import Ring, ring
from .wente_heights import wente_height
from .wishes import KNOBS

__all__ = [
    "KNOBS",
    "Bubble",
    "Closing",
    "Fit",
    "FitStatus",
    "Moduli",
    "Ring",
    "Start",
    "close_periods",
    "fit",
    "fit_gauss_map",
    "fit_outline",
    "hole",
    "ring",
    "tube",
    "tubes",
    "wente",
    "wente_height",
    "wente_start",
]
