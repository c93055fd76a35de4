"""The list by hand: rename, type an angle, choose a kind's parameters, hide the lines."""

from __future__ import annotations

import math

import bpy


def tell(hands):
    bpy.ops.mesh.primitive_circle_add(vertices=32, radius=3, fill_type="NGON")
    bpy.ops.cmc.mesh_plan(edge_length=0.5)
    plan = bpy.context.object
    bpy.ops.cmc.select_ungrouped()
    for _ in range(5):
        yield 0.05
        bpy.ops.cmc.group_add(assign=True)
    groups = plan.data.cmc.groups
    plan.data.cmc.active_index = 0
    groups[0].angle = math.radians(17)
    bpy.ops.ed.undo_push(message="Groups")
    yield from hands.picture("list")

    _, y = yield from hands.find("cmc.group_add")
    row = hands.sidebar.x + 90, y - 5
    yield from hands.click(*row, ctrl=True)  # as a double click
    yield from hands.press("A", row, ctrl=True)
    yield from hands.type("north", row)
    assert groups[0].name == "north", groups[0].name

    yield from hands.set_field("groups[0].angle", "45")
    assert math.isclose(groups[0].angle, math.radians(45), abs_tol=1e-6), groups[0].angle
    yield from hands.picture("renamed")

    for kind in ("PLANE", "TWISTED", "GAUSS_MAP", "FREE"):
        groups[0].kind = kind
        yield from hands.picture(kind.lower())
    yield from hands.click_button("cmc.group_remove")
    assert [group.uid for group in groups] == [2, 3, 4, 5]
