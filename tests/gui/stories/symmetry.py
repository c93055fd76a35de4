"""A module by hand: counts before it runs, one mesh, the redo panel, instances, undo."""

from __future__ import annotations

import bpy


def plan():
    return bpy.data.objects["Honeycomb Module"]


def tell(hands):
    bpy.ops.cmc.add_module(module="HONEYCOMB", edges=12)
    bpy.ops.ed.undo_push(message="Module")
    yield from hands.picture("module")
    hands.area.spaces.active.region_3d.view_distance = 60.0
    yield from hands.click_button("cmc.solve")
    yield from hands.wait_for(lambda: plan().cmc.f_plus is not None, "the shell is there")
    for panel in ("Plan", "Sides"):
        yield from hands.panel(panel, False)
    yield from hands.picture("solved")
    yield from hands.panel("Repeat")
    button = yield from hands.find("cmc.complete", (0.5,))
    yield from hands.click(*button)
    yield from hands.wait_for(lambda: plan().cmc.completed is not None, "the copies are there")
    yield from hands.press("HOME")
    yield 1.0
    yield from hands.picture("completed")
    assert len(plan().cmc.completed.data.polygons) == 216 * len(plan().data.polygons)
    plan().cmc.complete_as = "INSTANCES"
    yield from hands.click_button("cmc.complete", (0.5,))
    yield from hands.wait_for(lambda: plan().cmc.copies is not None, "the instances are there")
    yield from hands.picture("instances")
    assert len(plan().cmc.copies.objects) == 216
    yield from hands.press("Z", ctrl=True)
    yield from hands.wait_for(lambda: plan().cmc.completed and not plan().cmc.copies, "undo has taken them back")
