"""A court by hand: the gap, its arrow and what to press; closed with a bar, undone; tiled."""

from __future__ import annotations

import json

import bpy


def until(condition, what: str, seconds: float = 60.0):
    """Wait for something to become true."""
    waited = 0.0
    while not condition():
        assert waited < seconds, f"waited in vain until {what}"
        waited += 0.05
        yield 0.05


def plan():
    return bpy.data.objects["Annulus"]


def report() -> dict:
    return json.loads(plan().cmc.report)


def tell(hands):
    bpy.ops.cmc.add_plan(shape="ANNULUS", columns=96)
    bpy.ops.ed.undo_push(message="Plan")
    yield from hands.click_button("cmc.solve")
    yield from until(lambda: plan().cmc.f_plus is not None, "the shell is there")
    side = hands.sidebar
    for below in (15, 43):  # the headers of Plan and Boundary: more room below
        yield from hands.click(side.x + 60, side.y + side.height - below)
        yield 0.5
    yield from hands.picture("gap")
    button = yield from hands.find("cmc.close_periods")
    yield from hands.click(*button)
    yield from until(lambda: not report()["is_open"], "the shell closes")
    yield from hands.picture("closed")
    assert report()["closing"]["closed"]
    yield from hands.press("Z", ctrl=True)
    yield from until(lambda: report()["is_open"], "undo has brought the gap back")
    yield from hands.picture("undone")
    yield from hands.click_button("cmc.tile_periods", near=button[1] - 120)
    yield from until(lambda: plan().cmc.completed is not None, "the copies are there")
    yield from hands.picture("tiled")
