"""Distance of the boundary of a sheet from the drawn outline."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from ..errors import MeshError
from ..linalg import as_array, as_numbers
from .arrays import Array

if TYPE_CHECKING:
    from ..domain.domain import Domain

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
    along = ends - starts
    squared = np.einsum("kc,kc->k", along, along)
    squared = np.where(squared > 0, squared, 1.0)
    step = max(1, _BLOCK // max(1, len(starts)))
    nearest = [np.zeros(0)]
    for block in range(0, len(positions), step):
        offset = positions[block : block + step, None] - starts
        t = np.clip(np.einsum("nkc,kc->nk", offset, along) / squared, 0.0, 1.0)
        offset -= t[..., None] * along
        nearest.append(np.sqrt(np.einsum("nkc,nkc->nk", offset, offset).min(axis=1)))
    return np.concatenate(nearest)
