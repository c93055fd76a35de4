"""A coarse copy of a domain, to try things out on before they are done on the domain itself.

A few vertices are kept: some along each boundary loop, and inside an independent set of independent sets. Every vertex
belongs to the nearest kept one, along edges; the faces that touch three regions are the triangles between these (the
dual of a Voronoi diagram), with the shortest ways across as edge lengths. These are a few per cent off, which is near
enough to compare energies of several maps, not to report one.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray
from scipy.sparse.csgraph import dijkstra

from ..errors import MeshError
from .domain import Domain

Array = NDArray[np.float64]
Int = NDArray[np.integer]

# Kept vertices inside are at least this part of the coarse edge length away from those on the boundary.
_MARGIN = 1.0
# Ways along edges often lie on one line. Raised to a power below one they obey the triangle inequality strictly.
_BENT = 0.9
_DETOURS = 8


@dataclass(frozen=True, eq=False)
class Coarse:
    """A coarse domain; `vertices` (n,) of the fine one that it keeps, and for each fine vertex its `region` (V,)."""

    domain: Domain
    vertices: Int
    region: Int


def coarsened(domain: Domain, count: int) -> Coarse | None:
    """A copy of the domain with about `count` vertices; None where regions do not fit together as the domain does."""
    lengths = sp.csr_array(_symmetric(domain, domain.edge_lengths))
    edge = float(np.sqrt(domain.face_areas.sum() * 2.0 / np.sqrt(3.0) / count))
    rim = _along_loops(domain, edge)
    kept = np.concatenate([rim, _inside(lengths, rim, _MARGIN * edge, count)])
    distance, _, nearest = dijkstra(lengths, indices=kept, min_only=True, return_predecessors=True)
    place = np.full(domain.vertex_count, -1)
    place[kept] = np.arange(len(kept))
    region = place[nearest]
    faces = _between(region[domain.faces])
    try:
        coarse = Domain.from_edge_lengths(faces, _side_lengths(domain, faces, region, distance))
    except MeshError:
        return None
    fits = (coarse.genus, len(coarse.boundary_loops)) == (domain.genus, len(domain.boundary_loops))
    return Coarse(coarse, kept, region) if fits and coarse.vertex_count == len(kept) else None


def _symmetric(domain: Domain, values: Array) -> sp.coo_array:
    i, j = domain.edges.T
    n = domain.vertex_count
    return sp.coo_array((np.tile(values, 2), (np.concatenate([i, j]), np.concatenate([j, i]))), shape=(n, n))


def _along_loops(domain: Domain, edge: float) -> Int:
    """Vertices about `edge` apart along each boundary loop, at least three."""
    kept = [np.zeros(0, dtype=np.int64)]
    for loop, edges in zip(domain.boundary_loops, domain.boundary_loop_edges, strict=True):
        ends = np.cumsum(domain.edge_lengths[edges])
        parts = max(3, round(ends[-1] / edge))
        starts = ends - domain.edge_lengths[edges]
        places = np.searchsorted(starts, np.arange(parts) * (ends[-1] / parts) * (1.0 - 1e-12))
        kept.append(np.unique(loop[np.minimum(places, len(loop) - 1)]).astype(np.int64))
    return np.concatenate(kept)


def _inside(lengths: sp.csr_array, rim: Int, margin: float, count: int) -> Int:
    """Vertices away from the rim, thinned out to half to twice `count`: of neighbours one is kept, again and again."""
    n = len(lengths.indptr) - 1
    far = dijkstra(lengths, indices=rim, min_only=True) > margin if len(rim) else np.ones(n, dtype=bool)
    current = np.flatnonzero(far)
    order = np.random.default_rng(0).permutation(n)
    joined = _pattern(lengths[current][:, current])
    while len(current) > 2 * count:
        kept = _independent(joined, order[current])
        reach = joined[:, kept] + sp.csr_array(
            (np.ones(len(kept)), (kept, np.arange(len(kept)))), shape=(len(current), len(kept))
        )
        joined = _pattern(reach.T @ joined @ reach)
        current = current[kept]
    return current


def _pattern(matrix: sp.csr_array) -> sp.csr_array:
    """Ones off the diagonal where the matrix has entries."""
    rows, columns = matrix.nonzero()
    off = rows != columns
    return sp.csr_array((np.ones(off.sum()), (rows[off], columns[off])), shape=matrix.shape)


def _independent(joined: sp.csr_array, keys: Int) -> Int:
    """A maximal set of rows, no two joined: the highest keys among open neighbours, again and again."""
    i, j = joined.nonzero()
    is_open = np.ones(len(keys), dtype=bool)
    kept = np.zeros(len(keys), dtype=bool)
    while is_open.any():
        bids = np.where(is_open, keys, -1)
        highest = np.full(len(bids), -1)
        np.maximum.at(highest, i, bids[j])
        new = is_open & (bids > highest)
        kept |= new
        is_open &= ~new
        is_open[j[new[i]]] = False
    return np.flatnonzero(kept)


def _between(corners: Int) -> Int:
    """The triangles (T, 3) between three regions, each once, from the regions of the corners of faces (F, 3)."""
    a, b, c = corners.T
    three = corners[(a != b) & (b != c) & (c != a)]
    first = np.argmin(three, axis=1)
    turned = np.take_along_axis(three, (first[:, None] + np.arange(3)) % 3, axis=1)
    return np.unique(turned, axis=0).astype(np.int32)


def _side_lengths(domain: Domain, faces: Int, region: Int, distance: Array) -> Array:
    """(T, 3) the shortest ways between the kept vertices of each side, bent a little, side k opposite corner k."""
    i, j = domain.edges.T
    across = distance[i] + domain.edge_lengths + distance[j]
    order = np.argsort(across)
    between = np.sort(np.stack([region[i], region[j]], axis=1), axis=1)[order]
    pairs, first = np.unique(between, axis=0, return_index=True)
    lengths = across[order][first]
    count = int(region.max()) + 1
    keys = pairs[:, 0].astype(np.int64) * count + pairs[:, 1]
    ends = np.sort(np.stack([faces[:, [1, 2, 0]], faces[:, [2, 0, 1]]]), axis=0).astype(np.int64)
    sides = np.searchsorted(keys, ends[0] * count + ends[1])
    for _ in range(_DETOURS):  # a way over the third corner may be shorter
        of_faces = lengths[sides]
        np.minimum.at(lengths, sides, of_faces.sum(axis=1, keepdims=True) - of_faces)
    usual = float(np.median(lengths[sides]))
    return usual * (lengths[sides] / usual) ** _BENT
