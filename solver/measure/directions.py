"""Principal curvatures and directions at the vertices: the shape operators of the faces, averaged.

Principal directions are lines and cannot be averaged, and where the two curvatures are equal, K = H², there are none.
The operators themselves can be averaged. In space that of a face is the symmetric tensor Eᵀ S E, with the rows of E the
frame of the face; the eigenpairs of the mean over the faces around a vertex, in the plane orthogonal to its normal, are
the principal curvatures and directions there. The planes of the faces differ from that plane by an angle O(h), which
changes the eigenpairs by O(h²).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ..gauss.sphere import tangent_axes
from .arrays import Array, Indices, face_areas_in_space, points_in_space, range_text, triangles_of, vertex_means
from .curvature import face_frames, shape_operator

# Vertices where k1 - k2 is at most this part of the surface's curvature (root mean square) are umbilics.
UMBILIC = 0.05


class VertexCurvatures(NamedTuple):
    """Principal curvatures (n,), `k1 >= k2`, in 1/length, and unit directions (n, 3) orthogonal to the normals.

    A direction is a line: its sign means nothing. `strength` (n,), from 0 to 1, says how well the directions are
    defined: zero at umbilics, where they are zero vectors; 1 where k1 - k2 is as large as the surface's curvature.
    Vertices without a proper face have nan curvatures, zero directions and strength zero.
    """

    k1: Array
    k2: Array
    direction1: Array
    direction2: Array
    strength: Array

    def __repr__(self) -> str:
        return f"VertexCurvatures({len(self.k1)} vertices, k1 {range_text(self.k1)}, k2 {range_text(self.k2)})"

    @property
    def mean(self) -> Array:
        """Mean curvature H = ½ (k1 + k2), (n,)."""
        return 0.5 * (self.k1 + self.k2)

    @property
    def gauss(self) -> Array:
        """Gauss curvature K = k1 k2, (n,), in 1/length²."""
        return self.k1 * self.k2


def vertex_principal_curvatures(
    vertices: ArrayLike, faces: ArrayLike, normals: ArrayLike, *, umbilic: float = UMBILIC
) -> VertexCurvatures:
    """Principal curvatures and directions at the vertices: the eigenpairs of the mean shape operator around each.

    The mean of the operators of the faces (paper, Sec. 4.3.2; `shape_operator`) is weighted by their areas and taken in
    the plane orthogonal to the normal. `vertices` (n, 3), `faces` (F, 3), unit `normals` (n, 3).

    umbilic: where k1 - k2 is at most this part of the root mean square of sqrt(½ (k1² + k2²)) over the surface, or
    below the scatter of the faces around the vertex, it is an umbilic. Signs follow the normals, not the winding.
    Errors as `mean_curvature_of`; at the boundary the mean is over the faces there.
    """
    points = points_in_space(vertices)
    triangles = triangles_of(faces, len(points))
    frames, shapes = face_frames(points, triangles), shape_operator(points, triangles, normals)
    around = _in_space(frames, shapes)
    means = vertex_means(np.column_stack([around, _squared_difference(around)]), points, triangles)
    x, y = tangent_axes(np.asarray(normals, dtype=np.float64)).swapaxes(0, 1)
    xx, xy, yy = (_applied(means[:, :6], a, b) for a, b in ((x, x), (x, y), (y, y)))
    mean, half = 0.5 * (xx + yy), 0.5 * (xx - yy)
    radius = np.hypot(half, xy)
    scale = _curvature_scale(points, triangles, mean**2 + radius**2)
    with np.errstate(invalid="ignore"):
        defined = 2.0 * radius > np.maximum(umbilic * scale, _doubt(means, triangles))
        strength = np.where(defined, np.minimum(2.0 * radius / (scale or 1.0), 1.0), 0.0)
    angle = 0.5 * np.arctan2(xy, half)
    cos, sin = np.cos(angle)[:, None], np.sin(angle)[:, None]
    first, second = (np.where(defined[:, None], line, 0.0) for line in (cos * x + sin * y, cos * y - sin * x))
    return VertexCurvatures(mean + radius, mean - radius, first, second, strength)


# Components of a symmetric tensor, in this order, and how often each occurs.
_COMPONENTS = ((0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1))
_TIMES = np.array([1.0, 1.0, 1.0, 2.0, 2.0, 2.0])


def _in_space(frames: Array, shapes: Array) -> Array:
    """Components (F, 6) in space of operators (F, 2, 2) in frames (F, 2, 3)."""
    x, y = frames[:, 0], frames[:, 1]
    xx, xy, yy = shapes[:, 0, 0], shapes[:, 0, 1], shapes[:, 1, 1]
    return np.stack(
        [
            xx * x[:, i] * x[:, j] + xy * (x[:, i] * y[:, j] + y[:, i] * x[:, j]) + yy * y[:, i] * y[:, j]
            for i, j in _COMPONENTS
        ],
        axis=1,
    )


def _applied(tensors: Array, a: Array, b: Array) -> Array:
    """aᵀ T b of tensors (n, 6) and vectors (n, 3), symmetrised."""
    pairs = np.stack([0.5 * (a[:, i] * b[:, j] + a[:, j] * b[:, i]) for i, j in _COMPONENTS], axis=1)
    return np.einsum("nk,nk,k->n", tensors, pairs, _TIMES)


def _squared_difference(tensors: Array) -> Array:
    """(k1 - k2)² = 2 |T|² - (tr T)² of tensors (n, 6) with one eigenvalue 0."""
    return 2.0 * np.einsum("nk,nk,k->n", tensors, tensors, _TIMES) - tensors[:, :3].sum(axis=1) ** 2


def _doubt(means: Array, triangles: Indices) -> Array:
    """Twice the standard error (n,) of k1 - k2, from the scatter of the operators around each vertex.

    Mere noise exceeds it once in fifty times.

    means (n, 7): the mean operator, and the mean of `_squared_difference`, which is quadratic.
    """
    count = np.bincount(triangles.ravel(), minlength=len(means))
    variance = means[:, 6] - _squared_difference(means[:, :6])
    return 2.0 * np.sqrt(variance.clip(min=0.0) / np.maximum(count, 1))


def _curvature_scale(points: Array, triangles: Indices, squares: Array) -> float:
    """Root mean square over the surface, from the squares at the vertices."""
    areas = np.bincount(triangles.ravel(), np.repeat(face_areas_in_space(points, triangles), 3), len(points))
    known = np.isfinite(squares) & (areas > 0)
    return float(np.sqrt(np.average(squares[known], weights=areas[known]))) if known.any() else 0.0
