"""In which cell of a net the vertices of the domain lie."""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray
from scipy.sparse.csgraph import connected_components

from ..domain.domain import Domain
from .cells import Cells
from .tracing import Lines

Int = NDArray[np.integer]


def cells_of_vertices(domain: Domain, lines: Lines, cells: Cells) -> Int:
    """(V,) the cell in which each vertex of the domain lies.

    Vertices joined by an edge that no line crosses are in one cell; the first line across another edge of theirs has it
    on one side. A cell without an edge of the domain across its lines is the only one.
    """
    points = lines.points
    crossed = np.zeros(len(domain.edge_lengths), dtype=bool)
    crossed[points.edge] = True
    a, b = domain.edges[~crossed].T
    n = domain.vertex_count
    graph = sp.csr_array((np.ones(len(a), dtype=np.int8), (a, b)), shape=(n, n))
    group = connected_components(graph, directed=False)[1]
    cell_of_group = np.zeros(int(group.max()) + 1, dtype=np.int64)
    inner = np.flatnonzero((domain.edge_faces[points.edge, 1] >= 0) & (cells.arc_of_point >= 0))
    at_tail = inner[points.rank[inner] == 0]
    at_head = inner[points.rank[inner] == points.count[inner] - 1]
    # a line that leaves the left face of the edge has its tail on the right
    outwards = _leaves_left_face(domain, lines)
    for point, end, on_right in ((at_tail, 0, outwards), (at_head, 1, ~outwards)):
        half = 2 * cells.arc_of_point[point] + on_right[point]
        cell_of_group[group[domain.edges[points.edge[point], end]]] = cells.cell_of_half[half]
    return cell_of_group[group]


def _leaves_left_face(domain: Domain, lines: Lines) -> NDArray[np.bool_]:
    """(P,) whether the line through each edge point goes from the left face of its edge to the right one."""
    chords = lines.chords
    leaves = np.zeros(len(lines.points.edge), dtype=bool)
    left = domain.half_edges[lines.points.edge, 0]
    end = chords.ends[:, 1]
    # the perimeter goes through half-edges 2, 0, 1
    half = 3 * chords.face + (np.floor(chords.slots[:, 1]).astype(np.int64) + 2) % 3
    leaves[end] = half == left[end]
    return leaves
