"""What is measured at the rows of a placed sheet, for colours and strokes on it: one number or one line a row."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..measure.arrays import vertex_means
from ..measure.curvature import vertex_gauss_curvature, vertex_mean_curvature
from ..measure.directions import vertex_principal_curvatures
from ..measure.distortion import conformal_distortion
from ..measure.extent import boundary_sides
from ..measure.outline import distance_to_segments, outline_segments
from ..surface.cmc_surface import CmcSurface
from ..surface.placement import Similarity

if TYPE_CHECKING:
    from ..domain.domain import Domain
    from .polygon_sheets import PolygonSheet

Array = NDArray[np.float64]

MEASURES = ("mean_curvature", "gauss_curvature", "distortion")
"""Numbers at every row: H in 1/length, K in 1/length², Q >= 1 without unit."""
DIRECTION = "direction"
"""The line of the largest principal curvature at every row: unit vectors, zero at umbilics."""


def row_measures(
    surface: CmcSurface, similarity: Similarity, points: ArrayLike, sheet: str, names: Sequence[str] = MEASURES
) -> dict[str, Array]:
    """What is asked for of a placed sheet, "f+" or "f-": name -> (n,), or (n, 3) for "direction".

    points (n, 3): where the rows of the sheet are, an image of it under the similarity. Values are means over the faces
    around a row, weighted by area; signs are those for which H is positive. A row without a proper face has the target
    H, K = H² and Q = 1.
    """
    placed, faces = np.asarray(points, dtype=np.float64), surface.faces
    N = similarity.directions(surface.normals) * (1.0 if sheet == "f+" else -1.0)
    H = surface.mean_curvature / similarity.scale
    ways = {
        "mean_curvature": lambda: _filled(vertex_mean_curvature(placed, faces, N), H),
        "gauss_curvature": lambda: _filled(vertex_gauss_curvature(placed, faces, N), H * H),
        "distortion": lambda: row_distortion(surface.domain, placed, faces),
        DIRECTION: lambda: vertex_principal_curvatures(placed, faces, N).direction1,
    }
    return {name: ways[name]() for name in names}


def row_distortion(domain: Domain, points: Array, faces: ArrayLike) -> Array:
    """Conformal distortion Q (n,) at the rows of a surface over a domain: means over the faces around; 1 where none."""
    return _filled(vertex_means(conformal_distortion(domain, points, faces), points, faces), 1.0)


def _filled(values: Array, instead: float) -> Array:
    return np.where(np.isfinite(values), values, instead)


def rim_distances(surface: CmcSurface, points: ArrayLike, outline: ArrayLike | Sequence[ArrayLike]) -> Array:
    """Distance (n,) of each row of the rim of a placed sheet from a drawn outline (`outline_segments`), in its unit.

    nan inside, along cuts, and everywhere on a surface without a boundary.
    """
    found = np.full(len(np.asarray(points)), np.nan)
    rows = np.unique(boundary_sides(surface.domain, surface.faces))
    if len(rows):
        segments = outline_segments(surface.domain, outline)
        found[rows] = distance_to_segments(np.asarray(points, dtype=np.float64)[rows], *segments)
    return found


def on_polygons(sheet: PolygonSheet, values: Array, source: ArrayLike, vertex_count: int) -> Array:
    """Values (n,) at the rows of a surface, at the rows of its dual or corner mesh instead, interpolated.

    source (n,): the vertex of each row; rows of the same vertex count equally. nan where a value that counts is nan.
    """
    known = np.isfinite(values)
    rows = np.asarray(source)
    count = np.bincount(rows[known], minlength=vertex_count)
    sums = np.bincount(rows[known], values[known], vertex_count)
    table = np.stack([sums / np.maximum(count, 1), count > 0], axis=1)
    found, share = sheet.from_vertices(table).T
    return np.where(share > 1.0 - 1e-9, found, np.nan)


def lines_on_polygons(sheet: PolygonSheet, lines: Array, source: ArrayLike, vertex_count: int) -> Array:
    """The same for lines (n, 3), which have no sign: the tensors d dᵀ are interpolated. Zero where there is none."""
    tensors = np.einsum("ni,nj->nij", lines, lines).reshape(-1, 9)
    found = np.stack([on_polygons(sheet, column, source, vertex_count) for column in tensors.T], axis=1)
    values, vectors = np.linalg.eigh(np.nan_to_num(found).reshape(-1, 3, 3))
    # where lines cross, the largest part is hardly larger than the next
    reported = values[:, 2] > 2.0 * values[:, 1].clip(min=0.0) + 1e-9
    return np.where(reported[:, None], vectors[:, :, 2], 0.0)
