"""More vertices where a moving plan has drawn its faces out.

A hole that shrinks stretches the rings of faces around it: too few in the logarithm of the radius, they resist the neck
that the surface wants, and a neck that closes stays open. Long edges are halved, and the plan is triangulated anew.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..domain.domain import Domain
from ..errors import MeshError
from ..meshing.triangulate import triangulate

Array = NDArray[np.float64]

# An edge is long if it is this multiple of the shortest ones at both its ends.
_LONG = 2.0


def refined(domain: Domain, positions: Array, f: Array) -> tuple[Domain, Array, Array] | None:
    """The plan with the middles of its long inner edges as further vertices: domain, positions (n, 2), f (n, 3).

    The vertices and boundary edges of the plan stay. None where no edge is long, or the plan has no Delaunay
    triangulation with its boundary.
    """
    lengths = np.linalg.norm(np.diff(positions[domain.edges], axis=1)[:, 0], axis=1)
    shortest = np.full(domain.vertex_count, np.inf)
    for ends in domain.edges.T:
        np.minimum.at(shortest, ends, lengths)
    inside = domain.interior_edges
    long = inside[lengths[inside] > _LONG * shortest[domain.edges[inside]].max(axis=1)]
    if not len(long):
        return None
    i, j = domain.edges[long].T
    points = np.concatenate([positions, 0.5 * (positions[i] + positions[j])])
    rim = domain.edges[domain.boundary_edges].astype(np.int64)
    try:
        faces = triangulate(points / lengths.mean(), rim)
        made = Domain.from_positions(points, faces)
    except MeshError:
        return None
    if not np.array_equal(made.boundary_vertices, domain.boundary_vertices):
        return None
    return made, points, np.concatenate([f, 0.5 * (f[i] + f[j])])
