"""The net of a surface completed by its mirrors: that of one module, its sides on lines, copied and welded.

Nodes are welded because the copies are neighbours across a side, never because they are near. At corners of a module
where mirrors meet at 60°, three lines cross: there an umbilic is a node of valence 6.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ..domain.gluing import Glued, glue
from ..errors import ConditionError
from ..gauss.sphere import normalize
from ..symmetry.completion import Completion
from .assembly import net_of_count
from .field import LineField, line_field
from .net import Net
from .places import normals_at, points_at
from .sheets import Sheet
from .tracing import AXIS_OF_FAMILY

Array = NDArray[np.float64]
Int = NDArray[np.integer]


def completed_net(completion: Completion, spacing: float | None, count: int | None, kind: str) -> Net:
    """The net on all copies; see `panel_net`. count: of the panels of all copies together.

    Raises `ConditionError` on diagonal nets and where copies meet otherwise than across sides in planes.
    """
    if kind != "principal":
        raise ConditionError("Only principal nets go on across mirrors; make the diagonal net of one module.")
    side_of_edge = _sides(completion)
    module = module_sheet(completion, completion.sheet)
    each = None if count is None else max(1, round(count / len(completion.copies)))
    field = line_field(module, spacing, each, kind, completion.sheet, known=side_of_edge)
    return _copied(completion, field, net_of_count(field, each), side_of_edge)


def module_sheet(completion: Completion, name: str) -> Sheet:
    """The sheet "f+" or "f-" of the module, with its sides exactly in their planes."""
    surface = completion.surface
    pair = tuple(
        (surface.sheet(one), surface.sheet_normals(one)) for one in ("f+", "f-") if not surface.is_degenerate(one)
    )
    points, H = completion.piece(name), surface.mean_curvature
    return Sheet(surface.domain, points, surface.sheet_normals(name), H, name, pair)


def _sides(completion: Completion) -> Int:
    """The seam (E,) along each boundary edge of the module, -1 elsewhere."""
    domain = completion.surface.domain
    of_edge = np.full(len(domain.edge_lengths), -1)
    rim = domain.boundary_edges
    for number, seam in enumerate(completion.seams):
        if seam.here is not seam.there and not np.array_equal(seam.here, seam.there):
            raise ConditionError(
                f"Copies meet across the seam {seam.name!r} by a translation, which nets do not know; complete the "
                "surface by mirrors alone, or make the net of one module."
            )
        of_edge[rim[np.isin(domain.edges[rim], seam.here).all(axis=1)]] = number
    free = [plane.name for plane in completion.planes if plane.normal is None]
    if free:
        raise ConditionError(f"Nets do not go on across the free side {free[0]!r}; make the net of one module.")
    return of_edge


def _copied(completion: Completion, field: LineField, net: Net, side_of_edge: Int) -> Net:
    seam = np.where(net.rim_edges >= 0, side_of_edge[net.rim_edges], -1)
    glued = _glued(completion, net, seam)
    copies = list(zip(completion.copies, completion.sheets, strict=True))
    sheets = {name: module_sheet(completion, name) for name in set(completion.sheets)}
    places = {name: points_at(sheet, net.faces, net.barycentric) for name, sheet in sheets.items()}
    normals = {name: normals_at(sheet, net.faces, net.barycentric) for name, sheet in sheets.items()}
    polygons, ends, families, curvature = [], [], [], []
    across = np.concatenate([completion.neighbours, np.full((len(copies), 1), -1)], axis=1) >= 0
    family_of_side = _families(field, side_of_edge, len(completion.seams))
    on = {name: replace(field, sheet=sheet) for name, sheet in sheets.items()}
    for k, (copy, name) in enumerate(copies):
        members = glued.members[k]
        step = -1 if copy.flipped else 1
        polygons += [members[polygon[::step]] for polygon in net.polygons]
        ends.append(members[net.edges])
        families.append(np.where(across[k][seam], family_of_side[seam], net.family))
        k1 = on[name].sheet.mean_curvature + on[name].half_difference(net.faces, net.barycentric)
        curvature.append([k1[polygon].mean() for polygon in net.polygons])
    points = np.array([copy.points(places[name]) for copy, name in copies])
    turned = np.array([normals[name] @ copy.linear.T for copy, name in copies])
    edges, family = _unique(np.concatenate(ends), np.concatenate(families))
    count = len(net.polygons)
    return replace(
        net,
        vertices=glued.mean(points),
        normals=normalize(glued.mean(turned)),
        polygons=polygons,
        edges=edges,
        family=family,
        rim_edges=np.full(len(edges), -1),
        faces=_first(glued, net.faces),
        barycentric=_first(glued, net.barycentric),
        clipped=np.tile(net.clipped, len(copies)),
        orders=np.tile(net.orders, len(copies)),
        branched=(np.arange(len(copies))[:, None] * count + net.branched).ravel(),
        curvature=np.concatenate(curvature),
        euler_characteristic=_characteristic(completion),
    )


def _glued(completion: Completion, net: Net, seam: Int) -> Glued:
    """Nodes of the copies of the net, welded along the seam (m,) that each edge of its rim is on."""
    joins = [np.zeros((0, 4), dtype=np.int64)]
    for j in range(len(completion.seams)):
        nodes = np.unique(net.edges[seam == j])
        here = np.flatnonzero(completion.neighbours[:, j] >= 0)
        there = completion.neighbours[here, j]
        every = np.tile(nodes, len(here))
        joins.append(np.column_stack([np.repeat(here, len(nodes)), every, np.repeat(there, len(nodes)), every]))
    flipped = [copy.flipped for copy in completion.copies]
    return glue(np.zeros((0, 3), dtype=np.int64), len(net.vertices), flipped, np.concatenate(joins))


def _families(field: LineField, side_of_edge: Int, count: int) -> Int:
    """The family of the line along each side (count + 1,); the last one stands for no side."""
    found = np.full(count + 1, -1)
    for side in field.sides:
        found[side_of_edge[side.edges[0]]] = AXIS_OF_FAMILY.index(side.axis)
    found[-1] = -1
    return found


def _unique(ends: Int, family: Int) -> tuple[Int, Int]:
    """Edges (m, 2) that each occur once, and the largest of the families they have."""
    edges, same = np.unique(np.sort(ends, axis=1), axis=0, return_inverse=True)
    largest = np.full(len(edges), -1)
    np.maximum.at(largest, same.ravel(), family)
    return edges, largest


def _first(glued: Glued, values: NDArray) -> NDArray:
    """The value of each welded node in the module."""
    found = np.empty((glued.vertex_count, *values.shape[1:]), dtype=values.dtype)
    found[glued.members.ravel()[::-1]] = np.concatenate([values] * len(glued.members))[::-1]
    return found


def _characteristic(completion: Completion) -> int:
    faces = completion.mesh.faces
    sides = np.sort(np.stack([faces, np.roll(faces, -1, axis=1)], axis=2).reshape(-1, 2), axis=1)
    return completion.vertex_count - len(np.unique(sides, axis=0)) + len(faces)
