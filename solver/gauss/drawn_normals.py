"""Second-order normals of a drawn surface along its boundary.

The mean of the face normals around a boundary vertex is one-sided and only first order. Here a quadratic height
function over the mean normal n, h(x, y) = ax + by + cx² + dxy + ey², is fitted to the neighbours within two edges by
weighted least squares; the normal is that of its tangent plane, (-a, -b, 1). On a smooth surface its error is O(h²).
"""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from ..domain.domain import Domain
from ..linalg import sum_rows
from .frames import area_vectors, unit_rows
from .sphere import normalize, tangent_axes

Array = NDArray[np.float64]
Int = NDArray[np.integer]

# Fits whose normal equations are worse conditioned than this say nothing about the curvature: neighbours on a conic.
_CONDITION = 1e10
# A tangent plane that turns further than this (tangent of the angle) from the mean normal is a fold, not a fit.
_STEEPEST = 1.0
# Ways of two edges from a vertex above which no quadratic is fitted there: it is on a fan around one crowded vertex,
# whose other ends are far away, and all pairs of them would fill the memory.
_CROWDED = 1000


def drawn_normals(domain: Domain, points: Array, vertices: Int | None = None) -> Array:
    """Unit normals (n, 3) at `vertices` (n,), by default all, of the surface `points` (V, 3).

    Where the two-ring does not determine a quadratic (too few neighbours, or neighbours on a conic), where it is
    crowded (a fan), and where the mesh is folded, the normal is the mean of the face normals, weighted by their angles
    at the vertex. Raises `ConditionError` on faces without area and on vertices around which the face normals cancel.
    """
    vertices = np.arange(domain.vertex_count) if vertices is None else vertices
    means = _mean_normals(domain, points, vertices)
    owners, neighbours = _two_rings(domain, vertices)
    axes = tangent_axes(means)
    away = points[neighbours] - points[vertices[owners]]
    x, y = np.einsum("kij,kj->ik", axes[owners], away)
    z = np.einsum("ij,ij->i", means[owners], away)
    count = np.bincount(owners, minlength=len(vertices))
    squared = x * x + y * y
    size = np.sqrt(np.bincount(owners, squared, len(vertices)) / np.maximum(count, 1))
    size = np.where(size > 0.0, size, 1.0)[owners]
    x, y, z = x / size, y / size, z / size
    terms = np.column_stack([x, y, x * x, x * y, y * y])
    weights = 1.0 / np.maximum(x * x + y * y, 1e-6)
    products = (terms[:, :, None] * terms[:, None, :] * weights[:, None, None]).reshape(-1, 25)
    matrices = sum_rows(owners, products, len(vertices)).reshape(-1, 5, 5)
    loads = sum_rows(owners, terms * (weights * z)[:, None], len(vertices))
    good = (count >= 5) & (np.linalg.cond(matrices) < _CONDITION)
    slopes = np.zeros((len(vertices), 2))
    slopes[good] = np.linalg.solve(matrices[good], loads[good][:, :, None])[:, :2, 0]
    slopes[np.linalg.norm(slopes, axis=1) > _STEEPEST] = 0.0
    normals = means - np.einsum("ki,kij->kj", slopes, axes)
    return normalize(normals)


def _mean_normals(domain: Domain, points: Array, vertices: Int) -> Array:
    faces = domain.faces
    of_faces = unit_rows(area_vectors(points, faces), "face", "has no area in these positions")
    weighted = of_faces[:, None, :] * domain.corner_angles[:, :, None]
    sums = sum_rows(faces.ravel(), weighted.reshape(-1, 3), domain.vertex_count)[vertices]
    return unit_rows(sums, "vertex", "has faces whose normals cancel", vertices)


def _two_rings(domain: Domain, vertices: Int) -> tuple[Int, Int]:
    """Pairs (place in `vertices`, vertex within two edges of it), without the vertex itself; none for
    crowded vertices."""
    n = domain.vertex_count
    ends = np.concatenate([domain.edges, domain.edges[:, ::-1]])
    joined = sp.csr_array((np.ones(len(ends)), (ends[:, 0], ends[:, 1])), shape=(n, n))
    ways = joined @ np.diff(joined.indptr)
    places = np.flatnonzero(ways[vertices] <= _CROWDED)
    first = sp.csr_array(joined[vertices[places]])
    pairs = (first + first @ joined).tocoo()
    rows, neighbours = pairs.coords
    owners = places[rows]
    other = neighbours != vertices[owners]
    return owners[other].astype(np.int64), neighbours[other].astype(np.int64)
