"""A court by hand: closed by Solve; left open, with the arrow of its gap; closed again by one click; repeated."""

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
    assert report()["closing"]["closed"]
    for panel in ("Plan", "Sides"):
        yield from hands.panel(panel, False)
    yield from hands.picture("closed")
    yield from hands.click_field("cmc.keep_closed")
    yield from hands.click_button("cmc.solve")
    yield from hands.wait_for(lambda: report()["is_open"], "it is left open")
    yield from hands.picture("gap")
    yield from hands.panel("Repeat")
    yield from hands.click_button("cmc.tile_periods", (0.5,))
    yield from hands.wait_for(lambda: plan().cmc.completed is not None, "the copies are there")
    yield from hands.picture("tiled")
