"""Approximate Surface: the CMC surface nearest to the plan itself, a surface in space."""

from __future__ import annotations

from collections.abc import Callable
from types import SimpleNamespace

import bpy
import numpy as np
from numpy.typing import NDArray

from ...solver.errors import Progress
from ...solver.fitting.fit import Fit, FitStatus
from ...solver.fitting.gauss_map import fit_gauss_map
from ..background import plan_cache
from ..results.deviation import deviation_from
from .design import LIMIT, DesignTask, counted, read_common
from .design_frame import Frame

Array = NDArray[np.float64]

# Evaluations before a shape is shown; the start itself is a guess already.
_FIRST_LOOK = 5


class ApproximateTask(DesignTask):
    """settings: `APPROXIMATE_SETTINGS`."""

    @classmethod
    def read(
        cls, context: bpy.types.Context, plan: bpy.types.Object, settings: SimpleNamespace, stored: tuple[str, ...] = ()
    ) -> ApproximateTask:
        """Read the plan. stored: names of the settings to keep with it."""
        return cls(**read_common(context, plan, settings), role="NEAREST", stored=stored)

    def frame(self, prepared: plan_cache.Prepared) -> Frame:
        return Frame(self.mesh.positions.mean(axis=0), np.eye(3))

    def fit(self, frame: Frame, prepared: plan_cache.Prepared, progress: Progress, show: Callable[[Fit], None]) -> Fit:
        counting = counted(progress)
        near = self.settings.near if self.settings.match == "POSITION" else 0.0

        def run(earlier: Fit | None, near: float, evaluations: int) -> Fit:
            return fit_gauss_map(
                prepared.solver.domain,
                frame.inside(self.mesh.positions),
                self.settings.smoothness,
                near=near,
                max_evaluations=evaluations,
                initial=earlier,
                solver=prepared.solver,
                progress=counting,
            )

        first = run(None, 0.0, _FIRST_LOOK)
        if first.status is FitStatus.CANCELLED or (first.status is FitStatus.CONVERGED and not near):
            return first
        show(first)
        return run(first, near, LIMIT)

    def deviation(self, prepared: plan_cache.Prepared, points: Array) -> Array:
        return deviation_from(self.mesh.positions, prepared.triangles, points)
