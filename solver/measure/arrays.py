"""Checked points, triangles and edge vectors of a mesh in space: the input of every measure."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import MeshError, plural
from ..linalg import as_array, as_numbers

Array = NDArray[np.float64]
Indices = NDArray[np.integer]

# A triangle whose height is less than this fraction of its longest side has no direction to measure in.
_FLATTEST = 1e-12


def range_text(values: Array) -> str:
    """The least and the largest finite value, as a repr shows them: "0.61 to 0.87"."""
    finite = values[np.isfinite(values)]
    return f"{finite.min():.4g} to {finite.max():.4g}" if finite.size else "nan"


def points_in_space(points: ArrayLike, what: str = "vertices") -> Array:
    """Return points as (n, 3) float64; plane points (n, 2) get z = 0. Raises `MeshError` on another shape."""
    array = as_numbers(points, what.capitalize(), MeshError)
    if array.ndim != 2 or array.shape[1] not in (2, 3):
        raise MeshError(f"{what} have shape {array.shape}; give one row of two or three coordinates a point.")
    if array.shape[1] == 2:
        array = np.column_stack([array, np.zeros(len(array))])
    return array


def triangles_of(faces: ArrayLike, count: int) -> Indices:
    """Return faces as (F, 3) integers in [0, count). Raises `MeshError` naming the faces that are not."""
    array = as_array(faces, "Faces", MeshError)
    if array.size == 0:
        return np.zeros((0, 3), dtype=np.int32)
    if array.ndim != 2 or array.shape[1] != 3 or not np.issubdtype(array.dtype, np.integer):
        raise MeshError(f"faces have shape {array.shape} and type {array.dtype}; give three indices a face.")
    if array.min() < 0 or array.max() >= count:
        wrong = np.flatnonzero(((array < 0) | (array >= count)).any(axis=1))
        raise MeshError(
            f"{plural('face', wrong)} refer to missing vertices; indices run from 0 to {count - 1}.",
            faces=wrong,
        )
    return array


def edge_vectors(values: Array, faces: Indices) -> tuple[Array, Array]:
    """Differences of values (n, 3) along two edges of each face: v1 - v0 and v2 - v0, (3, F) each.

    Coordinates come first so that the arithmetic of the measures runs over contiguous memory.
    """
    columns = np.ascontiguousarray(values.T)
    first, second, third = (np.ascontiguousarray(faces[:, k]) for k in range(3))
    origin = columns[:, first]
    return columns[:, second] - origin, columns[:, third] - origin


def dot(a: Array, b: Array) -> Array:
    """Scalar products of coordinate-first vectors: (3, F), (3, F) -> (F,)."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def double_areas(u: Array, v: Array) -> Array:
    """|u × v| of coordinate-first vectors (3, F) -> (F,); exactly nan where the triangle is degenerate.

    Degenerate means lower than 1e-12 of its longest side, all three vertices in one place, or not finite.
    """
    with np.errstate(invalid="ignore", over="ignore"):
        x = u[1] * v[2] - u[2] * v[1]
        y = u[2] * v[0] - u[0] * v[2]
        z = u[0] * v[1] - u[1] * v[0]
        area = np.sqrt(x * x + y * y + z * z)
        w = v - u
        longest = np.maximum(np.maximum(dot(u, u), dot(v, v)), dot(w, w))
        proper = area > _FLATTEST * longest
    return np.where(proper, area, np.nan)


def face_areas_in_space(vertices: ArrayLike, faces: ArrayLike) -> Array:
    """Area of each triangle in space (F,), in squared model lengths; 0 where it is degenerate."""
    points = points_in_space(vertices)
    u, v = edge_vectors(points, triangles_of(faces, len(points)))
    return 0.5 * np.nan_to_num(double_areas(u, v), nan=0.0)


def weighted_mean(values: Array, weights: Array) -> float:
    """Mean of the finite values; nan if none has weight."""
    known = np.isfinite(values) & (weights > 0)
    total = float(weights[known].sum())
    if total <= 0.0:
        return float("nan")
    return float((values[known] * weights[known]).sum() / total)


def weighted_l2(values: Array, weights: Array) -> float:
    """sqrt(∫ values² / ∫ 1), over the finite values; nan if none has weight."""
    mean = weighted_mean(np.square(values), weights)
    return float(np.sqrt(mean))


def vertex_means(values: ArrayLike, vertices: ArrayLike, faces: ArrayLike) -> Array:
    """Mean of the values of the faces around each vertex, weighted by their areas in space.

    values (F,) or (F, …) on the faces (F, 3) of `vertices` (n, 3) -> (n,) or (n, …), in the unit of the values. At the
    boundary it is the mean over the faces there. Faces whose value is not finite, or whose area is zero, do not count;
    a vertex without other faces gives nan. Raises `MeshError` where the shapes do not match or an index does not
    exist.
    """
    points = points_in_space(vertices)
    triangles = triangles_of(faces, len(points))
    given = np.asarray(values, dtype=np.float64)
    if len(given) != len(triangles):
        raise MeshError(f"{len(triangles)} faces, but values of shape {given.shape}; give one a face.")
    columns = given.reshape(len(given), int(np.prod(given.shape[1:])))
    known = np.isfinite(columns).all(axis=1)
    weights = np.where(known, face_areas_in_space(points, triangles), 0.0)
    corners, count = triangles.ravel(), len(points)
    total = np.bincount(corners, np.repeat(weights, 3), minlength=count)
    means = np.full((count, columns.shape[1]), np.nan)
    for k in range(columns.shape[1]):
        products = np.where(known, weights * np.where(known, columns[:, k], 0.0), 0.0)
        sums = np.bincount(corners, np.repeat(products, 3), minlength=count)
        np.divide(sums, total, out=means[:, k], where=total > 0)
    return means.reshape(count, *given.shape[1:])
