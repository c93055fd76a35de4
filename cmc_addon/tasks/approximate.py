"""Approximate Surface: the CMC surface nearest to the plan itself, a surface in space.

During the work `latest` is the best shape so far, for the screen.
"""

from __future__ import annotations

import json
import time
from dataclasses import dataclass, field, replace
from functools import partial
from types import SimpleNamespace

import bpy
import numpy as np
from numpy.typing import NDArray

from ...solver.errors import Progress
from ...solver.fitting.fit import Fit, FitStatus
from ...solver.fitting.gauss_map import GaussMapOptions, fit_gauss_map
from ...solver.measure import report
from ...solver.measure.curvature_fault import curvature_note
from ...solver.notes import Note, Sentence, notes_data
from ...solver.shells.gaps import HoleGap, surface_gaps
from ...solver.shells.measured import placed_normals
from ...solver.surface.placement import Similarity
from ..background import plan_cache
from ..bridges.mesh_bridge import PlanMesh, read_plan
from ..bridges.result_bridge import Cut, find_cut
from ..properties.approximate_settings import APPROXIMATE_SETTINGS
from ..properties.attributes import USUAL
from ..properties.made import made_here
from ..properties.units import length_text
from ..results import colours
from ..results.deviation import deviation_from, show_deviation
from ..results.measures import Measured, sheet_measures
from ..results.objects import Writer, write_report
from .solve import check_unchanged, plan_depsgraph, plan_warnings
from .task import Result, Task

Array = NDArray[np.float64]

ROLE = "NEAREST"

LIMIT = 300
"""The largest number of evaluations."""
# Evaluations before a shape is shown; the start itself is a guess already.
_FIRST_LOOK = 5


@dataclass(frozen=True, eq=False)
class ApproximateResult(Result):
    """The surface in the world, with the gap around each hole of its plan.

    deviation (n,): distances of its points from the given surface. notes: warnings about it.
    """

    fit: Fit
    points: Array
    normals: Array
    measures: Measured
    cut: Cut | None
    report: dict
    gaps: list[HoleGap]
    deviation: Array
    notes: list[Note]

    @property
    def converged(self) -> bool:
        """Whether it is as near as can be."""
        return bool(self.fit.is_met)

    @property
    def message(self) -> str:
        """How near it is, and what to change where it was not found."""
        if not self.converged:
            write = partial(length_text, digits=2)
            return " ".join(
                text.written(write) if isinstance(text, Sentence) else text for text in self.fit.sentences
            )
        mean, most = (length_text(float(off), digits=2) for off in (self.deviation.mean(), self.deviation.max()))
        return f"The nearest surface is {most} off at most, {mean} on average."


