"""One solve of one plan: from the plan object to arrays, and from arrays to result objects.

Between the two lies the work itself, which sees no Blender data and may run in a thread (`session.steps`).
"""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from types import SimpleNamespace

import bpy
import numpy as np
from numpy.typing import NDArray

from ...solver.errors import CmcError, Progress
from ...solver.shells import form
from ...solver.shells.gaps import hole_gaps
from ...solver.shells.plan import Group, Plan, Settings
from ...solver.shells.polygon_sheets import PolygonSheet, polygon_sheet
from ...solver.shells.shell import Shell
from ...solver.surface.cmc_surface import SHEETS
from ..background import plan_cache, solve_cache
from ..bridges.mesh_bridge import PlanMesh, read_plan
from ..bridges.numbering import in_plan_numbers
from ..bridges.result_bridge import Cut, find_cut
from ..properties.attributes import ATTRIBUTES, USUAL
from ..properties.group_settings import parameter_values
from ..properties.links import result_of, results_of, wanted_roles
from ..properties.settings import SETTINGS, SIDES, SIZE_PROPERTY, fitted_settings
from ..properties.stored import ROLES
from ..results import colours
from ..results.measures import Measured, polygon_measures, sheet_measures
from ..results.objects import Writer, delete_result, hide_completed, show_wanted, write_report


@dataclass(frozen=True, eq=False)
class Order:
    """All that a solve needs, without any Blender data: safe in a thread. measured: names of what to measure."""

    name: str
    mesh: PlanMesh
    groups: list[Group]
    settings: SimpleNamespace
    warnings: list[str]
    measured: tuple[str, ...] = USUAL

    def work(self, progress: Progress) -> Outcome:
        """Solve. Raises `CmcError` in the plan's own numbering."""
        settings = solver_settings(self.settings)
        prepared = plan_cache.prepare(self.mesh, settings.solver_choice)
        try:
            shell = form.form(
                self.plan(prepared),
                settings,
                solver=prepared.solver,
                progress=progress,
                intersections=self.settings.intersections and asking(progress),
            )
        except CmcError as error:
            raise in_plan_numbers(error, self.mesh, prepared.triangles, prepared.owners) from error
        cut = find_cut(self.mesh, prepared.triangles, prepared.owners, shell.faces, shell.source)
        outcome = Outcome(shell, prepared, settings.combinatorics, cut)
        for name in (ROLES[role] for role in wanted_roles(self.settings)):
            if name in shell.placed:
                outcome.polygons(name)
                outcome.measures(name, self)
        solve_cache.remember(self, outcome)
        return outcome

    def plan(self, prepared: plan_cache.Prepared) -> Plan:
        """The plan as the solver takes it."""
        return replace(
            self.mesh.as_plan(prepared.triangles),
            polygons=self.mesh.polygons(),
            groups=self.groups,
            triangle_polygons=prepared.owners,
            flipped_corners=self.mesh.flipped_corners,
        )

    def deliver(self, context: bpy.types.Context, plan: bpy.types.Object, outcome: Outcome) -> list[str]:
        """Write the results of the plan; see `deliver`."""
        return deliver(context, plan, self, outcome)


def asking(progress: Progress) -> Callable[[], bool]:
    """Whether work without steps is still wanted: its progress is that of the last of the steps before it."""
    return lambda: progress(-1, 0.0)


@dataclass(frozen=True, eq=False)
class Outcome:
    """What the work gave: the surface, placed, where it is cut open, and the faces that its results are to have.

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

    def measures(self, sheet: str, order: Order) -> Measured | None:
        """What an order asks to measure of a placed sheet, each made once; None on g and the Gauss image."""
        if sheet not in SHEETS:
            return None
        known, shell = self._measures.setdefault(sheet, {}), self.shell
        names = [name for name in order.measured if name != "deviation" or sheet == ROLES[order.settings.sheet]]
        missing = [name for name in names if ATTRIBUTES[name] not in known]
        points, outline = shell.placed[sheet], order.mesh.positions
        known |= sheet_measures(shell.surface, shell.similarity, points, sheet, missing, outline)
        return {ATTRIBUTES[name]: known[ATTRIBUTES[name]] for name in names}

    @property
    def converged(self) -> bool:
        return self.shell.converged

    @property
    def message(self) -> str:
        return self.shell.message


def take_order(
    context: bpy.types.Context,
    plan: bpy.types.Object,
    settings: SimpleNamespace,
    selection: dict | None = None,
) -> Order:
    """Read the plan, its groups and, with `selection` (kind and parameters), its selected boundary edges.

    Raises `CmcError` where the plan cannot be read or nothing suitable is selected.
    """
    mesh = read_plan(plan, plan_depsgraph(context, settings))
    chosen = np.zeros(len(mesh.edges), dtype=bool)
    if selection is not None:
        chosen = mesh.selected & mesh.boundary
        if not chosen.any():
            raise CmcError(
                f"No boundary edge of '{plan.name}' is selected; select edges of its outline in edit mode."
            )
    groups, warnings = _groups(plan.data.cmc.groups, mesh, chosen)
    if selection is not None:
        kind = selection["kind"].lower()
        groups.append(Group("Selection", mesh.edges[chosen], kind, selection["parameters"]))
    return Order(plan.name, mesh, groups, settings, warnings, colours.wanted_measures(plan))


def plan_depsgraph(context: bpy.types.Context, settings: SimpleNamespace) -> bpy.types.Depsgraph | None:
    """The depsgraph to read the plan with, if its modifiers are to be applied."""
    return context.evaluated_depsgraph_get() if settings.apply_modifiers else None


def _groups(
    groups, mesh: PlanMesh, taken: NDArray[np.bool_]
) -> tuple[list[Group], list[str]]:
    """The plan's groups with their boundary edges, less those taken otherwise; and what was left out."""
    found, warnings = [], []
    for group in groups:
        mine = mesh.groups == group.uid
        inside = int((mine & ~mesh.boundary).sum())
        if inside:
            warnings.append(f"{inside} edges of group '{group.name}' are not on the boundary: ignored.")
        edges = mesh.edges[mine & mesh.boundary & ~taken]
        if len(edges):
            parameters = parameter_values(group.kind, group)
            found.append(Group(group.name, edges, group.kind.lower(), parameters))
    return found, warnings


