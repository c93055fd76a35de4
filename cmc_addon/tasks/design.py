"""Design by target: the common part of Fit to Outline and Approximate Surface.

Solve takes the boundary conditions as given; these two search for them. During the work `latest` is the best shape so
far, for the screen.
"""

from __future__ import annotations

import json
import time
from abc import abstractmethod
from collections.abc import Callable
from dataclasses import dataclass, field
from types import SimpleNamespace

import bpy
import numpy as np
from numpy.typing import NDArray

from ...solver.errors import Progress
from ...solver.fitting.fit import Fit
from ...solver.fitting.targets import SmoothRim
from ...solver.measure import report
from ...solver.shells.form import placed_normals
from ..background import plan_cache
from ..bridges.mesh_bridge import PlanMesh, read_plan
from ..bridges.result_bridge import Cut, find_cut
from ..properties.attributes import USUAL
from ..properties.links import result_of
from ..properties.made import made_here
from ..results import colours
from ..results.deviation import show_deviation
from ..results.measures import Measured, sheet_measures
from ..results.objects import Writer, park, write_report
from .design_frame import Frame
from .solve import check_unchanged, plan_depsgraph, plan_warnings
from .task import Result, Task

Array = NDArray[np.float64]

# The largest number of evaluations of a fit.
LIMIT = 300


@dataclass(frozen=True, eq=False)
class DesignResult(Result):
    """A fitted shell in the world; deviation (n,): distances of the points from the surface that it approximates."""

    fit: Fit
    points: Array
    normals: Array
    measures: Measured
    cut: Cut | None
    report: dict
    deviation: Array | None

    @property
    def converged(self) -> bool:
        """Whether the goals are met."""
        return bool(self.fit.is_met)

    @property
    def message(self) -> str:
        """How near the shell is to its target, and what to change where that is not near enough."""
        if not self.converged:
            return self.fit.message
        if self.deviation is not None:
            mean, most = self.deviation.mean(), self.deviation.max()
            return f"The nearest surface is {most:.2g} off at most, {mean:.2g} on average."
        near = [f"{label} to {number:.2g}" for label, number in self.fit.distances.items() if label != SmoothRim.label]
        return f"Fitted: {', '.join(near)}."


