"""A module by hand: counts before it runs, one mesh, the redo panel, instances, undo."""

from __future__ import annotations

import bpy


def until(condition, what: str, seconds: float = 60.0):
    """Wait for something to become true."""
    waited = 0.0
    while not condition():
        assert waited < seconds, f"waited in vain until {what}"
        waited += 0.05
        yield 0.05


def plan():
    return bpy.data.objects["Honeycomb Module"]


def tell(hands):
    bpy.ops.cmc.add_module(module="HONEYCOMB", edges=12)
    bpy.ops.ed.undo_push(message="Module")
    yield from hands.picture("module")
    hands.area.spaces.active.region_3d.view_distance = 60.0
    yield from hands.click_button("cmc.solve")
    yield from until(lambda: plan().cmc.f_plus is not None, "the shell is there")
    side = hands.sidebar
    yield from hands.click(side.x + 60, side.y + side.height - 15)  # the header of Plan: more room below
    yield 0.5
    yield from hands.picture("solved")
    button = yield from hands.find("cmc.complete")
    yield from hands.click(*button)
    yield from until(lambda: plan().cmc.completed is not None, "the copies are there")
    yield from hands.picture("completed")
    assert len(plan().cmc.completed.data.polygons) == 216 * len(plan().data.polygons)
    plan().cmc.complete_as = "INSTANCES"
    yield from hands.click_button("cmc.complete", near=button[1])
    yield from until(lambda: plan().cmc.copies is not None, "the instances are there")
    yield from hands.picture("instances")
    assert len(plan().cmc.copies.objects) == 216
    yield from hands.press("Z", ctrl=True)
    yield from until(lambda: plan().cmc.completed is not None and plan().cmc.copies is None, "undo has taken them back")
