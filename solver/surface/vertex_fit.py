"""Values at vertices from values at faces, by a linear fit around each vertex.

The conjugate is known at circumcentres and at the midpoints of boundary edges. Unfold the faces around a vertex into
the plane, their angles scaled so that those of an interior vertex sum to 2π; fit a linear function to the known values
by least squares, and take its value at the vertex. This is exact for linear functions on a flat domain, hence second
order for smooth ones; the area average of the paper (Eq. 11) is not, since a mean of circumcentres is not the vertex.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from ..domain.connectivity import after, before
from ..domain.domain import Domain
from ..domain.trees import accumulate
from ..linalg import sum_rows

Array = NDArray[np.float64]
Int = NDArray[np.integer]

# Singular values of the fit below this part of the largest are dropped: points on a line give no slope across it.
_RANK = 1e-6


def fit_weights(domain: Domain, vertices: Int) -> tuple[sp.csr_array, sp.csr_array]:
    """Matrices (n, 3 F) and (n, 2 B): values at `vertices` (n,) from those at corners and at ends of boundary edges.

    A corner stands for the circumcentre of its face in the chart of its vertex; an end of one of
    `domain.boundary_edges` (start before end) for the midpoint of the edge.
    """
    place, corners = _corners_at(domain, vertices)
    midpoints, midpoint_vertices = _midpoints(domain)
    kept = np.flatnonzero(place[midpoint_vertices] >= 0)
    rows = np.concatenate([place[domain.faces.ravel()[corners]], place[midpoint_vertices[kept]]])
    samples = np.concatenate([_chart(domain, corners)(*_circumcentres(domain, corners)), midpoints[kept]])
    weights = _value_at_origin(rows, samples, len(vertices))
    n = len(corners)
    shape = (len(vertices), domain.faces.size)
    at_corners = sp.csr_array((weights[:n], (rows[:n], corners)), shape=shape)
    shape = (len(vertices), 2 * len(domain.boundary_edges))
    return at_corners, sp.csr_array((weights[n:], (rows[n:], kept)), shape=shape)


def face_fit_weights(domain: Domain) -> sp.csr_array:
    """Matrix (V, F): values at all vertices from those at faces alone.

    At a boundary vertex the fit includes the faces beyond those around it, which may be only one or two.
    """
    vertices = domain.faces.ravel()
    corners = np.arange(domain.faces.size)
    on_rim = np.zeros(domain.vertex_count, dtype=bool)
    on_rim[domain.boundary_vertices] = True
    seen = np.flatnonzero(on_rim[vertices] & (domain.twins >= 0))
    chart = _chart(domain, corners)
    near = chart(*_circumcentres(domain, corners))
    far = chart(*_circumcentres_beyond(domain, corners))[seen]
    rows = np.concatenate([vertices, vertices[seen]])
    weights = _value_at_origin(rows, np.concatenate([near, far]), domain.vertex_count)
    faces = np.concatenate([corners, domain.twins[seen]]) // 3
    return sp.csr_array((weights, (rows, faces)), shape=(domain.vertex_count, len(domain.faces)))


def _corners_at(domain: Domain, vertices: Int) -> tuple[Int, Int]:
    """The place of each vertex (V,) among `vertices`, -1 for the others, and the corners (n,) at them."""
    place = np.full(domain.vertex_count, -1)
    place[vertices] = np.arange(len(vertices))
    return place, np.flatnonzero(place[domain.faces.ravel()] >= 0)


def _value_at_origin(rows: Int, samples: Array, count: int) -> Array:
    """Weight of each sample in the value at the origin of the linear function fitted to the samples of its row.

    Samples are weighted by the inverse square of their distance: the circumcentre of a needle lies far away.
    """
    distance = np.linalg.norm(samples, axis=1)
    near = sum_rows(rows, np.ones(len(rows)), count) / sum_rows(rows, 1.0 / distance, count)
    scaled = np.column_stack([near[rows], samples]) / distance[:, None]
    moments = sum_rows(rows, np.einsum("ia,ib->iab", scaled, scaled).reshape(-1, 9), count).reshape(-1, 3, 3)
    first_row: Array = np.linalg.pinv(moments, rcond=_RANK, hermitian=True)[:, 0]
    return np.einsum("ij,ij->i", first_row[rows], scaled) * near[rows] / distance


def _circumcentres(domain: Domain, corners: Int) -> tuple[Array, Array]:
    """x, y (n,) of the circumcentre of the face of each corner, which is the origin; the next one is on the x-axis."""
    angle = domain.corner_angles.ravel()[corners]
    along = domain.side_lengths.ravel()[before(corners)]  # from the corner to the next one
    back = domain.side_lengths.ravel()[after(corners)]  # from the corner to the one before
    return 0.5 * along, 0.5 * (back - along * np.cos(angle)) / np.sin(angle)


def _circumcentres_beyond(domain: Domain, corners: Int) -> tuple[Array, Array]:
    """The same for the face across the opposite edge: ½ cot θ' of its length away from its midpoint."""
    angle = domain.corner_angles.ravel()[corners]
    along = domain.side_lengths.ravel()[before(corners)]
    back = domain.side_lengths.ravel()[after(corners)]
    cotan = domain.corner_cotans.ravel()[domain.twins[corners]]
    x, y = back * np.cos(angle), back * np.sin(angle)
    return 0.5 * (along + x + cotan * y), 0.5 * (y + cotan * (along - x))


