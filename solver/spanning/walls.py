"""Sides that lean over their line: the area of the upright wall under the rim, and volumes over walls and planes.

A rim vertex of a leaning side stays over its line seen from above, and its height is free. With W the area of the wall
under it, counted with the sign of the height,

    E = D - 2H V + Σ cos t · W,   δE = 0:   f_ν = -cos t |f_γ| e_z  within the wall,

so the surface meets the wall at the angle t: N · ν = cos t with the wall's outward normal ν. 90° is a mirror. V is then
the volume under the graph: the cone over the surface and that over the walls, 1/6 (z_i + z_j) (x_i y_j - x_j y_i) an
edge. Along a mirror in the plane n · x = d a cone over the plane counts likewise, -d/6 n · f_i × f_j.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from .rim import OverCurve, Rim, Straight

Array = NDArray[np.float64]
Int = NDArray[np.integer]


class RimVolume(Protocol):
    """A part of the volume that boundary edges `pairs` add, a form of this degree in f."""

    @property
    def degree(self) -> int:
        """3 or 2."""
        ...

    @property
    def pairs(self) -> Int:
        """The edges (k, 2), as the boundary walks them."""
        ...

    def of(self, f: Array) -> float:
        """Its value at f (V, 3)."""
        ...

    def second(self, f: Array, d: Array) -> tuple[Array, Array]:
        """Its second derivative at f applied to d: (k, 3) at the first and at the second end of each edge."""
        ...


@dataclass(frozen=True, eq=False)
class OverWalls:
    """1/6 Σ (z_i + z_j) (x_i y_j - x_j y_i)."""

    pairs: Int
    degree = 3

    def of(self, f: Array) -> float:
        p, q = f[self.pairs[:, 0]], f[self.pairs[:, 1]]
        return float(np.sum((p[:, 2] + q[:, 2]) * (p[:, 0] * q[:, 1] - q[:, 0] * p[:, 1]))) / 6.0

    def second(self, f: Array, d: Array) -> tuple[Array, Array]:
        (px, py, pz), (qx, qy, qz) = f[self.pairs[:, 0]].T, f[self.pairs[:, 1]].T
        (ax, ay, az), (bx, by, bz) = d[self.pairs[:, 0]].T, d[self.pairs[:, 1]].T
        area = ax * qy + px * by - bx * py - qx * ay
        height, raised = pz + qz, az + bz
        first = [raised * qy + height * by, -raised * qx - height * bx, area]
        last = [-raised * py - height * ay, raised * px + height * ax, area]
        return np.column_stack(first) / 6.0, np.column_stack(last) / 6.0


@dataclass(frozen=True, eq=False)
class OverPlanes:
    """Σ normal · f_i × f_j, with the normals (k, 3) of the edges' planes times -d/6."""

    pairs: Int
    normals: Array
    degree = 2

    def of(self, f: Array) -> float:
        return float(np.sum(self.normals * np.cross(f[self.pairs[:, 0]], f[self.pairs[:, 1]])))

    def second(self, f: Array, d: Array) -> tuple[Array, Array]:
        return np.cross(d[self.pairs[:, 1]], self.normals), np.cross(self.normals, d[self.pairs[:, 0]])


@dataclass(frozen=True, eq=False)
class Walls:
    """Σ weight · (A x + a) (B x + b) over wall edges: a step along the line times a mean height, in the numbers x (n,)
    of the rim. A, B: (k, n) sparse; a, b, weights: (k,), the weights cos t."""

    A: sp.csr_array
    a: Array
    B: sp.csr_array
    b: Array
    weights: Array

    @classmethod
    def under(cls, rim: Rim) -> Walls:
        """The walls under the tracks of a rim that lie over a curve."""
        heights, lifted = _height_map(rim)
        steps, starts, ends, weights = [], [], [], []
        offset = 0
        for track in rim.tracks:
            if isinstance(track, OverCurve):
                step, start, pair = _steps(track, offset, len(rim.start))
                steps.append(step)
                starts.append(start)
                ends.append(pair)
                weights.append(np.full(len(start), np.cos(track.angle)))
            offset += track.start.size
        if not weights:
            none = sp.csr_array((0, len(rim.start)))
            return cls(none, np.zeros(0), none, np.zeros(0), np.zeros(0))
        pairs = np.concatenate(ends)
        means = sp.csr_array(0.5 * (heights[pairs[:, 0]] + heights[pairs[:, 1]]))
        rest = 0.5 * lifted[pairs].sum(axis=1)
        return cls(sp.csr_array(sp.vstack(steps)), np.concatenate(starts), means, rest, np.concatenate(weights))

    def value(self, x: Array) -> float:
        """Σ cos t · W."""
        return float(np.sum(self.weights * (self.A @ x + self.a) * (self.B @ x + self.b)))

    def gradient(self, x: Array) -> Array:
        """(n,)."""
        step, height = self.A @ x + self.a, self.B @ x + self.b
        return self.A.T @ (self.weights * height) + self.B.T @ (self.weights * step)

    @cached_property
    def second(self) -> sp.csr_array:
        """(n, n), the same everywhere."""
        half = self.A.T @ sp.diags_array(self.weights) @ self.B
        return sp.csr_array(half + half.T)


def _height_map(rim: Rim) -> tuple[sp.csr_array, Array]:
    """z of the rim's vertices as a matrix (B, n) times the numbers, and a rest (B,)."""
    slopes, rest, offset = [], np.zeros(rim.count), 0
    for track in rim.tracks:
        if isinstance(track, OverCurve):
            slopes.append(np.tile([0.0, 1.0], len(track.vertices)))
        elif isinstance(track, Straight):
            slopes.append(track.axes[:, :, 2].ravel())
            rest[track.vertices] = track.places[:, 2]
        else:
            slopes.append(np.zeros(track.start.size))
        offset += track.start.size
    columns = np.arange(offset)
    matrix = sp.coo_array((np.concatenate(slopes), (rim.owner, columns)), shape=(rim.count, offset))
    return sp.csr_array(matrix), rest


def _steps(track: OverCurve, offset: int, count: int) -> tuple[sp.csr_array, Array, Int]:
    """Steps along the line between neighbours: a matrix (k, count) of the numbers, a rest (k,), and the pairs (k, 2) of
    rim vertices. offset: of the track's first number."""
    inner = len(track.vertices)
    columns = offset + 2 * np.arange(inner)
    known = sp.coo_array((np.ones(inner), (np.arange(inner), columns)), shape=(inner, count)).tocsr()
    if track.ends is None:
        ahead = np.roll(np.arange(inner), -1)
        rest = np.zeros(inner)
        rest[-1] = track.curve.length
        return known[ahead] - known, rest, np.column_stack([track.vertices, track.vertices[ahead]])
    empty = sp.csr_array((1, count))
    s = sp.vstack([empty, known, empty]).tocsr()
    rest = np.zeros(inner + 1)
    rest[-1] = track.curve.length
    way = np.concatenate([track.ends[0][-1:], track.vertices, track.ends[1][:1]])
    return s[1:] - s[:-1], rest, np.column_stack([way[:-1], way[1:]])
