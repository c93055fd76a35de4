"""Solve: from a plan and its boundary groups to the shell over it. All other tasks on a shell start from this one."""

from __future__ import annotations

import json
import time
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from types import SimpleNamespace

import bpy
import numpy as np
from numpy.typing import NDArray

from ...solver.errors import CmcError, Progress
from ...solver.gauss.conditions import KINDS
from ...solver.notes import Note, notes_data
from ...solver.shells import form
from ...solver.shells.close import closing_report
from ...solver.shells.mixed import sides_report
from ...solver.shells.plan import Group, Plan, Settings
from ...solver.shells.polygon_sheets import PolygonSheet, polygon_sheet
from ...solver.shells.shell import Shell
from ...solver.shells.span import span_report
from ...solver.surface.cmc_surface import SHEETS
from ..background import plan_cache, solve_cache
from ..bridges.drawn_bridge import coarse, drawn_warnings
from ..bridges.mesh_bridge import PlanMesh, read_plan
from ..bridges.outline_bridge import WAY_OUT, closed_lines
from ..bridges.result_bridge import Cut, find_cut, put_plan_layer
from ..properties.attributes import ATTRIBUTES, USUAL
from ..properties.closing_settings import closing_of
from ..properties.group_settings import parameter_values
from ..properties.links import result_of, results_of, wanted_roles
from ..properties.made import made_here
from ..properties.settings import SETTINGS, SIDES, SIZE_PROPERTY, fitted_settings
from ..properties.stored import ROLES
from ..properties.units import in_scene_units
from ..results import colours
from ..results.measures import Measured, polygon_measures, sheet_measures
from ..results.objects import Writer, delete_result, hide_completed, show_wanted, write_report
from .task import Result, Task


@dataclass(frozen=True, eq=False)
class SolveResult(Result):
    """A shell, its cut where it is open, and the faces and measures of its result objects.

    more: tables to add to the report.
    """

    shell: Shell
    prepared: plan_cache.Prepared
    combinatorics: str
    cut: Cut | None
    more: dict = field(default_factory=dict)
    _polygons: dict[str, PolygonSheet] = field(default_factory=dict)
    _measures: dict[str, Measured] = field(default_factory=dict)

    def polygons(self, sheet: str) -> PolygonSheet | None:
        """A placed sheet with faces of its own, made once; None where it has the plan's."""
        if self.combinatorics == "primal":
            return None
        if sheet not in self._polygons:
            self._polygons[sheet] = polygon_sheet(self.shell, sheet, self.combinatorics)
        return self._polygons[sheet]

    def measures(self, sheet: str, task: SolveTask) -> Measured | None:
        """The measures on a placed sheet, each made once; None on g and the Gauss image."""
        if sheet not in SHEETS:
            return None
        known, shell = self._measures.setdefault(sheet, {}), self.shell
        names = [name for name in task.measured if name != "deviation" or sheet == ROLES[task.settings.sheet]]
        missing = [name for name in names if ATTRIBUTES[name] not in known]
        points, outline = shell.placed[sheet], task.mesh.positions
        known |= sheet_measures(shell.surface, shell.similarity, points, sheet, missing, outline)
        return {ATTRIBUTES[name]: known[ATTRIBUTES[name]] for name in names}

    @property
    def converged(self) -> bool:
        return self.shell.ok

    @property
    def message(self) -> str:
        return in_scene_units(self.shell.message)


