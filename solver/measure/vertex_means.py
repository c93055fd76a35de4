"""From faces to vertices: the mean of what is known on the faces around each, weighted by their areas."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from ..errors import MeshError
from .arrays import Array, face_areas_in_space, points_in_space, triangles_of


def vertex_means(values: ArrayLike, vertices: ArrayLike, faces: ArrayLike) -> Array:
    """Mean of the values of the faces around each vertex, weighted by their areas in space.

    values (F,) or (F, …) on the faces (F, 3) of `vertices` (n, 3) -> (n,) or (n, …), in the unit of the values. At the
    boundary it is the mean over the faces that are there. Faces whose value is not finite, or whose area is zero, do
    not count; a vertex that has no others gives nan. Raises `MeshError` where the shapes do not match or an index does
    not exist.
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
