"""Rims that touch without being joined: vertices of two parts that coincide, and T-junctions."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import KDTree

from ..errors import MeshError, plural

Array = NDArray[np.float64]
Int = NDArray[np.integer]

# Points closer than this part of the plan's size coincide.
_NEAR = 1e-6


def explain_parts(error: MeshError, positions: Array, triangles: Int) -> MeshError:
    """The error of a mesh that is no domain, or a better one if its parts only touch where they should be joined."""
    corners = np.asarray(triangles)
    if corners.ndim != 2 or not len(corners) or corners.min() < 0 or corners.max() >= len(positions):
        return error
    count = len(positions)
    pairs = np.concatenate([corners[:, [0, 1]], corners[:, [1, 2]], corners[:, [2, 0]]])
    graph = coo_array((np.ones(len(pairs)), tuple(pairs.T)), shape=(count, count))
    part = connected_components(graph, directed=False)[1]
    ends, uses = np.unique(np.sort(pairs, axis=1), axis=0, return_counts=True)
    rim = ends[uses == 1]
    twins, (lying, _) = coinciding(positions, np.unique(rim), part), t_junctions(positions, rim)
    if not twins.size and not lying.size:
        return error
    sentences = []
    if twins.size:
        sentences.append(
            f"{len(twins)} vertices of one part of the mesh coincide with vertices of another and are not joined "
            f"({plural('vertex', twins)}); weld them (Merge by Distance)."
        )
    if lying.size:
        sentences.append(_junction_sentence(positions, rim))
    return MeshError(" ".join(sentences), vertices=np.concatenate([twins, lying]))


def check_junctions(positions: Array, rim: Int) -> None:
    """Raise `MeshError` at vertices that lie on edges (n, 2) of the rim without being their ends."""
    lying, _ = t_junctions(positions, rim)
    if lying.size:
        raise MeshError(_junction_sentence(positions, rim), vertices=lying)


def coinciding(positions: Array, vertices: Int, part: Int) -> Int:
    """Those of the vertices that lie on one of another part; of each pair the one with the larger number."""
    points = positions[vertices]
    near = _NEAR * float(np.ptp(positions, axis=0).max())
    pairs = vertices[KDTree(points).query_pairs(near, output_type="ndarray")].reshape(-1, 2)
    apart = part[pairs[:, 0]] != part[pairs[:, 1]]
    return np.unique(pairs[apart].max(axis=1)) if apart.any() else np.zeros(0, dtype=np.int64)


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