@dataclass(frozen=True, eq=False)
class SolveTask(Task[SolveResult]):
    """A solve, without any Blender data. measured: names of the measures. started: when the plan was read."""

    name: str
    mesh: PlanMesh
    groups: list[Group]
    settings: SimpleNamespace
    warnings: list[Note]
    measured: tuple[str, ...] = USUAL
    started: float = field(default_factory=time.time)

    @classmethod
    def read(
        cls,
        context: bpy.types.Context,
        plan: bpy.types.Object,
        settings: SimpleNamespace,
        selection: dict | None = None,
    ) -> SolveTask:
        """Read the plan, its groups and, with `selection` (kind and parameters), its selected boundary edges.

        Raises `CmcError` where the plan cannot be read or no boundary edge is selected.
        """
        mesh = read_plan(plan, plan_depsgraph(context, settings))
        selected = np.zeros(len(mesh.edges), dtype=bool)
        if selection is not None:
            selected = mesh.selected & mesh.boundary
            if not selected.any():
                raise CmcError(
                    f"No boundary edge of '{plan.name}' is selected; select edges of its outline in edit mode."
                )
        groups, warnings = _groups(context, plan.data.cmc.groups, mesh, selected)
        warnings += plan_warnings(context, plan, settings)
        if selection is not None:
            kind = selection["kind"].lower()
            groups.append(Group("Selection", mesh.edges[selected], kind, selection["parameters"]))
        return cls(plan.name, mesh, groups, settings, warnings, colours.wanted_measures(plan))

    @property
    def tolerance(self) -> float:
        return self.settings.tolerance

    def made(self, more: SimpleNamespace | None = None) -> dict:
        """The provenance of the report; more: settings of a further task."""
        settings = vars(self.settings) | vars(more or SimpleNamespace())
        return made_here(self.name, plan_cache.fingerprint(self.mesh), settings, self.groups, self.started)

    def all_warnings(self, result: SolveResult) -> list[Note]:
        """Those of the plan and of its shell, in the units of the scene."""
        return [*self.warnings, *map(in_scene_units, result.shell.warnings)]

    def shows(self) -> str:
        return self.settings.sheet

    def work(self, progress: Progress) -> SolveResult:
        settings = solver_settings(self.settings)
        prepared = plan_cache.prepare(self.mesh, settings.solver_choice)
        with prepared.plan_numbers(self.mesh):
            shell = form.form(
                self.plan(prepared),
                settings,
                solver=prepared.solver,
                progress=progress,
                intersections=self.settings.intersections and still_wanted(progress),
            )
        result = self.result(shell, prepared, _tables(shell, self.groups))
        for name in self.sheets(shell):
            result.measures(name, self)
        solve_cache.remember(self, result)
        return result

    def plan(self, prepared: plan_cache.Prepared) -> Plan:
        """The plan as the solver takes it."""
        return replace(
            self.mesh.as_plan(prepared.triangles),
            polygons=self.mesh.polygons(),
            groups=self.groups,
            triangle_polygons=prepared.owners,
            flipped_corners=self.mesh.flipped_corners,
        )

    def result(self, shell: Shell, prepared: plan_cache.Prepared, more: dict | None = None) -> SolveResult:
        """A shell over this plan, cut as its result objects will be."""
        cut = find_cut(self.mesh, prepared.triangles, prepared.owners, shell.faces, shell.source)
        result = SolveResult(shell, prepared, self.settings.combinatorics.lower(), cut, more or {})
        for name in self.sheets(shell):
            result.polygons(name)
        return result

    def sheets(self, shell: Shell) -> list[str]:
        """The wanted sheets that are not points."""
        return [name for name in (ROLES[role] for role in wanted_roles(self.settings)) if name in shell.placed]

    def write(self, context: bpy.types.Context, plan: bpy.types.Object, result: SolveResult) -> list[Note]:
        self.check_unchanged(context, plan)
        warnings = self.write_results(context, plan, result)
        for name in SETTINGS:
            setattr(plan.cmc, name, getattr(self.settings, name))
        return warnings

    def check_unchanged(self, context: bpy.types.Context, plan: bpy.types.Object) -> None:
        check_unchanged(plan, plan_depsgraph(context, self.settings), self.mesh)

    def write_results(self, context: bpy.types.Context, plan: bpy.types.Object, result: SolveResult) -> list[Note]:
        """Write into a plan that has at least the polygons of this task; its settings stay."""
        shell, wanted = result.shell, wanted_roles(self.settings)
        warnings = self.all_warnings(result)
        writer = Writer(context, plan, plan_depsgraph(context, self.settings), self.mesh, result.cut)
        for role, sheet in ROLES.items():
            existing = result_of(plan, role)
            if role not in wanted and existing is None:
                continue
            if sheet not in shell.placed:  # a single point; the shell's warnings say so
                if existing is not None:
                    delete_result(existing)
                continue
            self._write_sheet(writer, role, result)
        write_reports(context, plan, result, warnings, self.made())
        show_wanted(plan, wanted)
        hide_completed(plan, True)
        plan.cmc.message, plan.cmc.latest = result.message, self.settings.sheet
        colours.repaint(plan, self.settings.sheet)
        return warnings

    def _write_sheet(self, writer: Writer, role: str, result: SolveResult) -> None:
        sheet, shell = ROLES[role], result.shell
        polygons, measures = result.polygons(sheet), result.measures(sheet, self)
        if polygons is None:
            result_object = writer.write(role, shell.placed[sheet], shell.normals[sheet], measures)
            if shell.adapted_plan is not None:
                put_plan_layer(result_object.data, shell.adapted_plan[shell.source])
            return
        if measures is not None:
            measures = polygon_measures(measures, polygons, shell.source, len(self.mesh.positions))
        writer.write_polygons(role, polygons, result.prepared.triangles, result.prepared.owners, measures)


def still_wanted(progress: Progress) -> Callable[[], bool]:
    """For work without steps: asks `progress` whether to continue, and reports nothing."""
    return lambda: progress(-1, 0.0) is not False


