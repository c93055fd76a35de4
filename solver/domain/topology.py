"""Homology: trees, loops and cuts for integrating closed forms on domains with holes or handles.

A form is one value an edge, the increment of a function on the faces: `value(left) - value(right)`. It is closed when
the increments around every interior vertex sum to zero. Then it has an integral on the cover of the domain; on the
domain itself, cut open along edges, the integral jumps by a period across each cut.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray
from scipy.sparse.csgraph import breadth_first_order

from .domain import Domain
from .trees import Tree

Array = NDArray[np.float64]
Int = NDArray[np.integer]


@dataclass(frozen=True)
class Homology:
    """Non-contractible loops, and a cut across each: `2 genus + loops - 1` of them (closed domains: `2 genus`).

    tree: of the faces; the fundamental domain.
    generators: (k,) one edge each; loop j crosses generator j from right to left and closes in the tree.
    crossings: (E, k) integers. When a closed form is integrated along the tree, the jump `form - (left - right)` across
        edge e is `crossings[e] @ periods`, which is zero off the cuts.
    """

    domain: Domain
    tree: Tree
    generators: Int
    crossings: NDArray[np.int8]

    @classmethod
    def of(cls, domain: Domain) -> Homology:
        """Generators and cuts of a domain, by a tree of faces and a tree of vertices that do not cross."""
        inside = domain.interior_edges
        tree = Tree.of(domain.edge_faces[inside], len(domain.faces))
        free = np.ones(len(domain.edges), dtype=bool)
        free[domain.boundary_edges] = False
        free[inside[tree.pair[tree.pair >= 0]]] = False
        candidates = np.flatnonzero(free)
        count = len(candidates) - domain.vertex_count + len(domain.boundary_vertices)
        if len(domain.boundary_edges) == 0:
            count += 1
        if count == 0:
            return cls(domain, tree, np.zeros(0, dtype=np.int64), np.zeros((len(domain.edges), 0), dtype=np.int8))
        primal = _PrimalTree.of(domain, candidates)
        generators = np.setdiff1d(candidates, primal.edge)
        return cls(domain, tree, generators, primal.crossings(domain, generators))

    @cached_property
    def is_trivial(self) -> bool:
        """Whether every closed form has an integral on the domain: a disc or a sphere."""
        return len(self.generators) == 0

    @cached_property
    def cut(self) -> Int:
        """Edges across which an integral may jump."""
        return np.flatnonzero(self.crossings.any(axis=1))

    def integrate(self, form: Array) -> Array:
        """Values (F, d) on the faces of the integral of `form` (E, d), along the tree."""
        return self.tree.integrate(form[self.domain.interior_edges])

    def periods(self, form: Array, values: Array) -> Array:
        """Jumps (k, d) of the `values` (F, d), integrated along the tree from `form` (E, d), at the generators."""
        left, right = self.domain.edge_faces[self.generators].T
        return form[self.generators] - (values[left] - values[right])

    @cached_property
    def loops(self) -> Int:
        """(E, k) how often each loop crosses an edge from right to left: `periods = loopsᵀ form`."""
        inside = self.domain.interior_edges
        loops = np.zeros((len(self.domain.edges), len(self.generators)), dtype=np.int64)
        for k, generator in enumerate(self.generators):
            loops[generator, k] = 1
            for face, side in zip(self.domain.edge_faces[generator].tolist(), (-1, 1), strict=True):
                pairs, signs = self.tree.climb(face)
                loops[inside[pairs], k] += side * signs.astype(np.int64)
        return loops

    @cached_property
    def sheets(self) -> CutSurface:
        """The domain cut open along `cut`."""
        return CutSurface.of(self)


@dataclass(frozen=True)
class _PrimalTree:
    """A spanning tree of the vertices along candidate edges, with the whole boundary as one node, the root."""

    parent: Int  # (V,), the vertex itself at a root
    edge: Int  # (V,), -1 at a root

    @classmethod
    def of(cls, domain: Domain, candidates: Int) -> _PrimalTree:
        n = domain.vertex_count
        node = np.arange(n)
        node[domain.boundary_vertices] = n if len(domain.boundary_vertices) else 0
        root = int(node[domain.boundary_vertices[0]]) if len(domain.boundary_vertices) else 0
        ends = node[domain.edges[candidates]]
        rows, cols = np.concatenate([ends[:, 0], ends[:, 1]]), np.concatenate([ends[:, 1], ends[:, 0]])
        adjacency = sp.csr_array((np.ones(rows.size), (rows, cols)), shape=(n + 1, n + 1))
        before = breadth_first_order(adjacency, root, directed=True)[1]
        parent, edge = node.copy(), np.full(n, -1)
        # the edge towards the parent: the last candidate that joins the two nodes
        for a, b in (ends.T, ends[:, ::-1].T):
            towards = before[a] == b
            edge[a[towards]] = candidates[towards]
        inner = np.flatnonzero(edge >= 0)
        i, j = domain.edges[edge[inner]].T
        parent[inner] = np.where(i == inner, j, i)
        return cls(parent, edge)

    def crossings(self, domain: Domain, generators: Int) -> NDArray[np.int8]:
        """Extend the unit jump of each generator along the tree so that jumps cancel around every interior vertex."""
        crossings = np.zeros((len(domain.edges), len(generators)), dtype=np.int8)
        for k, generator in enumerate(generators):
            crossings[generator, k] += 1
            tail, head = domain.edges[generator]
            for vertex, jump in ((tail, 1), (head, -1)):
                while (edge := self.edge[vertex]) >= 0:
                    outgoing = domain.edges[edge, 0] == vertex
                    crossings[edge, k] += -jump if outgoing else jump
                    vertex = self.parent[vertex]
        return crossings


@dataclass(frozen=True)
class CutSurface:
    """The domain cut open: n cut vertices, the V vertices and then their copies along the cuts.

    faces: (F, 3) cut vertices. source: (n,) the vertex of each cut vertex, the identity on the first V.
    offsets: (n, k) integers: `value(cut vertex) = value(source) + offsets @ periods`.
    """

    faces: NDArray[np.int32]
    source: NDArray[np.int32]
    offsets: Int

    @classmethod
    def of(cls, homology: Homology) -> CutSurface:
        domain = homology.domain
        joined = domain.edge_faces[:, 1] >= 0
        joined[homology.cut] = False
        classes = domain.corner_classes(joined)
        source = np.empty(classes.max() + 1, dtype=np.int64)
        source[classes.ravel()] = domain.faces.ravel()
        # cut vertices: the first class of every vertex, then the others
        order = np.lexsort((np.arange(len(source)), source))
        first = np.concatenate([[True], np.diff(source[order]) > 0])
        ordered = np.concatenate([order[first], order[~first]])
        number = np.empty_like(ordered)
        number[ordered] = np.arange(len(ordered))
        faces = number[classes]
        offsets = _offsets(homology, faces, len(source))
        return cls(faces.astype(np.int32), source[ordered].astype(np.int32), offsets)


def _next(corner: int) -> int:
    """The next corner of the face, counter-clockwise."""
    return corner - corner % 3 + (corner + 1) % 3


def _offsets(homology: Homology, faces: Int, count: int) -> Int:
    """Walk across the cuts around each vertex, from its first cut vertex: left is right minus the crossing."""
    domain = homology.domain
    cut_vertex_of_corner = faces.ravel().tolist()
    steps: dict[int, list[tuple[int, NDArray]]] = {}
    for e in homology.cut:
        crossing = homology.crossings[e].astype(np.int64)
        left, right = domain.half_edges[e].tolist()
        # by corners, as a face may repeat a vertex: the start of the left side is the end of the right one
        for left_corner, right_corner in ((_next(left), _next(_next(right))), (_next(_next(left)), _next(right))):
            a, b = cut_vertex_of_corner[left_corner], cut_vertex_of_corner[right_corner]
            steps.setdefault(b, []).append((a, -crossing))
            steps.setdefault(a, []).append((b, crossing))
    offsets = np.zeros((count, len(homology.generators)), dtype=np.int64)
    waiting = [vertex for vertex in steps if vertex < domain.vertex_count]
    seen = set(waiting)
    while waiting:
        vertex = waiting.pop()
        for other, step in steps[vertex]:
            if other not in seen:
                seen.add(other)
                offsets[other] = offsets[vertex] + step
                waiting.append(other)
    return offsets
