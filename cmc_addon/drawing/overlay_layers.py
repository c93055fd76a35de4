"""The overlay of a rim as layers of lines and triangles. Arrays only, so that tests need no viewport."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from . import overlay_geometry as shapes
from .palette import Colour
from .rim import NOBODY, Rim, Walk
from .rim_strip import GroupState

Array = NDArray[np.float64]

# As parts of the plan's diagonal: length of an arrow, shortest period of dashes, least side of a plane.
_ARROW, _DASH, _WALL = 0.075, 0.016, 0.3
# Largest number of dashes around the boundary.
_DASHES = 300
# Edges farther from a plane than this part of the plan's diagonal do not lie in it.
_FLAT = 0.01
# Line widths: of the active group, relative to the others; in pixels of shafts, ticks, outlines, cuts and gaps.
_ACTIVE, _SHAFT, _TICK, _OUTLINE, _BOLD = 1.7, 2.0, 2.0, 1.5, 3.0
_FILL, _PLATE = 0.12, 0.3
# Of lines on which the rim lies: factor of the width, and the width of the bright core as a part of it.
_HELD, _CORE = 1.5, 0.3
# Half the height of the strip of wall along which a rim leans, in arrows.
_UPRIGHT = 0.9
# Lines of groups while the mesh is edited: factor of the width, and alpha.
_BROAD, _PALE = 2.4, 0.35
_CORNER: Colour = (0.92, 0.92, 0.92)
_BRIGHT: Colour = (1.0, 1.0, 1.0)

PLANAR = {"mirror", "plane"}
"""Kinds of groups along which the shell lies in planes."""


@dataclass(frozen=True, eq=False)
class Layer:
    """Points (n, 3), as pairs for lines or triples for triangles, with a colour (red, green, blue, alpha).

    width: of lines, in pixels at interface scale 1. hides: leave out what lies behind a face, as for planes; otherwise
    it is drawn faintly. edged: give lines a dark edge, to be readable on any ground.
    """

    kind: str
    points: NDArray[np.float32]
    colour: tuple[float, float, float, float]
    width: float = 1.0
    hides: bool = False
    edged: bool = True


@dataclass(frozen=True)
class Look:
    """The look of an overlay. shown: names of switches. scale, count: of arrows. colours: of groups, by uid. active:
    uid of the active group. width: of the lines of groups, in pixels. editing: draw them pale, over the selection."""

    shown: frozenset[str]
    scale: float
    count: int
    colours: tuple[tuple[int, Colour], ...]
    active: int
    width: float
    editing: bool
    ungrouped: Colour
    gaps: Colour
    cut: Colour

    def colour(self, uid: int) -> Colour:
        return dict(self.colours).get(uid, self.ungrouped)


def lines(points: Array, colour: Colour, width: float, alpha: float = 1.0, hides: bool = False) -> Layer:
    return Layer("LINES", _flat(points), (*colour, alpha), width, hides)


def triangles(points: Array, colour: Colour, alpha: float = 1.0, hides: bool = False) -> Layer:
    return Layer("TRIS", _flat(points), (*colour, alpha), hides=hides)


def _flat(points: Array) -> NDArray[np.float32]:
    """Lines or triangles as one list of points, without those that are not finite."""
    known = np.isfinite(points).all(axis=(1, 2))
    return np.ascontiguousarray(points[known].reshape(-1, 3), dtype=np.float32)


def rim_layers(rim: Rim, look: Look, walls: frozenset[int] = frozenset()) -> list[Layer]:
    """The layers of the rim of a plan. walls: uids of groups whose planes are drawn on the shell instead."""
    makers = (
        ("show_mirrors", lambda: _walls(rim, look, walls)),
        ("show_tangents", lambda: _tangents(rim, look)),
        ("show_ungrouped", lambda: _ungrouped(rim, look)),
        ("show_groups", lambda: _groups(rim, look)),
        ("show_normals", lambda: _normals(rim, look)),
    )
    layers = [layer for name, make in makers if name in look.shown for layer in make()]
    return [layer for layer in layers if len(layer.points)]


def arrow_length(rim: Rim, look: Look) -> float:
    return _ARROW * rim.size * look.scale


def _groups(rim: Rim, look: Look) -> Iterator[Layer]:
    for uid in rim.lines:
        if uid != NOBODY:
            yield from _side(rim, uid, look.width * (_ACTIVE if uid == look.active else 1.0), look)
    yield from _uprights(rim, look)


def _side(rim: Rim, uid: int, width: float, look: Look) -> Iterator[Layer]:
    """The edges of a group, or of none; those that hold the rim with a core, but in edit mode."""
    if rim.lies_on(uid) and not look.editing:
        yield from held_lines(rim.lines[uid], look.colour(uid), width)
    else:
        yield _edges(rim.lines[uid], look.colour(uid), width, look)


def held_lines(ends: Array, colour: Colour, width: float) -> Iterator[Layer]:
    """Lines on which the rim of the shell lies, ends (n, 2, 3): broad, with a bright core."""
    yield lines(ends, colour, _HELD * width)
    yield replace(lines(ends, _BRIGHT, _CORE * _HELD * width), edged=False)


def _uprights(rim: Rim, look: Look) -> Iterator[Layer]:
    """A strip of the wall through the edges of each group that leans over its line: its rim may rise and fall there."""
    size = np.linalg.norm(rim.up)
    if not size > 0.0:
        return
    rise = _UPRIGHT * arrow_length(rim, look) * rim.up / size
    for walk in rim.walks:
        group = rim.group(walk.uid)
        if group is not None and group.kind == "lean":
            panes = shapes.panes(walk.points - rise, 2.0 * rise)
            yield triangles(shapes.filled(panes), look.colour(walk.uid), _FILL, hides=True)
            yield replace(lines(panes.reshape(-1, 2, 3), look.colour(walk.uid), _OUTLINE, 0.5, hides=True), edged=False)


def _edges(ends: Array, colour: Colour, width: float, look: Look) -> Layer:
    """Edges of the mesh in the colour of their group; broad and pale in edit mode, over the selection."""
    if not look.editing:
        return lines(ends, colour, width)
    return replace(lines(ends, colour, _BROAD * width, _PALE), edged=False)


def _ungrouped(rim: Rim, look: Look) -> Iterator[Layer]:
    if NOBODY not in rim.lines:
        return
    if rim.lies_on(NOBODY):
        yield from _side(rim, NOBODY, look.width, look)
        return
    period = max(_DASH * rim.size, rim.length / _DASHES)
    dashed = [shapes.dashes(walk.points, period) for walk in rim.walks if walk.uid == NOBODY]
    whole = [] if rim.walks else [rim.lines[NOBODY]]
    yield _edges(np.concatenate([shapes.NO_LINES, *dashed, *whole]), look.ungrouped, look.width, look)


def _normals(rim: Rim, look: Look) -> Iterator[Layer]:
    length = arrow_length(rim, look)
    for walk, group, (points, normals, tangents) in _along(rim, look):
        colour = look.colour(walk.uid)
        if group is not None and group.kind == "mirror":
            flat = np.cross(_plane(group), tangents)
            yield lines(shapes.ticks(points, flat, 0.8 * length), colour, _TICK)
        else:
            yield from arrows(points, length * normals, colour, _SHAFT)
    yield from arrows(rim.corners, length * rim.corner_normals, _CORNER, _SHAFT)


def _tangents(rim: Rim, look: Look) -> Iterator[Layer]:
    length, spacing = arrow_length(rim, look), _spacing(rim, look)
    for walk, group, (points, normals, tangents) in _along(rim, look):
        if group is not None and group.kind == "mirror":
            continue
        fills, edges = shapes.plates(points, normals, tangents, min(0.8 * spacing, 2.0 * length), length)
        yield triangles(fills, look.colour(walk.uid), _PLATE, hides=True)
        yield lines(edges, look.colour(walk.uid), _OUTLINE, 0.8, hides=True)


def _along(rim: Rim, look: Look) -> Iterator[tuple[Walk, GroupState | None, tuple[Array, Array, Array]]]:
    """The walks with their groups, and the points, normals and tangents along them, as many as the look asks for."""
    spacing = _spacing(rim, look)
    for walk in rim.walks:
        yield walk, rim.group(walk.uid), shapes.spread(walk, spacing)


def _spacing(rim: Rim, look: Look) -> float:
    return rim.length / look.count


def _walls(rim: Rim, look: Look, left_out: frozenset[int]) -> Iterator[Layer]:
    """Planes of groups whose edges on the plan lie in them; used until a shell was solved."""
    for walk in rim.walks:
        group = rim.group(walk.uid)
        if group is None or group.kind not in PLANAR or walk.uid in left_out:
            continue
        normal = _plane(group)
        if normal.any() and np.ptp(walk.points @ normal) <= _FLAT * rim.size:
            corners = shapes.wall(walk.points, normal, rim.up, _WALL * rim.size)
            yield from wall_layers(corners, normal, arrow_length(rim, look), look.colour(walk.uid))


def _plane(group: GroupState) -> Array:
    """Unit normal (3,) of a group's plane; zero if it has none."""
    normal = np.array(dict(group.parameters).get("normal", (0.0, 0.0, 1.0)), dtype=np.float64)
    length = np.linalg.norm(normal)
    return normal / length if length > 0.0 else np.zeros(3)


def wall_layers(corners: Array, normal: Array, length: float, colour: Colour) -> Iterator[Layer]:
    """A plane with its outline, and its normal as an arrow from its centre."""
    yield triangles(shapes.filled(corners[None]), colour, _FILL, hides=True)
    yield lines(shapes.outlined(corners[None]), colour, _OUTLINE, 0.8, hides=True)
    yield from arrows(corners.mean(axis=0)[None], length * normal[None], colour, _OUTLINE)


def arrows(points: Array, vectors: Array, colour: Colour, width: float = _BOLD) -> Iterator[Layer]:
    """Arrows from points (n, 3) along vectors (n, 3)."""
    shafts, heads = shapes.arrows(points, vectors)
    if len(shafts):
        yield lines(shafts, colour, width)
        yield triangles(heads, colour)


def cut_layer(ends: Array, colour: Colour) -> Layer:
    """The cut of an open surface, from the ends (n, 2, 3) of its edges."""
    return lines(ends, colour, _BOLD)
