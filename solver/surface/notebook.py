"""How results look in a notebook: a small table of numbers, and a picture where matplotlib is installed.

Plain arrays and strings in, so that every result can use it.
"""

from __future__ import annotations

import base64
import html
import importlib
import io
from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

# The camera looks down from the front and the right: angles in degrees.
_TURN, _TILT = 30.0, 30.0
# Pictures of more faces take seconds.
_MOST_FACES = 60_000
# Colours (red, green, blue) of faces that look away from the light and towards it.
_DARK, _BRIGHT = np.array([0.24, 0.33, 0.42]), np.array([0.87, 0.91, 0.94])


def table(title: str, numbers: Mapping[str, object], beside: str = "") -> str:
    """HTML: a title, a line for each name and its value, and an HTML element `beside` them, such as a picture."""
    lines = "".join(
        f'<tr><td style="text-align:left">{html.escape(name)}</td>'
        f'<td style="text-align:right">{html.escape(str(value))}</td></tr>'
        for name, value in numbers.items()
    )
    text = f"<div><b>{html.escape(title)}</b><table>{lines}</table></div>"
    return f'<div style="display:flex;gap:1.5em;align-items:center">{text}{beside}</div>'


def picture(vertices: Array, faces: NDArray[np.integer], width: int = 320) -> str:
    """HTML: a PNG of the triangles (F, 3) on vertices (n, 3), z up, `width` pixels wide.

    Empty where matplotlib is not installed, where there are more than 60 000 faces, or where a vertex is not finite.
    """
    if not 0 < len(faces) <= _MOST_FACES or not np.isfinite(vertices).all():
        return ""
    try:
        figures, collections = (importlib.import_module(f"matplotlib.{name}") for name in ("figure", "collections"))
    except ImportError:
        return ""
    corners, colours = _projected(np.asarray(vertices, dtype=np.float64)[faces])
    figure = figures.Figure(figsize=(4.0, 3.0), dpi=width / 4.0)
    axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
    axes.add_collection(collections.PolyCollection(corners, facecolors=colours, edgecolors=colours, linewidths=0.3))
    axes.autoscale_view()
    axes.set_aspect("equal")
    axes.set_axis_off()
    file = io.BytesIO()
    figure.savefig(file, format="png", transparent=True)
    data = base64.b64encode(file.getvalue()).decode("ascii")
    return f'<img alt="picture" width="{width}" src="data:image/png;base64,{data}">'


def _projected(triangles: Array) -> tuple[Array, Array]:
    """Corners (F, 3, 2) on the picture, the farthest triangle first, and a colour (F, 3) for each."""
    turn, tilt = np.radians([_TURN, _TILT])
    right = np.array([np.cos(turn), np.sin(turn), 0.0])
    towards = np.array([np.sin(turn) * np.cos(tilt), -np.cos(turn) * np.cos(tilt), np.sin(tilt)])
    up = np.cross(towards, right)
    normals = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    normals /= np.maximum(np.linalg.norm(normals, axis=1), 1e-300)[:, None]
    light = np.abs(normals @ (0.8 * towards + 0.6 * up))[:, None]  # both sides of a shell are seen
    order = np.argsort(triangles.mean(axis=1) @ towards)
    corners = np.stack([triangles @ right, triangles @ up], axis=2)
    return corners[order], (_DARK + light**2 * (_BRIGHT - _DARK))[order]
