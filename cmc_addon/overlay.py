"""The boundary groups of the active plan as coloured lines in the viewport.

Colours are the theme's bone colour sets, whose icons stand beside the groups in the list. Lines are drawn
through everything, since a shell usually stands over its rim. The cost of a redraw is that of the lines.
"""

from __future__ import annotations

import bpy
import gpu
from gpu_extras.batch import batch_for_shader

from .mesh_cache import group_lines

# Numbers of colour sets, those first that are unlike each other and unlike Blender's orange of selection.
_COLOURS = (4, 3, 9, 6, 1, 7, 5, 8, 12, 14, 13, 11, 10, 15, 2)
_WIDTH, _ACTIVE_WIDTH = 3.0, 5.0

_handle = None
_batches: dict[int, tuple[object, object]] = {}


def icon_of(uid: int) -> str:
    """Icon of the colour that the group with this uid has."""
    return f"COLORSET_{_colour_number(uid):02d}_VEC"


def colour_of(uid: int) -> tuple[float, float, float]:
    return tuple(bpy.context.preferences.themes[0].bone_color_sets[_colour_number(uid) - 1].select)


def _colour_number(uid: int) -> int:
    return _COLOURS[(uid - 1) % len(_COLOURS)]


def shown_plan(context: bpy.types.Context) -> bpy.types.Object | None:
    """The plan whose groups are drawn: the active object, or the plan of the active result."""
    ob = context.object
    if ob is not None and ob.cmc.role != "NONE":
        ob = ob.cmc.source
    if ob is None or ob.type != "MESH" or not ob.data.cmc.groups:
        return None
    return ob if ob.visible_get(view_layer=context.view_layer) else None


def _draw() -> None:
    context = bpy.context
    if not context.space_data.overlay.show_overlays or not context.scene.cmc.show_groups:
        return
    plan = shown_plan(context)
    if plan is None:
        return
    cmc, shader = plan.data.cmc, gpu.shader.from_builtin("POLYLINE_UNIFORM_COLOR")
    active = cmc.groups[cmc.active_index].uid if 0 <= cmc.active_index < len(cmc.groups) else 0
    scale = context.preferences.system.ui_scale
    shader.bind()
    shader.uniform_float("viewportSize", gpu.state.viewport_get()[2:])
    with gpu.matrix.push_pop():
        gpu.matrix.multiply_matrix(plan.matrix_world)
        for uid, lines in group_lines(plan.data).items():
            shader.uniform_float("lineWidth", scale * (_ACTIVE_WIDTH if uid == active else _WIDTH))
            shader.uniform_float("color", (*colour_of(uid), 1.0))
            _batch(shader, uid, lines).draw(shader)


def _batch(shader, uid: int, lines):
    """The lines as the graphics card has them; sent once, as long as they are the same."""
    known = _batches.get(uid)
    if known is None or known[0] is not lines:
        known = (lines, batch_for_shader(shader, "LINES", {"pos": lines.reshape(-1, 3)}))
        _batches[uid] = known
    return known[1]


def register() -> None:
    global _handle
    if not bpy.app.background:
        _handle = bpy.types.SpaceView3D.draw_handler_add(_draw, (), "WINDOW", "POST_VIEW")


def unregister() -> None:
    global _handle
    if _handle is not None:
        bpy.types.SpaceView3D.draw_handler_remove(_handle, "WINDOW")
        _handle = None
    _batches.clear()
