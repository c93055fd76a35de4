"""A domain cut open so that √q has one sign: paths between boundary loops, and from each odd zero to the boundary.

Paths have no vertex in common, so that the cut domain is a disc. Across a path w changes by `w_right = σ w_left + c`
with σ = ±1; at the path of a zero p, w_right = -w_left + 2 w_p.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray
from scipy.sparse.csgraph import dijkstra

from ..domain.connectivity import after, before
from ..domain.domain import Domain
from ..domain.trees import Tree
from ..errors import MeshError
from .hopf import HopfDifferential
from .sheets import layout

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
Int = NDArray[np.integer]


@dataclass(frozen=True, eq=False)
class CutDomain:
    """The cut domain, and how w at its n cut vertices follows from w at the V vertices and c of the k loop paths.

    faces: (F, 3) cut vertices. source, same: (n,) the vertex of each cut vertex, and ±1, how w follows that there.
    transfer: (n, V + k), `w = transfer @ unknowns`. signs: (k,) σ of the loop paths.
    omega: (F, 3) the increments ±√q z along the half-edges `3 f + k`, with one sign on the cut domain.
    zeros: the vertices of odd zeros. translation: (V + k,) how the unknowns change when w grows by 1 everywhere.
    """

    domain: Domain
    faces: NDArray[np.int32]
    source: NDArray[np.int64]
    same: Array
    transfer: sp.csr_array
    signs: NDArray[np.int64]
    omega: Complex
    zeros: NDArray[np.int64]

    @property
    def translation(self) -> Array:
        """(V + k,)"""
        return np.concatenate([np.ones(self.domain.vertex_count), 1.0 - self.signs])


def cut_domain(hopf: HopfDifferential) -> CutDomain:
    """Cut the domain of a Hopf differential. Raises `MeshError` where there is no room for a path."""
    domain = hopf.domain
    zeros = np.flatnonzero(hopf.vertex_orders % 2)
    paths, edges = _paths(domain, zeros)
    loops = len(paths) - len(zeros)
    on_cut = np.zeros(len(domain.edge_lengths), dtype=bool)
    on_cut[np.concatenate([*edges, np.zeros(0, dtype=np.int64)]).astype(np.int64)] = True
    omega, signs = _combed(domain, hopf.at_faces, on_cut)
    classes = domain.corner_classes(~on_cut & (domain.edge_faces[:, 1] >= 0))
    source = np.zeros(int(classes.max()) + 1, dtype=np.int64)
    source[classes.ravel()] = domain.faces.ravel()
    # w at a cut vertex is `same` times that at its vertex, and on the right of a path `factor` times unknown `other`
    same, factor, other = np.ones(len(source)), np.ones(len(source)), np.full(len(source), -1)
    for number, (path, along) in enumerate(zip(paths, edges, strict=True)):
        right = _right_classes(domain, classes, path, along)
        if (signs[along] != signs[along[0]]).any():
            raise MeshError("The curvature lines cannot be combed on this mesh; refine it near the umbilics.")
        if number < loops:
            same[right], other[right] = signs[along[0]], domain.vertex_count + number
        else:
            right = right[1:]  # the zero itself has one value
            same[right], other[right], factor[right] = -1.0, path[0], 2.0
    across = np.array([signs[along[0]] for along in edges[:loops]], dtype=np.int64)
    transfer = _transfer(source, same, other, factor, domain.vertex_count + loops)
    return CutDomain(domain, classes, source, same, transfer, across, omega, zeros)


def _transfer(source: Int, same: Array, other: Int, factor: Array, count: int) -> sp.csr_array:
    """(n, count) with `same` at the `source` of each row and `factor` at its `other` column, -1 for none."""
    every, moved = np.arange(len(source)), np.flatnonzero(other >= 0)
    rows, cols = np.concatenate([every, moved]), np.concatenate([source, other[moved]])
    data = np.concatenate([same, factor[moved]])
    return sp.csr_array(sp.coo_array((data, (rows, cols)), shape=(len(source), count)))


def _right_classes(domain: Domain, classes: Int, path: Int, edges: Int) -> Int:
    """The cut vertices along a path of vertices (m + 1,) and edges (m,), on its right side."""
    forward = domain.edges[edges, 0] == path[:-1]
    half = np.where(forward, domain.half_edges[edges, 1], domain.half_edges[edges, 0])
    corner = classes.ravel()
    # the half-edge in the face on the right runs backwards: it starts at the head
    return np.concatenate([corner[before(half)], corner[after(half)][-1:]])


def _combed(domain: Domain, q: Complex, on_cut: NDArray[np.bool_]) -> tuple[Complex, NDArray[np.int64]]:
    """±√q z (F, 3) of one sign along a tree of faces that does not cross the cut, and the signs (E,) across edges."""
    z = layout(domain)
    omega = np.sqrt(q)[:, None] * (z[:, [2, 0, 1]] - z[:, [1, 2, 0]])
    left, right = domain.half_edges.T
    flat = omega.ravel()
    agree = np.where((flat[left] * -flat[np.maximum(right, 0)].conj()).real >= 0.0, 0.0, 1.0)
    tree_edges = np.flatnonzero(~on_cut & (right >= 0))
    tree = Tree.of(domain.edge_faces[tree_edges], len(domain.faces))
    # parity along the tree: the sign of a face differs from its parent's where √q does
    steps = np.where(tree.pair >= 0, agree[tree_edges[tree.pair]], 0.0)
    parity = tree.accumulated(steps)
    sign = 1.0 - 2.0 * (np.rint(parity) % 2)
    faces = domain.edge_faces
    across = sign[faces[:, 0]] * sign[np.maximum(faces[:, 1], 0)] * (1.0 - 2.0 * agree)
    across = np.where(right >= 0, across, 1.0).astype(np.int64)
    if (across[tree_edges] < 0).any():
        raise MeshError("The curvature lines cannot be combed on this mesh; refine it near the umbilics.")
    return omega * sign[:, None], across


def _paths(domain: Domain, zeros: Int) -> tuple[list[Int], list[Int]]:
    """Vertices and edges of the paths that join the boundary loops, then of those from each zero to the boundary."""
    graph = _Ways(domain, zeros)
    paths, edges = [], []
    loop_of = np.full(domain.vertex_count, -1)
    for number, loop in enumerate(domain.boundary_loops):
        loop_of[loop] = number
    joined = {int(np.argmax([len(loop) for loop in domain.boundary_loops]))}
    while len(joined) < len(domain.boundary_loops):
        reached = np.isin(loop_of, list(joined))
        path, along = graph.shortest(np.flatnonzero(reached), (loop_of >= 0) & ~reached)
        joined.add(int(loop_of[path[-1]]))
        paths.append(path)
        edges.append(along)
    for zero in zeros:
        path, along = graph.shortest(np.array([zero]), loop_of >= 0)
        paths.append(path)
        edges.append(along)
    return paths, edges


class _Ways:
    """Edges inside the domain on which paths may still run; `used` vertices, zeros among them, are avoided."""

    def __init__(self, domain: Domain, zeros: Int) -> None:
        self.domain = domain
        self.used = np.zeros(domain.vertex_count, dtype=bool)
        self.used[zeros] = True
        self.inside = domain.interior_edges
        self.on_rim = np.zeros(domain.vertex_count, dtype=bool)
        self.on_rim[domain.boundary_vertices] = True
        a, b = domain.edges[self.inside].T
        n = domain.vertex_count
        pairs = zip(np.minimum(a, b).tolist(), np.maximum(a, b).tolist(), strict=True)
        self.number = dict(zip(pairs, self.inside.tolist(), strict=True))
        self.ends = np.concatenate([a, b]), np.concatenate([b, a])
        self.lengths = np.tile(domain.edge_lengths[self.inside], 2)
        self.n = n

    def shortest(self, sources: Int, is_target: NDArray[np.bool_]) -> tuple[Int, Int]:
        """The shortest path from one of the sources to a target, whose vertices are used from then on."""
        start, end = self.ends
        is_source = np.zeros(self.n, dtype=bool)
        is_source[sources] = True
        single = len(sources) == 1
        is_source &= ~self.used | single
        # paths leave the boundary at sources only, and end where they reach it
        open_edge = (is_source[start] | ~(self.used | self.on_rim)[start]) & ~self.used[end]
        graph = sp.csr_array((self.lengths[open_edge], (start[open_edge], end[open_edge])), shape=(self.n, self.n))
        distance, previous, _ = dijkstra(
            graph, indices=np.flatnonzero(is_source), min_only=True, return_predecessors=True
        )
        targets = np.flatnonzero(is_target & ~self.used & np.isfinite(distance) & ~is_source)
        if not targets.size:
            raise MeshError(
                "The mesh is too coarse for curvature lines: there is no room to cut it between its umbilics and "
                "loops; refine it."
            )
        path = [int(targets[np.argmin(distance[targets])])]
        while not is_source[path[-1]]:
            path.append(int(previous[path[-1]]))
        path.reverse()
        self.used[path] = True
        edges = [self.number[min(i, j), max(i, j)] for i, j in pairwise(path)]
        return np.array(path), np.array(edges)
