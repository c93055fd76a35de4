"""Mesh Plan refuses outlines that bound nothing, names the reason and changes nothing."""

from __future__ import annotations

import math

import bpy
import pytest

from .outlines import HOLE, SQUARE, added, curve, linked, ngon, wire


def two_plans():
    return wire(SQUARE, [(20, 0), (22, 0), (21, 2)])


def closed_mesh():
    bpy.ops.mesh.primitive_cube_add()


def three_faces():
    added("Hall", [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1)], [], [(0, 1, 2), (0, 1, 3), (0, 1, 4)])


def text():
    return linked(bpy.data.objects.new("Hall", bpy.data.curves.new("Hall", "FONT")))


BAD = {
    "open": (lambda: added("Hall", [(0, 0, 0), (1, 0, 0), (1, 1, 0)], [(0, 1), (1, 2)], []), "open at vertices 0, 2"),
    "open curve": (lambda: curve(SQUARE, HOLE, cyclic=False), r"Splines 0, 1 of 'Hall' are open"),
    "empty curve": (lambda: curve(), "is empty"),
    "empty": (lambda: added("Hall", [(0, 0, 0)], [], []), "no outline"),
    "scaled to a point": (
        lambda: setattr(wire(SQUARE), "scale", (0, 0, 0)), "'Hall' are at one place; check its scale"),
    "closed": (closed_mesh, "'Cube' is closed and has no boundary"),
    "three faces": (three_faces, r"Edge \d of 'Hall' has more than two faces"),
    "bow tie": (
        lambda: wire([(0, 0), (4, 4), (4, 0), (0, 4)]), r"crosses or touches itself.*In 'Hall': vertices 0, 1, 2, 3"),
    "bow tie, curve": (lambda: curve([(0, 0), (4, 4), (4, 0), (0, 4)]), r"crosses.*In 'Hall': \(0, 0, 0\)"),
    "touching faces": (
        lambda: added("Hall", [(x, y, 0) for x, y in [*SQUARE, (9, 9), (8, 9)]], [], [(0, 1, 2, 3), (2, 4, 5)]),
        "More than two edges .* meet at vertex 2"),
    "two plans": (two_plans, "2 separate outlines"),
    "spike": (lambda: ngon([*SQUARE[:3], (4, 6), (4, 9), (4.0001, 6), (0, 6)]), "spike.*In 'Hall': vertex 4"),
    "no area": (lambda: wire([(0, 0), (1, 0), (2, 0)]), "spike|encloses no area"),
    "NaN": (lambda: wire([(0, 0), (math.nan, 0), (2, 2)]), "vertex 1 of 'Hall' is not finite"),
    "text": (text, "Select an outline"),
}


@pytest.mark.parametrize(("build", "message"), BAD.values(), ids=BAD.keys())
@pytest.mark.parametrize("mode", ["OBJECT", "EDIT"])
def test_bad_outlines(build, message, mode) -> None:
    build()
    ob = bpy.context.object
    if ob.type != "FONT":
        bpy.ops.object.mode_set(mode=mode)
    before = everything()
    with pytest.raises(RuntimeError, match=message):
        bpy.ops.cmc.mesh_plan()
    assert everything() == before


def everything() -> tuple:
    """What a failed call must leave alone."""
    return (
        bpy.context.mode,
        bpy.context.object,
        [(o.name, o.hide_get(), o.select_get(), o.data, o.cmc.plan) for o in bpy.data.objects],
        [len(bpy.data.meshes), len(bpy.data.curves), len(bpy.data.collections)],
        bpy.context.scene.cmc.edge_length,
    )


def test_absurd_edge_length() -> None:
    ngon(SQUARE)
    with pytest.raises(RuntimeError, match=r"1,000,000 vertices of a plan that measures 8, .*longer than 0.0074"):
        bpy.ops.cmc.mesh_plan(edge_length=1e-5)
    assert list(bpy.data.objects) == [bpy.context.object]
