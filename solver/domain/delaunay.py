"""Intrinsic Delaunay triangulation: other triangles for the same metric and the same vertices.

A harmonic map depends on the metric only, so a poor mesh may be exchanged for the best triangulation that its
vertices have (paper, Section 4.3.3; Fisher et al. 2007). Its edges are geodesics of the domain, not chords in space:
they may join the same two vertices, or a vertex to itself, and only their lengths are known.
"""

from __future__ import annotations

import importlib
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import CmcError
from . import connectivity
from .domain import Domain
from .flips import Flips

Int = NDArray[np.int32]

# A domain counts as Delaunay with weights above this: those of diagonals of a grid are zero up to rounding.
_LEAST_WEIGHT = -1e-12


@dataclass(frozen=True, eq=False)
class Retriangulation:
    """Another triangulation of a domain: its vertices, numbered as they were, and its metric.

    domain: the new triangles and edges.
    edges: (E,) for each boundary edge of the old domain its number in the new one; -1 for interior edges, which
        have no successor.
    """

    domain: Domain
    edges: Int


def intrinsic_delaunay(domain: Domain) -> Retriangulation:
    """The intrinsic Delaunay triangulation: no interior edge has opposite angles that sum to more than π.

    Then all cotangent weights inside are ≥ 0 (paper, Section 4.3.3). Area, boundary edges and their lengths stay,
    and faces stay counter-clockwise. Where four vertices lie on a circle either diagonal may come out. A domain
    that is Delaunay already is returned as it is. Raises `CmcError` without libigl.
    """
    igl = _libigl()
    if _is_delaunay(domain):
        new = domain
    elif _told_apart_by_vertices(domain):
        new = _flipped_by(igl, domain)
    else:
        new = Flips(domain).run()
    return Retriangulation(new, _followed(domain, new))


def _libigl() -> Any:
    try:
        return importlib.import_module("igl")
    except ImportError as error:
        raise CmcError(
            f"Intrinsic Delaunay triangulation needs libigl, which cannot be imported ({error}). Install it with "
            '`pip install "cmc-formfinding[intrinsic]"` (Blender\'s extension brings it along), or do without.'
        ) from None


def _is_delaunay(domain: Domain) -> bool:
    return bool((domain.cotan_weights[domain.interior_edges] >= _LEAST_WEIGHT).all())


def _told_apart_by_vertices(domain: Domain) -> bool:
    """Whether no two edges join the same two vertices, and none a vertex to itself."""
    pairs = connectivity.edges_by_vertex_pairs(domain.faces, domain.vertex_count)
    return int(pairs.max()) + 1 == len(domain.edges) and bool((domain.edges[:, 0] != domain.edges[:, 1]).all())


def _flipped_by(igl: Any, domain: Domain) -> Domain:
    """By libigl, which numbers the edges of its input by their two vertices, but not those of its result."""
    result = igl.intrinsic_delaunay_triangulation(domain.side_lengths, domain.faces.astype(np.int64))
    lengths, faces, edge_of_side = result[0], result[1], result[4]
    # its side f + F c is opposite corner c of face f
    return Domain.from_edge_lengths(faces, lengths, face_edges=edge_of_side.reshape(3, -1).T)


def _followed(old: Domain, new: Domain) -> Int:
    """Boundary edges of `old` in `new`: exactly one leaves each boundary vertex."""
    leaving = np.full(old.vertex_count, -1, dtype=np.int32)
    leaving[new.edges[new.boundary_edges, 0]] = new.boundary_edges
    edges = np.full(len(old.edges), -1, dtype=np.int32)
    edges[old.boundary_edges] = leaving[old.edges[old.boundary_edges, 0]]
    return edges
