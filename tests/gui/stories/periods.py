"""A court by hand: the gap, its arrow and the buttons; closed with a progress bar, undone; repeated."""

from __future__ import annotations

import json

import bpy


def plan():
    return bpy.data.objects["Annulus"]


def report() -> dict:
    return json.loads(plan().cmc.report)


def tell(hands):
    bpy.ops.cmc.add_plan(shape="ANNULUS", columns=96)
    bpy.ops.ed.undo_push(message="Plan")
    yield from hands.click_button("cmc.solve")
    yield from hands.wait_for(lambda: plan().cmc.f_plus is not None, "the shell is there")
    for panel in ("Plan", "Boundary"):
        yield from hands.panel(panel, False)
    yield from hands.picture("gap")
    button = yield from hands.find("cmc.close_periods", (0.5,))
    yield from hands.click(*button)
    yield from hands.wait_for(lambda: not report()["is_open"], "the shell closes")
    yield from hands.picture("closed")
    assert report()["closing"]["closed"]
    yield from hands.press("Z", ctrl=True)
    yield from hands.wait_for(lambda: report()["is_open"], "undo has brought the gap back")
    yield from hands.picture("undone")
    yield from hands.click_button("cmc.tile_periods", (0.5,))
    yield from hands.wait_for(lambda: plan().cmc.completed is not None, "the copies are there")
    yield from hands.picture("tiled")
