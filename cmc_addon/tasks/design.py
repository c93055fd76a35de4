"""One design by target: from the plan object and what it is to fit to, to arrays, and from arrays to the result.

The counterpart of `forming`, which solves for boundary conditions that are given. The work between the two ends sees
no Blender data and may run in a thread; while it runs, `latest` is the best shape found so far, for the screen.
"""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import dataclass, field
from types import SimpleNamespace

import bpy
import numpy as np
from numpy.typing import NDArray

from ...solver.errors import CmcError, Progress
from ...solver.fitting.fit import Fit
from ...solver.fitting.targets import SmoothRim
from ...solver.measure import report
from ...solver.shells.form import placed_normals
from ..background import plan_cache
from ..bridges.mesh_bridge import PlanMesh, read_plan
from ..bridges.numbering import in_plan_numbers
from ..bridges.result_bridge import Cut, find_cut
from ..properties.attributes import USUAL
from ..properties.links import result_of
from ..results import colours
from ..results.deviation import show_deviation
from ..results.measures import Measured, sheet_measures
from ..results.objects import Writer, park, write_report
from .design_frame import Frame
from .solve import check_unchanged, plan_depsgraph

Array = NDArray[np.float64]

# Evaluations of a fit at most.
LIMIT = 300


@dataclass(eq=False)
class DesignOrder:
    """All that a fit needs, without any Blender data.

    latest: points (n, 3) in the world and triangles (F, 3) of the best shape so far, set while the work runs.
    stored: names of the settings to keep with the plan. chosen: names of the data-blocks to keep with it, for the
    pointers of `design_settings`. measured: names of what to measure.
    """

    name: str
    mesh: PlanMesh
    settings: SimpleNamespace
    role: str
    stored: tuple[str, ...] = ()
    warnings: list[str] = field(default_factory=list)
    chosen: dict[str, object] = field(default_factory=dict)
    latest: tuple[Array, NDArray] | None = None
    measured: tuple[str, ...] = USUAL

    def work(self, progress: Progress) -> DesignOutcome:
        """Fit. Raises `CmcError` in the plan's own numbering."""
        prepared = plan_cache.prepare(self.mesh)
        try:
            return self._work(prepared, progress)
        except CmcError as error:
            raise in_plan_numbers(error, self.mesh, prepared.triangles, prepared.owners) from error

    def _work(self, prepared: plan_cache.Prepared, progress: Progress) -> DesignOutcome:
        frame = self.frame(prepared)

        def show(found: Fit) -> None:
            self.latest = frame.placing(found).points(found.surface.sheet(found.sheet)), found.surface.faces

        found = self.fit(frame, prepared, progress, show)
        surface, sheet, placing = found.surface, found.sheet, frame.placing(found)
        points = placing.points(surface.sheet(sheet))
        outline, deviation = self.outline(frame, prepared), self.deviation(prepared, points)
        measured = report(
            surface,
            outline,
            sheet=sheet,
            positions={sheet: points},
            intersections=False,
            up=frame.up,
        )
        return DesignOutcome(
            found,
            points,
            placed_normals(surface.normals, sheet, placing),
            sheet_measures(surface, placing, points, sheet, self.measured, outline if deviation is None else None),
            find_cut(self.mesh, prepared.triangles, prepared.owners, surface.faces, surface.source),
            measured.to_dict(),
            deviation,
        )

    # --- what the two do differently

    def frame(self, prepared: plan_cache.Prepared) -> Frame:
        raise NotImplementedError

    def fit(
        self, frame: Frame, prepared: plan_cache.Prepared, progress: Progress, show: Callable[[Fit], None]
    ) -> Fit:
        raise NotImplementedError

    def outline(self, frame: Frame, prepared: plan_cache.Prepared) -> Array | list[Array] | None:
        """What the rim's distance is measured from: drawn positions of the vertices, closed lines, or nothing."""
        return self.mesh.positions

    def deviation(self, prepared: plan_cache.Prepared, points: Array) -> Array | None:
        return None

    # --- the result

    def deliver(self, context: bpy.types.Context, plan: bpy.types.Object, outcome: DesignOutcome) -> list[str]:
        """Write the result of a plan and return what the user should be warned of.

        Raises `CmcError`, with nothing changed, where the plan is not what it was when the order was taken.
        """
        depsgraph = plan_depsgraph(context, self.settings)
        check_unchanged(plan, depsgraph, self.mesh)
        writer = Writer(context, plan, depsgraph, self.mesh, outcome.cut)
        writer.write(self.role, outcome.points, outcome.normals, outcome.measures)
        result = result_of(plan, self.role)
        result.cmc.parked = result.hide_viewport = result.hide_render = False
        if self.role == "FIT":
            park(result_of(plan, plan.cmc.sheet))
        told = self._report(context, plan, outcome)
        if outcome.deviation is not None:
            show_deviation(plan, result, outcome.deviation)
        write_report(result, told)
        plan.cmc.design_report = json.dumps(told, ensure_ascii=False)
        for name in self.stored:
            setattr(plan.cmc, name, getattr(self.settings, name))
        for name, block in self.chosen.items():
            setattr(plan.cmc, name, _still_there(block))
        colours.repaint(plan)
        return [*self.warnings, *([] if outcome.converged else [outcome.message])]

    def _report(self, context: bpy.types.Context, plan: bpy.types.Object, outcome: DesignOutcome) -> dict:
        found = outcome.fit
        told = {
            "plan": plan.name,
            "unit_scale": context.scene.unit_settings.scale_length,
            "design": self.role,
            **outcome.report,
            "message": outcome.message,
            "met": outcome.converged,
            "distances": {label: float(number) for label, number in found.distances.items()},
            "evaluations": len(found.history),
        }
        if outcome.deviation is not None:
            told["deviation"] = {"mean": float(outcome.deviation.mean()), "max": float(outcome.deviation.max())}
        return told