@dataclass(eq=False)
class DesignTask(Task[DesignResult]):
    """A fit, without any Blender data.

    latest: points (n, 3) in the world and triangles (F, 3) of the best shape so far, set by the work.
    stored: names of the settings to keep with the plan. targets: names of the data-blocks to keep with it, for the
    pointers of `design_settings`. measured: names of what to measure. started: when the plan was read.
    """

    name: str
    mesh: PlanMesh
    settings: SimpleNamespace
    role: str
    stored: tuple[str, ...] = ()
    warnings: list[str] = field(default_factory=list)
    targets: dict[str, tuple[str, str] | None] = field(default_factory=dict)
    latest: tuple[Array, NDArray] | None = None
    measured: tuple[str, ...] = USUAL
    started: float = field(default_factory=time.time)

    @property
    def tolerance(self) -> float:
        return self.settings.tolerance

    def shows(self) -> str:
        return self.role

    def work(self, progress: Progress) -> DesignResult:
        prepared = plan_cache.prepare(self.mesh)
        with prepared.plan_numbers(self.mesh):
            return self._work(prepared, progress)

    def _work(self, prepared: plan_cache.Prepared, progress: Progress) -> DesignResult:
        frame = self.frame(prepared)

        def show(fit: Fit) -> None:
            self.latest = frame.placing(fit).points(fit.surface.sheet(fit.sheet)), fit.surface.faces

        fit = self.fit(frame, prepared, progress, show)
        surface, sheet, placing = fit.surface, fit.sheet, frame.placing(fit)
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
        return DesignResult(
            fit,
            points,
            placed_normals(surface.normals, sheet, placing),
            sheet_measures(surface, placing, points, sheet, self.measured, outline if deviation is None else None),
            find_cut(self.mesh, prepared.triangles, prepared.owners, surface.faces, surface.source),
            measured.to_dict(),
            deviation,
        )

    # --- what differs between the two

    @abstractmethod
    def frame(self, prepared: plan_cache.Prepared) -> Frame:
        """The coordinates of the fit."""

    @abstractmethod
    def fit(self, frame: Frame, prepared: plan_cache.Prepared, progress: Progress, show: Callable[[Fit], None]) -> Fit:
        """The fit in these coordinates; calls `show` with shapes on the way."""

    def outline(self, frame: Frame, prepared: plan_cache.Prepared) -> Array | list[Array] | None:
        """The reference for the rim's distance: drawn positions of the vertices, closed lines, or nothing."""
        return self.mesh.positions

    def deviation(self, prepared: plan_cache.Prepared, points: Array) -> Array | None:
        """Distances (n,) of the points from the surface that they approximate, if there is one."""
        return None

    # --- the result

    def write(self, context: bpy.types.Context, plan: bpy.types.Object, result: DesignResult) -> list[str]:
        depsgraph = plan_depsgraph(context, self.settings)
        check_unchanged(plan, depsgraph, self.mesh)
        writer = Writer(context, plan, depsgraph, self.mesh, result.cut)
        ob = writer.write(self.role, result.points, result.normals, result.measures)
        ob.cmc.parked = ob.hide_viewport = ob.hide_render = False
        if self.role == "FIT":
            park(result_of(plan, plan.cmc.sheet))
        table = self._report(context, plan, result)
        if result.deviation is not None:
            show_deviation(plan, ob, result.deviation)
        write_report(ob, table)
        plan.cmc.design_report = json.dumps(table, ensure_ascii=False)
        for name in self.stored:
            setattr(plan.cmc, name, getattr(self.settings, name))
        for name, block in self.targets.items():
            setattr(plan.cmc, name, _still_there(block))
        colours.repaint(plan)
        return [*self.warnings, *([] if result.converged else [result.message])]

    def _report(self, context: bpy.types.Context, plan: bpy.types.Object, result: DesignResult) -> dict:
        fit = result.fit
        table = {
            "plan": plan.name,
            "unit_scale": context.scene.unit_settings.scale_length,
            "design": self.role,
            **result.report,
            "message": result.message,
            "met": result.converged,
            "distances": {label: float(number) for label, number in fit.distances.items()},
            "evaluations": len(fit.history),
        }
        if result.deviation is not None:
            table["deviation"] = {"mean": float(result.deviation.mean()), "max": float(result.deviation.max())}
        fingerprint = plan_cache.fingerprint(self.mesh)
        table["made"] = made_here(plan.name, fingerprint, vars(self.settings), [], self.started)
        return table


def read_common(context: bpy.types.Context, plan: bpy.types.Object, settings: SimpleNamespace) -> dict:
    """The fields that every `DesignTask` has. The settings get those that a plan stores for all its solves."""
    settings.apply_modifiers, settings.tolerance = plan.cmc.apply_modifiers, plan.cmc.tolerance
    mesh = read_plan(plan, plan_depsgraph(context, settings))
    measured = colours.wanted_measures(plan)
    warnings = plan_warnings(context, plan, settings)
    return {"name": plan.name, "mesh": mesh, "settings": settings, "measured": measured, "warnings": warnings}


def _still_there(block: tuple[str, str] | None):
    """A data-block by collection and name, if it has not been deleted meanwhile."""
    return None if block is None else getattr(bpy.data, block[0]).get(block[1])


def counted(progress: Progress) -> Progress:
    """A progress that counts on where the evaluations start again from one, in a stage or a slice."""
    before = last = 0

    def counting(count: int, value: float) -> bool | None:
        nonlocal before, last
        before, last = (before + last if count <= last else before), count
        return progress(before + count, value)

    return counting
