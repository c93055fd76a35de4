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
from functools import partial
from types import SimpleNamespace

import bpy
import numpy as np
from numpy.typing import NDArray

from ...solver.errors import Progress
from ...solver.fitting.fit import Fit
from ...solver.fitting.targets import SmoothRim
from ...solver.measure import report
from ...solver.measure.curvature_fault import curvature_note
from ...solver.notes import Note, Sentence, notes_data
from ...solver.shells.gaps import HoleGap, surface_gaps
from ...solver.shells.measured import placed_normals
from ..background import plan_cache
from ..bridges.mesh_bridge import PlanMesh, read_plan
from ..bridges.result_bridge import Cut, find_cut
from ..properties.attributes import USUAL
from ..properties.distances import goal_text
from ..properties.links import result_of
from ..properties.made import made_here
from ..properties.units import length_text
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
    """A fitted shell in the world, with the gap around each hole of its plan.

    deviation (n,): distances of the points from the surface that it approximates. notes: warnings about the shell.
    """

    fit: Fit
    points: Array
    normals: Array
    measures: Measured
    cut: Cut | None
    report: dict
    gaps: list[HoleGap]
    deviation: Array | None
    notes: list[Note]

    @property
    def converged(self) -> bool:
        """Whether the goals are met."""
        return bool(self.fit.is_met)

    @property
    def message(self) -> str:
        """How near the shell is to its target, and what to change where that is not near enough."""
        if not self.converged:
            write = partial(length_text, digits=2)
            return " ".join(
                text.written(write) if isinstance(text, Sentence) else text for text in self.fit.sentences
            )
        if self.deviation is not None:
            mean, most = (length_text(float(off), digits=2) for off in (self.deviation.mean(), self.deviation.max()))
            return f"The nearest surface is {most} off at most, {mean} on average."
        size, known = float(np.ptp(self.points, axis=0).max()), self.fit.distances.items()
        texts = {label: goal_text(label, off, size) for label, off in known if label != SmoothRim.label}
        near = [f"{label} to {text}" for label, text in texts.items() if text != "None"]
        return f"Fitted: {', '.join(near)}." if near else "Fitted: all goals are met."


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
    warnings: list[Note] = field(default_factory=list)
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
        N = (1.0 if sheet == "f+" else -1.0) * placing.directions(surface.normals)
        off = curvature_note(measured.shown, surface.domain, self.mesh.positions, points, surface.faces, N)
        return DesignResult(
            fit,
            points,
            placed_normals(surface.normals, sheet, placing),
            sheet_measures(surface, placing, points, sheet, self.measured, outline if deviation is None else None),
            find_cut(self.mesh, prepared.triangles, prepared.owners, surface.faces, surface.source),
            measured.to_dict(),
            surface_gaps(surface, placing, points),
            deviation,
            [] if off is None else [off],
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

    def write(self, context: bpy.types.Context, plan: bpy.types.Object, result: DesignResult) -> list[Note]:
        depsgraph = plan_depsgraph(context, self.settings)
        check_unchanged(plan, depsgraph, self.mesh)
        writer = Writer(context, plan, depsgraph, self.mesh, result.cut)
        ob = writer.write(self.role, result.points, result.normals, result.measures)
        ob.cmc.parked = ob.hide_viewport = ob.hide_render = False
        if self.role == "FIT":
            park(result_of(plan, plan.cmc.sheet))
        missed = [] if result.converged else [Note("goal-missed", result.message)]
        notes = [*self.warnings, *missed, *result.notes]
        table = self._report(context, plan, result) | {"warnings": notes_data(notes)}
        if result.deviation is not None:
            show_deviation(plan, ob, result.deviation)
        write_report(ob, table)
        plan.cmc.design_report, plan.cmc.latest = json.dumps(table, ensure_ascii=False), self.role
        for name in self.stored:
            setattr(plan.cmc, name, getattr(self.settings, name))
        for name, block in self.targets.items():
            setattr(plan.cmc, name, _still_there(block))
        colours.repaint(plan)
        return notes

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
            "holes": [gap.to_dict() for gap in result.gaps],
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
