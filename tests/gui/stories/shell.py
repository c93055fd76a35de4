"""The main story by hand: a curve, its plan, a group on one part of the rim, an angle, the shell, undo and redo."""

from __future__ import annotations

import bmesh
import bpy
import numpy as np


def tell(hands):
    bpy.ops.curve.primitive_bezier_circle_add(radius=3)
    bpy.ops.ed.undo_push(message="Curve")
    yield from hands.click_button("cmc.mesh_plan")
    plan = bpy.context.object
    assert plan.name == "BézierCircle Plan" and len(plan.data.polygons) > 1000
    yield from hands.picture("meshed")
    yield from hands.press("F9")
    yield from hands.redo_enter("Edge Length", "0.2")
    yield from hands.picture("redo-panel")
    plan = bpy.context.object
    assert len(bpy.data.objects) == 2 and 1000 < len(plan.data.polygons) < 2000
    assert abs(bpy.context.scene.cmc.edge_length - 0.2) < 1e-6
    yield from hands.press("ESC")

    yield from hands.press("TAB")
    yield from hands.press("TWO")
    assert bpy.context.mode == "EDIT_MESH"
    select_half(plan)
    bpy.ops.ed.undo_push(message="Select")
    yield from hands.click_button("cmc.group_add")
    yield from hands.click_button("cmc.group_assign")
    assert membership(plan) == {0: count(plan) - half(plan), 1: half(plan)}, membership(plan)
    yield from hands.picture("assigned")
    yield from hands.click_button("cmc.group_deselect")
    assert not any(edge.select for edge in bmesh.from_edit_mesh(plan.data).edges)
    yield from hands.click_button("cmc.group_select")
    assert sum(edge.select for edge in bmesh.from_edit_mesh(plan.data).edges) == half(plan)

    plan.data.cmc.groups[0].tilt = np.radians(30)
    yield from hands.press("TAB")
    yield from hands.click_button("cmc.solve")
    for _ in range(200):
        if not bpy.context.window_manager.cmc.running:
            break
        yield 0.1
    shell = plan.cmc.f_plus
    assert shell is not None and not bpy.context.window_manager.cmc.running
    assert 1.0 < max(v.co.z for v in shell.data.vertices) < 4.0
    yield from hands.picture("solved")

    yield from hands.press("Z", ctrl=True)
    assert not [ob for ob in bpy.data.objects if ob.cmc.role == "F_PLUS"]
    assert bpy.context.object.data.cmc.groups[0].name == "Group"
    yield from hands.picture("undone")
    yield from hands.press("Z", ctrl=True, shift=True)
    assert [ob.name for ob in bpy.data.objects if ob.cmc.role == "F_PLUS"] == ["BézierCircle Plan f+"]
    yield from hands.picture("redone")


def rim(plan):
    return [edge for edge in bmesh.from_edit_mesh(plan.data).edges if edge.is_boundary]


def count(plan) -> int:
    return len(bmesh.from_edit_mesh(plan.data).edges)


def in_half(edge) -> bool:
    return all(vertex.co.y < 1e-4 for vertex in edge.verts)


def half(plan) -> int:
    return sum(in_half(edge) for edge in rim(plan))


def select_half(plan) -> None:
    bpy.ops.mesh.select_all(action="DESELECT")
    for edge in rim(plan):
        edge.select_set(in_half(edge))
    bmesh.update_edit_mesh(plan.data)


def membership(plan) -> dict[int, int]:
    """Uid -> number of edges."""
    bm = bmesh.from_edit_mesh(plan.data)
    layer = bm.edges.layers.int["cmc_group"]
    uids, counts = np.unique([edge[layer] for edge in bm.edges], return_counts=True)
    return dict(zip(uids.tolist(), counts.tolist(), strict=True))
