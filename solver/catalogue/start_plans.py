"""Ordinary plans to start from: rectangular, round, L-shaped, with a court; meshed, on their lines all around.

Convex corners are sharp, re-entrant ones rounded by a tenth of the size, so that the plan can be solved at once.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from . import shapes
from .holed_plans import StartPlan

Array = NDArray[np.float64]

# Radius of the rounded corners as a part of the plan's length.
_ROUND = 0.1


def rectangle(size: float, width: float, columns: int) -> StartPlan:
    """A rectangle: size long, width (a part of its length) deep, about `columns` edges long."""
    return _plan("Rectangle", _box(size, width * size), (), size, columns)


def round_plan(size: float, columns: int) -> StartPlan:
    """A circle of a diameter, about `columns` edges wide; its shell is a piece of a sphere."""
    angle = np.linspace(0.0, 2.0 * np.pi, 96, endpoint=False)
    circle = 0.5 * size * np.column_stack([np.cos(angle), np.sin(angle)])
    return _plan("Round", circle, (), size, columns, corner=0.0)


def l_shape(size: float, width: float, columns: int) -> StartPlan:
    """Two wings at a right angle, size long and width (a part of it) deep, their corners rounded."""
    deep = min(width, 0.8) * size
    corners = np.array([[0, 0], [size, 0], [size, deep], [deep, deep], [deep, size], [0, size]], dtype=np.float64)
    return _plan("L-Shaped", corners - 0.5 * size, (), size, columns)


def court(size: float, width: float, hole: float, columns: int) -> StartPlan:
    """A rectangle around a round court in its middle, whose diameter is a part of the shorter side.

    By its symmetry the shell closes around the court with any lean of its rims.
    """
    angle = np.linspace(0.0, 2.0 * np.pi, 96, endpoint=False)
    inner = 0.5 * hole * min(width, 1.0) * size * np.column_stack([np.cos(angle), np.sin(angle)])
    return _plan("Court", _box(size, width * size), (inner,), size, columns)


def _box(length: float, width: float) -> Array:
    return 0.5 * np.array([[-length, -width], [length, -width], [length, width], [-length, width]])


def _plan(
    name: str,
    outline: Array,
    holes: Sequence[Array],
    size: float,
    columns: int,
    corner: float = _ROUND,
) -> StartPlan:
    radius = corner * size
    corners = "re-entrant" if radius else "none"
    shape = shapes.polygon(outline, holes, max_edge=size / columns, corner_radius=radius, corners=corners)
    flat = shape.positions
    points = np.column_stack([flat, np.zeros(len(flat))])
    settings, uvs = {"default_kind": "LINE"}, flat[shape.domain.faces]
    return StartPlan(name, shape.domain, points, uvs, {}, {}, settings=settings, remesh=True)
