"""Inverse problems: the boundary normals whose surface comes nearest to what is wanted."""

from .fit import Fit, FitStatus, Start, fit
from .gauss_map import fit_gauss_map
from .outline import KNOBS, fit_outline

__all__ = ["KNOBS", "Fit", "FitStatus", "Start", "fit", "fit_gauss_map", "fit_outline"]
