"""Intrinsic Delaunay triangulation: other triangles with the same metric and the same vertices.

A harmonic map depends on the metric only, so the best triangulation of its vertices can replace a poor mesh (paper,
Section 4.3.3; Fisher et al. 2007). Its edges are geodesics of the domain, not chords in space: two may join the same
vertices, one may join a vertex to itself, and only their lengths are known.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import chain
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..interrupts import compiled
from ..notes import Note
from . import connectivity
from .domain import Domain
from .flips import Flips
from .shape import DomainLike, as_domain
from .topology import CutSurface, Homology
from .trees import Tree

Int = NDArray[np.integer]

# A domain counts as Delaunay if its weights exceed this: those of diagonals of a grid are zero up to rounding.
_LEAST_WEIGHT = -1e-12
# Flips preserve the area up to rounding: 1e-9 of it where the smallest angle is a millionth of a degree.
_SAME_AREA = 1e-6
# The number of faces above which our own flips take three seconds or more.
_LARGE = 150_000


@dataclass(frozen=True, eq=False)
class Retriangulation:
    """Another triangulation of a domain with the same vertices, numbered as before, and the same metric.

    domain: the new triangles and edges.
    edges: (E,) for each boundary edge of the old domain its number in the new one; -1 for interior edges, which
        have no successor.
    flips: the flips that led to it, on domains with holes or handles; None on discs and spheres, which need none.
    """

    domain: Domain
    edges: Int
    flips: Flips | None = None


def intrinsic_delaunay(domain: DomainLike) -> Retriangulation:
    """The intrinsic Delaunay triangulation: no interior edge has opposite angles that sum to more than π.

    Then all cotangent weights inside are ≥ 0 (paper, Section 4.3.3). Area, boundary edges and their lengths stay,
    and faces stay counter-clockwise. With four vertices on a circle either diagonal is possible. A Delaunay domain is
    returned as it is. libigl does the flips if it is installed and handles the domain, our own code otherwise. Raises
    `MeshError` on faces so thin that rounding makes them flat.
    """
    domain = as_domain(domain)
    simple = _is_disc_or_sphere(domain)
    if _is_delaunay(domain):
        return Retriangulation(domain, _followed(domain, domain), None if simple else Flips(domain))
    igl = _libigl() if _is_for_libigl(domain) else None
    new = None if igl is None else _flipped_by(igl, domain)
    if new is not None:
        return Retriangulation(new, _followed(domain, new))
    flips = Flips(domain)
    new = flips.domain()
    return Retriangulation(new, _followed(domain, new), None if simple else flips)


def speed_note(domain: Domain) -> Note | None:
    """A warning if `intrinsic_delaunay` would be seconds faster on this domain with libigl; else None."""
    if len(domain.faces) < _LARGE or _libigl() is not None or _is_delaunay(domain) or not _is_for_libigl(domain):
        return None
    return Note(
        "slow",
        "libigl is not installed, so edges were flipped one by one for the intrinsic Delaunay triangulation, which is "
        "slower on large meshes; `pip install libigl` makes it faster.",
    )


def carried_cut(domain: Domain, retriangulation: Retriangulation, new: Homology) -> CutSurface:
    """The old domain cut open, for functions given on the vertices of the new one up to their periods.

    new: the homology of `retriangulation.domain`. A function with values x (V, d) on the first V vertices of
    `new.sheets` and periods p (k, d) has the value `x[source] + offsets @ p` at each cut vertex of the result; the
    first V may have offsets, too. Exact: edges are followed through the flips, however large the triangles.
    """
    old = Homology.of(domain).sheets
    if retriangulation.flips is None or new.is_trivial:
        return old
    # two bases of the closed forms with integer periods, on the new edges; they differ by a change of basis and by the
    # differential of a function on the vertices
    mine = retriangulation.flips.carry(_increments(domain, old))
    theirs = _increments(new.domain, new.sheets)
    tree = Tree.of(new.domain.edges, new.domain.vertex_count)
    at_vertices = [-tree.integrate(form.astype(float)) for form in (mine, theirs)]
    i, j = new.domain.edges.T
    around = [form - (values[j] - values[i]) for form, values in zip((mine, theirs), at_vertices, strict=True)]
    basis = np.linalg.lstsq(*around, rcond=None)[0]
    shift = at_vertices[1] - at_vertices[0] @ basis
    offsets = np.rint(old.offsets @ basis + shift[old.source]).astype(np.int64)
    return CutSurface(old.faces, old.source, offsets)


def _increments(domain: Domain, sheets: CutSurface) -> Int:
    """(E, k) changes of the offsets along each edge, within its left face: a closed form on the edges."""
    left = domain.half_edges[:, 0]
    face = left - left % 3
    cut_vertices = sheets.faces.ravel()
    start, end = (cut_vertices[face + (left + k) % 3] for k in (1, 2))
    return sheets.offsets[end] - sheets.offsets[start]


def _libigl() -> Any:
    """The module, or None."""
    try:
        return compiled("igl")
    except ImportError:
        return None


def _is_disc_or_sphere(domain: Domain) -> bool:
    return domain.genus == 0 and len(domain.boundary_loops) <= 1


def _is_for_libigl(domain: Domain) -> bool:
    """Whether libigl handles the domain: it does not report how edges run around holes and handles, and needs edges
    with distinct pairs of vertices.
    """
    return _is_disc_or_sphere(domain) and _has_distinct_pairs(domain)


def _is_delaunay(domain: Domain) -> bool:
    return bool((domain.cotan_weights[domain.interior_edges] >= _LEAST_WEIGHT).all())


def _has_distinct_pairs(domain: Domain) -> bool:
    """Whether no two edges join the same two vertices, and none a vertex to itself."""
    pairs = connectivity.edges_by_vertex_pairs(domain.faces, domain.vertex_count)
    return int(pairs.max()) + 1 == len(domain.edges) and bool((domain.edges[:, 0] != domain.edges[:, 1]).all())


def _flipped_by(igl: Any, domain: Domain) -> Domain | None:
    """The triangulation by libigl, for edges with distinct pairs of vertices; None if its tables contradict each other.

    Edges of the result may share their vertices. But flipping an edge whose two triangles share a second edge leaves
    libigl (2.6.3) with contradicting lists of sides, and from then on it flips the wrong ones.
    """
    result = igl.intrinsic_delaunay_triangulation(domain.side_lengths, domain.faces.astype(np.int64))
    lengths, faces, edge_of_side, sides_of_edge = result[0], result[1], result[4], result[5]
    if not _agree(edge_of_side, sides_of_edge):
        return None
    # its side f + F c is opposite corner c of face f
    new = Domain.from_edge_lengths(faces, lengths, face_edges=edge_of_side.reshape(3, -1).T)
    return new if abs(new.area - domain.area) <= _SAME_AREA * domain.area else None


def _agree(edge_of_side: NDArray[np.integer], sides_of_edge: list[list[int]]) -> bool:
    """Whether both tables agree and give every side one edge."""
    sides = np.fromiter(chain.from_iterable(sides_of_edge), dtype=np.int64)
    edges = np.repeat(np.arange(len(sides_of_edge)), [len(sides) for sides in sides_of_edge])
    return len(np.unique(sides)) == len(sides) == len(edge_of_side) and np.array_equal(edge_of_side[sides], edges)


def _followed(old: Domain, new: Domain) -> Int:
    """Boundary edges of `old` in `new`, matched by the vertex that they leave; -1 inside."""
    leaving = np.full(old.vertex_count, -1, dtype=np.int32)
    leaving[new.edges[new.boundary_edges, 0]] = new.boundary_edges
    edges = np.full(len(old.edges), -1, dtype=np.int32)
    edges[old.boundary_edges] = leaving[old.edges[old.boundary_edges, 0]]
    return edges
