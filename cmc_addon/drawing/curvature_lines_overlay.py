"""Draws the curvature lines of the results of the plan whose look is shown (see `look_plan`) in the viewport.

They are computed once per change of a mesh. While a shell only changes its shape, the lines keep their vertices: they
turn, and do not jump.
"""

from __future__ import annotations

import bpy
import gpu
import numpy as np
from gpu_extras.batch import batch_for_shader
from mathutils import Matrix

from ..bridges.colour_bridge import points_and_directions
from ..bridges.geometry_changes import watched
from ..properties.colour_settings import watchers
from ..properties.links import families
from .curvature_lines import curvature_lines, default_spacing, spread
from .shading import look_plan
from .viewport import redraw

# Along the larger and the smaller principal curvature: far from every colour of the ramps and of the selection.
_COLOURS = ((1.0, 0.1, 0.75, 1.0), (0.3, 0.95, 0.0, 1.0))
_EDGE = (0.05, 0.05, 0.05, 0.6)
_WIDTH, _EDGE_WIDTH = 1.6, 3.6
# The lines are drawn nearer by this part of their distance, so that their own surface does not hide them.
_NEARER = 2e-3

_handle = None
# By mesh: its batches on the graphics card, and the vertices with a line, each with the key it was made for.
_batches: dict[int, tuple[tuple, list]] = watched({})
_places: dict[int, tuple[tuple, np.ndarray]] = watched({}, geometry=False)


def lines_of(mesh: bpy.types.Mesh, which: str, spacing: float) -> tuple[np.ndarray, np.ndarray] | None:
    """Ends (k, 2, 3) of both kinds of lines on a result, in its own coordinates; None if it has no directions.

    spacing: 0 means the default.
    """
    surface = points_and_directions(mesh)
    if surface is None:
        return None
    points, normals, directions = surface
    key = (len(points), spacing)
    known = _places.get(mesh.session_uid)
    if known is None or known[0] != key:
        known = key, spread(points, spacing or default_spacing(points))
        _places[mesh.session_uid] = known
    at = known[1]
    return curvature_lines(points[at], normals[at], directions[at], which, spacing or default_spacing(points))


def shown_results(context: bpy.types.Context, plan: bpy.types.Object) -> list[bpy.types.Object]:
    """The visible meshes among the results of a plan, with all instances."""
    results = [member for family in families(plan) for member in (family.shell, *family.others)]
    copies = [] if plan.cmc.copies is None else list(plan.cmc.copies.objects)
    every = {ob.name: ob for ob in (*results, *copies)}.values()
    return [ob for ob in every if ob.type == "MESH" and ob.visible_get(view_layer=context.view_layer)]


def _draw() -> None:
    context = bpy.context
    if not context.space_data.overlay.show_overlays:
        return
    plan = look_plan(context)
    if plan is None or plan.cmc.curvature_lines == "NONE":
        return
    shader = gpu.shader.from_builtin("POLYLINE_UNIFORM_COLOR")
    shader.bind()
    shader.uniform_float("viewportSize", gpu.state.viewport_get()[2:])
    gpu.state.depth_test_set("LESS_EQUAL")
    gpu.state.blend_set("ALPHA")
    projection, distance = gpu.matrix.get_projection_matrix(), context.region_data.view_distance
    shown, scale = shown_results(context, plan), context.preferences.system.ui_scale
    for part, width, colours in ((_NEARER, _EDGE_WIDTH, (_EDGE, _EDGE)), (1.5 * _NEARER, _WIDTH, _COLOURS)):
        shader.uniform_float("lineWidth", scale * width)
        with gpu.matrix.push_pop_projection():
            gpu.matrix.load_projection_matrix(nearer(projection, distance, part))
            for ob in shown:
                _draw_on(shader, ob, plan.cmc, colours)
    gpu.state.blend_set("NONE")
    gpu.state.depth_test_set("NONE")


def nearer(projection: Matrix, distance: float, part: float = _NEARER) -> Matrix:
    """A projection that moves things nearer to the eye by a part of their distance, along their line of sight.

    distance: of the view, used by a parallel projection.
    """
    perspective = projection[3][3] == 0.0
    moved = Matrix.Scale(1.0 - part, 4) if perspective else Matrix.Translation((0.0, 0.0, part * distance))
    if perspective:
        moved[3][3] = 1.0
    return projection @ moved


def _draw_on(shader, ob: bpy.types.Object, settings, colours: tuple) -> None:
    with gpu.matrix.push_pop():
        gpu.matrix.multiply_matrix(ob.matrix_world)
        for batch, colour in zip(_batches_of(shader, ob.data, settings), colours, strict=True):
            if batch is not None:
                shader.uniform_float("color", colour)
                batch.draw(shader)


def _batches_of(shader, mesh: bpy.types.Mesh, settings) -> list:
    key = (settings.curvature_lines, settings.curvature_line_spacing, len(mesh.vertices))
    known = _batches.get(mesh.session_uid)
    if known is None or known[0] != key:
        known = key, _made(shader, lines_of(mesh, settings.curvature_lines, settings.curvature_line_spacing))
        _batches[mesh.session_uid] = known
    return known[1]


def _made(shader, lines) -> list:
    if lines is None:
        return [None, None]
    flat = [ends.reshape(-1, 3).astype(np.float32) for ends in lines]
    return [batch_for_shader(shader, "LINES", {"pos": points}) if len(points) else None for points in flat]


def _on_setting(*_: object) -> None:
    redraw()


def register() -> None:
    global _handle
    watchers.append(_on_setting)
    if not bpy.app.background:
        _handle = bpy.types.SpaceView3D.draw_handler_add(_draw, (), "WINDOW", "POST_VIEW")


def unregister() -> None:
    global _handle
    if _handle is not None:
        bpy.types.SpaceView3D.draw_handler_remove(_handle, "WINDOW")
        _handle = None
    if _on_setting in watchers:
        watchers.remove(_on_setting)
    _batches.clear()
    _places.clear()
