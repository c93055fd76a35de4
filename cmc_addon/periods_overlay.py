"""The gap around each hole of the active plan as an arrow in the viewport, from one end of it to the other."""

from __future__ import annotations

import bpy
import gpu
import numpy as np
from gpu_extras.batch import batch_for_shader
from mathutils import Matrix
from numpy.typing import NDArray

from .panels import plan_to_solve
from .properties import ROLES
from .results import result_of
from .results_panel import last_report

_COLOUR = (1.0, 0.42, 0.1, 1.0)
_WIDTH = 3.0
# Length of the head as a part of the arrow, and its half width as a part of that.
_HEAD, _SPREAD = 0.18, 0.35

_handle = None
_known: tuple[object, object] | None = None


def arrows(report: dict) -> NDArray[np.float32]:
    """Ends (n, 2, 3), in the world, of the lines of the arrows of a report; none where the shell closes."""
    holes = report.get("holes") or []
    if not report.get("is_open") or not holes:
        return np.zeros((0, 2, 3), dtype=np.float32)
    lines = [_arrow(np.array(hole["at"]), np.array(hole["period"])) for hole in holes if hole["length"] > 0.0]
    return np.concatenate([np.zeros((0, 2, 3)), *lines]).astype(np.float32)


def _arrow(start: NDArray, along: NDArray) -> NDArray:
    tip = start + along
    side = np.cross(along, np.eye(3)[np.argmin(np.abs(along))])
    side *= np.linalg.norm(along) / np.linalg.norm(side)
    other = np.cross(side, along) / np.linalg.norm(along)
    barbs = [tip + _HEAD * (_SPREAD * s - along) for s in (side, -side, other, -other)]
    return np.array([(start, tip), *((barb, tip) for barb in barbs)])


def placing(plan: bpy.types.Object, report: dict) -> NDArray[np.float64]:
    """(4, 4) from where the shell of a plan was made to where it is now."""
    role = next(role for role, sheet in ROLES.items() if sheet == report["sheet"])
    shell = result_of(plan, role)
    if shell is None:
        return np.eye(4)
    back = np.eye(4)
    back[:3, 3] = -np.array(shell.cmc.placed_at)
    return np.array(shell.matrix_world) @ back


def _draw() -> None:
    context = bpy.context
    if not context.space_data.overlay.show_overlays or not context.scene.cmc.show_periods:
        return
    report, plan = last_report(context), plan_to_solve(context)
    if report is None or plan is None or not report.get("is_open"):
        return
    shader = gpu.shader.from_builtin("POLYLINE_UNIFORM_COLOR")
    batch = _batch(shader, report)
    if batch is None:
        return
    shader.bind()
    shader.uniform_float("viewportSize", gpu.state.viewport_get()[2:])
    shader.uniform_float("lineWidth", context.preferences.system.ui_scale * _WIDTH)
    shader.uniform_float("color", _COLOUR)
    with gpu.matrix.push_pop():
        gpu.matrix.multiply_matrix(Matrix(placing(plan, report).tolist()))
        batch.draw(shader)


def _batch(shader, report: dict):
    """The lines as the graphics card has them; sent once a report."""
    global _known
    if _known is None or _known[0] is not report:
        lines = arrows(report)
        batch = batch_for_shader(shader, "LINES", {"pos": lines.reshape(-1, 3)}) if len(lines) else None
        _known = (report, batch)
    return _known[1]


def register() -> None:
    global _handle
    if not bpy.app.background:
        _handle = bpy.types.SpaceView3D.draw_handler_add(_draw, (), "WINDOW", "POST_VIEW")


def unregister() -> None:
    global _handle, _known
    if _handle is not None:
        bpy.types.SpaceView3D.draw_handler_remove(_handle, "WINDOW")
        _handle = None
    _known = None
