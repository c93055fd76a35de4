"""Copies of a mesh glued by adjacency: vertices become one where a seam joins them, never because they are near.

A copy is like the piece or turned over (its faces walk the other way round), as mirror images are.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from numpy.typing import ArrayLike, NDArray
from scipy.sparse.csgraph import connected_components

from ..errors import MeshError, plural
from .domain import Domain

Int = NDArray[np.integer]


@dataclass(frozen=True, eq=False)
class Glued:
    """A mesh of K copies of a piece with n vertices and F faces.

    faces: (K F, 3), copy after copy. members: (K, n) the glued vertex of each vertex of each copy, numbered in order of
    first appearance. vertex_count: the number of glued vertices. corners: (K F, 3) the corner `3 f + k` of the piece
    at each corner. copies: (K F,) the copy each face belongs to.
    """

    faces: NDArray[np.int32]
    members: NDArray[np.int64]
    vertex_count: int
    corners: NDArray[np.int32]
    copies: NDArray[np.int32]

    def mean(self, values: NDArray[np.float64]) -> NDArray[np.float64]:
        """The mean (vertex_count, d) of `values` (K, n, d) over the members of each glued vertex."""
        flat = self.members.ravel()
        table = values.reshape(len(flat), -1)
        sums = np.stack([np.bincount(flat, column, self.vertex_count) for column in table.T], axis=1)
        return sums / np.bincount(flat, minlength=self.vertex_count)[:, None]


def glue(faces: ArrayLike, count: int, flipped: ArrayLike, joins: ArrayLike) -> Glued:
    """Copies of the triangles `faces` (F, 3) on `count` vertices, those `flipped` (K,) turned over.

    joins: (m, 4), each (copy, vertex, copy, vertex): these two become one. Joins need no order and may repeat.
    """
    piece = np.asarray(faces, dtype=np.int64)
    turned = np.asarray(flipped, dtype=bool)
    k, a, other, b = np.asarray(joins, dtype=np.int64).reshape(-1, 4).T
    total = len(turned) * count
    links = sp.coo_array((np.ones(len(k), dtype=np.int8), (k * count + a, other * count + b)), (total, total))
    labels = connected_components(sp.csr_array(links), directed=False)[1]
    _, first, same = np.unique(labels, return_index=True, return_inverse=True)
    rank = np.empty(len(first), dtype=np.int64)
    rank[np.argsort(first)] = np.arange(len(first))
    members = rank[same].reshape(len(turned), count)
    corners = np.arange(3 * len(piece)).reshape(-1, 3)
    order = np.where(turned[:, None], [2, 1, 0], [0, 1, 2])
    every = corners[:, order].transpose(1, 0, 2).reshape(-1, 3)
    owner = np.repeat(np.arange(len(turned)), len(piece))
    glued = members[owner[:, None], piece.ravel()[every]]
    return Glued(glued.astype(np.int32), members, len(first), every.astype(np.int32), owner.astype(np.int32))


def check_glued(glued: Glued) -> None:
    """Raise `MeshError` where gluing folded a face or put more than two faces on an edge.

    `faces` and `vertices` of the error are numbered as in the piece.
    """
    faces = glued.faces
    folded = (faces == np.roll(faces, 1, axis=1)).any(axis=1)
    ends = np.sort(np.stack([faces[:, [1, 2, 0]], faces[:, [2, 0, 1]]], axis=2).reshape(-1, 2), axis=1)
    keys = ends[:, 0].astype(np.int64) * glued.vertex_count + ends[:, 1]
    _, same, count = np.unique(keys, return_inverse=True, return_counts=True)
    crowded = (count[same].reshape(-1, 3) > 2).any(axis=1)
    bad = np.unique(glued.corners[folded | crowded] // 3)
    if bad.size:
        raise MeshError(
            f"Glued along its sides, {plural('face', bad)} of the piece would fold onto others: an edge inside joins "
            "two vertices of one side; subdivide the mesh there.",
            faces=bad,
        )


def glued_domain(domain: Domain, flipped: ArrayLike, seams: Iterable[tuple[int, int, ArrayLike]]) -> Domain:
    """Copies of a domain glued along sides: seam (a, b, edges) joins these edges of copy a to the same of copy b.

    Of the two copies at a seam exactly one must be turned over. Edges keep their identity, so two may join the same
    two vertices. Vertices, faces and edges of copy 0 come first and keep their order.
    """
    turned = np.asarray(flipped, dtype=bool)
    seam_list = [(a, b, np.asarray(edges, dtype=np.int64)) for a, b, edges in seams]
    vertex_joins, edge_joins = [], []
    for a, b, edges in seam_list:
        ends = domain.edges[edges].ravel()
        for joined, into in ((ends, vertex_joins), (edges, edge_joins)):
            full = np.ones(len(joined), dtype=np.int64)
            into.append(np.column_stack([a * full, joined, b * full, joined]))
    empty = np.zeros((0, 4), dtype=np.int64)
    vertices = glue(domain.faces, domain.vertex_count, turned, np.concatenate([empty, *vertex_joins]))
    edges = glue(domain.face_edges, len(domain.edge_lengths), turned, np.concatenate([empty, *edge_joins]))
    lengths = domain.side_lengths.ravel()[vertices.corners]
    return Domain.from_edge_lengths(vertices.faces, lengths, face_edges=edges.faces)


def doubled(domain: Domain, edges: ArrayLike) -> Domain:
    """The domain and its mirror image, glued along boundary `edges` (K,); its own vertices come first."""
    return glued_domain(domain, [False, True], [(0, 1, edges)])
