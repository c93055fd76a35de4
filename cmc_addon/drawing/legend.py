"""The colour legend: a bar with numbers at the left of the viewport.

It is drawn while Solid shading shows the colours and the coloured result of a plan is visible.
"""

from __future__ import annotations

from dataclasses import dataclass

import blf
import bpy
import gpu
import numpy as np
from gpu_extras.batch import batch_for_shader

from ..bridges.colour_bridge import is_painted
from ..properties.colour_maps import Range, decimals
from ..properties.colour_range import stored_range
from ..properties.colour_settings import QUANTITIES
from ..properties.links import result_of, seen_results
from ..properties.stored import COMPLETED_ROLES
from ..properties.units import in_units, length_text, per_length
from . import shading

# Pixels at an interface scale of 1.
_BAR, _HEIGHT, _MARGIN, _FONT, _LINE = 16, 190, 22, 11, 15
# Number of pieces of the bar, and its largest height as a part of the viewport.
_PIECES, _LARGEST = 48, 0.5
# Text of a colour nearer than this to the ground's is black or white instead.
_LIKE = 0.5

_handle = None


@dataclass(frozen=True)
class Legend:
    """Title and subtitle; labels: a place on the bar, from 0 to 1, and its text; range: None draws no bar."""

    title: str
    subtitle: str
    labels: list[tuple[float, str]]
    range: Range | None


# --- its texts --------------------------------------------------------------------------

def legend_of(context: bpy.types.Context) -> Legend | None:
    """The legend for the plan whose colours are shown; None if no coloured result is visible."""
    plan = shading.look_plan(context)
    if plan is None or plan.cmc.colour_by == "NONE":
        return None
    result = _seen(context, plan)
    if result is None:
        return None
    by = QUANTITIES[plan.cmc.colour_by]
    span = _range(plan, result)
    if span is None:
        return Legend(by.label, f"{result.name} is not measured: solve again", [], None)
    parts = [_unit(plan.cmc.colour_by, result.cmc.role), result.name]
    return Legend(by.label, "  ".join(part for part in parts if part), labels(plan.cmc.colour_by, span), span)


def _seen(context: bpy.types.Context, plan: bpy.types.Object) -> bpy.types.Object | None:
    """The result that is shown if it is coloured, else the first one seen that is."""
    return next((ob for ob in seen_results(context, plan) if ob.type == "MESH" and is_painted(ob.data)), None)


def _range(plan: bpy.types.Object, result: bpy.types.Object) -> Range | None:
    """The range of a result; instances without their own have the range of the shell."""
    own = stored_range(result)
    if own is None and result.cmc.role in COMPLETED_ROLES:
        shell = result_of(plan, plan.cmc.sheet)
        return None if shell is None else stored_range(shell)
    return own


def _unit(by: str, role: str) -> str:
    if by == "DEVIATION":
        return "from the surface" if role == "NEAREST" else "of the rim"
    return {-1: per_length(), -2: f"{per_length()}²"}.get(QUANTITIES[by].power, "1 keeps shapes")


def labels(by: str, span: Range) -> list[tuple[float, str]]:
    """The numbers beside the bar, with the target named, and ≤ or ≥ where values lie beyond an end."""
    ticks, power = span.ticks(), QUANTITIES[by].power
    numbers = [in_units(value, -power) for value in ticks]
    digits = decimals(numbers)
    written = []
    for value, number in zip(ticks, numbers, strict=True):
        text = length_text(value, digits=3) if power == 1 else _number(number, digits)
        if value == span.low and span.below:
            text = f"≤ {text}"
        if value == span.high and span.above:
            text = f"≥ {text}"
        if by == "MEAN_CURVATURE" and value == span.centre:
            text += "  target"
        written.append(((value - span.low) / (span.high - span.low), text))
    return written


def _number(value: float, digits: int) -> str:
    return f"{value:.3g}" if not value or digits > 5 or abs(value) >= 1e5 else f"{value:.{digits}f}"


