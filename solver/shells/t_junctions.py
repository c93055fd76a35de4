"""T-junctions: vertices of the rim that lie inside one of its edges, where a mesh is open unnoticed."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree

from ..errors import MeshError, plural
from ..linalg import as_array

Array = NDArray[np.float64]
Int = NDArray[np.integer]

# Points closer than this part of the plan's size coincide.
_NEAR = 1e-6


def rim_of(triangles: Int, count: int) -> Int:
    """Edges (n, 2) that one triangle has, of triangles that may be no surface; none where they are no triangles."""
    corners = as_array(triangles, "Triangles", MeshError)
    is_list = corners.ndim == 2 and corners.shape[1] == 3 and len(corners) > 0
    if not is_list or corners.dtype.kind not in "iu" or corners.min() < 0 or corners.max() >= count:
        return np.zeros((0, 2), dtype=np.int64)
    pairs = np.concatenate([corners[:, [0, 1]], corners[:, [1, 2]], corners[:, [2, 0]]])
    ends, uses = np.unique(np.sort(pairs, axis=1), axis=0, return_counts=True)
    return ends[uses == 1]


def check_junctions(positions: Array, rim: Int) -> None:
    """Raise `MeshError` at vertices that lie on edges (n, 2) of the rim without being their ends."""
    lying = t_junctions(positions, rim)[0] if len(rim) else rim[:0, 0]
    if lying.size:
        raise MeshError(_junction_sentence(positions, rim), vertices=lying)


def t_junctions(positions: Array, rim: Int) -> tuple[Int, Int]:
    """Vertices of the rim that lie inside one of its edges (n, 2), and these edges."""
    vertices = np.unique(rim)
    near = _NEAR * float(np.ptp(positions, axis=0).max())
    a, b = positions[rim[:, 0]], positions[rim[:, 1]]
    half = 0.5 * np.linalg.norm(b - a, axis=1)
    found = KDTree(positions[vertices]).query_ball_point(0.5 * (a + b), half)
    edge = np.repeat(np.arange(len(rim)), [len(inside) for inside in found])
    vertex = vertices[np.array([k for inside in found for k in inside], dtype=np.int64)]
    along = (b - a)[edge] / np.maximum(2.0 * half[edge], 1e-300)[:, None]
    step = positions[vertex] - a[edge]
    place = np.einsum("ij,ij->i", step, along)
    off = np.linalg.norm(step - place[:, None] * along, axis=1)
    inner = (off <= near) & (place > 2.0 * near) & (place < 2.0 * half[edge] - 2.0 * near)
    lying, first = np.unique(vertex[inner], return_index=True)
    return lying, edge[inner][first]


def _junction_sentence(positions: Array, rim: Int) -> str:
    lying, edges = t_junctions(positions, rim)
    a, b = rim[edges[0]]
    verb = "lies" if len(lying) == 1 else "lie"
    text = plural("vertex", lying)
    return (
        f"{text[0].upper()}{text[1:]} {verb} inside an edge of the rim, the first inside {a}–{b}, so the mesh is open "
        "there (a T-junction); split the edge at the vertex, and weld (Merge by Distance)."
    )
