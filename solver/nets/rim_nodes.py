"""Vertices of the rim that are nodes of a net beside the ends of its lines: corners, and where the rim bends."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from ..domain.domain import Domain
from .tracing import EdgePoints

Array = NDArray[np.float64]
Int = NDArray[np.integer]


def distance_to_chord(points: Array, start: Array, end: Array) -> Array:
    """Distances (n,) of points (n, 3) from the segment between two points."""
    along = end - start
    size = float(along @ along)
    share = np.clip((points - start) @ along / size, 0.0, 1.0) if size else np.zeros(len(points))
    return np.linalg.norm(points - start - share[:, None] * along, axis=1)


def rim_nodes(
    domain: Domain, points: Array, crossed: EdgePoints, corners: Int, on_line: NDArray[np.bool_], tolerance: float
) -> Int:
    """The corners, and the fewest vertices more with which no vertex of the rim is farther than `tolerance` from the
    polygon through all nodes (Douglas and Peucker). points: (V, 3).

    on_line: (E,) the edges of sides that are lines of the net: sides of panels are straight there as elsewhere.
    """
    nodes = set(corners.tolist())
    first = np.searchsorted(crossed.edge, np.arange(len(domain.edge_lengths) + 1))
    for vertices, edges in zip(domain.boundary_loops, domain.boundary_loop_edges, strict=True):
        places, vertex, straight = [], [], []
        for v, edge in zip(vertices.tolist(), edges.tolist(), strict=True):
            places.append(points[v])
            vertex.append(v)
            straight += [bool(on_line[edge])] * (1 + int(first[edge + 1] - first[edge]))
            i, j = domain.edges[edge]
            for k in range(first[edge], first[edge + 1]):
                places.append((1.0 - crossed.t[k]) * points[i] + crossed.t[k] * points[j])
                vertex.append(-1)
        around = np.array(places)
        fixed = [k for k, v in enumerate(vertex) if v < 0 or v in nodes] or [0]
        if vertex[fixed[0]] >= 0:
            nodes.add(vertex[fixed[0]])
        turn = np.vstack([np.roll(around, -fixed[0], axis=0), around[fixed[0]]])
        vertex, straight = (one[fixed[0] :] + one[: fixed[0]] + one[:1] for one in (vertex, straight))
        stops = [k - fixed[0] for k in fixed] + [len(around)]
        waiting = list(pairwise(stops))
        while waiting:
            a, b = waiting.pop()
            if b - a < 2 or straight[a]:
                continue
            off = distance_to_chord(turn[a + 1 : b], turn[a], turn[b])
            worst = a + 1 + int(np.argmax(off))
            if off.max() > tolerance:
                nodes.add(vertex[worst])
                waiting += [(a, worst), (worst, b)]
    return np.array(sorted(nodes), dtype=np.int64)
