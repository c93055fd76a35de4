"""Draws the viewport overlay. The graphics card keeps the layers it was sent for as long as they are used.

Lines have a dark edge, so that they are readable on light and dark ground. What lies behind a face is drawn faintly,
since a shell usually stands over its rim. Everything is drawn a little nearer to the eye than it is, or the faces of
the plan would cut into lines that lie in them.
"""

from __future__ import annotations

import traceback
from dataclasses import dataclass

import bpy
import gpu
from gpu_extras.batch import batch_for_shader
from mathutils import Matrix

from . import overlay, overlay_cache
from .overlay_layers import Layer

# Everything is drawn nearer by this part of its distance to the eye.
_NEARER = 2e-3
# Alpha behind a face, as a part of the alpha in front of it.
_BEHIND = 0.28
# The dark edge of lines: pixels on both sides together, and alpha.
_EDGE, _EDGE_ALPHA = 2.0, 0.45
_SHADERS = {"LINES": "POLYLINE_UNIFORM_COLOR", "TRIS": "UNIFORM_COLOR"}


@dataclass
class _Batch:
    """A layer as the graphics card has it; `used` counts frames."""

    layer: Layer
    batch: object
    used: int


class Drawing:
    """Blender's draw handle, the batches on the graphics card, the number of the frame, and the last reported error."""

    handle = None
    batches: dict[int, _Batch] = {}
    frame = 0
    reported = ""


def _draw() -> None:
    """Draw the overlay. An error is printed once, since an overlay must not stop the viewport from drawing."""
    context = bpy.context
    state = gpu.state.blend_get(), gpu.state.depth_test_get(), gpu.state.depth_mask_get()
    try:
        parts = overlay.frame(context, context.space_data)
        if parts:
            _draw_parts(parts, context)
    except Exception as error:
        if Drawing.reported != repr(error):
            Drawing.reported = repr(error)
            traceback.print_exc()
    finally:
        blend, test, mask = state
        gpu.state.blend_set(blend)
        gpu.state.depth_test_set(test)
        gpu.state.depth_mask_set(mask)


def _draw_parts(parts: list[overlay.Part], context: bpy.types.Context) -> None:
    Drawing.frame += 1
    shaders = {kind: gpu.shader.from_builtin(name) for kind, name in _SHADERS.items()}
    scale = context.preferences.system.ui_scale
    gpu.state.blend_set("ALPHA")
    gpu.state.depth_mask_set(False)
    with gpu.matrix.push_pop_projection():
        gpu.matrix.load_projection_matrix(_nearer(gpu.matrix.get_projection_matrix(), context.region_data))
        for behind in (True, False):
            gpu.state.depth_test_set("GREATER" if behind else "LESS_EQUAL")
            for part in parts:
                with gpu.matrix.push_pop():
                    gpu.matrix.multiply_matrix(part.matrix)
                    for layer in part.layers:
                        if not (behind and layer.hides):
                            _draw_layer(layer, shaders[layer.kind], scale, _BEHIND if behind else 1.0)
    _drop_unused()


def _nearer(projection: Matrix, region: bpy.types.RegionView3D | None) -> Matrix:
    """The projection of points moved towards the eye, each along its line of sight."""
    if region is None or not region.is_perspective:
        distance = region.view_distance if region is not None else 1.0
        return projection @ Matrix.Translation((0.0, 0.0, _NEARER * distance))
    return projection @ Matrix.Scale(1.0 - _NEARER, 4)


def _draw_layer(layer: Layer, shader, scale: float, alpha: float) -> None:
    batch = _batch(layer, shader)
    shader.bind()
    *colour, own = layer.colour
    if layer.kind == "LINES":
        shader.uniform_float("viewportSize", gpu.state.viewport_get()[2:])
        if layer.edged and layer.width > _EDGE and alpha == 1.0:
            shader.uniform_float("lineWidth", scale * (layer.width + _EDGE))
            shader.uniform_float("color", (0.0, 0.0, 0.0, _EDGE_ALPHA * own))
            batch.draw(shader)
        shader.uniform_float("lineWidth", scale * layer.width)
    shader.uniform_float("color", (*colour, own * alpha))
    batch.draw(shader)


def _batch(layer: Layer, shader):
    """The layer as the graphics card has it; sent once."""
    known = Drawing.batches.get(id(layer))
    if known is None or known.layer is not layer:
        known = _Batch(layer, batch_for_shader(shader, layer.kind, {"pos": layer.points}), 0)
        Drawing.batches[id(layer)] = known
    known.used = Drawing.frame
    return known.batch


def _drop_unused() -> None:
    """Drop batches unused in the last frames; each viewport draws its own."""
    for key in [key for key, known in Drawing.batches.items() if known.used < Drawing.frame - 20]:
        del Drawing.batches[key]


def register() -> None:
    if not bpy.app.background and Drawing.handle is None:
        Drawing.handle = bpy.types.SpaceView3D.draw_handler_add(_draw, (), "WINDOW", "POST_VIEW")


def unregister() -> None:
    if Drawing.handle is not None:
        bpy.types.SpaceView3D.draw_handler_remove(Drawing.handle, "WINDOW")
        Drawing.handle = None
    Drawing.batches.clear()
    Drawing.reported = ""
    overlay_cache.forget()