@dataclass(eq=False)
class ApproximateTask(Task[ApproximateResult]):
    """An approximation, without any Blender data.

    settings: `APPROXIMATE_SETTINGS` and those that a plan stores for all its solves. options: what they mean to the
    solver. latest: points (n, 3) in the world and triangles (F, 3) of the best shape so far, set by the work.
    measured: names of what to measure. started: when the plan was read.
    """

    name: str
    mesh: PlanMesh
    settings: SimpleNamespace
    options: GaussMapOptions
    warnings: list[Note] = field(default_factory=list)
    latest: tuple[Array, NDArray] | None = None
    measured: tuple[str, ...] = USUAL
    started: float = field(default_factory=time.time)

    @classmethod
    def read(
        cls,
        context: bpy.types.Context,
        plan: bpy.types.Object,
        settings: SimpleNamespace,
        options: GaussMapOptions | None = None,
    ) -> ApproximateTask:
        """Read the plan. options: those of a job, in place of the settings, which then say as much of them as a plan
        stores."""
        if options is not None:
            settings = _stored(options, settings)
        settings.apply_modifiers, settings.tolerance = plan.cmc.apply_modifiers, plan.cmc.tolerance
        near = settings.near if settings.match == "POSITION" else 0.0
        return cls(
            plan.name,
            read_plan(plan, plan_depsgraph(context, settings)),
            settings,
            options or GaussMapOptions(settings.smoothness, near=near, max_evaluations=LIMIT),
            plan_warnings(context, plan, settings),
            measured=colours.wanted_measures(plan),
        )

    @property
    def tolerance(self) -> float:
        return self.settings.tolerance

    def shows(self) -> str:
        return ROLE

    def work(self, progress: Progress) -> ApproximateResult:
        prepared = plan_cache.prepare(self.mesh)
        with prepared.plan_numbers(self.mesh):
            return self._work(prepared, progress)

    def _work(self, prepared: plan_cache.Prepared, progress: Progress) -> ApproximateResult:
        origin = self.mesh.positions.mean(axis=0)
        fit = self._fit(prepared, origin, progress)
        surface, sheet, placing = fit.surface, fit.sheet, _placing(fit, origin)
        points = placing.points(surface.sheet(sheet))
        measured = report(
            surface, self.mesh.positions, sheet=sheet, positions={sheet: points}, intersections=False
        )
        N = (1.0 if sheet == "f+" else -1.0) * placing.directions(surface.normals)
        off = curvature_note(measured.shown, surface.domain, self.mesh.positions, points, surface.faces, N)
        return ApproximateResult(
            fit,
            points,
            placed_normals(surface.normals, sheet, placing),
            sheet_measures(surface, placing, points, sheet, self.measured, None),
            find_cut(self.mesh, prepared.triangles, prepared.owners, surface.faces, surface.source),
            measured.to_dict(),
            surface_gaps(surface, placing, points),
            deviation_from(self.mesh.positions, prepared.triangles, points),
            [] if off is None else [off],
        )

    def _fit(self, prepared: plan_cache.Prepared, origin: Array, progress: Progress) -> Fit:
        """The surface around `origin`, shown after a first look."""
        counting, points = counted(progress), self.mesh.positions - origin

        def run(options: GaussMapOptions, **changes: object) -> Fit:
            options = replace(options, solver=prepared.solver, progress=counting, **changes)
            return fit_gauss_map(prepared.solver.domain, points, **vars(options))

        first = run(self.options, near=0.0, max_evaluations=min(_FIRST_LOOK, self.options.max_evaluations))
        if first.status is FitStatus.CANCELLED or (first.status is FitStatus.CONVERGED and not self.options.near):
            return first
        self.latest = _placing(first, origin).points(first.surface.sheet(first.sheet)), first.surface.faces
        return run(self.options, initial=first)

    # --- the result

    def write(self, context: bpy.types.Context, plan: bpy.types.Object, result: ApproximateResult) -> list[Note]:
        depsgraph = plan_depsgraph(context, self.settings)
        check_unchanged(plan, depsgraph, self.mesh)
        writer = Writer(context, plan, depsgraph, self.mesh, result.cut)
        ob = writer.write(ROLE, result.points, result.normals, result.measures)
        ob.cmc.parked = ob.hide_viewport = ob.hide_render = False
        missed = [] if result.converged else [Note("goal-missed", result.message)]
        notes = [*self.warnings, *missed, *result.notes]
        table = self._report(context, plan, result) | {"warnings": notes_data(notes)}
        show_deviation(plan, ob, result.deviation)
        write_report(ob, table)
        plan.cmc.design_report, plan.cmc.latest = json.dumps(table, ensure_ascii=False), ROLE
        for name in APPROXIMATE_SETTINGS:
            setattr(plan.cmc, name, getattr(self.settings, name))
        colours.repaint(plan)
        return notes

    def _report(self, context: bpy.types.Context, plan: bpy.types.Object, result: ApproximateResult) -> dict:
        fit, fingerprint = result.fit, plan_cache.fingerprint(self.mesh)
        return {
            "plan": plan.name,
            "unit_scale": context.scene.unit_settings.scale_length,
            "design": ROLE,
            **result.report,
            "message": result.message,
            "met": result.converged,
            "distances": {label: float(number) for label, number in fit.distances.items()},
            "evaluations": len(fit.history),
            "holes": [gap.to_dict() for gap in result.gaps],
            "deviation": {"mean": float(result.deviation.mean()), "max": float(result.deviation.max())},
            "made": made_here(plan.name, fingerprint, vars(self.settings), [], self.started),
        }


def _placing(fit: Fit, origin: Array) -> Similarity:
    """The map from the points of a fit to the world."""
    return Similarity(1.0, fit.sign * np.eye(3), origin + fit.shift)


def _stored(options: GaussMapOptions, settings: SimpleNamespace) -> SimpleNamespace:
    """Options as settings of a plan, as far as it has them."""
    near = options.near or settings.near
    match = "POSITION" if options.near else "TANGENT_PLANES"
    return SimpleNamespace(smoothness=options.regularisation, match=match, near=near)


def counted(progress: Progress) -> Progress:
    """A progress that counts on where the evaluations start again from one, in a stage or a slice."""
    before = last = 0

    def counting(count: int, value: float) -> bool | None:
        nonlocal before, last
        before, last = (before + last if count <= last else before), count
        return progress(before + count, value)

    return counting
