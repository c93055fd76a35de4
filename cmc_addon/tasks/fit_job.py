"""The fit of a job: Fit to Outline and Approximate Surface with the options of its [fit] in place of the plan's."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from types import SimpleNamespace
from typing import Any

import bpy
import numpy as np
from numpy.typing import NDArray

from ...solver.errors import Progress
from ...solver.fitting.fit import Fit
from ...solver.fitting.gauss_map import GaussMapOptions, fit_gauss_map
from ...solver.fitting.goals import OutlineOptions
from ...solver.fitting.outline import fit_outline
from ...solver.shells.fit import FitOptions
from ...solver.shells.rim_curves import curves_of_loops
from ..background import plan_cache
from ..properties.design_settings import HEIGHT_PROPERTY
from ..results.deviation import deviation_from
from .design import DesignTask, read_common
from .design_frame import Frame

Array = NDArray[np.float64]


@dataclass(eq=False)
class JobFitTask(DesignTask):
    """options: of the job, in the coordinates of its plan."""

    options: FitOptions = field(default_factory=OutlineOptions)

    @classmethod
    def read(cls, context: bpy.types.Context, plan: bpy.types.Object, options: FitOptions) -> JobFitTask:
        """Read the plan; the options that a plan has, too, stay with it."""
        settings = SimpleNamespace(**_stored(options))
        role = "NEAREST" if isinstance(options, GaussMapOptions) else "FIT"
        return cls(**read_common(context, plan, settings), role=role, stored=tuple(_stored(options)), options=options)

    def frame(self, prepared: plan_cache.Prepared) -> Frame:
        return Frame(self.mesh.positions.mean(axis=0), np.eye(3))

    def fit(self, frame: Frame, prepared: plan_cache.Prepared, progress: Progress, show: Callable[[Fit], None]) -> Fit:
        domain, points = prepared.solver.domain, frame.inside(self.mesh.positions)
        options = replace(self.options, solver=prepared.solver, progress=progress)
        if isinstance(options, GaussMapOptions):
            return fit_gauss_map(domain, points, **vars(options))
        lines = self._lines(frame, prepared)
        anchors = options.anchors
        if anchors is not None:
            anchors = anchors[0], frame.inside(np.asarray(anchors[1])), anchors[2]
        curve = None if lines is None else [frame.inside(line) for line in lines]
        return fit_outline(domain, points, **vars(replace(options, curve=curve, anchors=anchors)))

    def _lines(self, frame: Frame, prepared: plan_cache.Prepared) -> list[Array] | None:
        """A line for each loop of the plan, in the world; None where these are the plan's own."""
        if not isinstance(self.options, OutlineOptions) or self.options.curve is None:
            return None
        curves: Any = self.options.curve
        return curves_of_loops(prepared.solver.domain, self.mesh.positions, [np.asarray(curve) for curve in curves])

    def outline(self, frame: Frame, prepared: plan_cache.Prepared) -> Array | list[Array] | None:
        on_curve = isinstance(self.options, OutlineOptions) and self.options.on_curve
        lines = self._lines(frame, prepared) if on_curve else None
        return self.mesh.positions if lines is None else lines

    def deviation(self, prepared: plan_cache.Prepared, points: Array) -> Array | None:
        if self.role != "NEAREST":
            return None
        return deviation_from(self.mesh.positions, prepared.triangles, points)


def _stored(options: FitOptions) -> dict[str, object]:
    """The options as settings of a plan, as far as it has them."""
    if isinstance(options, GaussMapOptions):
        match = "POSITION" if options.near else "TANGENT_PLANES"
        near = {"near": options.near} if options.near else {}
        return {"smoothness": options.regularisation, "match": match, **near}
    name, number = options.height_parameter
    values: dict[str, object] = {"height_parameter": name.upper(), HEIGHT_PROPERTY[name.upper()]: number}
    values |= {"free_heights": options.free_heights, "limit_tilt": options.tilt is not None}
    if options.tilt is not None:
        values |= {"tilt_min": options.tilt[0], "tilt_max": options.tilt[1]}
    return values | {"fit_to": "OUTLINE" if options.on_curve else "ANCHORS"}