def settings_of(owner) -> SimpleNamespace:
    """The solve settings of an object as plain values; the energy is one that fits the sites."""
    return fitted_settings({name: getattr(owner, name) for name in SETTINGS})


def solver_settings(settings: SimpleNamespace) -> Settings:
    """Settings as the pipeline takes them."""
    value_name = SIZE_PROPERTY[settings.size]
    return Settings(
        size=settings.size.lower(),
        value=getattr(settings, value_name) if value_name else 1.0,
        ground=settings.ground.lower(),
        blend=settings.blend,
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


def _report(context: bpy.types.Context, plan: bpy.types.Object, outcome: Outcome) -> dict:
    """The solver's report, with what only Blender knows: the plan's name and the scene's unit."""
    return {
        "plan": plan.name,
        "unit_scale": context.scene.unit_settings.scale_length,
        "message": outcome.shell.message,
        **outcome.shell.report.to_dict(),
        "holes": [gap.to_dict() for gap in hole_gaps(outcome.shell)],
        **outcome.more,
    }


def tell(context: bpy.types.Context, plan: bpy.types.Object, outcome: Outcome, warnings: list[str]) -> None:
    """Put the report on a plan and its results."""
    report = {**_report(context, plan, outcome), "warnings": warnings}
    for result in results_of(plan).values():
        write_report(result, report)
    plan.cmc.report = json.dumps(report, ensure_ascii=False)


def check_unchanged(plan: bpy.types.Object, depsgraph: bpy.types.Depsgraph | None, mesh: PlanMesh) -> None:
    """Raise `CmcError` where the plan is not what it was when `mesh` was read."""
    if plan_cache.fingerprint(read_plan(plan, depsgraph)) != plan_cache.fingerprint(mesh):
        raise CmcError(f"'{plan.name}' was changed while it was being solved; solve again.")


def deliver(
    context: bpy.types.Context, plan: bpy.types.Object, order: Order, outcome: Outcome
) -> list[str]:
    """Write the results of a plan and return what the user should be warned of.

    Raises `CmcError`, with nothing changed, where the plan is not what it was when the order was taken.
    """
    check_unchanged(plan, plan_depsgraph(context, order.settings), order.mesh)
    warnings = put_results(context, plan, order, outcome)
    for name in SETTINGS:
        setattr(plan.cmc, name, getattr(order.settings, name))
    return warnings


def put_results(
    context: bpy.types.Context, plan: bpy.types.Object, order: Order, outcome: Outcome
) -> list[str]:
    """The same for a plan whose polygons, at least, are those that the order was taken with; its settings stay."""
    settings, shell = order.settings, outcome.shell
    depsgraph = plan_depsgraph(context, settings)
    wanted = wanted_roles(settings)
    warnings = [*order.warnings, *shell.warnings]
    writer = Writer(context, plan, depsgraph, order.mesh, outcome.cut)
    for role, sheet in ROLES.items():
        existing = result_of(plan, role)
        if role not in wanted and existing is None:
            continue
        if sheet not in shell.placed:  # a single point; the pipeline's warnings say so
            if existing is not None:
                delete_result(existing)
            continue
        polygons, prepared = outcome.polygons(sheet), outcome.prepared
        measures = outcome.measures(sheet, order)
        if polygons is None:
            writer.write(role, shell.placed[sheet], shell.normals[sheet], measures)
        else:
            if measures is not None:
                measures = polygon_measures(measures, polygons, shell.source, len(order.mesh.positions))
            writer.write_polygons(role, polygons, prepared.triangles, prepared.owners, measures)
    tell(context, plan, outcome, warnings)
    show_wanted(plan, wanted)
    hide_completed(plan, True)
    plan.cmc.message = shell.message
    colours.repaint(plan, settings.sheet)
    return warnings
