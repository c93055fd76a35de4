"""Draws the current shape of a running fit over the scene, without changing its data."""

from __future__ import annotations

import bpy
import gpu
import numpy as np
from gpu_extras.batch import batch_for_shader
from numpy.typing import NDArray

_FILL = (0.35, 0.65, 1.0, 0.25)
_LINES = (0.35, 0.65, 1.0, 0.8)


class Preview:
    """The shape shown and Blender's draw handle; None while nothing is shown."""

    shape: tuple[NDArray, NDArray] | None = None
    batches: list[tuple[object, tuple]] | None = None
    handle = None


def show(points: NDArray[np.float64], triangles: NDArray[np.integer]) -> None:
    """Draw triangles (F, 3) of points (n, 3) in the world from the next redraw on."""
    Preview.shape, Preview.batches = (points, triangles), None
    if Preview.handle is None and not bpy.app.background:
        Preview.handle = bpy.types.SpaceView3D.draw_handler_add(_draw, (), "WINDOW", "POST_VIEW")


def clear() -> None:
    """Stop drawing."""
    if Preview.handle is not None:
        bpy.types.SpaceView3D.draw_handler_remove(Preview.handle, "WINDOW")
    Preview.handle = Preview.shape = Preview.batches = None


def sides(triangles: NDArray[np.integer]) -> NDArray[np.int32]:
    """Each edge of the triangles once (E, 2)."""
    pairs = triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2)
    return np.unique(np.sort(pairs, axis=1), axis=0).astype(np.int32)


def _draw() -> None:
    if Preview.shape is None:
        return
    shader = gpu.shader.from_builtin("UNIFORM_COLOR")
    if Preview.batches is None:
        points, triangles = Preview.shape
        place = {"pos": np.ascontiguousarray(points, dtype=np.float32)}
        Preview.batches = [
            (batch_for_shader(shader, "TRIS", place, indices=triangles.astype(np.int32)), _FILL),
            (batch_for_shader(shader, "LINES", place, indices=sides(triangles)), _LINES),
        ]
    gpu.state.blend_set("ALPHA")
    gpu.state.depth_test_set("LESS_EQUAL")
    shader.bind()
    for batch, colour in Preview.batches:
        shader.uniform_float("color", colour)
        batch.draw(shader)
    gpu.state.depth_test_set("NONE")
    gpu.state.blend_set("NONE")


def register() -> None:
    """Nothing to do: the drawing comes with a fit."""


def unregister() -> None:
    clear()
