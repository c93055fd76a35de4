"""Draws handles in pixels of the region: shafts, grips, arcs and captions."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import blf
import gpu
import numpy as np
from gpu_extras.batch import batch_for_shader
from numpy.typing import NDArray

from .palette import Colour

Array = NDArray[np.float64]

# Pixels at an interface scale of 1: widths of a shaft and of its dark edge, radius of a grip, length of the head of an
# arrow, size of letters, and the margin around them.
_WIDTH, _EDGE, _GRIP, _HEAD, _FONT, _MARGIN = 2.5, 2.0, 5.0, 11.0, 12.0, 5.0
_LARGER = 1.35  # under the mouse
_SIDES = 20
_DARK, _GROUND, _INK = (0.0, 0.0, 0.0, 0.6), (0.08, 0.08, 0.08, 0.8), (1.0, 1.0, 1.0, 1.0)


@contextmanager
def blended() -> Iterator[None]:
    """Colours with an alpha mix with what is behind them; afterwards all is as before."""
    before = gpu.state.blend_get()
    gpu.state.blend_set("ALPHA")
    try:
        yield
    finally:
        gpu.state.blend_set(before)


def handle(track: Array, colour: Colour, scale: float, is_hot: bool, is_arrow: bool = False) -> None:
    """A shaft along points (n, 2) that ends in a grip: a disc, or an arrow's head. is_hot: under the mouse."""
    if not np.isfinite(track).all():
        return
    size = scale * (_LARGER if is_hot else 1.0)
    paint = (*colour, 1.0)
    line(track, _DARK, size * (_WIDTH + _EDGE))
    line(track, paint, size * _WIDTH)
    grip = _head if is_arrow else _disc
    _triangles(grip(track, size, 0.5 * _EDGE * size), _DARK)
    _triangles(grip(track, size, 0.0), (1.0, 1.0, 1.0, 1.0) if is_hot else paint)


def line(points: Array, colour: tuple[float, ...], width: float) -> None:
    """A polyline through points (n, 2); nothing where one is not known."""
    if not np.isfinite(points).all():
        return
    shader = gpu.shader.from_builtin("POLYLINE_UNIFORM_COLOR")
    shader.bind()
    shader.uniform_float("viewportSize", gpu.state.viewport_get()[2:])
    shader.uniform_float("lineWidth", width)
    shader.uniform_float("color", colour)
    batch_for_shader(shader, "LINE_STRIP", {"pos": _flat(points)}).draw(shader)


def caption(text: str, at: Array, scale: float, end: float) -> None:
    """A line of text right of a place (2,), on dark ground; end: of the view on the right, which it does not pass."""
    if not np.isfinite(at).all():
        return
    blf.size(0, _FONT * scale)
    width, height = blf.dimensions(0, text)
    margin = _MARGIN * scale
    x, y = at + [3.0 * _GRIP * scale, 2.0 * _GRIP * scale]
    x = min(x, end - width - 2.0 * margin)
    left, right, low, high = x - margin, x + width + margin, y - margin, y + height + margin
    corners = [(left, low), (right, low), (right, high), (left, low), (right, high), (left, high)]
    _triangles(np.array(corners), _GROUND)
    blf.color(0, *_INK)
    blf.position(0, round(x), round(y), 0.0)
    blf.draw(0, text)


def _disc(track: Array, size: float, more: float) -> Array:
    turn = np.linspace(0.0, 2.0 * np.pi, _SIDES + 1)
    ring = track[-1] + (_GRIP * size + more) * np.column_stack([np.cos(turn), np.sin(turn)])
    middle = np.broadcast_to(track[-1], ring[:-1].shape)
    return np.stack([middle, ring[:-1], ring[1:]], axis=1).reshape(-1, 2)


def _head(track: Array, size: float, more: float) -> Array:
    """The head of an arrow at the end of a track, pointing along its last piece; upwards where that is a point."""
    along = track[-1] - track[0]
    length = float(np.linalg.norm(along))
    along = along / length if length > 1.0 else np.array([0.0, 1.0])
    across = np.array([-along[1], along[0]])
    long, broad = _HEAD * size + 2.0 * more, 0.55 * _HEAD * size + 1.5 * more
    foot = track[-1] - more * along
    return np.stack([foot - broad * across, foot + broad * across, foot + long * along])


def _triangles(points: Array, colour: tuple[float, ...]) -> None:
    shader = gpu.shader.from_builtin("UNIFORM_COLOR")
    shader.bind()
    shader.uniform_float("color", colour)
    batch_for_shader(shader, "TRIS", {"pos": _flat(points)}).draw(shader)


def _flat(points: Array) -> NDArray[np.float32]:
    return np.column_stack([points, np.zeros(len(points))]).astype(np.float32)