def plan_depsgraph(context: bpy.types.Context, settings: SimpleNamespace) -> bpy.types.Depsgraph | None:
    """The depsgraph to read the plan with, if its modifiers are applied."""
    return context.evaluated_depsgraph_get() if settings.apply_modifiers else None


def plan_warnings(context: bpy.types.Context, plan: bpy.types.Object, settings: SimpleNamespace) -> list[Note]:
    """What of a plan is seen and not solved."""
    if settings.apply_modifiers:
        return coarse(plan)
    return drawn_warnings(context, plan, "tick Apply Modifiers to solve what is seen")


def check_unchanged(plan: bpy.types.Object, depsgraph: bpy.types.Depsgraph | None, mesh: PlanMesh) -> None:
    """Raise `CmcError` where the plan is no longer as `mesh` was read."""
    if plan_cache.fingerprint(read_plan(plan, depsgraph)) != plan_cache.fingerprint(mesh):
        raise CmcError(f"'{plan.name}' was changed while it was being solved; solve again.")


def write_reports(
    context: bpy.types.Context, plan: bpy.types.Object, result: SolveResult, warnings: list[Note], made: dict
) -> None:
    """Put the solver's report on a plan and its results, with names and the scene's unit."""
    report = {
        "plan": plan.name,
        "unit_scale": context.scene.unit_settings.scale_length,
        "message": result.message,
        **result.shell.report.to_dict(),
        "holes": [gap.to_dict() for gap in result.shell.gaps],
        **result.more,
        "warnings": notes_data(warnings),
        "made": made,
    }
    for ob in results_of(plan).values():
        write_report(ob, report)
    plan.cmc.report = json.dumps(report, ensure_ascii=False)


def _tables(shell: Shell, groups: list[Group]) -> dict[str, object]:
    """How a shell was closed; of a shell on lines the search for its span, or how far its sides are from what was asked
    of them."""
    if shell.closing is not None:
        return {"closing": closing_report(shell.closing)}
    if shell.span is not None:
        return {"span": span_report(shell.span)}
    return {"sides": sides_report(groups, shell.fit)} if shell.fit is not None and shell.fit.sides else {}


def _groups(
    context: bpy.types.Context, groups, mesh: PlanMesh, taken: NDArray[np.bool_]
) -> tuple[list[Group], list[Note]]:
    """The plan's groups with their boundary edges, without those taken; and a warning for each edge left out."""
    read, warnings = [], []
    for group in groups:
        mine = mesh.groups == group.uid
        inside = int((mine & ~mesh.boundary).sum())
        if inside:
            text = f"{inside} edges of group '{group.name}' are not on the boundary: ignored."
            warnings.append(Note("left-out", text))
        edges = mesh.edges[mine & mesh.boundary & ~taken]
        if len(edges):
            parameters = parameter_values(group.kind, group)
            if KINDS[group.kind.lower()].curve and group.curve is not None:
                parameters["curve"] = _curve(group)
                warnings += drawn_warnings(context, group.curve, WAY_OUT)
            read.append(Group(group.name, edges, group.kind.lower(), parameters))
    return read, warnings


def _curve(group) -> tuple[tuple[float, ...], ...]:
    """The curve of a group as plain values, which compare."""
    lines = closed_lines(group.curve, f"for the group '{group.name}'")
    if len(lines) != 1:
        raise CmcError(
            f"'{group.curve.name}' has {len(lines)} closed loops; the group '{group.name}' lies on one. Separate them, "
            "and give each loop of the plan a group with a curve of its own."
        )
    return tuple(map(tuple, lines[0].tolist()))


def settings_of(owner) -> SimpleNamespace:
    """The solve settings of an object as plain values; the energy is one that fits the sites."""
    return fitted_settings({name: getattr(owner, name) for name in SETTINGS})


def solver_settings(settings: SimpleNamespace) -> Settings:
    """The settings as the solver takes them."""
    value_name = SIZE_PROPERTY[settings.size]
    return Settings(
        size=settings.size.lower(),
        value=getattr(settings, value_name) if value_name else 1.0,
        default_kind=settings.default_kind.lower(),
        holes=settings.holes.lower(),
        corners=settings.corners.lower(),
        close=closing_of(settings),
        ground=settings.ground.lower(),
        blend=settings.blend,
        against=settings.against.lower(),
        rotate=settings.rotate,
        flip=settings.flip,
        sheet=ROLES[settings.sheet],
        sites=settings.sites.lower(),
        energy=settings.energy.lower(),
        method=settings.method.lower(),
        delaunay=settings.delaunay,
        combinatorics=settings.combinatorics.lower(),
        averaging=settings.averaging.lower(),
        tolerance=settings.tolerance,
        shell="bubble" if settings.shell == "BUBBLE" else "first",
        degree=settings.degree if settings.shell == "DEGREE" else None,
        side=SIDES[settings.side],
        count_modes=settings.count_modes,
    )
