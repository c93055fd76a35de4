"""The batches of curvature lines are dropped by whatever changes a mesh, an animation included."""

from __future__ import annotations

import bpy

# isort: split
from .test_colours import hall, module, solve


def test_batches_of_curvature_lines_are_dropped_at_a_frame_that_changes_a_mesh():
    result = solve(hall())
    bend = result.modifiers.new("Bend", "SIMPLE_DEFORM")
    bend.factor = 0.0
    bend.keyframe_insert("factor", frame=1)
    bend.factor = 0.5
    bend.keyframe_insert("factor", frame=10)
    bpy.context.scene.frame_set(1)
    batches = module("drawing.curvature_lines_overlay")._batches
    batches[result.data.session_uid] = ((), [])
    bpy.context.scene.frame_set(10)
    assert not batches
