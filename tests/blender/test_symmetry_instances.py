"""Repeat by Symmetry with instances: linked duplicates that meet without a gap."""

from __future__ import annotations

import bpy
import numpy as np
from numpy.testing import assert_allclose

from .scenes import activate, positions
from .solved_modules import COPIES, FINISHED, completion_report, farthest, matrices, solved


def test_instances_meet_and_are_where_the_mesh_is():
    bpy.context.scene.cursor.location = (7.0, -3.0, 2.0)
    for name in ("HONEYCOMB", "NODOID"):
        plan = solved(name)
        assert bpy.ops.cmc.complete(complete_repeat=(2, 1, 1)) == FINISHED
        whole = positions(plan.cmc.completed)
        assert bpy.ops.cmc.complete(complete_as="INSTANCES", complete_repeat=(2, 1, 1)) == FINISHED
        assert plan.cmc.completed is None or not plan.cmc.completed.users_scene
        copies = plan.cmc.copies
        assert len(copies.objects) == completion_report(plan)["copies"] == 2 * COPIES[name]
        assert copies.name in plan.cmc.collection.children
        found = np.concatenate([positions(ob) for ob in copies.objects])
        size = np.linalg.norm(np.ptp(whole, axis=0))
        assert farthest(found, whole) < 1e-5 * size
        assert len({ob.data.name for ob in copies.objects}) == (2 if name == "NODOID" else 1)
        signs = np.sign(np.linalg.det(matrices(plan)[:, :3, :3]))
        assert sorted(set(signs)) == [-1.0, 1.0]
        assert_allclose(np.abs(np.linalg.det(matrices(plan)[:, :3, :3])), 1.0, atol=1e-5)
        reflected = [ob for ob, sign in zip(copies.objects, signs, strict=True) if sign < 0]
        assert all(max(ob.scale) < 0 for ob in reflected)


def test_instances_are_brought_up_to_date_in_place():
    plan = solved("UNDULOID")
    assert bpy.ops.cmc.complete(complete_as="INSTANCES", complete_count=6) == FINISHED
    first = plan.cmc.copies.objects[0]
    piece = first.data
    steel = bpy.data.materials.new("Steel")
    piece.materials.append(steel)
    before, count = matrices(plan), len(bpy.data.meshes)
    assert bpy.ops.cmc.complete(complete_count=4) == FINISHED
    assert len(plan.cmc.copies.objects) == 4 and plan.cmc.copies.objects[0] == first
    assert first.data == piece and list(piece.materials) == [steel] and len(bpy.data.meshes) == count
    assert_allclose(matrices(plan), before[:4], atol=1e-6)
    activate(first)
    assert bpy.ops.cmc.complete(complete_as="MESH") == FINISHED, "with a copy active, too"
    assert plan.cmc.copies is None and not [ob for ob in bpy.data.objects if " copy" in ob.name]
    assert not [mesh for mesh in bpy.data.meshes if mesh.get("cmc_piece")]
