"""Inverse problems: the boundary normals whose surface comes nearest to what is wanted."""

from .closing import Closing, close_periods
from .fit import Fit, FitStatus, Start, fit
from .gauss_map import fit_gauss_map
from .holes import hole
from .moduli import Moduli, tube, tubes
from .outline import fit_outline
from .wishes import KNOBS

__all__ = [
    "KNOBS",
    "Closing",
    "Fit",
    "FitStatus",
    "Moduli",
    "Start",
    "close_periods",
    "fit",
    "fit_gauss_map",
    "fit_outline",
    "hole",
    "tube",
    "tubes",
]
