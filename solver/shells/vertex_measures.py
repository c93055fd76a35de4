"""Measures at the vertices of a placed sheet, one number or one line each, for colours and curvature lines on it.

A surface that is cut open has several vertices for one of the plan along its cuts: n of them, `source` (n,).
"""

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
"""Numbers at every vertex: H in 1/length, K in 1/length², Q >= 1 without unit."""
DIRECTION = "direction"
"""The line of the largest principal curvature at every vertex: unit vectors, zero at umbilics."""


def vertex_measures(
    surface: CmcSurface, similarity: Similarity, points: ArrayLike, sheet: str, names: Sequence[str] = MEASURES
) -> dict[str, Array]:
    """The named measures of a placed sheet, "f+" or "f-": name -> (n,), or (n, 3) for "direction".

    points (n, 3): of the sheet, an image of it under the similarity. Values are means over the faces around a vertex,
    weighted by area; the sign makes H positive. A vertex without a proper face gets the target H, K = H² and Q = 1.
    """
    placed, faces = np.asarray(points, dtype=np.float64), surface.faces
    N = similarity.directions(surface.normals) * (1.0 if sheet == "f+" else -1.0)
    H = surface.mean_curvature / similarity.scale
    ways = {
        "mean_curvature": lambda: _filled(vertex_mean_curvature(placed, faces, N), H),
        "gauss_curvature": lambda: _filled(vertex_gauss_curvature(placed, faces, N), H * H),
        "distortion": lambda: vertex_distortion(surface.domain, placed, faces),
        DIRECTION: lambda: vertex_principal_curvatures(placed, faces, N).direction1,
    }
    return {name: ways[name]() for name in names}


def vertex_distortion(domain: Domain, points: Array, faces: ArrayLike) -> Array:
    """Conformal distortion Q (n,) at the vertices of a surface over a domain: face means; 1 without a proper face."""
    return _filled(vertex_means(conformal_distortion(domain, points, faces), points, faces), 1.0)


def _filled(values: Array, instead: float) -> Array:
    return np.where(np.isfinite(values), values, instead)


def rim_distances(surface: CmcSurface, points: ArrayLike, outline: ArrayLike | Sequence[ArrayLike]) -> Array:
    """Distance (n,) of the rim of a placed sheet from a drawn outline (`outline_segments`), in model length.

    nan inside, along cuts, and everywhere on a surface without a boundary.
    """
    distances = np.full(len(np.asarray(points)), np.nan)
    rim = np.unique(boundary_sides(surface.domain, surface.faces))
    if len(rim):
        segments = outline_segments(surface.domain, outline)
        distances[rim] = distance_to_segments(np.asarray(points, dtype=np.float64)[rim], *segments)
    return distances


def on_polygons(sheet: PolygonSheet, values: Array, source: ArrayLike, vertex_count: int) -> Array:
    """Values (n,) at the vertices of a surface, interpolated to those of its dual or corner mesh.

    source (n,): the plan's vertex behind each; the copies of one vertex count equally. nan next to a nan.
    """
    known = np.isfinite(values)
    vertices = np.asarray(source)[known]
    count = np.bincount(vertices, minlength=vertex_count)
    sums = np.bincount(vertices, values[known], vertex_count)
    table = np.stack([sums / np.maximum(count, 1), count > 0], axis=1)
    means, share = sheet.from_vertices(table).T
    return np.where(share > 1.0 - 1e-9, means, np.nan)


def lines_on_polygons(sheet: PolygonSheet, lines: Array, source: ArrayLike, vertex_count: int) -> Array:
    """The same for lines (n, 3), which have no sign: the tensors d dᵀ are interpolated. Zero where no line wins."""
    tensors = np.einsum("ni,nj->nij", lines, lines).reshape(-1, 9)
    means = np.stack([on_polygons(sheet, column, source, vertex_count) for column in tensors.T], axis=1)
    values, vectors = np.linalg.eigh(np.nan_to_num(means).reshape(-1, 3, 3))
    # where lines cross, the largest eigenvalue is hardly larger than the next
    wins = values[:, 2] > 2.0 * values[:, 1].clip(min=0.0) + 1e-9
    return np.where(wins[:, None], vectors[:, :, 2], 0.0)
