"""The boundary edges of a job's condition: a loop, a side, a named group, or a list."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from ..domain.domain import Domain
from ..errors import CmcError, suggestion
from ..gauss.conditions import KINDS
from ..io.obj import MeshData, same_name
from ..limits import shown
from .tables import INTEGERS, Table

Pairs = NDArray[np.integer]

_PARAMETERS = [parameter.name for kind in KINDS.values() for parameter in kind.parameters] + ["curve"]
WAYS = ("loop", "side", "group", "edges", "vertices")


def select(table: Table, domain: Domain, mesh: MeshData, sides: Mapping[str, Pairs]) -> tuple[str, Pairs]:
    """Name and edges (K, 2), vertex pairs, of a condition's table, which must have one of `WAYS`.

    loop: number of a boundary loop, the longest one is 0. side: a side of a shape. group: a polyline group of the mesh
    file, else the boundary edges of the faces in a group, object or material of that name. edges: vertex pairs.
    vertices: the boundary edges with both ends in the list. Raises `JobError`.
    """
    given = [way for way in WAYS if way in table]
    if len(given) != 1:
        if not given:
            table.finish([*WAYS, "kind", *_PARAMETERS])  # a misspelt one
        what = " and ".join(f'"{way}"' for way in given) or "none"
        raise table.fail(f"a condition needs one of {', '.join(WAYS)} for its edges; it has {what}.")
    way = given[0]
    pairs = _SELECTORS[way](table, domain, mesh, sides)
    table.known.extend(WAYS)
    named = table.data[way] if way in ("loop", "side", "group") else f"of {table.name}"
    return f"{way} {named}", pairs


def loops_by_length(domain: Domain) -> list[NDArray[np.int32]]:
    """Edges of the boundary loops, the longest loop first."""
    loops = domain.boundary_loop_edges
    lengths = [domain.edge_lengths[edges].sum() for edges in loops]
    return [loops[k] for k in np.argsort(-np.array(lengths), kind="stable")]


def _loop(table: Table, domain: Domain, mesh: MeshData, sides: Mapping[str, Pairs]) -> Pairs:
    number, loops = table.integer("loop"), loops_by_length(domain)
    if not 0 <= number < len(loops):
        raise table.fail(f"there is no boundary loop {number}; there are {len(loops)}, the longest is loop 0.")
    return domain.edges[loops[number]]


def _side(table: Table, domain: Domain, mesh: MeshData, sides: Mapping[str, Pairs]) -> Pairs:
    name = table.text("side")
    if not sides:
        raise table.fail('only shapes have sides; on a mesh file use "loop", "group", "edges" or "vertices".')
    if name not in sides:
        raise table.fail(f'there is no side "{name}"{suggestion(name, sides)}')
    return sides[name]


def _group(table: Table, domain: Domain, mesh: MeshData, sides: Mapping[str, Pairs]) -> Pairs:
    name = same_name(table.text("group"))
    if name in mesh.edge_groups:
        return mesh.edge_groups[name]
    for names in (mesh.groups, mesh.objects, mesh.materials):
        if name in names:
            return _boundary_of_polygons(
                domain, [p for p, owner in zip(mesh.polygons, names, strict=True) if owner == name]
            )
    known = dict.fromkeys([*mesh.edge_groups, *mesh.groups, *mesh.objects, *mesh.materials])
    known.pop("", None)
    if not known:
        raise table.fail(f'there is no group "{name}": the mesh has no named groups.')
    raise table.fail(f'there is no group "{name}" in the mesh{suggestion(name, known)}')


def _boundary_of_polygons(domain: Domain, polygons: list[NDArray[np.int32]]) -> Pairs:
    boundary = domain.edges[domain.boundary_edges]
    walked = np.concatenate([np.column_stack([p, np.roll(p, -1)]) for p in polygons])
    n = domain.vertex_count
    return boundary[
        np.isin(
            boundary[:, 0].astype(np.int64) * n + boundary[:, 1],
            walked[:, 0].astype(np.int64) * n + walked[:, 1],
        )
    ]


def _edges(table: Table, domain: Domain, mesh: MeshData, sides: Mapping[str, Pairs]) -> Pairs:
    rows = table.rows("edges", 2, "pairs of vertices, [[0, 1], [1, 2]]")
    return _from_file(table, mesh, _whole(table, "edges", rows))


def _vertices(table: Table, domain: Domain, mesh: MeshData, sides: Mapping[str, Pairs]) -> Pairs:
    value = table.data["vertices"]
    table.data = {**table.data, "vertices": [[item] for item in value] if isinstance(value, list) else value}
    listed = _from_file(table, mesh, _whole(table, "vertices", table.rows("vertices", 1, "vertices, [0, 1, 2]")))[:, 0]
    boundary = domain.edges[domain.boundary_edges]
    chosen = boundary[np.isin(boundary, listed).all(axis=1)]
    if not len(chosen):
        raise table.fail("no boundary edge has both ends among these vertices.")
    return chosen


def _from_file(table: Table, mesh: MeshData, numbers: Pairs) -> Pairs:
    """Vertices of the plan by their numbers in the file, where these differ."""
    try:
        return mesh.from_file(numbers) if len(mesh.vertex_of) else numbers
    except CmcError as error:
        raise table.fail(str(error)) from error


def _whole(table: Table, key: str, numbers: NDArray[np.float64]) -> Pairs:
    if not (np.array_equal(numbers, np.round(numbers)) and (np.abs(numbers) <= INTEGERS.most).all()):
        raise table.fail(f'"{key}" must be whole numbers of at most {shown(INTEGERS.most)}.')
    return numbers.astype(np.int64)


_SELECTORS = {"loop": _loop, "side": _side, "group": _group, "edges": _edges, "vertices": _vertices}
