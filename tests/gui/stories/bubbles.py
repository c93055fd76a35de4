"""Bubbles by hand: the whole Wente torus, a quarter completed to it, a honeycomb of rings; two shells over one rim."""

from __future__ import annotations

import json
import math

import bpy


def report(name: str) -> dict:
    return json.loads(bpy.data.objects[name].cmc.report or "{}")


def added(hands, **bubble):
    for ob in list(bpy.data.objects):
        bpy.data.objects.remove(ob)
    bpy.ops.cmc.add_bubble(**bubble)
    bpy.ops.ed.undo_push(message="Bubble")
    yield from hands.settle()


def framed(hands, distance: float):
    hands.area.spaces.active.region_3d.view_distance = distance
    yield from hands.settle()


def tell(hands):
    yield from torus(hands)
    yield from cylinder(hands)
    yield from ring(hands)
    yield from two_shells(hands)


def torus(hands):
    yield from added(hands, bubble="TORUS", columns=16)
    yield from framed(hands, 22.0)
    yield from hands.picture("torus-drawn")
    yield from hands.click_button("cmc.solve")
    yield from hands.wait_for(lambda: report("Wente Torus"), "the torus is there", 120.0)
    bpy.data.objects["Wente Torus"].hide_set(True)
    for panel in ("Plan", "Sides"):
        yield from hands.panel(panel, False)
    for panel in ("Checks", "Solver"):
        yield from hands.panel(panel)
    yield from hands.picture("torus")
    assert report("Wente Torus")["index"] > 5


def cylinder(hands):
    yield from added(hands, bubble="WENTE")
    bpy.ops.cmc.solve()
    yield from hands.picture("quarter")
    yield from hands.panel("Repeat")
    yield from hands.click_button("cmc.complete")
    whole = bpy.data.objects["Wente Cylinder"].cmc
    yield from hands.wait_for(lambda: whole.completed is not None, "the copies are there")
    bpy.data.objects["Wente Cylinder"].hide_set(True)
    yield from hands.picture("cylinder-completed")
    assert json.loads(whole.complete_report)["copies"] == 24


def ring(hands):
    yield from added(hands, bubble="RING")
    bpy.ops.cmc.solve()
    yield from hands.picture("ring")
    yield from framed(hands, 110.0)
    bpy.ops.cmc.complete()
    yield from hands.picture("rings")
    assert json.loads(bpy.data.objects["Honeycomb Ring"].cmc.complete_report)["copies"] == 9


def two_shells(hands):
    for ob in list(bpy.data.objects):
        bpy.data.objects.remove(ob)
    bpy.ops.cmc.add_plan(shape="ROUND")
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.select_all(action="SELECT")
    bpy.ops.mesh.region_to_loop()
    bpy.ops.cmc.group_add(name="Rim", kind="BINORMAL", tilt=0.25 * math.pi, assign=True)
    bpy.ops.object.mode_set(mode="OBJECT")
    bpy.ops.ed.undo_push(message="Plan")
    yield from framed(hands, 26.0)
    plan = bpy.data.objects["Round"].cmc
    yield from hands.panel("Options", True)
    yield from hands.click_button("cmc.solve")
    yield from hands.wait_for(lambda: report("Round"), "the small shell is there")
    for panel in ("Checks", "Solver"):
        yield from hands.panel(panel)
    yield from hands.click_button("cmc.count_modes")
    yield from hands.wait_for(lambda: report("Round")["index"] == 0, "its modes are counted")
    yield from hands.picture("small")
    plan.shell = "BUBBLE"
    yield from hands.settle()
    yield from hands.click_button("cmc.solve")
    yield from hands.wait_for(lambda: report("Round")["degree"] < 0, "the large shell is there")
    yield from hands.picture("large")
    assert plan.sheet == "F_MINUS" and report("Round")["converged"]
