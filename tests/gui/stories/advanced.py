"""Other sites, energies and faces, chosen in the redo panel: the energy follows the sites, and every choice solves."""

from __future__ import annotations

import bpy


def plan():
    return bpy.data.objects["Circle Plan"]


def choice() -> tuple[str, str]:
    return plan().cmc.sites, plan().cmc.energy


def tell(hands):
    bpy.ops.mesh.primitive_circle_add(vertices=48, radius=4.0, fill_type="NGON")
    bpy.ops.cmc.mesh_plan(edge_length=0.5)
    bpy.context.object.cmc.default_kind = "BINORMAL"
    bpy.ops.ed.undo_push(message="Plan")
    yield from hands.click_button("cmc.solve")
    yield from hands.wait_for(lambda: plan().cmc.f_plus is not None, "the shell is there")
    before = [tuple(vertex.co) for vertex in plan().cmc.f_plus.data.vertices]

    yield from hands.press("F9")
    yield from hands.picture("vertices")
    yield from hands.redo_choose("Normals On Vertices", "Faces")  # not "Normals on a Sphere"
    usual = ("FACES", "DUAL_COTAN")
    yield from hands.wait_for(lambda: choice() == usual, "normals are on faces, with their usual energy")
    assert [tuple(vertex.co) for vertex in plan().cmc.f_plus.data.vertices] != before
    yield from hands.picture("faces")
    yield from hands.press("ESC")
    yield from hands.press("Z", ctrl=True)
    yield from hands.wait_for(lambda: plan().cmc.f_plus is None, "undo has taken it back")
    assert choice() == ("VERTICES", "COTAN")