def _chart(domain: Domain, corners: Int) -> Callable[[Array, Array], Array]:
    """Maps points from the plane of the face of each corner to the chart of its vertex, (n, 2)."""
    start, stretch = fan_angles(domain, corners)

    def unfold(x: Array, y: Array) -> Array:
        direction = start + stretch * np.arctan2(y, x)
        points = np.empty((len(corners), 2))
        points[:, 0], points[:, 1] = np.cos(direction), np.sin(direction)
        return points * np.sqrt(x**2 + y**2)[:, None]

    return unfold


def _midpoints(domain: Domain) -> tuple[Array, Int]:
    """(2 B, 2) midpoint of each boundary edge in the charts of its two ends, and those vertices (2 B,)."""
    rim = domain.boundary_edges
    tail, head = domain.edges[rim].T
    total = _vertex_angles(domain)[head]
    half = 0.5 * domain.edge_lengths[rim]
    points = np.zeros((len(rim), 2, 2))
    points[:, 0, 0] = half  # the edge that leaves a boundary vertex starts its fan
    points[:, 1] = half[:, None] * np.stack([np.cos(total), np.sin(total)], axis=1)
    return points.reshape(-1, 2), np.stack([tail, head], axis=1).ravel()


def _vertex_angles(domain: Domain) -> Array:
    return sum_rows(domain.faces.ravel(), domain.corner_angles.ravel(), domain.vertex_count)


def fan_angles(domain: Domain, corners: Int) -> tuple[Array, Array]:
    """Direction (n,) in which the face of each corner begins, and the stretch (n,) of its angles.

    corners: all those of some vertices, traversed counter-clockwise around each vertex, from the boundary edge that
    leaves it, or from any corner of an interior vertex.
    """
    vertices = domain.faces.ravel()[corners]
    # the half-edge that leaves corner k lies opposite corner k + 2; behind it is the corner before, clockwise
    twin = domain.twins[before(corners)].astype(np.int64)
    position = np.empty(domain.faces.size, dtype=np.int64)
    position[corners] = np.arange(len(corners))
    previous = np.where(twin >= 0, position[before(twin)], np.arange(len(corners)))
    first = np.full(domain.vertex_count, len(corners))
    np.minimum.at(first, vertices, np.arange(len(corners)))
    on_rim = np.zeros(domain.vertex_count, dtype=bool)
    on_rim[domain.boundary_vertices] = True
    starts = np.where(on_rim[vertices], twin < 0, first[vertices] == np.arange(len(corners)))
    parent = np.where(starts, np.arange(len(corners)), previous)
    stretch = np.where(on_rim, 1.0, 2.0 * np.pi / _vertex_angles(domain))[vertices]
    # a corner begins where the one before ends
    turned = (domain.corner_angles.ravel()[corners] * stretch)[previous]
    return accumulate(parent, turned[:, None])[:, 0], stretch
