"""The options of a solve: those of the normals (`gauss.options`), and those of the surface made from them."""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass

import numpy as np

from ..errors import ConditionError, check_choice
from ..gauss.options import MapOptions
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
        if not (_is_number(self.mean_curvature) and np.isfinite(self.mean_curvature) and self.mean_curvature > 0.0):
            raise ConditionError(f"The mean curvature must be a positive number, not {self.mean_curvature!r}.")
        check_choice(self.averaging, AVERAGINGS, "average")
        # an infinite tolerance closes every gap
        if not (_is_number(self.period_tolerance) and self.period_tolerance >= 0.0):
            raise ConditionError(
                f"The tolerance of periods must be a part of the diameter, 0 or more, not {self.period_tolerance!r}."
            )

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


def _is_number(value: object) -> bool:
    return isinstance(value, (int, float, np.number))
