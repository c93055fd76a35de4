"""Frames of the rim against the horizon: a lean of 0° is a vertical rim and 90° a level one, whatever was drawn.

The frame (t; t × n, n) of a drawn rim turns about the tangent t until the conormal is level,

    t × u / |t × u|    and    u - <u, t> t,  normalised,    with u upwards.

On a level plan this changes nothing. Where the rim climbs there is one such frame still, but along a vertical t the
horizon says nothing, since every N ⟂ t is level there: the drawn frame stays. Within `_STEEP` of the vertical a frame
turns smoothly from one to the other.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ..linalg import sum_rows
from .frames import EdgeFrames, Frames

Array = NDArray[np.float64]

# Sine of the angle between the rim and the vertical from which on only the horizon counts (15°).
_STEEP = np.sin(np.radians(15.0))
# At a corner whose level conormals cancel to this part of their weights, both edges keep their drawn frames.
_CANCELLED = 0.1
# Part of a plan's area below which it looks neither up nor down.
_STANDS = 1e-9


def upwards(area: Array) -> Array:
    """(3,) z; or -z if a plan with this area vector (3,) looks down, as one with its faces turned over does."""
    return np.array([0.0, 0.0, -1.0 if area[2] < -_STANDS * np.linalg.norm(area) else 1.0])


def against_horizon(along: EdgeFrames, up: Array) -> EdgeFrames:
    """The frames of edges turned about them until their conormals are level; up: (3,), a unit vector."""
    tangents = np.cross(along.normals, along.conormals)
    level = np.cross(tangents, up)
    steepness = np.linalg.norm(level, axis=1, keepdims=True)
    is_vertical = steepness < 1e-12
    conormals = np.where(is_vertical, along.conormals, level / np.where(is_vertical, 1.0, steepness))
    normals = np.cross(conormals, tangents)
    # the angle about t from this frame back to the drawn one
    back = np.arctan2(_dot(along.normals, conormals), _dot(along.normals, normals)) * _drawn_share(steepness)
    cos, sin = np.cos(back), np.sin(back)
    return replace(along, conormals=cos * conormals - sin * normals, normals=cos * normals + sin * conormals)


def level_at_vertices(drawn: Frames, level: EdgeFrames) -> Frames:
    """The frames of edges against the horizon, blended at the vertices as the `drawn` ones are."""
    ends, weights = drawn.ends.ravel(), np.repeat(drawn.weights, 2)
    count = len(drawn.vertices)
    conormals, normals = (
        sum_rows(ends, weights[:, None] * np.repeat(rows, 2, axis=0), count) / sum_rows(ends, weights, count)[:, None]
        for rows in (level.conormals, level.normals)
    )
    conormals, lengths = _directions(conormals)
    normals, heights = _directions(normals - _dot(normals, conormals) * conormals)
    is_sound = (lengths > _CANCELLED) & (heights > _CANCELLED)
    return replace(
        drawn,
        conormals=np.where(is_sound, conormals, drawn.conormals),
        normals=np.where(is_sound, normals, drawn.normals),
    )


def _directions(vectors: Array) -> tuple[Array, Array]:
    """Unit vectors, and the lengths (n, 1) they had; zero vectors stay zero."""
    lengths = np.linalg.norm(vectors, axis=1, keepdims=True)
    return vectors / np.where(lengths > 0.0, lengths, 1.0), lengths


def _drawn_share(steepness: Array) -> Array:
    """1 on a vertical rim, 0 from `_STEEP` on, with derivatives that vanish at both ends."""
    x = np.clip(steepness / _STEEP, 0.0, 1.0)
    return 1.0 - x * x * (3.0 - 2.0 * x)


def _dot(u: Array, v: Array) -> Array:
    return np.einsum("ij,ij->i", u, v)[:, None]
