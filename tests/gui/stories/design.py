"""Fit to Outline by hand: the panel, the shape drawn while it runs, Esc, the shell, its numbers, following, undo; and
the deviation of an approximated surface as colours."""

from __future__ import annotations

import sys

import bpy
import numpy as np


def running() -> bool:
    return bpy.context.window_manager.cmc.running


def preview():
    return next(module for name, module in sys.modules.items() if name.endswith("cmc_addon.drawing.preview")).Preview


def fits() -> list:
    return [ob for ob in bpy.data.objects if ob.cmc.role == "FIT"]


def top() -> float:
    return max(v.co.z for v in fits()[0].data.vertices)


def following() -> bool:
    found = next(module for name, module in sys.modules.items() if name.endswith("cmc_addon.live.follow"))
    return found.Follow.uid


def tell(hands):
    bpy.ops.mesh.primitive_circle_add(vertices=48, radius=4, fill_type="NGON")
    bpy.context.object.scale = (1.6, 1.0, 1.0)
    bpy.ops.cmc.mesh_plan(edge_length=0.06)
    plan = bpy.context.object
    bpy.ops.ed.undo_push(message="Plan")
    yield 0.5
    for panel in ("Plan", "Boundary"):
        yield from hands.panel(panel, False)
    yield from hands.panel("Design")
    yield from hands.picture("panel")
    button = yield from hands.find("cmc.fit_outline", (0.5,))

    yield from hands.click(*button)
    yield from hands.wait_for(running, "it runs")
    yield from hands.picture("running")
    assert running(), "it ended before anyone could look; use a finer plan"
    yield from hands.press("ESC")
    yield from hands.wait_for(lambda: not running(), "Esc has stopped it")
    assert plan.cmc.fit is None and preview().handle is None
    yield 1.0  # the panel moves back to where it was

    yield from hands.click(*button)
    yield from hands.wait_for(lambda: plan.cmc.fit is not None, "the shell is there")
    assert abs(top() - 2.0) < 0.02, top()
    yield from hands.picture("fitted")

    plan.cmc.follow = True
    for rise in (0.52, 0.56, 0.6):
        plan.cmc.fit_rise = rise
        yield 0.1
    yield from hands.wait_for(lambda: abs(top() - 2.4) < 0.02, "the shell has followed")
    assert not running(), "the panel can be used meanwhile"
    yield from hands.wait_for(lambda: not following(), "it is at rest")
    yield from hands.picture("followed")
    yield from hands.press("Z", ctrl=True)
    yield from hands.wait_for(lambda: abs(top() - 2.0) < 0.02, "undo has taken back what it has followed")
    yield 1.0
    assert abs(top() - 2.0) < 0.02, "and it stays there"

    yield from hands.press("Z", ctrl=True)
    yield from hands.wait_for(lambda: not fits(), "undo has taken it back")
    yield from hands.press("Z", ctrl=True, shift=True)
    yield from hands.wait_for(fits, "redo has brought it again")

    plan = next(ob for ob in bpy.data.objects if ob.cmc.meshed)
    for vertex in plan.data.vertices:
        x, y = vertex.co.xy
        vertex.co.z = 2 - 0.06 * (x * x + y * y) + 0.15 * np.sin(2 * x) * np.cos(2 * y)
    bpy.context.view_layer.objects.active = plan
    bpy.ops.cmc.approximate_surface()
    for ob in bpy.data.objects:
        ob.hide_set(ob.cmc.role != "NEAREST")
    hands.area.spaces.active.shading.color_type = "VERTEX"
    yield from hands.picture("deviation")
