"""A whole day by hand: a plane, its plan, a group from selected edges, Solve, an angle dragged with Live, a long solve
cancelled, everything undone and redone, a module and Repeat by Symmetry, saved and loaded again.

Everything is clicked, dragged or typed; Blender's data are only looked at.
"""

from __future__ import annotations

import json
import math
import os

import bmesh
import bpy
import numpy as np
from bpy_extras.view3d_utils import location_3d_to_region_2d

CAPITAL = "Column Capital"


def plan():
    return bpy.data.objects["Plane Plan"]


def capital():
    return bpy.data.objects[CAPITAL]


def group():
    """That of the right side."""
    return plan().data.cmc.groups[0]


def running() -> bool:
    return bpy.context.window_manager.cmc.running


def shell() -> np.ndarray:
    """Positions of f+."""
    data = plan().cmc.f_plus.data.attributes["position"].data
    points = np.empty(3 * len(data), dtype=np.float32)
    data.foreach_get("vector", points)
    return points.reshape(-1, 3)


def tell(hands):
    yield from draw(hands)
    yield from assign(hands)
    yield from solve(hands)
    yield from drag(hands)
    yield from call_off(hands)
    yield from undo_all(hands)
    yield from complete(hands)
    yield from save(hands)


def draw(hands):
    """Add > Mesh > Plane, five times as large, Mesh Plan."""
    middle = (hands.viewport.width // 2, hands.viewport.height // 2)
    yield from hands.press("A", middle, shift=True)
    yield from hands.click_words("Mesh", hands.viewport)
    yield from hands.click_words("Plane", hands.viewport)
    yield from hands.wait_for(lambda: "Plane" in bpy.data.objects, "the plane is there")
    yield from hands.press("S", middle)
    yield from hands.type("5", middle)
    assert math.isclose(bpy.data.objects["Plane"].dimensions.x, 10, rel_tol=1e-5)
    yield from hands.press("NUMPAD_7")
    yield from hands.press("NUMPAD_PERIOD", middle)
    yield 1.0
    yield from hands.click_button("cmc.mesh_plan")
    yield from hands.wait_for(lambda: "Plane Plan" in bpy.data.objects, "the plan is there")
    yield from hands.picture("plan")


def assign(hands):
    """In edit mode a group of the right side, by a box around it: it leans over its line, the others lie on theirs."""
    yield from hands.press("TAB")
    yield from hands.press("TWO")
    yield from hands.press("A", alt=True)
    yield from hands.press("B")
    yield from hands.drag(place(hands, (5.1, -5.1, 0)), place(hands, (4.95, 5.1, 0)))
    selected = [edge for edge in bmesh.from_edit_mesh(plan().data).edges if edge.select]
    assert selected and all(edge.is_boundary for edge in selected), len(selected)
    yield from hands.click_button("cmc.group_add")
    yield from hands.click_button("cmc.group_assign")
    assert members(1) == len(selected) and group().kind == "LEAN"
    yield from hands.set_field("groups[0].angle", "60")
    assert math.isclose(group().angle, math.radians(60), abs_tol=1e-5)
    yield from hands.picture("assigned")
    yield from hands.press("TAB")
    assert bpy.context.mode == "OBJECT"


def solve(hands):
    yield from hands.click_button("cmc.solve")
    yield from hands.wait_for(lambda: plan().cmc.f_plus is not None and not running(), "the shell is there")
    assert 0.5 < np.ptp(shell()[:, 2]) < 10
    yield from hands.press("NUMPAD_1")
    for key in ("NUMPAD_8", "NUMPAD_8", "NUMPAD_6", "NUMPAD_6"):
        yield from hands.press(key)
    yield from hands.press("HOME")
    yield 1.0
    yield from hands.picture("solved")


def drag(hands):
    """Live on, the angle dragged: the shell moves before the mouse is let go. Undo and redo of that alone."""
    yield from hands.click_button("cmc.live")
    assert plan().cmc.live
    before, angle = shell(), group().angle
    x, y = yield from hands.find_field("groups[0].angle")
    hands.move(x, y)
    yield 0.3
    hands.window.event_simulate(type="LEFTMOUSE", value="PRESS", x=x, y=y)
    shapes = [before]
    for k in range(1, 21):
        hands.window.event_simulate(type="MOUSEMOVE", value="NOTHING", x=x + k, y=y)
        yield 0.15
        if not np.array_equal(shell(), shapes[-1]):
            shapes.append(shell())
    yield from hands.picture("dragging")
    hands.window.event_simulate(type="LEFTMOUSE", value="RELEASE", x=x + 20, y=y)
    yield 1.0
    assert len(shapes) > 3, f"{len(shapes) - 1} shapes were shown in 20 moves of the mouse"
    assert group().angle > angle + math.radians(1)
    dragged, after = group().angle, shell()
    yield from hands.picture("dragged")

    yield from hands.press("Z", ctrl=True)
    yield from hands.wait_for(lambda: math.isclose(group().angle, angle, abs_tol=1e-6), "the angle is what it was")
    yield from hands.wait_for(lambda: near(shell(), before), "and the shell")
    yield from hands.press("Z", ctrl=True, shift=True)
    yield from hands.wait_for(lambda: math.isclose(group().angle, dragged, abs_tol=1e-6), "the angle is redone")
    yield from hands.wait_for(lambda: near(shell(), after), "and the shell")
    yield from hands.click_button("cmc.live")
    assert not plan().cmc.live


def call_off(hands):
    """A finer plan keeps its group; Solve on it takes long, and Esc leaves everything as it was."""
    yield from hands.set_field("cmc.edge_length", "0.08")
    yield from hands.click_button("cmc.mesh_plan")
    yield from hands.wait_for(lambda: len(plan().data.polygons) > 10000, "the plan is finer")
    assert len(plan().data.cmc.groups) == 1 and members(1) > 60
    yield from hands.click_button("cmc.solve")
    yield from hands.wait_for(lambda: len(plan().cmc.f_plus.data.polygons) == len(plan().data.polygons), "solved again")
    yield from hands.wait_for(lambda: not running(), "solved")
    before = shell()
    yield from hands.click_button("cmc.solve")
    yield from hands.wait_for(running, "the solve runs")
    yield from hands.picture("running")
    assert running(), "the solve ended before anyone could call it off; use a finer plan"
    yield from hands.press("ESC")
    yield from hands.wait_for(lambda: not running(), "Esc has stopped it")
    assert np.array_equal(shell(), before)
    yield from hands.picture("called-off")


def undo_all(hands):
    """Back to Blender as it starts, step by step, and forth again."""
    after, faces, steps = shell(), len(plan().data.polygons), 0
    while "Plane" in bpy.data.objects:
        assert steps < 60, "undo does not come to an end"
        yield from hands.press("Z", ctrl=True)
        steps += 1
    assert not [ob.name for ob in bpy.data.objects if ob.name.startswith("Plane") or ob.cmc.role != "NONE"]
    yield from hands.picture("undone")
    for _ in range(steps):
        yield from hands.press("Z", ctrl=True, shift=True)
    yield 0.5
    assert bpy.context.mode == "OBJECT" and len(plan().data.polygons) == faces
    assert np.array_equal(shell(), after)
    yield from hands.picture("redone")


def complete(hands):
    """Add > Mesh > CMC > Column Capital, by typing; Solve, Repeat by Symmetry: a roof on columns."""
    middle = (hands.viewport.width // 2, hands.viewport.height // 2)
    yield from hands.press("A", middle, shift=True)
    yield from hands.type("column", middle)
    yield from hands.wait_for(lambda: CAPITAL in bpy.data.objects, "the capital is there")
    yield from hands.click_button("cmc.solve")
    yield from hands.wait_for(lambda: capital().cmc.f_plus is not None and not running(), "its shell is there")
    yield from hands.panel("Repeat")
    yield from hands.click_button("cmc.complete", (0.5,))
    yield from hands.wait_for(lambda: capital().cmc.completed is not None, "the copies are there")
    copies = json.loads(capital().cmc.complete_report)["copies"]
    assert copies > 8 and len(capital().cmc.completed.data.polygons) == copies * len(capital().data.polygons)
    yield from hands.press("HOME")
    yield 1.0
    yield from hands.picture("completed")


def save(hands):
    """Ctrl S, Enter; File > Revert; everything is there and works."""
    bpy.context.preferences.view.filebrowser_display_type = "SCREEN"
    yield from hands.press("S", ctrl=True)
    yield 1.5
    yield from hands.press("RET", (640, 450))  # the file browser has taken the viewport's place
    yield from hands.wait_for(lambda: bpy.data.filepath and os.path.exists(bpy.data.filepath), "the file is saved")
    faces, points = len(capital().cmc.completed.data.polygons), shell()
    yield 1.0
    yield from hands.click_words("File", hands.viewport)
    yield from hands.click_words("Revert", hands.viewport)
    yield 1.0
    yield from hands.press("RET", hands.view)
    yield 2.0
    assert len(capital().cmc.completed.data.polygons) == faces and np.array_equal(shell(), points)
    assert [one.name for one in plan().data.cmc.groups] == ["Group"] and not running()
    assert capital().cmc.f_plus.hide_viewport, "it is one of the copies"
    yield from hands.picture("loaded")
    before = capital().cmc.complete_report
    yield from hands.click_button("cmc.solve")
    yield from hands.wait_for(
        lambda: capital().cmc.complete_report != before and not running(), "its copies are made again"
    )
    assert capital().cmc.f_plus.hide_viewport and not capital().cmc.completed.hide_viewport
    yield from hands.picture("solved-again")


def place(hands, point) -> tuple[int, int]:
    """Where a point of the plan is in the window."""
    region = next(region for region in hands.area.regions if region.type == "WINDOW")
    found = location_3d_to_region_2d(region, hands.area.spaces.active.region_3d, point)
    return region.x + round(found.x), region.y + round(found.y)


def members(uid: int) -> int:
    """Number of edges in a group."""
    if plan().mode == "EDIT":
        bm = bmesh.from_edit_mesh(plan().data)
        layer = bm.edges.layers.int["cmc_group"]
        return sum(edge[layer] == uid for edge in bm.edges)
    return sum(value.value == uid for value in plan().data.attributes["cmc_group"].data)


def near(points, others) -> bool:
    return points.shape == others.shape and np.abs(points - others).max() < 1e-3
