"""Approximate Surface by hand: the shape drawn while it runs, Esc, the shell, undo, its deviation as colours."""

from __future__ import annotations

import sys

import bpy
import numpy as np


def running() -> bool:
    return bpy.context.window_manager.cmc.running


def preview():
    return next(module for name, module in sys.modules.items() if name.endswith("cmc_addon.drawing.preview")).Preview


def nearest() -> list:
    return [ob for ob in bpy.data.objects if ob.cmc.role == "NEAREST"]


def tell(hands):
    bpy.ops.mesh.primitive_circle_add(vertices=48, radius=4, fill_type="NGON")
    bpy.context.object.scale = (1.6, 1.0, 1.0)
    bpy.ops.cmc.mesh_plan(edge_length=0.06)
    plan = bpy.context.object
    for vertex in plan.data.vertices:
        x, y = vertex.co.xy
        vertex.co.z = 2 - 0.06 * (x * x + y * y) + 0.15 * np.sin(2 * x) * np.cos(2 * y)
    bpy.ops.ed.undo_push(message="Surface")
    yield 0.5
    for panel in ("Plan", "Sides"):
        yield from hands.panel(panel, False)
    yield from hands.panel("Options")
    yield from hands.panel("Approximate a Surface")
    yield from hands.picture("panel")
    button = yield from hands.find("cmc.approximate_surface", (0.5,))
    yield from hands.click(*button)
    yield from hands.wait_for(running, "it runs")
    yield from hands.picture("running")
    assert running(), "it ended before anyone could look; use a finer surface"
    yield from hands.press("ESC")
    yield from hands.wait_for(lambda: not running(), "Esc has stopped it")
    assert not nearest() and preview().handle is None
    yield 1.0  # the panel moves back to where it was

    yield from hands.click(*button)
    yield from hands.wait_for(nearest, "the shell is there")
    yield from hands.press("Z", ctrl=True)
    yield from hands.wait_for(lambda: not nearest(), "undo has taken it back")
    yield from hands.press("Z", ctrl=True, shift=True)
    yield from hands.wait_for(nearest, "redo has brought it again")
    for ob in bpy.data.objects:
        ob.hide_set(ob.cmc.role != "NEAREST")
    hands.area.spaces.active.shading.color_type = "VERTEX"
    yield from hands.picture("deviation")
