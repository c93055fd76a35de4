"""Approximations that are refused: one sentence, and an unchanged scene."""

from __future__ import annotations

import bpy

# isort: split
import numpy as np
import pytest

from .approximate_scenes import approximated, cap
from .scenes import activate, mesh_object, positions, quad_disc, snapshot


def fails(pattern: str, call, **settings) -> None:
    before = snapshot()
    with pytest.raises(RuntimeError, match=pattern):
        call(**settings)
    assert snapshot() == before


@pytest.fixture
def operator():
    return bpy.ops.cmc.approximate_surface


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
    first, second = cap("One"), cap("Two")
    faces = [tuple(p.vertices) for p in first.data.polygons]
    points = np.concatenate([positions(first), positions(second) + [20.0, 0.0, 0.0]])
    count = len(first.data.vertices)
    mesh_object("Both", points, faces + [tuple(i + count for i in face) for face in faces])
    fails("2 components", operator)


def test_a_result_whose_plan_is_gone(operator):
    plan = cap()
    approximated(plan)
    result = plan.cmc.nearest
    bpy.data.objects.remove(plan)
    activate(result)
    fails("plan has been deleted", operator)


def test_a_result_in_edit_mode(operator):
    plan = cap()
    approximated(plan)
    activate(plan.cmc.nearest)
    bpy.ops.object.mode_set(mode="EDIT")
    fails("is in edit mode", operator)


def test_a_flat_surface_has_no_nearest_one():
    quad_disc()
    fails("flat or a point", bpy.ops.cmc.approximate_surface)
