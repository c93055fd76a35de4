"""Handles dragged with the mouse: a side leans, the crown rises and sinks; each drag one step of undo, with Live."""

from __future__ import annotations

import math
import sys

import bpy
import numpy as np
from stories.lines import Heights, look, plan, rectangle, side
from stories.live import at_rest, points


def gizmos():
    return next(module for name, module in sys.modules.items() if name.endswith("cmc_addon.drawing.handle_gizmos"))


def region(hands):
    return next(region for region in hands.area.regions if region.type == "WINDOW")


def screen(hands):
    """The projection of the view, in pixels of the window."""
    with bpy.context.temp_override(window=hands.window, area=hands.area, region=region(hands)):
        return gizmos().screen_of(bpy.context)


def place(hands, point):
    """Where a point of the world is in the window."""
    x, y = screen(hands).pixels(np.asarray(point, dtype=float)[None])[0]
    return round(region(hands).x + x), round(region(hands).y + y)


def lever(hands, name, angle=None):
    """Where the tip of the lever of a group is, or would be at another angle."""
    mine = next(one for one in gizmos().levers_of(bpy.context, plan()) if one.name == name)
    shown = screen(hands)
    length = gizmos()._LEVER * bpy.context.preferences.system.ui_scale * shown.pixel(mine.at)
    return place(hands, mine.tips(np.array([mine.angle if angle is None else angle]), length)[0])


def crown(hands):
    """Where to take the arrow of the crown, and the same a metre higher."""
    top = gizmos().crown(bpy.context, plan())
    shown = screen(hands)
    length = gizmos()._ARROW * bpy.context.preferences.system.ui_scale * shown.pixel(top.at)
    x, y = place(hands, top.at + [0.0, 0.0, length])
    above = place(hands, top.at + [0.0, 0.0, 1.0 + length])
    return (x, y + 4), (above[0], above[1] + 4)


def group(name):
    return plan().data.cmc.groups[name]


def tell(hands):
    rectangle()
    side(lambda p: p.y < -2.9 and abs(p.x) < 4.0)
    bpy.ops.cmc.group_add(name="Street", kind="LEAN", angle=math.radians(45), assign=True)
    bpy.ops.object.mode_set(mode="OBJECT")
    plan().cmc.size, plan().cmc.rise = "RISE", 0.35
    bpy.ops.ed.undo_push(message="Side")
    yield from look(hands)
    yield from hands.picture("plan")
    yield from hands.click_button("cmc.live")
    yield from hands.wait_for(lambda: plan().cmc.f_plus is not None and at_rest(), "the shell is there")
    yield from look(hands)
    hands.move(*lever(hands, "Street"))
    yield from hands.picture("lever-hovered")

    hands.move(*place(hands, max((v.co for v in plan().data.vertices), key=lambda p: p.x - 0.1 * abs(p.y))))
    yield from hands.picture("side-hovered")

    yield from cancelled(hands)
    yield from lean(hands)
    yield from rise(hands)
    yield from switches(hands)


def cancelled(hands):
    """Esc while the button is down takes the drag back."""
    before = group("Street").angle
    (x, y), (to_x, to_y) = lever(hands, "Street"), lever(hands, "Street", math.radians(80))
    hands.move(x, y)
    yield 0.3
    hands.window.event_simulate(type="LEFTMOUSE", value="PRESS", x=x, y=y)
    for k in range(1, 11):
        hands.move(x + (to_x - x) * k / 10, y + (to_y - y) * k / 10)
        yield 0.05
    assert math.degrees(group("Street").angle - before) > 20, "it is dragged"
    hands._key("ESC", (to_x, to_y))
    yield 0.3
    hands.window.event_simulate(type="LEFTMOUSE", value="RELEASE", x=to_x, y=to_y)
    yield 0.3
    assert group("Street").angle == before, "Esc has taken it back"
    yield from hands.wait_for(at_rest, "it is at rest again")


def lean(hands):
    before = points(plan().cmc.f_plus)
    start, to = lever(hands, "Street"), lever(hands, "Street", math.radians(70))
    watch = Heights()
    yield from hands.drag(start, to, steps=15, pause=0.08)
    shapes = len(watch.stop())
    print(f"a lean: {shapes} shapes", flush=True)
    assert shapes > 2, f"the shell has moved {shapes} times only"
    angle = group("Street").angle
    assert abs(math.degrees(angle) - 70) < 2, math.degrees(angle)
    yield from hands.wait_for(at_rest, "it has come to rest")
    leant = points(plan().cmc.f_plus)
    assert np.abs(leant - before).max() > 0.02
    yield from hands.picture("leant")
    yield from hands.press("Z", ctrl=True)
    yield from hands.wait_for(
        lambda: abs(math.degrees(group("Street").angle) - 45) < 0.01, "undo has taken back the drag, in one")
    yield from hands.wait_for(at_rest, "it is at rest again")
    assert np.abs(points(plan().cmc.f_plus) - before).max() < 1e-3
    yield from hands.press("Z", ctrl=True, shift=True)
    yield from hands.wait_for(lambda: group("Street").angle == angle, "redo has brought it again")
    yield from hands.wait_for(at_rest, "it is at rest again")


def rise(hands):
    before = plan().cmc.rise
    (x, y), (_, above) = crown(hands)
    hands.move(x, y)
    yield from hands.picture("crown-hovered")
    height = gizmos().crown(bpy.context, plan()).height
    yield from hands.drag((x, y), (x, above), steps=15, pause=0.08)
    assert plan().cmc.rise > before + 0.1, plan().cmc.rise
    yield from hands.wait_for(at_rest, "it has come to rest")
    higher = gizmos().crown(bpy.context, plan()).height
    assert abs(higher - height - 1.0) < 0.1, f"dragged by a metre it went from {height} to {higher}"
    yield from hands.picture("risen")
    rise = plan().cmc.rise
    (x, y), (_, above) = crown(hands)
    yield from hands.drag((x, y), (x, above), shift=True)
    assert 0.02 < plan().cmc.rise - rise < 0.05, "with Shift by a tenth of a metre"
    yield from hands.wait_for(at_rest, "it has come to rest")
    (x, y), (_, above) = crown(hands)
    yield from hands.drag((x, y), (x, y - 4 * (above - y)), steps=25, pause=0.08)
    assert plan().cmc.rise < 0, plan().cmc.rise
    yield from hands.wait_for(at_rest, "it has come to rest below")
    yield from hands.picture("hangs")
    for _ in range(3):
        yield from hands.press("Z", ctrl=True)
    yield from hands.wait_for(lambda: abs(plan().cmc.rise - before) < 1e-6, "undo has taken back the three drags")
    yield from hands.wait_for(at_rest, "it is at rest again")


def switches(hands):
    """With Handles off, and in edit mode, the mouse finds none."""
    start, to = lever(hands, "Street"), lever(hands, "Street", math.radians(20))
    angle = group("Street").angle
    bpy.context.scene.cmc.show_handles = False
    yield 0.5
    yield from hands.picture("off")
    yield from hands.drag(start, to)
    assert group("Street").angle == angle
    bpy.context.scene.cmc.show_handles = True
