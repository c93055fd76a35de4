"""A click on Solve: the window stays responsive, Esc and the cross stop it, F9 changes it, undo takes it back."""

from __future__ import annotations

import bpy


def running() -> bool:
    return bpy.context.window_manager.cmc.running


def plan():
    return bpy.data.objects["Plan"]


def tell(hands):
    bpy.ops.mesh.primitive_grid_add(x_subdivisions=250, y_subdivisions=250, size=10)
    bpy.context.object.name = "Plan"
    yield 0.5
    button = yield from hands.find("cmc.solve")

    yield from hands.click(*button)
    yield from hands.wait_for(running, "the solve runs")
    yield from hands.picture("running")
    assert running(), "the solve ended before anyone could cancel it; use a finer plan"
    yield from hands.press("ESC")
    yield from hands.wait_for(lambda: not running(), "Esc has stopped it")
    assert len(bpy.data.objects) == 1

    plan().data.vertices[0].co.z += 0.01  # else all that is kept from the first time makes it too quick
    yield from hands.click(*button)
    yield from hands.wait_for(running, "the solve runs again")
    yield from hands.click_button("cmc.cancel", (0.95,), near=button[1])
    yield from hands.wait_for(lambda: not running(), "the cross has stopped it")
    assert len(bpy.data.objects) == 1

    bpy.ops.ed.undo_push(message="Plan")
    yield from hands.click(*button)
    yield from hands.wait_for(lambda: plan().cmc.f_plus is not None, "the shell is there")
    assert not running()
    yield from hands.picture("solved")
    assert bpy.context.window_manager.operators[-1].bl_idname == "CMC_OT_solve"

    yield from hands.press("F9")
    yield from hands.picture("redo-panel")
    yield from hands.redo_click("Flip")
    yield from hands.wait_for(lambda: plan().cmc.flip, "the redo panel has solved again")
    assert len(bpy.data.objects) == 2
    heights = [vertex.co.z for vertex in plan().cmc.f_plus.data.vertices]
    assert heights[0] > 0.5 * max(heights), "flipped, the corners are on top"
    yield from hands.picture("flipped")
    yield from hands.press("ESC")

    yield from hands.press("Z", ctrl=True)
    yield from hands.wait_for(lambda: len(bpy.data.objects) == 1, "undo has taken it back")
    yield from hands.press("Z", ctrl=True, shift=True)
    yield from hands.wait_for(lambda: len(bpy.data.objects) == 2, "redo has brought it again")
    assert plan().cmc.f_plus == bpy.data.objects["Plan f+"]
