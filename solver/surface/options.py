"""The options of a solve: those of the normals (`gauss.options`), and those of the surface made from them."""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass

import numpy as np

from ..errors import check_choice
from ..gauss.options import MapOptions
from ..limits import POSITIVE, Range, check_number
from .averaging import AVERAGINGS


@dataclass(frozen=True, eq=False)
class SolveOptions(MapOptions):
    """Options of `CmcSolver.solve`; `solve_cmc` describes them.

    Raises `ConditionError` on a mean curvature or a tolerance that is out of range, and on an unknown average.
    """

    _: KW_ONLY
    averaging: str = "galerkin"
    mean_curvature: float = 0.5
    period_tolerance: float = 1e-3

    def __post_init__(self) -> None:
        super().__post_init__()
        check_number(self.mean_curvature, "mean curvature", POSITIVE)
        check_choice(self.averaging, AVERAGINGS, "average")
        # an infinite tolerance closes every gap
        check_number(self.period_tolerance, "tolerance of periods", Range(0.0, np.inf))

    @property
    def scale(self) -> float:
        """1 / (2 H), the factor from the paper's scale to that of the result."""
        return 0.5 / self.mean_curvature


@dataclass(frozen=True, eq=False)
class CmcOptions(SolveOptions):
    """Options of `solve_cmc`: those of the solver, and those of its solve."""

    _: KW_ONLY
    sites: str = "vertices"
    energy: str = "cotan"
    delaunay: bool = False
