"""Fits that are refused: one sentence, and an unchanged scene."""

from __future__ import annotations

import bpy

# isort: split
import numpy as np
import pytest

from .design_scenes import approximated, fitted, raised_loop, small_disc
from .scenes import activate, mesh_object, positions, quad_ring, snapshot


def fails(pattern: str, call, **settings) -> None:
    before = snapshot()
    with pytest.raises(RuntimeError, match=pattern):
        call(**settings)
    assert snapshot() == before


@pytest.fixture(params=["approximate_surface", "fit_outline"])
def operator(request):
    return getattr(bpy.ops.cmc, request.param)


def test_nothing_active(operator):
    activate(None)
    fails("No object is active", operator)


def test_not_a_mesh(operator):
    bpy.ops.object.camera_add()
    fails("'Camera' is not a mesh", operator)


def test_no_faces(operator):
    mesh_object("Wire", [(0, 0, 0), (1, 0, 0), (1, 1, 0)], [], edges=[(0, 1), (1, 2)])
    fails("'Wire' has no faces", operator)


def test_closed_mesh(operator):
    bpy.ops.mesh.primitive_cube_add()
    fails("The mesh is closed: it has no boundary", operator)


def test_two_components(operator):
    first, second = small_disc("One"), small_disc("Two")
    faces = [tuple(p.vertices) for p in first.data.polygons]
    points = np.concatenate([positions(first), positions(second) + [20.0, 0.0, 0.0]])
    count = len(first.data.vertices)
    mesh_object("Both", points, faces + [tuple(i + count for i in face) for face in faces])
    fails("2 components", operator)


def test_a_result_whose_plan_is_gone(operator):
    plan = small_disc()
    fitted(plan)
    result = plan.cmc.fit
    bpy.data.objects.remove(plan)
    activate(result)
    fails("plan has been deleted", operator)


def test_a_result_in_edit_mode(operator):
    plan = small_disc(rise=1.0)
    fitted(plan)
    approximated(plan)
    activate(plan.cmc.nearest)
    bpy.ops.object.mode_set(mode="EDIT")
    fails("is in edit mode", operator)


def test_a_flat_surface_has_no_nearest_one():
    small_disc()
    fails("flat or a point", bpy.ops.cmc.approximate_surface)


def test_no_curve():
    plan = small_disc()
    fails("'Disc' has no curve", bpy.ops.cmc.fit_outline, fit_to="CURVE")
    fails("No object is called 'Nobody'", bpy.ops.cmc.fit_outline, curve="Nobody")
    curve, _ = raised_loop()
    plan.cmc.fit_to, plan.cmc.fit_curve = "CURVE", curve
    bpy.context.scene.collection.objects.unlink(curve)
    activate(plan)
    fails("'Curve' has been deleted", bpy.ops.cmc.fit_outline)


def test_curves_that_will_not_do():
    mesh_object("Open", [(0, 0, 0), (1, 0, 0), (1, 1, 0)], [], edges=[(0, 1), (1, 2)])
    quad_ring("Two")
    mesh_object("Points", [(0, 0, 0), (1, 0, 0)], [])
    bpy.ops.object.camera_add()
    small_disc()
    fails("'Open' is open at", bpy.ops.cmc.fit_outline, curve="Open")
    fails("There are 2 curves, but the plan's boundary has one loop", bpy.ops.cmc.fit_outline, curve="Two")
    fails("'Points' has no edges", bpy.ops.cmc.fit_outline, curve="Points")
    fails("'Camera' is neither a mesh nor a curve", bpy.ops.cmc.fit_outline, curve="Camera")


def test_no_anchors():
    bpy.data.collections.new("Nothing")
    small_disc()
    fails("There are no anchors", bpy.ops.cmc.fit_outline, fit_to="ANCHORS")
    fails("'Nothing' has no empties", bpy.ops.cmc.fit_outline, anchors="Nothing")
    fails("No collection is called 'Nobody'", bpy.ops.cmc.fit_outline, anchors="Nobody")
