"""A net from the lines of a field: cells, panels, umbilics."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..errors import ConditionError
from .cells import Cells, cells_of, collapsed
from .field import LineField, mean_deviation
from .net import Net
from .places import normals_at, points_at
from .rim_nodes import rim_nodes
from .sheets import Sheet, gradients
from .sides import corner_vertices
from .slivers import merged
from .zero_cells import cells_of_vertices

Array = NDArray[np.float64]
Int = NDArray[np.integer]

# The rim of the panels is within this part of the spacing from the rim of the surface.
_NEAR = 0.1
# Nodes that are nearer than this part of the spacing are one.
_POINT = 1e-5
# A count of panels that is nearer to the wanted one, as a part of it, is not improved.
_NEAR_COUNT = 0.05


def net_of(field: LineField) -> Net:
    """The net of the lines at whole numbers of a field."""
    lines = field.lines
    domain, near = field.sheet.domain, _NEAR * field.spacing
    bends = corner_vertices(field.hopf)
    corners = rim_nodes(domain, field.sheet.points, lines.points, bends, field.on_line, near)
    cells = cells_of(domain, lines, corners)
    return _assembled(field, cells)


def net_of_count(field: LineField, count: int | None) -> Net:
    """The net of a field, or of one with its lines farther apart or nearer that has more nearly `count` panels.

    How many panels the rim cuts is known only afterwards.
    """
    net = net_of(field)
    if count is None or abs(len(net.polygons) / count - 1.0) <= _NEAR_COUNT:
        return net
    try:
        again = net_of(field.scaled(float(np.sqrt(len(net.polygons) / count))))
    except ConditionError:  # its lines would be too far apart
        return net
    return min((net, again), key=lambda one: abs(len(one.polygons) - count))


def _assembled(field: LineField, cells: Cells) -> Net:
    sheet = field.sheet
    points = points_at(sheet, cells.faces, cells.barycentric)
    cells = collapsed(cells, points, _POINT * field.spacing)
    is_open = (cells.family < 0) & ~field.on_line[cells.rim_edge]
    rim = {(int(i), int(j)) for i, j in cells.arcs[is_open]}
    kept = set(cells.corners.tolist())
    polygons, members = merged([cell.tolist() for cell in cells.cells], rim, points, kept, _NEAR * field.spacing)
    number = np.full(len(points), -1)
    used = np.unique(np.concatenate(polygons))
    number[used] = np.arange(len(used))
    edges, family, rim_edges = _edges(polygons, cells)
    panel_of_cell = np.empty(len(cells.cells), dtype=np.int64)
    for panel, parts in enumerate(members):
        panel_of_cell[parts] = panel
    orders, branched = _umbilics(field, cells, panel_of_cell, len(polygons))
    clipped = np.zeros(len(polygons), dtype=bool)
    clipped[panel_of_cell[np.unique(cells.cell_of_half[2 * np.flatnonzero(is_open)])]] = True
    k1 = field.sheet.mean_curvature + field.half_difference(cells.faces, cells.barycentric)
    return Net(
        vertices=points[used],
        normals=normals_at(sheet, cells.faces[used], cells.barycentric[used]),
        polygons=[number[polygon] for polygon in polygons],
        edges=number[edges],
        family=family,
        rim_edges=rim_edges,
        faces=cells.faces[used],
        barycentric=cells.barycentric[used],
        clipped=clipped,
        orders=orders,
        branched=branched,
        kind=field.kind,
        sheet=sheet.name,
        spacing=field.spacing,
        spacings=field.coordinates.spacings,
        curvature=np.array([k1[polygon].mean() for polygon in polygons]),
        deviation=mean_deviation(field.coordinates),
        mean_curvature=sheet.mean_curvature,
        euler_characteristic=sheet.domain.euler_characteristic,
        folded=folded_vertices(sheet, field.hopf.zeros),
    )


def _edges(polygons: list[list[int]], cells: Cells) -> tuple[Int, Int, Int]:
    """The edges (m, 2) of the panels, their families (m,), -1 on the rim, and the boundary edges where they begin."""
    ends = np.concatenate([np.column_stack([p, np.roll(p, -1)]) for p in polygons])
    edges = np.unique(np.sort(ends, axis=1), axis=0)
    count = len(cells.faces)
    keys = np.sort(cells.arcs, axis=1) @ [count, 1]
    order = np.lexsort((cells.family, keys))  # the rim first, where a line joins the same two nodes
    wanted = edges @ [count, 1]
    at = np.minimum(np.searchsorted(keys[order], wanted), len(keys) - 1)
    known = keys[order][at] == wanted
    family, rim_edges = (np.where(known, of_arcs[order][at], -1) for of_arcs in (cells.family, cells.rim_edge))
    return edges, family, rim_edges


def _umbilics(field: LineField, cells: Cells, panel_of_cell: Int, count: int) -> tuple[Int, Int]:
    """The sum of the orders of the zeros in each panel, and the panels in which the sheet has a branch point."""
    zeros = field.hopf.zeros
    where = panel_of_cell[cells_of_vertices(field.sheet.domain, field.lines, cells)[zeros]]
    orders = np.bincount(where, field.hopf.orders, count).astype(np.int64)
    return orders, np.unique(where[branch_points(field.sheet, zeros)])


def folded_vertices(sheet: Sheet, zeros: Int) -> Int:
    """Vertices of f± in the middle of faces that look the other way than the normals, as at sharp corners of plans.

    Faces around zeros of q are passed over: at branch points they turn over, too.
    """
    if sheet.name == "g":
        return np.zeros(0, dtype=np.int64)
    faces = sheet.domain.faces
    a, b, c = (sheet.points[faces[:, k]] for k in range(3))
    turned = np.einsum("fi,fi->f", np.cross(b - a, c - a), sheet.normals[faces].sum(axis=1)) < 0.0
    turned &= ~np.isin(faces, zeros).any(axis=1)
    count = np.bincount(faces[turned].ravel(), minlength=len(sheet.points))
    found = []
    while count.any():  # one vertex for each group of such faces
        vertex = int(np.argmax(count))
        found.append(vertex)
        near = np.isin(faces, np.unique(faces[(faces == vertex).any(axis=1)])).any(axis=1)
        count[np.unique(faces[near])] = 0
    return np.array(found, dtype=np.int64)


def branch_points(sheet: Sheet, zeros: Int) -> NDArray[np.bool_]:
    """Which zeros of q are branch points of f±: where <N, N_x × N_y> < 0. At H = 0 and on g none are."""
    if sheet.mean_curvature == 0.0 or sheet.name == "g":
        return np.zeros(len(zeros), dtype=bool)
    nx, ny = gradients(sheet.domain, sheet.normals)
    middle = sheet.normals[sheet.domain.faces].mean(axis=1)
    turned = np.einsum("fi,fi->f", middle, np.cross(nx, ny)) * sheet.domain.face_areas
    around = np.bincount(sheet.domain.faces.ravel(), np.repeat(turned, 3), sheet.domain.vertex_count)
    return around[zeros] < 0.0
