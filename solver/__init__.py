"""Constant mean curvature surfaces from discrete harmonic maps.

The way through the package is the way through the mathematics: domain → gauss → surface → measure, with design (from
what is wanted back to the boundary normals) on top.
"""

from .design import Fit, close_periods, fit, fit_gauss_map, fit_outline, ring, wente
from .domain import shapes
from .domain.domain import Domain
from .errors import CmcError, ConditionError, JobError, MeshError, Status
from .gauss import conditions
from .gauss.conditions import Conditions
from .gauss.harmonic import HarmonicMap, HarmonicSolver
from .gauss.saddle_maps import modes_of, saddle
from .measure import (
    conformal_distortion,
    gauss_curvature_of,
    mean_curvature_of,
    principal_curvatures,
    report,
    vertex_principal_curvatures,
)
from .surface.cmc import CmcSurface
from .surface.periods import periods
from .surface.sides import Side, side_plane
from .surface.solve import CmcSolver, solve_cmc
from .surface.symmetry import complete
from .surface.whole import whole

__version__ = "0.1.0"

__all__ = [
    "CmcError",
    "CmcSolver",
    "CmcSurface",
    "ConditionError",
    "Conditions",
    "Domain",
    "Fit",
    "HarmonicMap",
    "HarmonicSolver",
    "JobError",
    "MeshError",
    "Side",
    "Status",
    "close_periods",
    "complete",
    "conditions",
    "conformal_distortion",
    "fit",
    "fit_gauss_map",
    "fit_outline",
    "gauss_curvature_of",
    "mean_curvature_of",
    "modes_of",
    "periods",
    "principal_curvatures",
    "report",
    "ring",
    "saddle",
    "shapes",
    "side_plane",
    "solve_cmc",
    "vertex_principal_curvatures",
    "wente",
    "whole",
]