# --- drawing -------------------------------------------------------------------------------

def _shows_colours(view: bpy.types.SpaceView3D) -> bool:
    solid = view.shading.type == "SOLID" and view.shading.color_type == shading.BY_ATTRIBUTE
    return solid and view.overlay.show_overlays


def _draw() -> None:
    context = bpy.context
    if not _shows_colours(context.space_data):
        return
    legend = legend_of(context)
    if legend is None:
        return
    scale = context.preferences.system.ui_scale
    x, height = _left(context) + _MARGIN * scale, min(_HEIGHT * scale, _LARGEST * context.region.height)
    y = 0.5 * (context.region.height - height)
    if legend.range is not None:
        _bar(legend.range, x, y, _BAR * scale, height)
    text, shadow = inks(context.preferences.themes[0].view_3d.space)
    top = y + height if legend.range is not None else y
    _write(legend.title, x, top + (_MARGIN + _LINE) * scale, _FONT * scale, text, shadow)
    _write(legend.subtitle, x, top + _MARGIN * scale, _FONT * scale, text, shadow)
    for place, words in legend.labels:
        _write(words, x + 1.5 * _BAR * scale, y + place * height - 0.35 * _FONT * scale, _FONT * scale, text, shadow)


def _left(context: bpy.types.Context) -> float:
    """The right edge of the toolbar, in pixels of the region."""
    edges = [
        region.x + region.width - context.region.x
        for region in context.area.regions
        if region.type == "TOOLS" and region.width > 1
    ]
    return max(0, *edges) if edges else 0


def _bar(span: Range, x: float, y: float, width: float, height: float) -> None:
    parts = np.linspace(0.0, 1.0, _PIECES)
    rgb = span.colours(span.low + parts * (span.high - span.low))
    places = [(x + side * width, y + part * height) for part in parts for side in (0, 1)]
    colours = np.column_stack([np.repeat(rgb, 2, axis=0), np.ones(2 * _PIECES)])
    shader = gpu.shader.from_builtin("SMOOTH_COLOR")
    batch_for_shader(shader, "TRI_STRIP", {"pos": places, "color": colours.tolist()}).draw(shader)
    frame = [(x, y), (x + width, y), (x + width, y + height), (x, y + height), (x, y)]
    plain = gpu.shader.from_builtin("UNIFORM_COLOR")
    plain.uniform_float("color", (0.0, 0.0, 0.0, 1.0))
    batch_for_shader(plain, "LINE_STRIP", {"pos": frame}).draw(plain)


def inks(space: bpy.types.ThemeSpaceGradient) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Colours of the text and of its shadow: the theme's, or black or white where that is too like the ground, and the
    shadow the other one, as Blender's own text in the viewport."""
    text, ground = np.array(space.text_hi), np.array(space.gradients.high_gradient)
    if np.linalg.norm(text - ground) < _LIKE:
        text = np.full(3, float(ground.mean() < 0.5))
    return (*text.tolist(), 1.0), (*[float(text.mean() < 0.5)] * 3, 0.7)


def _write(
    words: str, x: float, y: float, size: float, colour: tuple[float, ...], shadow: tuple[float, ...]
) -> None:
    blf.size(0, size)
    blf.color(0, *colour)
    blf.enable(0, blf.SHADOW)
    blf.shadow(0, 3, *shadow)
    blf.shadow_offset(0, 1, -1)
    blf.position(0, round(x), round(y), 0)
    blf.draw(0, words)
    blf.disable(0, blf.SHADOW)


def register() -> None:
    global _handle
    if not bpy.app.background:
        _handle = bpy.types.SpaceView3D.draw_handler_add(_draw, (), "WINDOW", "POST_PIXEL")


def unregister() -> None:
    global _handle
    if _handle is not None:
        bpy.types.SpaceView3D.draw_handler_remove(_handle, "WINDOW")
        _handle = None
