"""Colours by hand: each Colour By, the legend, curvature lines, normals on a sphere, undo, and the former shading."""

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
    return bpy.data.objects["Rectangle"]


def shading(hands) -> str:
    return hands.area.spaces.active.shading.color_type


def tell(hands):
    bpy.ops.cmc.add_plan(shape="RECTANGLE")
    plan().cmc.default_kind = "BINORMAL"
    bpy.ops.cmc.solve("EXEC_DEFAULT")
    bpy.ops.ed.undo_push(message="Solved")
    hands.area.spaces.active.region_3d.view_distance = 22.0
    yield 0.5
    was = shading(hands)
    assert was != "VERTEX"
    yield from hands.only_panel("Look")
    for by in ("MEAN_CURVATURE", "GAUSS_CURVATURE", "DISTORTION", "DEVIATION"):
        plan().cmc.colour_by = by
        assert shading(hands) == "VERTEX"
        yield from hands.picture(by.lower().replace("_", "-"))
    plan().cmc.colour_by = "GAUSS_CURVATURE"
    plan().cmc.curvature_lines = "BOTH"
    yield from hands.picture("curvature-lines")
    hands.area.spaces.active.region_3d.view_rotation = (0.35, 0.9, 0.2, 0.1)
    yield from hands.picture("below")
    bpy.ops.ed.undo_push(message="Curvature Lines")
    hands.area.spaces.active.region_3d.view_rotation = (0.81, 0.46, 0.17, 0.3)
    yield from hands.click_button("cmc.gauss_image")
    assert plan().cmc.gauss is not None
    yield from hands.picture("gauss-image")
    yield from hands.press("Z", ctrl=True)
    assert plan().cmc.gauss is None
    plan().cmc.curvature_lines = "NONE"
    plan().cmc.colour_by = "NONE"
    assert shading(hands) == was
    yield from hands.picture("none")
