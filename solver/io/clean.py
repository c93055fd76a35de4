"""From the faces of a file to a surface: vertices in one place merged, unused ones and faces without area left out."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import KDTree

from ..errors import MeshError, listed, plural
from ..linalg import out_of_range, reach_of_place, same_places
from ..notes import Note
from .obj import MeshData

Int = NDArray[np.int64]


def clean(mesh: MeshData, *, weld: bool = False) -> MeshData:
    """The mesh with one vertex in each place where needed, and without vertices and faces that have no part in it.

    Coinciding vertices are merged with `weld`, and where the faces fall into parts that join when they are merged. A
    corner named twice running counts once; a face of fewer than three corners is left out. Polylines whose vertices
    are in no face take those in the same places. Raises `MeshError` on indices out of range, and on coordinates of
    used vertices that are not finite.
    """
    sizes = np.array([len(polygon) for polygon in mesh.polygons], dtype=np.int64)
    flat = np.concatenate([np.zeros(0, dtype=np.int64), *mesh.polygons]).astype(np.int64)
    used = _used(mesh, flat, sizes)
    reach = reach_of_place(mesh.positions[used])
    place, notes = _places(mesh, flat, sizes, used, reach, weld)
    mesh = _without_repeats(replace(mesh, notes=[*mesh.notes, *notes]), place, flat, sizes)
    kept = np.unique(np.concatenate([np.zeros(0, dtype=np.int64), *mesh.polygons]).astype(np.int64))
    if len(kept) == len(mesh.positions):
        return mesh
    vertex_of = np.full(len(mesh.positions), -1)
    vertex_of[kept] = np.arange(len(kept))
    vertex_of = vertex_of[place]
    _place_loose(mesh, vertex_of, kept, reach)
    groups, notes = _moved_groups(mesh, vertex_of)
    return replace(
        mesh,
        positions=mesh.positions[kept],
        polygons=[vertex_of[polygon].astype(np.int32) for polygon in mesh.polygons],
        edge_groups=groups,
        vertex_of=vertex_of,
        notes=mesh.notes + notes,
    )


def _used(mesh: MeshData, flat: Int, sizes: Int) -> Int:
    """The vertices of faces, sorted."""
    count = len(mesh.positions)
    outside = np.flatnonzero((flat < 0) | (flat >= count))
    if outside.size:
        face = int(np.searchsorted(np.cumsum(sizes), outside[0], side="right"))
        raise MeshError(f"face {face} has vertex {flat[outside[0]]}, but there are {count}, counted from 0.")
    used = np.unique(flat)
    bad, what = out_of_range(mesh.positions[used])
    if bad.size:
        raise MeshError(f"the position of {plural('vertex', used[bad])} is {what}; repair or delete it.")
    return used


def _places(
    mesh: MeshData, flat: Int, sizes: Int, used: Int, reach: float, weld: bool
) -> tuple[Int, list[Note]]:
    """The vertex that stands for each, and a note where vertices are merged to join parts."""
    place = np.arange(len(mesh.positions))
    parts = 1 if weld else _part_count(flat, sizes)
    if not weld and parts == 1:
        return place, []
    place[used] = used[same_places(mesh.positions[used], reach)]
    if weld:
        return place, []
    joined = _part_count(place[flat], sizes)
    if joined == parts:
        return np.arange(len(mesh.positions)), []
    merged = int((place != np.arange(len(place))).sum())
    text = f"{parts} parts of the mesh coincide along their edges; {merged} vertices were merged, which makes {joined}."
    return place, [Note("merged", text)]


def _part_count(flat: Int, sizes: Int) -> int:
    """The number of parts of polygons joined across edges."""
    if not len(sizes):
        return 0
    owner = np.repeat(np.arange(len(sizes)), sizes)
    after = np.arange(1, len(flat) + 1)
    after[np.cumsum(sizes) - 1] = np.cumsum(sizes) - sizes
    ends = np.sort(np.column_stack([flat, flat[after]]), axis=1)
    solid = ends[:, 0] != ends[:, 1]
    _, edge = np.unique(ends[solid] @ [int(flat.max()) + 1, 1], return_inverse=True)
    count = len(sizes) + int(edge.max(initial=-1)) + 1
    graph = coo_array((np.ones(len(edge)), (owner[solid], len(sizes) + edge.ravel())), shape=(count, count))
    return int(connected_components(graph, directed=False)[0])


def _without_repeats(mesh: MeshData, place: Int, flat: Int, sizes: Int) -> MeshData:
    """The polygons on their places, a corner that repeats the one before left out, and polygons of two corners, too."""
    corners = place[flat]
    ends = np.cumsum(sizes)
    if not len(ends):
        return mesh
    before = np.concatenate([[0], corners[:-1]])
    before[ends - sizes] = corners[ends - 1]
    new = corners != before
    polygons = list(np.split(corners.astype(np.int32), ends[:-1]))
    uvs = list(mesh.uv_corners)
    for index in np.unique(np.searchsorted(ends, np.flatnonzero(~new), side="right")).tolist():
        keep = new[ends[index] - sizes[index] : ends[index]]
        polygons[index] = polygons[index][keep]
        if index < len(uvs) and len(uvs[index]):
            uvs[index] = uvs[index][keep]
    left = [index for index, polygon in enumerate(polygons) if len(polygon) > 2]
    mesh = replace(mesh, polygons=polygons, uv_corners=uvs)
    if len(left) == len(polygons):
        return mesh
    gone = np.setdiff1d(np.arange(len(polygons)), left)
    note = Note("left-out", f"Left out of the mesh, since they have no area: {plural('face', gone)}.")
    lists = {
        name: [values[index] for index in left] if (values := getattr(mesh, name)) else []
        for name in ("polygons", "uv_corners", "objects", "groups", "materials")
    }
    return replace(mesh, **lists, polygon_numbers=np.array(left, dtype=np.int64), notes=[*mesh.notes, note])


def _place_loose(mesh: MeshData, vertex_of: Int, kept: Int, reach: float) -> None:
    """Give the vertices of polylines that are in no face the vertex in the same place."""
    drawn = np.unique(np.concatenate([np.zeros((0, 2), dtype=np.int64), *mesh.edge_groups.values()]).astype(np.int64))
    loose = drawn[vertex_of[drawn] < 0]
    if len(loose) and len(kept):
        far, nearest = KDTree(mesh.positions[kept]).query(mesh.positions[loose], distance_upper_bound=2.0 * reach)
        near = np.isfinite(far)
        vertex_of[loose[near]] = np.asarray(nearest)[near]


def _moved_groups(mesh: MeshData, vertex_of: Int) -> tuple[dict[str, NDArray[np.int32]], list[Note]]:
    """The polylines on their new vertices, and a note about segments that end beside the faces."""
    groups, notes = {}, []
    for name, pairs in mesh.edge_groups.items():
        moved = vertex_of[pairs]
        off = (moved < 0).any(axis=1)
        if off.any():
            count = int(off.sum())
            text = (
                f'The polyline group "{name}" has {count} segment{"s" * (count > 1)} with an end (vertices '
                f"{listed(np.unique(pairs[moved < 0]))}) where no face has a corner; they were left out."
            )
            notes.append(Note("left-out", text))
        moved = moved[~off & (moved[:, 0] != moved[:, 1])]
        if len(moved):
            groups[name] = moved.astype(np.int32)
    return groups, notes
