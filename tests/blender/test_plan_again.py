"""Mesh Plan once more: a plan is updated in place, its groups are carried over, nothing is lost."""

from __future__ import annotations

import math

import bpy
import numpy as np
import pytest

from .outlines import SQUARE, activate, area, linked, mesh_plan, ngon, points, wire


def boundary(ob) -> list[int]:
    used = np.bincount([loop.edge_index for loop in ob.data.loops], minlength=len(ob.data.edges))
    return np.flatnonzero(used == 1).tolist()


def groups(ob) -> dict[str, set[int]]:
    """Edges of each group, by name."""
    values = np.array([item.value for item in ob.data.attributes["cmc_group"].data])
    return {group.name: set(np.flatnonzero(values == group.uid).tolist()) for group in ob.data.cmc.groups}


def set_group(ob, name, edges, **parameters) -> None:
    ob.data.edges.foreach_set("select", np.isin(np.arange(len(ob.data.edges)), list(edges)))
    activate(ob)
    bpy.ops.cmc.group_add(name=name, assign=True, **parameters)


def along(ob, axis, where) -> set[int]:
    """Boundary edges with both ends at that coordinate."""
    at = np.isclose(points(ob)[:, axis], where, atol=1e-5)
    return {k for k in boundary(ob) if all(at[v] for v in ob.data.edges[k].vertices)}


def test_the_plan_is_updated_in_place() -> None:
    ob = ngon(SQUARE)
    paint = bpy.data.materials.new("Concrete")
    ob.data.materials.append(paint)
    plan = mesh_plan(edge_length=1.0)
    assert list(plan.data.materials) == [paint]
    plan.name, plan.cmc.size, mesh = "Renamed", "HEIGHT", plan.data
    coarse = len(mesh.polygons)
    again = mesh_plan(edge_length=0.5)  # with the plan active: meshes its outline anew
    assert again == plan and plan.data == mesh and len(mesh.polygons) > 1.4 * coarse
    assert (plan.name, plan.cmc.size, list(mesh.materials)) == ("Renamed", "HEIGHT", [paint])
    ob.hide_set(False)
    ob.data.vertices[2].co.x = 12
    for other in bpy.context.selected_objects:
        other.select_set(False)
    activate(ob)
    assert mesh_plan(corners="NONE") == plan, "with the outline active: the same plan"
    assert area(plan) == pytest.approx(48 + 0.5 * 4 * 6, rel=1e-5)
    assert len([o for o in bpy.data.objects if o.type == "MESH"]) == 2


def test_duplicates_and_deletions() -> None:
    ob = ngon(SQUARE)
    plan = mesh_plan(edge_length=1.0)
    twin = ob.copy()
    twin.data = ob.data.copy()
    linked(twin)
    other = mesh_plan(edge_length=1.0)
    assert other != plan and other.cmc.outline == twin, "a duplicated outline gets a plan of its own"

    copy = plan.copy()
    copy.data = plan.data.copy()
    linked(copy)
    assert mesh_plan(edge_length=0.5) == copy, "a duplicated plan is updated when it is active"
    assert len(copy.data.polygons) > len(plan.data.polygons)

    bpy.data.objects.remove(plan)
    activate(ob)
    fresh = mesh_plan(edge_length=1.0, corners="NONE")
    assert fresh not in (other, copy) and fresh.cmc.outline == ob, "a deleted plan is made anew"

    bpy.data.objects.remove(ob)
    activate(fresh)
    assert mesh_plan(edge_length=0.5) == fresh, "without its outline a plan is meshed from its own rim"
    assert area(fresh) == pytest.approx(48, rel=1e-5)


def test_an_outline_with_faces_is_hidden_and_nothing_else() -> None:
    ob = ngon(SQUARE)
    plan = mesh_plan(edge_length=1.0)
    assert ob.hide_get() and ob.hide_render and not plan.hide_get()
    assert bpy.context.selected_objects == [plan]
    edges = wire(SQUARE, name="Wire")
    mesh_plan(edge_length=1.0)
    assert not edges.hide_get()


def test_groups_carry_over_to_the_pieces() -> None:
    ob = ngon(SQUARE)  # edges 0 south, 1 east, 2 north, 3 west
    order = {tuple(sorted(e.vertices)): e.index for e in ob.data.edges}
    set_group(ob, "long", [order[0, 1], order[2, 3]], kind="BINORMAL", tilt=0.5)
    set_group(ob, "east", [order[1, 2]], kind="PLANE", normal=(1, 0, 0))
    plan = mesh_plan(edge_length=0.5, corners="NONE")
    assert groups(plan) == {"long": along(plan, 1, 0) | along(plan, 1, 6), "east": along(plan, 0, 8)}
    long, east = plan.data.cmc.groups
    assert (long.kind, long.tilt, east.kind) == ("BINORMAL", pytest.approx(0.5), "PLANE")
    assert len(groups(plan)["east"]) == 12 and len(along(plan, 0, 0)) == 12, "the west side is in no group"


def test_group_borders_on_a_smooth_outline_stay_vertices() -> None:
    count = 60
    circle = [(5 * math.cos(t), 5 * math.sin(t)) for t in 2 * np.pi * np.arange(count) / count]
    ob = wire(circle)
    set_group(ob, "quarter", range(7, 22))
    plan = mesh_plan(edge_length=0.9)
    ends = np.array([circle[7], circle[22]])
    gap = np.linalg.norm(points(plan)[:, None, :2] - ends, axis=2).min(axis=0)
    assert gap.max() < 1e-5


def test_own_groups_and_settings_of_the_plan_survive_an_update() -> None:
    ob = ngon(SQUARE)
    order = {tuple(sorted(e.vertices)): e.index for e in ob.data.edges}
    set_group(ob, "east", [order[1, 2]])
    plan = mesh_plan(edge_length=0.5, corners="NONE")
    plan.data.cmc.groups["east"].tilt = 0.7
    for other in bpy.context.selected_objects:
        other.select_set(False)
    set_group(plan, "west", along(plan, 0, 0), kind="FREE")
    mesh_plan(edge_length=0.3, corners="NONE")
    assert groups(plan) == {"east": along(plan, 0, 8), "west": along(plan, 0, 0)}
    assert plan.data.cmc.groups["east"].tilt == pytest.approx(0.7)
    assert plan.data.cmc.groups["west"].kind == "FREE"
    assert len({group.uid for group in plan.data.cmc.groups}) == 2


def test_nothing_of_a_new_plan_is_selected() -> None:
    ngon(SQUARE)
    plan = mesh_plan(edge_length=1.0)
    bpy.ops.object.mode_set(mode="EDIT")
    assert plan.data.total_edge_sel == 0
    bpy.ops.object.mode_set(mode="OBJECT")
    bpy.ops.cmc.select_ungrouped()
    assert sum(edge.select for edge in plan.data.edges) == len(boundary(plan))


def test_a_linked_outline_gets_a_local_plan(tmp_path) -> None:
    ngon(SQUARE)
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "library.blend"))
    bpy.ops.wm.read_homefile(use_empty=True)
    with bpy.data.libraries.load(str(tmp_path / "library.blend"), link=True) as (_, taken):
        taken.objects = ["Hall"]
    ob = linked(taken.objects[0])
    plan = mesh_plan(edge_length=1.0)
    assert plan.library is None and plan.data.library is None and plan.cmc.outline == ob
    activate(ob)
    for other in bpy.context.selected_objects:
        other.select_set(False)
    bpy.context.view_layer.objects.active = plan
    assert mesh_plan(edge_length=0.5) == plan
