"""Live by hand: a tilt dragged in the panel, a corner grabbed in edit mode, undo and redo, and nothing at rest."""

from __future__ import annotations

import math
import sys
import time

import bpy
import numpy as np


def live():
    return next(module for name, module in sys.modules.items() if name.endswith("cmc_addon.live.live"))


def at_rest() -> bool:
    states = live().Live.states.values()
    return bool(states) and live().Live.running is None and all(s.is_settled and not s.is_dirty for s in states)


def points(ob) -> np.ndarray:
    flat = np.empty(3 * len(ob.data.vertices), dtype=np.float32)
    ob.data.attributes["position"].data.foreach_get("vector", flat)
    return flat.reshape(-1, 3)


class Watch:
    """Called by a timer: how often the shell has changed, and the longest time between two calls."""

    def __init__(self) -> None:
        self.shapes: set[bytes] = set()
        self.longest = 0.0
        self.last = time.perf_counter()
        bpy.app.timers.register(self)

    def __call__(self) -> float | None:
        now = time.perf_counter()
        self.longest, self.last = max(self.longest, now - self.last), now
        shell = plan().cmc.f_plus
        if shell is not None and len(shell.data.vertices):
            self.shapes.add(points(shell).tobytes())
        return 0.0

    def stop(self) -> int:
        bpy.app.timers.unregister(self)
        return len(self.shapes)


def plan():
    return bpy.data.objects["Hall"]


def tell(hands):
    bpy.ops.cmc.add_plan(shape="RECTANGLE")
    bpy.ops.cmc.mesh_plan(edge_length=0.5)
    bpy.context.object.name = "Hall"
    plan().cmc.intersections = True
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.select_all(action="SELECT")
    bpy.ops.mesh.region_to_loop()
    bpy.ops.cmc.group_add(name="Rim", kind="BINORMAL", tilt=0.25 * math.pi, assign=True)
    bpy.ops.object.mode_set(mode="OBJECT")
    bpy.ops.ed.undo_push(message="Plan")
    yield 0.5

    yield from hands.click_button("cmc.live")
    yield from hands.wait_for(lambda: plan().cmc.f_plus is not None and at_rest(), "the shell is there by itself")
    yield from hands.picture("on")
    flat = points(plan().cmc.f_plus)

    x, y = yield from hands.find_field("].tilt")
    watch = Watch()
    yield from hands.drag((x, y), (x + 30, y), steps=15, pause=0.05)
    changes = watch.stop()
    tilted = plan().data.cmc.groups[0].tilt
    assert abs(tilted) > 0.05, "the tilt was dragged"
    assert changes > 5, f"the shell has moved {changes} times only"
    yield from hands.wait_for(at_rest, "it has come to rest")
    high = points(plan().cmc.f_plus)
    assert np.abs(high - flat).max() > 0.05
    print(f"a tilt: {changes} shapes, the window waited {watch.longest:.3f} s at most", flush=True)
    yield from hands.picture("tilted")

    yield from hands.press("Z", ctrl=True)
    yield from hands.wait_for(lambda: plan().data.cmc.groups[0].tilt != tilted, "undo has taken back the drag, in one")
    yield from hands.wait_for(at_rest, "it is at rest again")
    assert np.abs(points(plan().cmc.f_plus) - flat).max() < 1e-4
    yield from hands.press("Z", ctrl=True, shift=True)
    yield from hands.wait_for(lambda: plan().data.cmc.groups[0].tilt == tilted, "redo has brought it again")
    yield from hands.wait_for(at_rest, "it is at rest again")
    assert np.abs(points(plan().cmc.f_plus) - high).max() < 1e-4

    yield from grab(hands, high)
    yield from quiet(hands)


def grab(hands, before):
    """A corner of the plan, grabbed in edit mode with its neighbourhood."""
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.select_all(action="DESELECT")
    bpy.ops.object.mode_set(mode="OBJECT")
    corner = max(plan().data.vertices, key=lambda vertex: vertex.co.x + vertex.co.y)
    corner.select = True
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.context.scene.tool_settings.use_proportional_edit = True
    bpy.context.scene.tool_settings.proportional_size = 3.0
    yield from hands.wait_for(at_rest, "it is at rest in edit mode")
    x, y = hands.view
    hands.move(x, y)
    yield 0.3
    watch = Watch()
    yield from hands.press("G")
    for k in range(25):
        hands.move(x + 3 * k, y + 2 * k)
        yield 0.04
    yield from hands.picture("grabbed")
    changes = watch.stop()
    yield from hands.click(x + 75, y + 50)
    assert bpy.context.mode == "EDIT_MESH" and changes > 3, f"the shell has moved {changes} times only"
    yield from hands.wait_for(at_rest, "it has come to rest")
    print(f"vertices: {changes} shapes, the window waited {watch.longest:.3f} s at most", flush=True)
    there = points(plan().cmc.f_plus)
    assert np.abs(there - before).max() > 0.05
    yield from hands.press("Z", ctrl=True)
    yield 0.5
    yield from hands.wait_for(at_rest, "it is at rest after undo in edit mode")
    assert np.abs(points(plan().cmc.f_plus) - before).max() < 1e-4, "undo has brought the corner back"
    bpy.ops.object.mode_set(mode="OBJECT")


def quiet(hands):
    """At rest nothing happens: no ticks, although the mouse moves and the window is drawn."""
    yield from hands.wait_for(at_rest, "it is at rest")
    calls, real = [], live()._read
    live()._read = lambda *args: calls.append(1) or real(*args)
    for k in range(20):
        hands.move(hands.view[0] + 5 * k, hands.view[1])
        yield 0.05
    live()._read = real
    assert len(calls) < 5, f"{len(calls)} ticks although nothing has changed"
    bpy.context.scene.tool_settings.use_proportional_edit = False
    plan().data.cmc.groups[0].kind = "FREE"
    yield from hands.wait_for(lambda: live().problem_of(plan()), "a problem is shown")
    yield from hands.picture("problem")
