"""Distance of the boundary of a sheet from the drawn outline."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial import KDTree

from ..errors import MeshError
from ..linalg import as_array, as_numbers
from .arrays import Array

if TYPE_CHECKING:
    from ..domain.domain import Domain

# Segments with which a point is compared at first, those whose middles are nearest; four times as many where one
# further away could be nearer.
_LOOKED = 8
# Distances from points to segments in memory at once.
_BLOCK = 1 << 19


def outline_segments(domain: Domain, outline: ArrayLike | Sequence[ArrayLike]) -> tuple[Array, Array]:
    """Starts and ends (k, 2|3) of the segments of a drawn outline.

    `outline` is either an array (V, 2|3), where the domain's vertices were drawn — its boundary loops are the
    outline — or a list of closed polylines (m, 2|3), without a repeated last point. Raises `MeshError`
    otherwise.
    """
    loops = _polylines(domain, outline)
    for loop in loops:
        if loop.ndim != 2 or loop.shape[1] not in (2, 3) or loop.shape[1] != loops[0].shape[1] or len(loop) < 2:
            raise MeshError(
                f"A polyline of the outline has shape {loop.shape}; give at least two points of "
                "two or three coordinates, as many in every polyline."
            )
    starts = np.concatenate(loops)
    ends = np.concatenate([np.roll(loop, -1, axis=0) for loop in loops])
    return starts, ends


def _is_line(given: ArrayLike) -> bool:
    """Whether this is a line, and no point."""
    return as_array(given, "The outline", MeshError).ndim == 2


def _polylines(domain: Domain, outline: ArrayLike | Sequence[ArrayLike]) -> list[Array]:
    if isinstance(outline, (list, tuple)) and outline and _is_line(outline[0]):
        return [as_numbers(loop, "The outline", MeshError) for loop in outline]
    points = as_numbers(outline, "The outline", MeshError)  # pyright: ignore[reportArgumentType]
    if points.ndim != 2 or len(points) != domain.vertex_count:
        raise MeshError(
            f"The outline has shape {points.shape}; give the drawn position of each of the "
            f"{domain.vertex_count} vertices, or a list of closed polylines."
        )
    if not domain.boundary_loops:
        raise MeshError("The domain has no boundary, so there is no outline to measure a distance from.")
    return [points[loop] for loop in domain.boundary_loops]


def distance_to_segments(points: ArrayLike, starts: Array, ends: Array) -> Array:
    """Distance (n,) of each point (n, 2|3) from the segments (k, 2|3): to the curve, not to its points.

    Where the segments have two coordinates, the distance is measured in plan.
    """
    positions = np.asarray(points, dtype=np.float64)[:, : starts.shape[1]]
    starts, ends = _in_pieces(starts, ends)
    tree, reach = KDTree(0.5 * (starts + ends)), 0.5 * float(np.linalg.norm(ends - starts, axis=1).max())
    distances, unsure, looked = np.full(len(positions), np.inf), np.arange(len(positions)), min(_LOOKED, len(starts))
    while unsure.size:
        parts = np.array_split(unsure, unsure.size * looked // _BLOCK + 1)
        sure = []
        for part in parts:
            found = tree.query(positions[part], k=looked)
            from_middle, near = (np.asarray(one).reshape(len(part), looked) for one in found)
            distances[part] = _distances(positions[part, None], starts[near], ends[near]).min(axis=1)
            # A segment further down the list is at least so far away.
            sure.append((looked == len(starts)) | (from_middle[:, -1] - reach >= distances[part]))
        unsure = unsure[~np.concatenate(sure)]
        looked = min(4 * looked, len(starts))
    return distances


def _in_pieces(starts: Array, ends: Array) -> tuple[Array, Array]:
    """The same segments, those longer than the mean cut into pieces of at most that: twice as many at most."""
    lengths = np.linalg.norm(ends - starts, axis=1)
    count = np.maximum(1, np.ceil(lengths / max(lengths.mean(), 1e-300))).astype(np.int64)
    of = np.repeat(np.arange(len(count)), count)
    part = (np.arange(len(of)) - np.repeat(np.cumsum(count) - count, count))[:, None] / count[of, None]
    along = (ends - starts)[of]
    return starts[of] + part * along, starts[of] + (part + 1.0 / count[of, None]) * along


def _distances(points: Array, starts: Array, ends: Array) -> Array:
    """Distance of points (…, 2|3) from one segment each."""
    along, offset = ends - starts, points - starts
    squared = np.einsum("...c,...c->...", along, along)
    t = np.clip(np.einsum("...c,...c->...", offset, along) / np.where(squared > 0, squared, 1.0), 0.0, 1.0)
    return np.linalg.norm(offset - t[..., None] * along, axis=-1)
