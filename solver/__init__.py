"""Constant mean curvature surfaces from discrete harmonic maps.

The rooms follow the mathematics: domain → gauss → surface → measure. What is done with surfaces comes next (symmetry,
closing, fitting), then ready-made ones (catalogue), and shells over a drawn plan (shells, jobs).
"""

from .catalogue import modules, shapes
from .catalogue.honeycomb_ring import ring
from .catalogue.wente import wente, wente_start
from .catalogue.wente_heights import wente_height
from .closing.close import close_periods
from .closing.holes import hole
from .closing.moduli import tube
from .domain.domain import Domain
from .errors import CmcError, ConditionError, JobError, MeshError, Status
from .fitting.fit import Fit, fit
from .fitting.gauss_map import fit_gauss_map
from .fitting.outline import fit_outline
from .gauss import conditions
from .gauss.boundary_data import Conditions
from .gauss.harmonic import HarmonicMap, HarmonicSolver
from .gauss.modes import modes_of, saddle
from .measure import (
    conformal_distortion,
    gauss_curvature_of,
    mean_curvature_of,
    principal_curvatures,
    report,
    vertex_principal_curvatures,
)
from .shells.form import form
from .shells.plan import Group, Plan, Settings, read_plan
from .surface.cmc_surface import CmcSurface
from .surface.periods import periods
from .surface.solve import CmcSolver, solve_cmc
from .symmetry.complete import complete
from .symmetry.glued_map import whole
from .symmetry.sides import Side, side_plane

__version__ = "0.1.0"

__all__ = [
    "CmcError",
    "CmcSolver",
    "CmcSurface",
    "ConditionError",
    "Conditions",
    "Domain",
    "Fit",
    "Group",
    "HarmonicMap",
    "HarmonicSolver",
    "JobError",
    "MeshError",
    "Plan",
    "Settings",
    "Side",
    "Status",
    "close_periods",
    "complete",
    "conditions",
    "conformal_distortion",
    "fit",
    "fit_gauss_map",
    "fit_outline",
    "form",
    "gauss_curvature_of",
    "hole",
    "mean_curvature_of",
    "modes_of",
    "modules",
    "periods",
    "principal_curvatures",
    "read_plan",
    "report",
    "ring",
    "saddle",
    "shapes",
    "side_plane",
    "solve_cmc",
    "tube",
    "vertex_principal_curvatures",
    "wente",
    "wente_height",
    "wente_start",
    "whole",
]
