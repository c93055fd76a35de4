"""A flat layout of the plan, which its moduli move: as drawn, with its faces unrolled, or as seen from above."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..domain.domain import Domain
from ..domain.trees import Tree
from ..gauss.frames import area_vectors

Array = NDArray[np.float64]

# Lengths that agree to this part are equal.
_EQUAL = 1e-6


def flat_layout(domain: Domain, points: Array) -> tuple[Domain, Array] | None:
    """A domain with these faces, and positions (V, 2) that give its lengths; None if there is none.

    points: (V, 3) as drawn. The domain is the given one if it is flat, as drawn or unrolled; else the plan seen from
    above takes its place, if no face is turned over there.
    """
    if _has_lengths(domain, points[:, :2]):
        return domain, points[:, :2]
    if len(domain.boundary_loops) == 1 and not domain.genus:
        unrolled = _unrolled(domain)
        if _has_lengths(domain, unrolled):
            return domain, unrolled
    above = points * [1.0, 1.0, 0.0]
    if area_vectors(above, domain.faces)[:, 2].min() <= 0.0:
        return None
    return Domain.from_positions(above, domain.faces), above[:, :2]


def _has_lengths(domain: Domain, flat: Array) -> bool:
    """Whether positions (V, 2) give the domain's edges their lengths, and no face is turned over."""
    i, j = domain.edges.T
    off = np.abs(np.linalg.norm(flat[j] - flat[i], axis=1) - domain.edge_lengths)
    up = area_vectors(np.column_stack([flat, np.zeros(len(flat))]), domain.faces)[:, 2].min() > 0.0
    return bool(up and (off <= _EQUAL * domain.edge_lengths).all())


def _unrolled(domain: Domain) -> Array:
    """(V, 2) from the layouts of the faces, each turned so that it continues the one before it in a tree of faces."""
    inside = domain.interior_edges
    left, right = domain.edge_faces[inside].T
    ahead, back = (_directions(domain, half) for half in domain.half_edges[inside].T)
    turned = ahead - back - np.pi
    faces = np.stack([right, left], axis=1)  # right face minus left face
    angle = Tree.of(faces, len(domain.faces)).integrate(turned[:, None])[:, 0]
    behind = domain.half_edges[:, 0]
    direction = _directions(domain, behind) + angle[behind // 3]
    ways = domain.edge_lengths[:, None] * np.column_stack([np.cos(direction), np.sin(direction)])
    return Tree.of(domain.edges[:, ::-1], domain.vertex_count).integrate(ways)


def _directions(domain: Domain, half_edges: NDArray[np.integer]) -> Array:
    """Angles (n,) of half-edges in the layouts of their faces."""
    face, k = half_edges // 3, half_edges % 3
    d = domain.layout[face, (k + 2) % 3] - domain.layout[face, (k + 1) % 3]
    return np.arctan2(d[:, 1], d[:, 0])
