"""Edges from faces, and the checks that a mesh is a surface.

A half-edge is the side of a face opposite one of its corners: half-edge `3 f + k` is opposite corner `k` of face `f`
and runs counter-clockwise, from `faces[f, k + 1]` to `faces[f, k + 2]`.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import scipy.sparse as sp
from numpy.typing import ArrayLike, NDArray
from scipy.sparse.csgraph import connected_components

from ..errors import MeshError, listed, plural
from ..linalg import reach_of_place, same_places

Int = NDArray[np.int32]


class Edges(NamedTuple):
    """The edges of a mesh; see `Domain` for the first three arrays.

    half_edges: (E, 2) the left and the right half-edge of each edge, -1 outside.
    """

    face_edges: Int
    edges: Int
    edge_faces: Int
    half_edges: Int


def as_faces(faces: ArrayLike) -> Int:
    """Triangles as an (F, 3) int32 array of vertex indices; `MeshError` on other shapes and negative indices."""
    try:
        array = np.asarray(faces)
    except ValueError:
        raise MeshError("Faces must be an (F, 3) array of triangles; some have more corners than others.") from None
    if array.size == 0:
        raise MeshError("The mesh has no faces; fill the outline with faces first.")
    if array.ndim != 2 or array.shape[1] != 3:
        raise MeshError(f"Faces must be an (F, 3) array of triangles, not one of shape {array.shape}.")
    if not np.issubdtype(array.dtype, np.integer):
        raise MeshError(f"Faces must hold integers, not {array.dtype}.")
    if array.min() < 0:
        bad = np.flatnonzero((array < 0).any(axis=1))
        raise MeshError(f"{_cap(plural('face', bad))} refer to a negative vertex index.", faces=bad)
    return np.ascontiguousarray(array, dtype=np.int32)


def check_faces(faces: Int, vertex_count: int) -> None:
    """Raise `MeshError` on indices out of range, repeated vertices of a face, repeated faces and loose vertices."""
    bad = np.flatnonzero((faces >= vertex_count).any(axis=1))
    if bad.size:
        index = int(faces[bad[0]].max())
        raise MeshError(
            f"Face {bad[0]} refers to vertex {index}, but there are only {vertex_count} vertices"
            + (f" (faces out of range: {listed(bad)})." if bad.size > 1 else "."),
            faces=bad,
        )
    repeats = (faces == np.roll(faces, 1, axis=1)).any(axis=1)
    bad = np.flatnonzero(repeats)
    if bad.size:
        raise MeshError(
            f"{_cap(plural('face', bad))} repeat a vertex and have no area; dissolve degenerate faces.",
            faces=bad,
            vertices=np.unique(faces[bad]),
        )
    bad = _repeated_faces(faces, vertex_count)
    if bad.size:
        raise MeshError(
            f"{_cap(plural('face', bad))} have the same vertices; delete the repeated faces.", faces=bad
        )
    unused = np.flatnonzero(np.bincount(faces.ravel(), minlength=vertex_count) == 0)
    if unused.size:
        raise MeshError(
            f"{_cap(plural('vertex', unused))} {_belong(unused)} to no face; delete loose vertices.",
            vertices=unused,
        )


def _repeated_faces(faces: Int, vertex_count: int) -> NDArray[np.int64]:
    # equal faces have equal sums of hashes; the exact, slower comparison runs only if some sums agree
    hashes = np.random.default_rng(0).integers(0, 2**62, vertex_count, dtype=np.uint64)
    sums = np.sort(hashes[faces].sum(axis=1))
    if (sums[1:] != sums[:-1]).all():
        return np.zeros(0, dtype=np.int64)
    _, inverse, counts = np.unique(np.sort(faces, axis=1), axis=0, return_inverse=True, return_counts=True)
    return np.flatnonzero(counts[inverse.ravel()] > 1)


def edges_by_vertex_pairs(faces: Int, vertex_count: int) -> Int:
    """`face_edges` (F, 3): half-edges that join the same two vertices share an edge."""
    start, end = half_edge_vertices(faces)
    low, high = np.minimum(start, end).astype(np.int64), np.maximum(start, end)
    inverse = np.unique(low * vertex_count + high, return_inverse=True)[1]
    return inverse.reshape(-1, 3).astype(np.int32)


def half_edge_vertices(faces: Int) -> tuple[Int, Int]:
    """Start and end vertex of every half-edge, (3 F,) each."""
    return faces[:, [1, 2, 0]].ravel(), faces[:, [2, 0, 1]].ravel()


def pair_half_edges(faces: Int, face_edges: Int) -> Edges:
    """The two sides of every edge; `MeshError` on a third face, and on two that walk it in the same direction."""
    sides = face_edges.ravel()
    counts = np.bincount(sides)
    order = np.argsort(sides, kind="stable")
    first_slot = np.concatenate([[0], np.cumsum(counts)[:-1]])
    start, end = half_edge_vertices(faces)

    crowded = np.flatnonzero(counts > 2)
    if crowded.size:
        h = order[first_slot[crowded[0]]]
        raise MeshError(
            f"{_cap(plural('edge', crowded))} {_have(crowded)} more than two faces (edge {crowded[0]}: vertices "
            f"{start[h]}, {end[h]}; {counts[crowded[0]]} faces); split it, or delete the extra faces.",
            edges=crowded,
            vertices=np.unique(np.concatenate([start[np.isin(sides, crowded)], end[np.isin(sides, crowded)]])),
        )
    left = order[first_slot]
    interior = np.flatnonzero(counts == 2)
    right = np.full(counts.size, -1, dtype=np.int64)
    right[interior] = order[first_slot[interior] + 1]
    _check_opposite(faces, start, end, left, right, interior)
    edges = np.stack([start[left], end[left]], axis=1).astype(np.int32)
    half_edges = np.stack([left, right], axis=1).astype(np.int32)
    return Edges(face_edges.astype(np.int32), edges, half_edges // 3, half_edges)


def _check_opposite(faces: Int, start: Int, end: Int, left: NDArray, right: NDArray, interior: NDArray) -> None:
    """Raise `MeshError` unless the two faces of each edge walk it in opposite directions."""
    first, second = left[interior], right[interior]
    opposite = (start[first] == end[second]) & (end[first] == start[second])
    if opposite.all():
        return
    bad = interior[~opposite]
    joined = (start[first] == start[second]) & (end[first] == end[second])
    if not (opposite | joined).all():
        e = interior[~(opposite | joined)]
        raise MeshError(f"{_cap(plural('edge', e))} join different vertices in their two faces.", edges=e)
    turned = _turned(len(faces), first // 3, second // 3, opposite)
    if turned is not None:
        raise MeshError(
            f"{_cap(plural('face', turned))} {_have(turned)} the other orientation than the rest of the mesh; "
            "recalculate the normals.",
            edges=bad,
            faces=turned,
        )
    involved = np.unique(np.stack([first[~opposite] // 3, second[~opposite] // 3]))
    a, b = start[left[bad[0]]], end[left[bad[0]]]
    raise MeshError(
        f"The mesh is one-sided, like a Möbius strip: no choice of normals is consistent across {plural('edge', bad)} "
        f"(the first joins vertices {a}, {b}; {plural('face', involved)}); cut the strip open, or untwist it.",
        edges=bad,
        faces=involved,
    )


def _turned(face_count: int, left: NDArray, right: NDArray, opposite: NDArray) -> NDArray[np.int64] | None:
    """The faces to turn, the smaller part of each component; None if the mesh is one-sided.

    On the orientation cover the two sides of a face are apart, unless the mesh is one-sided.
    """
    shift = np.where(opposite, 0, face_count)
    rows = np.concatenate([left, left + face_count])
    cols = np.concatenate([right + shift, right + face_count - shift])
    cover = sp.coo_array((np.ones(rows.size), (rows, cols)), shape=(2 * face_count, 2 * face_count))
    labels = connected_components(cover, directed=False)[1]
    front, back = labels[:face_count], labels[face_count:]
    if (front == back).any():
        return None
    sizes = np.bincount(front, minlength=labels.max() + 1)
    fewer = sizes[front] < sizes[back]
    return np.flatnonzero(fewer | ((sizes[front] == sizes[back]) & (front > back)))


def check_surface(faces: Int, mesh: Edges, vertex_count: int, positions: NDArray | None = None) -> None:
    """Raise `MeshError` on vertices where several sheets touch, and on several components.

    positions (V, 2|3) tell components that coincide along their edges from those that are apart.
    """
    interior = mesh.edge_faces[:, 1] >= 0
    left, right = mesh.edge_faces[interior].T
    graph = sp.coo_array((np.ones(left.size), (left, right)), shape=(len(faces), len(faces)))
    count, labels = connected_components(graph, directed=False)
    if count > 1 and positions is not None:
        _check_contact(faces, count, labels, positions)
    if count > 1:
        sizes = np.bincount(labels)
        smallest = np.flatnonzero(labels == np.argmin(sizes))
        raise MeshError(
            f"The mesh has {count} components, of {listed(np.sort(sizes)[::-1])} triangles; solve them one by one "
            f"(separate by loose parts), or delete the smallest ({plural('face', smallest)}).",
            faces=smallest,
        )
    fans = np.bincount(_fan_vertices(faces, mesh), minlength=vertex_count)
    pinched = np.flatnonzero(fans > 1)
    if pinched.size:
        raise MeshError(
            f"{_cap(plural('vertex', pinched))} {'joins' if pinched.size == 1 else 'join'} parts of "
            "the mesh that share no edge there; split the vertex, or widen the neck.",
            vertices=pinched,
        )


def _check_contact(faces: Int, count: int, labels: NDArray, positions: NDArray) -> None:
    """Raise `MeshError` where components have vertices in the same places, but not in common."""
    place = same_places(positions, reach_of_place(positions))
    pairs = np.unique(np.column_stack([place[faces].ravel(), np.repeat(labels, 3)]), axis=0)
    shared, times = np.unique(pairs[:, 0], return_counts=True)
    touching = np.flatnonzero(np.isin(place, shared[times > 1]))
    if len(touching) == (times > 1).sum():  # each is one vertex already
        return
    start, end = half_edge_vertices(place[faces].astype(np.int32))
    sides = np.unique(
        np.column_stack([np.minimum(start, end), np.maximum(start, end), np.repeat(labels, 3)]), axis=0
    )
    edges_meet = (np.diff(sides[:, :2], axis=0) == 0).all(axis=1).any()
    way_out = "merge them by distance"
    if not edges_meet:
        way_out = "split the longer of their edges there at the ends of the shorter ones, then merge by distance"
    raise MeshError(
        f"The mesh has {count} components that touch: {plural('vertex', touching)} lie where another one has a vertex, "
        f"too; {way_out}.",
        vertices=touching,
    )


def _fan_vertices(faces: Int, mesh: Edges) -> Int:
    """The vertex of each fan of faces."""
    labels = corner_classes(faces, mesh, mesh.edge_faces[:, 1] >= 0)
    vertex_of_class = np.empty(labels.max() + 1, dtype=np.int32)
    vertex_of_class[labels.ravel()] = faces.ravel()
    return vertex_of_class


def corner_classes(faces: Int, mesh: Edges, joined: NDArray[np.bool_]) -> Int:
    """Classes (F, 3) of corners of a vertex that are connected across the `joined` (E,) interior edges.

    With all interior edges joined, each vertex of a surface is one class; without the edges of a cut, each vertex of
    the cut surface is one.
    """
    left, right = mesh.half_edges[joined].T
    # the corner at the start of the left half-edge meets the corner at the end of the right one, and vice versa
    rows = np.concatenate([after(left), before(left)])
    cols = np.concatenate([before(right), after(right)])
    graph = sp.coo_array((np.ones(rows.size), (rows, cols)), shape=(faces.size, faces.size))
    return connected_components(graph, directed=False)[1].reshape(-1, 3).astype(np.int32)


def after(corners: NDArray) -> NDArray:
    """The next corner `3 f + k` of the same face; of a half-edge, the corner where it starts."""
    return corners - corners % 3 + (corners + 1) % 3


def before(corners: NDArray) -> NDArray:
    """The previous corner of the same face; of a half-edge, the corner where it ends."""
    return corners - corners % 3 + (corners + 2) % 3


def boundary_loops(mesh: Edges) -> tuple[list[Int], list[Int]]:
    """Closed boundary walks, the surface on the left: the vertices of each, and its edges (edge k starts at vertex k).

    A loop starts at its smallest vertex; loops are sorted by it.
    """
    boundary = np.flatnonzero(mesh.edge_faces[:, 1] < 0)
    start = mesh.edges[boundary, 0]
    leaving = dict(zip(start.tolist(), boundary.tolist(), strict=True))
    loops: list[Int] = []
    loop_edges: list[Int] = []
    for first in np.sort(start).tolist():
        vertices, edges = [], []
        vertex = first
        while vertex in leaving:
            edge = leaving.pop(vertex)
            vertices.append(vertex)
            edges.append(edge)
            vertex = int(mesh.edges[edge, 1])
        if vertices:
            loops.append(np.array(vertices, dtype=np.int32))
            loop_edges.append(np.array(edges, dtype=np.int32))
    return loops, loop_edges


def _cap(text: str) -> str:
    return text[0].upper() + text[1:]


def _have(items: NDArray) -> str:
    return "has" if len(items) == 1 else "have"


def _belong(items: NDArray) -> str:
    return "belongs" if len(items) == 1 else "belong"