def read_order(context: bpy.types.Context, plan: bpy.types.Object, settings: SimpleNamespace) -> dict:
    """What every order is made of. Settings get what is stored with the plan for all solves."""
    settings.apply_modifiers, settings.tolerance = plan.cmc.apply_modifiers, plan.cmc.tolerance
    mesh = read_plan(plan, plan_depsgraph(context, settings))
    measured = colours.wanted_measures(plan)
    return {"name": plan.name, "mesh": mesh, "settings": settings, "measured": measured}


def _still_there(block: tuple[str, str] | None):
    """A data-block by collection and name, if it has not been deleted meanwhile."""
    return None if block is None else getattr(bpy.data, block[0]).get(block[1])


@dataclass(frozen=True, eq=False)
class DesignOutcome:
    """What a fit gave, in the world; deviation (n,): distances of the points from the surface that was fitted to."""

    fit: Fit
    points: Array
    normals: Array
    measures: Measured
    cut: Cut | None
    report: dict
    deviation: Array | None

    @property
    def converged(self) -> bool:
        """Whether the wishes are met."""
        return bool(self.fit.is_met)

    @property
    def message(self) -> str:
        """How near it came; where that is not near enough, what to change."""
        if not self.converged:
            return self.fit.message
        if self.deviation is not None:
            mean, most = self.deviation.mean(), self.deviation.max()
            return f"The nearest surface is {most:.2g} off at most, {mean:.2g} on average."
        near = [f"{label} to {number:.2g}" for label, number in self.fit.distances.items() if label != SmoothRim.label]
        return f"Fitted: {', '.join(near)}."


def counted(progress: Progress) -> Progress:
    """A progress that counts on where the evaluations are counted from the beginning, in a stage or a slice."""
    before = last = 0

    def told(count: int, value: float) -> bool | None:
        nonlocal before, last
        before, last = (before + last if count <= last else before), count
        return progress(before + count, value)

    return told
