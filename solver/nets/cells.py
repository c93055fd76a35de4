"""Cells between traced lines and the rim: the net as a mesh, by its order alone.

Nodes are crossings, ends of lines on the rim and corners of the domain; arcs run between consecutive nodes of a line or
of a boundary loop. Arc a has half-arcs 2a and 2a + 1; each cell is a cycle of half-arcs with the cell on their left.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray
from scipy.sparse.csgraph import connected_components

from ..domain.domain import Domain
from ..errors import ConditionError
from .tracing import Lines

Array = NDArray[np.float64]
Int = NDArray[np.integer]


@dataclass(frozen=True, eq=False)
class Cells:
    """A net of n nodes, m arcs and P cells, on the faces of a domain.

    faces (n,), barycentric (n, 3): where each node is. corners: the nodes that are corners of the domain. arcs: (m, 2)
    nodes; family: (m,) of the line, -1 on the rim. cells: nodes of each cell, counter-clockwise. cell_of_half: (2 m,)
    the cell on the left of each half-arc, -1 outside. rim_edge: (m,) the boundary edge on which an arc of the rim
    begins, else -1. arc_of_point: (P,) for each edge point inside, the arc it is on.
    """

    faces: Int
    barycentric: Array
    corners: Int
    arcs: Int
    family: Int
    cells: list[Int]
    cell_of_half: Int
    rim_edge: Int
    arc_of_point: Int


def cells_of(domain: Domain, lines: Lines, corners: Int) -> Cells:
    """The cells of traced lines; corners: vertices of the boundary that are nodes.

    Raises `ConditionError` where the lines do not divide the surface into discs: the spacing is too large for it.
    """
    faces, barycentric, node_of_point, node_of_corner = _nodes(domain, lines, corners)
    along, family, arc_of_point = _line_arcs(lines, node_of_point)
    rim, rim_edge, empty = _rim_arcs(domain, lines, node_of_point, node_of_corner)
    arcs = np.concatenate([along, rim])
    families = np.concatenate([family, np.full(len(rim), -1)])
    following = _next_halves(arcs, families, lines.from_right, len(faces))
    cells, cell_of_half = _cycles(arcs, families, following)
    euler = len(faces) - len(arcs) + len(cells)
    if empty or euler != domain.euler_characteristic or _parts(arcs, len(faces)) > 1:
        raise ConditionError(
            "At this spacing the lines do not divide the surface into panels: too few of them cross it, or it is "
            "narrower somewhere than a panel; choose a smaller spacing."
        )
    on_corners = node_of_corner[corners]
    edge = np.concatenate([np.full(len(along), -1), rim_edge])
    return Cells(faces, barycentric, on_corners, arcs, families, cells, cell_of_half, edge, arc_of_point)


def collapsed(cells: Cells, points: Array, least: float) -> Cells:
    """The cells with nodes (n, 3) that are joined by arcs shorter than `least` in one: the first of each group.

    Where sides that are lines meet at an umbilic, another line starts there, and ends beside the corner by rounding.
    """
    short = np.linalg.norm(points[cells.arcs[:, 1]] - points[cells.arcs[:, 0]], axis=1) < least
    if not short.any():
        return cells
    i, j = cells.arcs[short].T
    graph = sp.csr_array((np.ones(len(i), dtype=np.int8), (i, j)), shape=(len(points), len(points)))
    _, first, same = np.unique(
        connected_components(graph, directed=False)[1], return_index=True, return_inverse=True
    )
    node = first[same.ravel()]
    merged = [node[cell] for cell in cells.cells]
    proper = [cell[cell != np.roll(cell, 1)] for cell in merged]
    return replace(cells, arcs=node[cells.arcs], cells=proper, corners=np.unique(node[cells.corners]))


def _nodes(domain: Domain, lines: Lines, corners: Int) -> tuple[Int, Array, Int, Int]:
    """Face and barycentric place (n,) of the nodes, and the node of each edge point and of each vertex, or -1."""
    on_rim = domain.edge_faces[lines.points.edge, 1] < 0
    count = len(lines.crossings)
    node_of_point = np.full(len(on_rim), -1)
    node_of_point[on_rim] = count + np.arange(on_rim.sum())
    node_of_corner = np.full(domain.vertex_count, -1)
    node_of_corner[corners] = count + on_rim.sum() + np.arange(len(corners))
    half = domain.half_edges[lines.points.edge[on_rim], 0]
    face, k, t = half // 3, half % 3, lines.points.t[on_rim]
    on_edge = np.zeros((len(half), 3))
    on_edge[np.arange(len(half)), (k + 1) % 3] = 1.0 - t
    on_edge[np.arange(len(half)), (k + 2) % 3] = t
    corner = domain.fan_starts[corners]
    faces = np.concatenate([lines.chords.face[lines.crossings[:, 0]], face, corner // 3])
    places = np.concatenate([lines.places, on_edge, np.eye(3)[corner % 3]])
    return faces.astype(np.int64), places, node_of_point, node_of_corner


def _line_arcs(lines: Lines, node_of_point: Int) -> tuple[Int, Int, Int]:
    """Arcs (m, 2) between consecutive nodes of each line, their families, and the arc (P,) of each edge point."""
    chords, crossings = lines.chords, lines.crossings
    count = len(crossings)
    # events along the lines: crossings, ends on the rim, and the inner edge points between chords
    rows = []
    for side in (0, 1):
        chord = crossings[:, side]
        crossing = np.arange(count)
        rows.append((chords.line[chord], chords.position[chord], lines.along[:, side], crossing, np.full(count, -1)))
    for end, key in ((0, -1.0), (1, 4.0)):
        point = chords.ends[:, end]
        node = node_of_point[point]
        kept = (node >= 0) | (end == 1)
        keys = np.full(kept.sum(), key)
        rows.append((chords.line[kept], chords.position[kept], keys, node[kept], point[kept]))
    line, position, key, node, point = (np.concatenate(column) for column in zip(*rows, strict=True))
    order = np.lexsort((key, position, line))
    line, node, point = line[order], node[order], point[order]
    is_node = node >= 0
    line_n, node_n = line[is_node], node[is_node]
    # the arc from each node to the next one on its line; of the last one back to the first, where the line is closed
    total = len(line_n)
    first = np.searchsorted(line_n, np.arange(len(lines.family)))
    stop = np.searchsorted(line_n, np.arange(len(lines.family)), side="right")
    following = np.arange(1, total + 1)
    last = stop[stop > first] - 1
    following[last] = first[stop > first]
    has_arc = np.ones(total, dtype=bool)
    has_arc[last] = lines.closed[line_n[last]]
    number = np.cumsum(has_arc) - 1
    arcs = np.column_stack([node_n, node_n[following % max(total, 1)]])[has_arc]
    family = lines.family[line_n[has_arc]]
    # an edge point is on the arc of the last node before it; before the first node of a closed line, on the last arc
    before = np.cumsum(is_node) - 1
    inner = ~is_node
    wrapped = before[inner] < first[line[inner]]
    at = np.where(wrapped, stop[line[inner]] - 1, before[inner])
    arc_of_point = np.full(len(node_of_point), -1)
    exists = stop[line[inner]] > first[line[inner]]
    arc_of_point[point[inner][exists]] = number[at[exists]]
    return arcs, family, arc_of_point


def _rim_arcs(domain: Domain, lines: Lines, node_of_point: Int, node_of_corner: Int) -> tuple[Int, Int, bool]:
    """Arcs (m, 2) along the boundary loops, the surface on the left, the edges (m,) on which they begin, and whether a
    loop has no node at all.
    """
    points = lines.points
    arcs, begins, empty = [], [], False
    first = np.searchsorted(points.edge, np.arange(len(domain.edge_lengths) + 1))
    for vertices, edges in zip(domain.boundary_loops, domain.boundary_loop_edges, strict=True):
        # a boundary edge is directed with the surface on its left, and so are its points
        count = first[edges + 1] - first[edges]
        node = np.full((len(edges), 1 + count.max(initial=0)), -1)
        node[:, 0] = node_of_corner[vertices]
        for j in range(count.max(initial=0)):
            has = count > j
            node[has, 1 + j] = node_of_point[first[edges[has]] + j]
        is_node = node >= 0
        around = node[is_node]
        begins.append(np.repeat(edges, node.shape[1]).reshape(node.shape)[is_node])
        empty |= not len(around)
        arcs.append(np.column_stack([around, np.roll(around, -1)]))
    return np.concatenate(arcs), np.concatenate(begins), empty


def _next_halves(arcs: Int, family: Int, from_right: NDArray[np.bool_], nodes: int) -> Int:
    """(2 m,) the half-arc that follows each one around the cell on its left: the next clockwise at its end."""
    leaving, arriving = np.full((2, 3, nodes), -1)  # the half-arcs that leave a node, by family; the rim comes last
    for one in (0, 1, -1):
        mine = np.flatnonzero(family == one)
        leaving[one][arcs[mine, 0]] = 2 * mine
        arriving[one][arcs[mine, 1]] = 2 * mine + 1
    clockwise = np.full(2 * len(arcs), -1)
    x = np.arange(len(from_right))
    up = np.where(from_right, leaving[1][x], arriving[1][x])
    down = np.where(from_right, arriving[1][x], leaving[1][x])
    around = [leaving[0][x], up, arriving[0][x], down]
    for k in range(4):
        clockwise[around[k]] = around[k - 1]
    on_rim = np.arange(len(from_right), nodes)
    inwards = np.maximum(leaving[:2].max(axis=0), arriving[:2].max(axis=0))[on_rim]
    ahead, behind = leaving[-1][on_rim], arriving[-1][on_rim]
    has_line = inwards >= 0
    clockwise[inwards[has_line]] = ahead[has_line]
    clockwise[behind] = np.where(has_line, inwards, ahead)
    clockwise[ahead] = behind
    return clockwise[np.arange(2 * len(arcs)) ^ 1]


def _cycles(arcs: Int, family: Int, following: Int) -> tuple[list[Int], Int]:
    """The nodes of each cell, and the cell (2 m,) on the left of each half-arc, -1 outside."""
    count = len(following)
    half = np.arange(count)
    graph = sp.csr_array((np.ones(count, dtype=np.int8), (half, following)), shape=(count, count))
    label = connected_components(graph, directed=False)[1]
    outside = np.zeros(int(label.max(initial=-1)) + 1, dtype=bool)
    outside[label[2 * np.flatnonzero(family < 0) + 1]] = True
    number = np.cumsum(~outside) - 1
    cell_of_half = np.where(outside[label], -1, number[label])
    inside = np.flatnonzero(cell_of_half >= 0)
    sizes = np.bincount(cell_of_half[inside])
    first = np.full(len(sizes), count)
    np.minimum.at(first, cell_of_half[inside], inside)
    around = np.empty((len(sizes), int(sizes.max(initial=0))), dtype=np.int64)
    at = first
    for k in range(around.shape[1]):
        around[:, k] = arcs[at // 2, at % 2]
        at = following[at]
    return [row[:size] for row, size in zip(around, sizes.tolist(), strict=True)], cell_of_half


def _parts(arcs: Int, nodes: int) -> int:
    graph = sp.csr_array((np.ones(len(arcs), dtype=np.int8), (arcs[:, 0], arcs[:, 1])), shape=(nodes, nodes))
    return int(connected_components(graph, directed=False)[0])
