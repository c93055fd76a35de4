"""Values along the boundary that flow into each other instead of jumping.

Where two neighbouring groups of edges prescribe different tilts, the normals jump and the surface gets a spike there. A
moving average along the boundary turns the jump into a ramp.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..domain.domain import Domain

Array = NDArray[np.float64]
Int = NDArray[np.integer]


def moving_average(domain: Domain, edges: Int, values: Array, width: float) -> Array:
    """Mean (K,) of `values` (K,) on boundary `edges` (K,) over the arc of length `width` around each edge's midpoint.

    Windows run along connected runs of the given edges; beyond the end of a run its last value goes on, around a
    whole loop they go round. A width of zero, or below an edge length, changes (almost) nothing.
    """
    given = np.full(len(domain.edges), np.nan)
    given[edges] = values
    averaged = np.empty(len(domain.edges))
    if width > 0.0:
        for loop in domain.boundary_loop_edges:
            for run, is_loop in _runs(loop, np.isfinite(given[loop])):
                averaged[run] = _average(domain.edge_lengths[run], given[run], width, is_loop)
        return averaged[edges]
    return np.array(values, dtype=np.float64)


def _runs(loop: Int, chosen: NDArray[np.bool_]) -> list[tuple[Int, bool]]:
    """Maximal runs of chosen edges in a closed walk, and whether a run is all of it."""
    if chosen.all():
        return [(loop, True)]
    start = int(np.flatnonzero(~chosen)[0])
    walk, marks = np.roll(loop, -start), np.roll(chosen, -start)
    breaks = np.flatnonzero(np.diff(marks.astype(np.int8))) + 1
    parts = zip(np.split(walk, breaks), np.split(marks, breaks), strict=True)
    return [(part, False) for part, mark in parts if mark[0]]


def _average(lengths: Array, values: Array, width: float, is_loop: bool) -> Array:
    ends = np.concatenate([[0.0], np.cumsum(lengths)])
    integral = np.concatenate([[0.0], np.cumsum(lengths * values)])
    total, width = ends[-1], min(width, ends[-1])
    if is_loop:
        ends = np.concatenate([ends[:-1] - total, ends, ends[1:] + total])
        integral = np.concatenate([integral[:-1] - integral[-1], integral, integral[1:] + integral[-1]])
    else:
        ends = np.concatenate([[-width], ends, [total + width]])
        integral = np.concatenate([[-width * values[0]], integral, [integral[-1] + width * values[-1]]])
    middles = np.cumsum(lengths) - 0.5 * lengths
    upper, lower = (np.interp(middles + s * 0.5 * width, ends, integral) for s in (1, -1))
    return (upper - lower) / width
