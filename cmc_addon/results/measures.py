"""The measures of results and their attributes. Arrays only: safe in a thread.

==========================  =========================================================================================
`cmc_mean_curvature`        H, in 1/length; positive, whichever way the shell stands; on lines negative where it hangs
`cmc_gauss_curvature`       K, in 1/length²
`cmc_distortion`            quasi-conformal distortion Q >= 1 of the map from the plan; 1 where shapes are kept
`cmc_deviation`             a length: of a nearest surface the distance from the original, everywhere; of the other
                            shells that of the rim from its target line, and -1 inside
`cmc_direction`             unit vectors along the larger principal curvature, zero where it has no direction; the
                            other direction is square to it. Signs mean nothing. Only where curvature lines are shown
==========================  =========================================================================================

All on vertices. On dual and corner meshes they are interpolated from the triangles of the plan.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...solver.shells.polygon_sheets import PolygonSheet
from ...solver.shells.vertex_measures import DIRECTION, lines_on_polygons, on_polygons, rim_distances, vertex_measures
from ...solver.surface.cmc_surface import CmcSurface
from ...solver.surface.placement import Similarity
from ..properties.attributes import ATTRIBUTES, DEVIATION, USUAL

Array = NDArray[np.float64]
Measured = dict[str, Array]

UNKNOWN = -1.0
"""Deviation where it has no reference."""


def sheet_measures(
    surface: CmcSurface,
    similarity: Similarity,
    points: Array,
    sheet: str,
    names: Sequence[str] = USUAL,
    outline: ArrayLike | Sequence[ArrayLike] | None = None,
) -> Measured:
    """Attribute -> values (n,) or (n, 3) of a placed sheet; deviation only where there is an outline."""
    wanted = [name for name in names if name != DEVIATION]
    measures = vertex_measures(surface, similarity, points, sheet, wanted)
    if DEVIATION in names and outline is not None:
        measures[DEVIATION] = known_or_not(rim_distances(surface, points, outline))
    return {ATTRIBUTES[name]: values for name, values in measures.items()}


def known_or_not(distances: Array) -> Array:
    return np.where(np.isfinite(distances), distances, UNKNOWN)


def polygon_measures(
    measures: Mapping[str, Array], sheet: PolygonSheet, source: ArrayLike, vertex_count: int
) -> Measured:
    """The same on a dual or corner mesh, see `on_polygons`."""
    interpolated: Measured = {}
    for name, values in measures.items():
        if name == ATTRIBUTES[DIRECTION]:
            interpolated[name] = lines_on_polygons(sheet, values, source, vertex_count)
        elif name == ATTRIBUTES[DEVIATION]:
            distances = np.where(values < 0.0, np.nan, values)
            interpolated[name] = known_or_not(on_polygons(sheet, distances, source, vertex_count))
        else:
            interpolated[name] = on_polygons(sheet, values, source, vertex_count)
    return interpolated
