"""Links between an outline, its plan, its results and their copies."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

import bpy

from ...solver.errors import CmcError
from .stored import COMPLETED_ROLES, DESIGN_ROLES, ROLES


def plan_of(ob: bpy.types.Object | None) -> bpy.types.Object:
    """The plan to solve when this object is active: itself, or the plan it is a result of.

    Raises `CmcError` if it has no plan.
    """
    if ob is None:
        raise CmcError("No object is active; select a plan, or make one with Mesh Plan.")
    if ob.cmc.role == "NONE":
        return ob
    plan = ob.cmc.source
    if plan is None or not plan.users_scene:
        raise CmcError(f"'{ob.name}' is a result whose plan has been deleted; undo that, or select a plan.")
    return plan


def result_of(plan: bpy.types.Object, role: str) -> bpy.types.Object | None:
    """The result of a plan in this role; None unless it is the plan's own and in a scene."""
    result = _linked(plan, role)
    return result if result is not None and result.users_scene else None


def _linked(plan: bpy.types.Object, role: str) -> bpy.types.Object | None:
    """The same, in a scene or not: `users_scene` looks through all objects of all scenes."""
    result = getattr(plan.cmc, role.lower())
    return result if result is not None and _is_own(plan, role, result) else None


def results_of(plan: bpy.types.Object, roles: Iterable[str] = ROLES) -> dict[str, bpy.types.Object]:
    """Role -> result of a plan, for these roles; by default those of Solve."""
    results = {role: result_of(plan, role) for role in roles}
    return {role: result for role, result in results.items() if result is not None}


def _is_own(plan: bpy.types.Object, role: str, result: bpy.types.Object) -> bool:
    return result.cmc.source == plan and result.cmc.role == role


def wanted_roles(settings) -> list[str]:
    """The roles of the results to make, the shown sheet first."""
    twin = {"F_PLUS": "F_MINUS", "F_MINUS": "F_PLUS"}[settings.sheet]
    others = {twin: settings.want_twin, "G": settings.want_g, "GAUSS": settings.want_gauss}
    return [settings.sheet] + [role for role, wanted in others.items() if wanted]


def copies_of(plan: bpy.types.Object) -> bpy.types.Collection | None:
    """The collection of instances that Repeat by Symmetry made of this plan's shell, or None."""
    copies = plan.cmc.copies
    return copies if copies is not None and copies.cmc_plan == plan else None


def plan_to_solve(context: bpy.types.Context) -> bpy.types.Object | None:
    """The plan that Solve would take, see `plan_of`; None without one, or where it is not a mesh."""
    try:
        plan = plan_of(context.object)
    except CmcError:
        return None
    return plan if plan.type == "MESH" else None


def seen_results(context: bpy.types.Context, plan: bpy.types.Object) -> Iterator[bpy.types.Object]:
    """The results of a plan that are seen: first the active one, then the one written last, then the others."""
    active = context.object
    if active is not None and active.cmc.role != "NONE" and active.cmc.source == plan and _is_seen(context, active):
        yield active
    roles = (plan.cmc.latest, *COMPLETED_ROLES, plan.cmc.sheet, *DESIGN_ROLES, *ROLES)
    for role in dict.fromkeys(role for role in roles if role):
        ob = _first_copy(plan, role) or _linked(plan, role)
        if ob is not None and ob != active and _is_seen(context, ob):
            yield ob


def shown_shell(context: bpy.types.Context) -> bpy.types.Object | None:
    """The shell that is shown: of the active plan or result the one that is seen (see `seen_results`).

    Panels, overlay, legend and export are about this one. If all are hidden it is the last one written. A result whose
    plan has been deleted is its own.
    """
    plan = plan_to_solve(context)
    if plan is None:
        return context.object if is_orphan(context.object) else None
    seen = (ob for ob in seen_results(context, plan) if ob.cmc.role not in _IMAGES)
    roles = [role for role in (plan.cmc.latest, plan.cmc.sheet, *DESIGN_ROLES) if role]
    hidden = (_first_copy(plan, role) or result_of(plan, role) for role in roles)
    return next(seen, None) or next((ob for ob in hidden if ob is not None), None)


def is_orphan(ob: bpy.types.Object | None) -> bool:
    """Whether this is a result whose plan has been deleted."""
    if ob is None or ob.type != "MESH" or ob.cmc.role == "NONE":
        return False
    return ob.cmc.source is None or not ob.cmc.source.users_scene


_IMAGES = ("G", "GAUSS")
"""Roles of results that are no shells."""


def _first_copy(plan: bpy.types.Object, role: str) -> bpy.types.Object | None:
    """The first of the instances of a repeated shell."""
    copies = copies_of(plan) if role in COMPLETED_ROLES else None
    return copies.objects[0] if copies is not None and copies.objects else None


def _is_seen(context: bpy.types.Context, ob: bpy.types.Object) -> bool:
    return ob.visible_get(view_layer=context.view_layer)


def by_uid(uid: int) -> bpy.types.Object | None:
    """An object by its session uid, which survives undo and renaming; Python references do not."""
    return next((ob for ob in bpy.data.objects if ob.session_uid == uid), None)


@dataclass(frozen=True)
class Family:
    """Results that share a colour range: the shell that sets it, others with values, and images with its colours."""

    shell: bpy.types.Object
    others: list[bpy.types.Object]
    images: list[bpy.types.Object]

    def members(self) -> Iterable[bpy.types.Object]:
        return (self.shell, *self.others, *self.images)


def families(plan: bpy.types.Object, sheet: str = "") -> list[Family]:
    """The results of a plan that can be coloured. sheet: role of the shell, by default the setting's."""
    known = []
    solved = results_of(plan)
    shell = solved.pop(sheet or plan.cmc.sheet, None)
    if shell is not None:
        images = [solved.pop(role) for role in ("G", "GAUSS") if role in solved]
        known.append(Family(shell, [*solved.values(), *_completed(plan)], images))
    known += [Family(ob, [], []) for ob in results_of(plan, DESIGN_ROLES).values()]
    return known


def _completed(plan: bpy.types.Object) -> list[bpy.types.Object]:
    """The repeated shell: one mesh, or one instance for each mesh of the copies."""
    welded = result_of(plan, next(iter(COMPLETED_ROLES)))
    copies = copies_of(plan)
    pieces = {} if copies is None else {ob.data.name: ob for ob in copies.objects if ob.type == "MESH"}
    return [ob for ob in (welded, *pieces.values()) if ob is not None]
