"""Which motions of a plan change its conformal type: those of its marked boundary points, and of its holes.

A point of the rim is marked if the surface holds it: at a sharp corner, or where a curve meets a plane. A disc with n
marked points has n - 3 moduli. Corners of the plan keep their angles, since these are the angles of the conformal map:
chords from corner to corner shift in parallel, and the side over a chord with ends a, b goes along by

    z ↦ d_a + β (z - a),   β = <d_b - d_a, b - a> / |b - a|².

A marked point between corners slides along the outline. A hole shifts along x and y and grows, and its marked points
slide along it: three moduli and one a point. Inside, displacements are harmonic; where a hole grows by d they are
u (x - c) d with its centre c and u harmonic, 1 on it, 0 on the other loops: on a ring this is r ln r, which stretches
all faces alike.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ..gauss.dirichlet import Dirichlet
from .curves import corners
from .gauge import angle_fields

Array = NDArray[np.float64]
Int = NDArray[np.integer]

# Singular values of the conditions on shifts below this part of the largest are zero.
_RANK = 1e-9
# The chord over two edges, as a part of one of them, below which an outline runs back on itself.
_FOLDED = 1e-9


def plan_fields(
    dirichlet: Dirichlet, positions: Array, loops: Sequence[Int], phi: Array, marks: Sequence[Int], moving_holes: bool
) -> Array:
    """(m, V, 2) fields. positions (V, 2); loops: vertices of each loop, the outer one first; phi: angles of its
    vertices seen from inside (`douglas`); marks: places of marked points along each loop."""
    size = float(np.linalg.norm(np.ptp(positions[loops[0]], axis=0)))
    moved = [(loops[0], each) for each in _outline_fields(positions[loops[0]], phi, marks[0], size)]
    grown = []
    if moving_holes:
        for loop, marked in zip(loops[1:], marks[1:], strict=True):
            moved += [(loop, each) for each in _hole_fields(positions[loop], marked, size)]
        grown = _growth(dirichlet, positions, loops[1:]) if len(loops) > 1 else []
    return np.concatenate([_harmonic(dirichlet, positions, moved), np.reshape(grown, (-1, *positions.shape))])


def _harmonic(dirichlet: Dirichlet, positions: Array, moved: Sequence[tuple[Int, Array]]) -> Array:
    """(m, V, 2) the harmonic extensions of displacements (k, 2) of a loop (k,), zero on the others."""
    if not moved:
        return np.zeros((0, *positions.shape))
    rim = np.zeros((len(dirichlet.fixed), len(moved), 2))
    for k, (loop, displacement) in enumerate(moved):
        rim[np.searchsorted(dirichlet.fixed, loop), k] = displacement
    full = dirichlet.extend(rim.reshape(len(rim), -1))
    return np.ascontiguousarray(full.reshape(len(positions), -1, 2).transpose(1, 0, 2))


def _growth(dirichlet: Dirichlet, positions: Array, holes: Sequence[Int]) -> list[Array]:
    """u (x - c) (V, 2) for each hole."""
    shares = dirichlet.extend(np.stack([np.isin(dirichlet.fixed, loop) for loop in holes], axis=1).astype(np.float64))
    centres = [positions[loop].mean(axis=0) for loop in holes]
    return [u[:, None] * (positions - c) for u, c in zip(shares.T, centres, strict=True)]


def _outline_fields(points: Array, phi: Array, marks: Int, size: float) -> list[Array]:
    """(k, 2) displacements of an outline with k points.

    With fewer than three corners, marks also slide along Möbius fields that keep the corners; slides are then those
    orthogonal to them.
    """
    bent = np.intersect1d(marks, corners(np.column_stack([points, np.zeros(len(points))])))
    between = np.setdiff1d(marks, bent)
    slides = [_slid(points, marks, mark, size) for mark in between]
    moebius = angle_fields(phi, bent)[between]  # (f, 3 - c)
    lengths = np.linalg.norm(np.roll(points, -1, axis=0) - np.roll(points, 1, axis=0), axis=1)
    speed = lengths / (np.roll(phi, -1) - np.roll(phi, 1) + 2.0 * np.pi * _comes_round(len(phi)))
    mixed = _complement(moebius) * speed[between][:, None]
    mixed = mixed / np.maximum(np.abs(mixed).max(axis=0, initial=0.0), 1e-300)
    fields = [sum((a * each for a, each in zip(row, slides, strict=True)), 0.0 * points) for row in mixed.T]
    return fields + (_shifted_chords(points, bent, size) if len(bent) > 3 else [])


def _comes_round(count: int) -> Int:
    """(count,) 1 at the first and the last place of a loop, where the angle jumps by 2π, else 0."""
    return np.isin(np.arange(count), [0, count - 1]).astype(np.int64)


def _complement(columns: Array) -> Array:
    """(f, f - k) an orthonormal basis of the vectors orthogonal to the columns (f, k); none if k is f or more."""
    count, taken = columns.shape
    if taken >= count:
        return np.zeros((count, 0))
    return np.linalg.svd(columns, full_matrices=True)[0][:, taken:] if taken else np.eye(count)


def _hole_fields(points: Array, marks: Int, size: float) -> list[Array]:
    """(k, 2) displacements of a hole with k points: shifts and slides."""
    shifts = [size * np.ones((len(points), 1)) * axis for axis in np.eye(2)]
    return [*shifts, *(_slid(points, marks, mark, size) for mark in marks)]


def _slid(points: Array, marks: Int, mark: int, size: float) -> Array:
    """A displacement along the outline, `size` at a marked point and falling linearly to zero at its neighbours."""
    count = len(points)
    ahead = np.roll(points, -1, axis=0) - points
    tangents = np.roll(points, -1, axis=0) - np.roll(points, 1, axis=0)
    folded = np.linalg.norm(tangents, axis=1) < _FOLDED * np.linalg.norm(ahead, axis=1)
    tangents[folded] = ahead[folded]
    tangents /= np.linalg.norm(tangents, axis=1, keepdims=True)
    lengths = np.linalg.norm(ahead, axis=1)
    others = np.setdiff1d(marks, [mark])
    height = np.zeros(count)
    height[mark] = 1.0
    for way in (1, -1):
        stop = int(min(((way * (other - mark)) % count for other in others), default=count // 2))
        run = (mark + way * np.arange(stop + 1)) % count
        steps = lengths[run[:-1]] if way > 0 else lengths[run[1:]]
        travelled = np.concatenate([[0.0], np.cumsum(steps)])
        height[run[1:]] = 1.0 - travelled[1:] / travelled[-1]
    return size * height[:, None] * tangents


def _shifted_chords(points: Array, bent: Int, size: float) -> list[Array]:
    """Displacements that keep the direction of every chord; without shifts and growth of the whole."""
    corner = points[bent]
    count = len(bent)
    chord = np.roll(corner, -1, axis=0) - corner
    across = np.column_stack([-chord[:, 1], chord[:, 0]]) / np.linalg.norm(chord, axis=1, keepdims=True)
    kept = np.zeros((count + 3, count, 2))
    every = np.arange(count)
    kept[every, every], kept[every, (every + 1) % count] = -across, across
    kept[count, :, 0], kept[count + 1, :, 1] = 1.0, 1.0
    kept[count + 2] = (corner - corner.mean(axis=0)) / size
    _, values, right = np.linalg.svd(kept.reshape(count + 3, 2 * count))
    free = right[int(np.sum(values > _RANK * values[0])) :].reshape(-1, count, 2)
    return [_along_sides(points, bent, each * size / np.abs(each).max()) for each in free]


def _along_sides(points: Array, bent: Int, moved: Array) -> Array:
    """Displacements (k, 2) of the outline from those of its corners."""
    field = np.zeros_like(points)
    for k in range(len(bent)):
        here, there = bent[k], bent[(k + 1) % len(bent)]
        run = (here + np.arange((there - here) % len(points))) % len(points)
        chord = points[there] - points[here]
        growth = (moved[(k + 1) % len(bent)] - moved[k]) @ chord / (chord @ chord)
        field[run] = moved[k] + growth * (points[run] - points[here])
    return field
