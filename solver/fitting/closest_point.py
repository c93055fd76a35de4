"""Closest points on a triangle mesh: exact, from the centres of faces in a k-d tree."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree

Array = NDArray[np.float64]
Int = NDArray[np.integer]

# Candidate faces of each point at first; three times as many while a face further away could be nearer.
_FACES = 16
# Pairs of points and faces compared at once.
_CHUNK = 1_000_000
_TINY = 1e-300


class Closest(NamedTuple):
    """Points (n, 3) of a mesh, each with its distance (n,) and its face (n,)."""

    points: Array
    distances: Array
    faces: Int


@dataclass(frozen=True, eq=False)
class Triangles:
    """A triangle mesh to measure distances from: points (V, 3), faces (F, 3)."""

    points: Array
    faces: Int

    @cached_property
    def _corners(self) -> Array:
        return self.points[self.faces]

    @cached_property
    def _tree(self) -> KDTree:
        return KDTree(self._corners.mean(axis=1))

    @cached_property
    def _radius(self) -> float:
        """The largest distance of a corner from the centre of its face."""
        return float(np.linalg.norm(self._corners - self._corners.mean(axis=1, keepdims=True), axis=2).max())

    def closest(self, queries: Array) -> Closest:
        """The closest point of the surface to each of the queries (n, 3)."""
        count = len(queries)
        closest = Closest(np.zeros((count, 3)), np.full(count, np.inf), np.zeros(count, dtype=np.int64))
        unsure = np.arange(count)
        looked = min(_FACES, len(self.faces))
        while unsure.size:
            parts = np.array_split(unsure, unsure.size * looked // _CHUNK + 1)
            unsure = np.concatenate([part[~self._look(queries[part], part, looked, closest)] for part in parts])
            looked = min(3 * looked, len(self.faces))
        return closest

    def _look(self, queries: Array, rows: Int, looked: int, closest: Closest) -> NDArray[np.bool_]:
        """Compare the faces with the nearest centres; True (n,) where no other face can be nearer."""
        reach, faces = self._tree.query(queries, k=looked)
        reach = np.asarray(reach).reshape(len(rows), -1)
        faces = np.asarray(faces, dtype=np.int64).reshape(len(rows), -1)
        squares, v, w = self._compare(queries, faces)
        best = np.argmin(squares, axis=1)[:, None]
        face = np.take_along_axis(faces, best, axis=1)[:, 0]
        v, w = np.take_along_axis(v, best, axis=1), np.take_along_axis(w, best, axis=1)
        a, b, c = self._corners[face].transpose(1, 0, 2)
        points = a + v * (b - a) + w * (c - a)
        distances = np.linalg.norm(points - queries, axis=1)
        closest.points[rows], closest.distances[rows], closest.faces[rows] = points, distances, face
        return (reach[:, -1] - self._radius >= distances) | (looked == len(self.faces))

    def _compare(self, queries: Array, faces: Int) -> tuple[Array, Array, Array]:
        """Squared distances (n, k) of the queries (n, 3) from faces (n, k), at a + v (b - a) + w (c - a)."""
        a, b, c = (self._corners[:, k].T for k in range(3))
        sides = b - a, c - a
        away = np.stack([queries[:, i, None] - a[i][faces] for i in range(3)])
        first, second = (np.einsum("ink,ink->nk", away, side[:, faces]) for side in sides)
        pairs = ((sides[0], sides[0]), (sides[0], sides[1]), (sides[1], sides[1]))
        uu, uw, ww = (np.einsum("if,if->f", u, v)[faces] for u, v in pairs)
        square = _Square(uu, uw, ww, first, second)
        v, w = square.least()
        return np.einsum("ink,ink->nk", away, away) + square(v, w), v, w


class _Square(NamedTuple):
    """uu v² + 2 uw v w + ww w² - 2 (first v + second w), with uu ww >= uw²."""

    uu: Array
    uw: Array
    ww: Array
    first: Array
    second: Array

    def __call__(self, v: Array, w: Array) -> Array:
        return v * (self.uu * v + 2.0 * (self.uw * w - self.first)) + w * (self.ww * w - 2.0 * self.second)

    def least(self) -> tuple[Array, Array]:
        """The minimum over v, w >= 0, v + w <= 1: inside, or on one of the sides."""
        uu, uw, ww, first, second = self
        whole = np.maximum(uu * ww - uw * uw, _TINY)
        v, w = (ww * first - uw * second) / whole, (uu * second - uw * first) / whole
        best = np.where((v < 0.0) | (w < 0.0) | (v + w > 1.0), np.inf, -np.inf)
        bottom = np.clip(first / np.maximum(uu, _TINY), 0.0, 1.0)
        left = np.clip(second / np.maximum(ww, _TINY), 0.0, 1.0)
        across = np.clip((first - second + ww - uw) / np.maximum(uu - 2.0 * uw + ww, _TINY), 0.0, 1.0)
        zero = np.zeros_like(v)
        for s, t in ((bottom, zero), (zero, left), (across, 1.0 - across)):
            value = self(s, t)
            v, w = np.where(value < best, s, v), np.where(value < best, t, w)
            best = np.minimum(value, best)
        return v, w
