"""The overlay of a viewport: the rim of the active plan, and the planes, cuts and gaps of its results.

A part is a list of layers with the matrix that places them in the world. Parts are kept from redraw to redraw (see
`overlay_cache`); `overlay_draw` draws them.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from itertools import count

import bpy
import numpy as np
from mathutils import Matrix
from numpy.typing import NDArray

from ...solver.errors import CmcError
from ..bridges.geometry_changes import version
from ..bridges.overlay_bridge import cut_of, line_of, points_of, seen_plan
from ..properties import group_list, preferences
from ..properties.group_settings import parameter_values
from ..properties.links import plan_to_solve, results_of, shown_shell
from ..properties.overlay_settings import SHOWN
from ..properties.reports import last_report
from ..properties.settings import SIDES
from ..properties.stored import COMPLETED_ROLES, DESIGN_ROLES, ROLES
from .overlay_cache import kept
from .overlay_layers import Layer, Look, arrow_length, cut_layer, held_lines, rim_layers
from .palette import colour_of, other_colour
from .result_layers import gap_layers, measured, plane_layers
from .rim import Drawn, Leaning, Rim, prescribed_rim
from .rim_strip import GroupState

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Part:
    """Layers, and the matrix from their coordinates to the world."""

    matrix: Matrix
    layers: list[Layer]


def frame(context: bpy.types.Context, view: bpy.types.SpaceView3D | None = None) -> list[Part]:
    """The parts to draw in a 3D view; none if the overlay is off or no plan is active."""
    settings, plan = context.scene.cmc, plan_to_solve(context)
    if not settings.show_all or plan is None or not is_plan(plan):
        return []
    if view is not None and not view.overlay.show_overlays:
        return []
    look, report = look_of(context, plan), last_report(context)
    shell = None if report is None else shown_shell(context)
    planes = _planes(plan, report, shell if is_visible(shell, context, view) else None, look)
    seen = seen_plan_of(context, plan) if is_visible(plan, context, view) else None
    parts = []
    if seen is not None:
        parts += _plan_parts(plan, seen, look, frozenset(uid for uid, _, _ in planes))
        parts += _curve_parts(plan, look, context, view)
    for result in results_of(plan, [role for role in (*ROLES, *DESIGN_ROLES) if role != "GAUSS"]).values():
        if is_visible(result, context, view):
            parts += _result_parts(result, look, planes if result == shell else [], seen)
    if shell is not None and shell.cmc.role in COMPLETED_ROLES:  # copies meet at the gaps
        return parts
    if report is not None and "show_gaps" in look.shown:
        parts += _gap_parts(plan, report, shell, context, view, look)
    if "show_cut" in look.shown and seen is not None and shell is not None:
        parts += _plan_cut(plan, seen, shell, look)
    return parts


def is_plan(ob: bpy.types.Object) -> bool:
    """Whether a mesh is in use as a plan; nothing is drawn on other meshes."""
    return ob.type == "MESH" and bool(ob.data.cmc.groups or ob.cmc.meshed or ob.cmc.report or ob.cmc.design_report)


def is_visible(ob: bpy.types.Object | None, context, view) -> bool:
    """Visible in this scene and view: not hidden, nor by its collections, nor outside the local view."""
    if ob is None or not ob.visible_get(view_layer=context.view_layer):
        return False
    return view is None or ob.visible_in_viewport_get(view)


def look_of(context: bpy.types.Context, plan: bpy.types.Object) -> Look:
    """The look of the plan, as plain values."""
    settings, group = context.scene.cmc, group_list.active(plan.data)
    return Look(
        shown=frozenset(name for name in SHOWN if getattr(settings, name)),
        scale=settings.arrow_scale,
        count=settings.arrow_count,
        colours=tuple((group.uid, colour_of(group.uid)) for group in plan.data.cmc.groups),
        active=0 if group is None else group.uid,
        width=preferences.get("line_width"),
        editing=plan.data.is_editmode,
        ungrouped=other_colour("colour_ungrouped"),
        gaps=other_colour("colour_gaps"),
        cut=other_colour("colour_cut"),
    )


def group_states(mesh: bpy.types.Mesh) -> tuple[GroupState, ...]:
    """The groups of a mesh as plain values."""
    return tuple(
        GroupState(
            group.uid, group.name, group.kind.lower(), tuple(parameter_values(group.kind, group).items()),
            is_elsewhere=group.kind == "LINE" and group.curve is not None,
        )
        for group in mesh.cmc.groups
    )


# --- the plan -------------------------------------------------------------------------------

@dataclass(frozen=True, eq=False)
class Seen:
    """A plan as drawn, turned and scaled as in the world, with its own origin.

    number: unique, to compare by.
    """

    drawn: Drawn
    rim: Rim
    number: int = field(default_factory=count().__next__)


def _leaning(settings) -> Leaning:
    return Leaning(settings.blend, settings.against.lower(), settings.default_kind.lower())


def seen_plan_of(context: bpy.types.Context, plan: bpy.types.Object) -> Seen | None:
    """The plan and its rim; None if it cannot be read."""
    settings, groups = plan.cmc, group_states(plan.data)
    matrix = plan.matrix_world.to_3x3().to_4x4()
    uids, modified = tuple(group.uid for group in groups), settings.apply_modifiers
    shape = (version(plan, plan.data), plan.mode, modified, tuple(map(tuple, matrix)), uids)
    prescribed = groups, _leaning(settings), SIDES[settings.side]

    def draw() -> Drawn | None:
        depsgraph = context.view_layer.depsgraph or context.evaluated_depsgraph_get()
        try:
            return Drawn.of(seen_plan(plan, depsgraph, np.array(matrix, dtype=np.float64), modified), uids)
        except CmcError:
            return None

    with np.errstate(all="ignore"):  # faces without area divide by zero
        drawn = kept(("drawn", plan.session_uid), shape, draw)
        key = id(drawn), prescribed
        seen = kept(("seen", plan.session_uid), key, lambda: drawn and Seen(drawn, prescribed_rim(drawn, *prescribed)))
    return seen


def _plan_parts(plan: bpy.types.Object, seen: Seen, look: Look, walls: frozenset[int]) -> list[Part]:
    key = seen.number, look, walls
    layers = kept(("rim", plan.session_uid), key, lambda: rim_layers(seen.rim, look, walls))
    return [Part(Matrix.Translation(plan.matrix_world.translation), layers)]


def _curve_parts(plan: bpy.types.Object, look: Look, context, view) -> Iterator[Part]:
    """The curves on which rims lie in place of drawn edges, in their own coordinates."""
    for group in plan.data.cmc.groups if "show_groups" in look.shown else ():
        curve = group.curve if group.kind == "LINE" else None
        if curve is not None and is_visible(curve, context, view):
            key, colour = (version(curve), look), look.colour(group.uid)
            layers = kept(
                ("curve", plan.session_uid, group.uid), key,
                lambda curve=curve, colour=colour: list(held_lines(line_of(curve, context), colour, look.width)),
            )
            yield Part(curve.matrix_world, layers)


# --- its results ----------------------------------------------------------------------------

def _planes(plan, report: dict | None, shell: bpy.types.Object | None, look: Look) -> list[tuple[int, Array, float]]:
    """The planes measured by the last solve, while its shell is visible."""
    if report is None or shell is None or "show_mirrors" not in look.shown or shell.data.is_editmode:
        return []
    return measured(report, group_states(plan.data), plan.cmc.rotate)


def _result_parts(
    result: bpy.types.Object, look: Look, planes: list[tuple[int, Array, float]], seen: Seen | None
) -> Iterator[Part]:
    """Planes and cut of a result, in its own coordinates."""
    mesh = result.data
    state, origin = version(result, mesh), np.array(result.cmc.placed_at, dtype=np.float64)
    if planes:
        length = 0.0 if seen is None else arrow_length(seen.rim, look)
        key = (state, look, length, tuple((uid, *normal, offset) for uid, normal, offset in planes), tuple(origin))
        yield Part(result.matrix_world, kept(
            ("planes", result.session_uid), key,
            lambda: list(plane_layers(planes, points_of(mesh), origin, length, look)),
        ))
    ends, _ = _cut(result)
    if "show_cut" in look.shown and len(ends):
        layers = kept(("cut layer", result.session_uid), (state, look), lambda: [cut_layer(ends, look.cut)])
        yield Part(result.matrix_world, layers)


def _cut(result: bpy.types.Object) -> tuple[Array, NDArray[np.integer]]:
    """The cut of a result, see `cut_of`."""
    mesh = result.data
    return kept(("cut", result.session_uid), (version(result, mesh), mesh.is_editmode), lambda: cut_of(mesh))


def _plan_cut(plan: bpy.types.Object, seen: Seen, shell: bpy.types.Object, look: Look) -> Iterator[Part]:
    """The cut on the plan, whether the shell is visible or not."""
    _, pairs = _cut(shell)
    if len(pairs) and pairs.max() < len(seen.drawn.positions):
        key = version(shell, shell.data), look, seen.number
        ends = seen.drawn.positions[pairs]
        layers = kept(("plan cut", plan.session_uid), key, lambda: [cut_layer(ends, look.cut)])
        yield Part(Matrix.Translation(plan.matrix_world.translation), layers)


def _gap_parts(plan, report: dict, shell, context, view, look: Look) -> list[Part]:
    """The gaps around the holes, on the shell or, without one, in its place."""
    if shell is not None and not is_visible(shell, context, view):
        return []
    origin = np.zeros(3) if shell is None else np.array(shell.cmc.placed_at, dtype=np.float64)
    matrix = Matrix() if shell is None else shell.matrix_world
    key = (str(report.get("holes")), look, tuple(origin))
    return [Part(matrix, kept(("gaps", plan.session_uid), key, lambda: list(gap_layers(report, origin, look))))]
