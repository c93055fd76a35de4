"""The tips of ears: vertices of the boundary about which normals at faces say nothing.

A face with two sides on the boundary is an ear, and its tip belongs to no other face. No link crosses an edge at the
tip, so the conjugate is not determined there: the triangle of g that belongs to the face has a known side, and a plane.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..domain.connectivity import after, before
from ..domain.domain import Domain
from .planes import VertexPlanes

Array = NDArray[np.float64]
Int = NDArray[np.integer]


def unfold_ears(domain: Domain, rows: Int, g: Array, tau: Array, N: Array, planes: Array) -> tuple[Array, Array]:
    """g (n, 3) and tau (E, 3) with the tips where the affine map of the neighbouring face puts them.

    The ear and its neighbour are laid out in the plane; the map of the neighbour's triangle on g is continued to the
    tip, which is then moved into the plane through its two neighbours that is orthogonal to N (F, 3), and into those of
    the mirrors beside it: planes (E, 3), their normals or zero. rows: (F, 3), the row of g at each corner.
    """
    base = _bases(domain)
    if not len(base):
        return g, tau
    across = domain.twins[base].astype(np.int64)
    tip, start = rows.ravel()[base], rows.ravel()[after(base)]
    # the other face walks the common edge backwards
    a, b, far = (g[rows.ravel()[corner]] for corner in (before(across), after(across), across))
    along, away = _coordinates(domain, base, across)
    point = along[:, None] * (b - a) + away[:, None] * (far - a)
    # the tip as seen from `start`; the sides beside it end at the two ends of the base
    to_start, to_other = (domain.face_edges.ravel()[side] for side in (before(base), after(base)))
    other = rows.ravel()[before(base)]
    normals = np.concatenate([N[base // 3], planes[to_start], planes[to_other]])
    zero = np.zeros(len(tip))
    offsets = np.concatenate([zero, zero, np.einsum("ij,ij->i", g[other] - g[start], planes[to_other])])
    at = VertexPlanes(tip, np.tile(np.arange(len(tip)), 3), normals, np.zeros(0, dtype=np.int64))
    g, tau = g.copy(), tau.copy()
    g[tip] = g[start] + at.nearest(point, offsets)
    for side in (after(base), before(base)):
        tau[domain.face_edges.ravel()[side]] = g[rows.ravel()[before(side)]] - g[rows.ravel()[after(side)]]
    return g, tau


def _bases(domain: Domain) -> Int:
    """The inner half-edge of each ear; its number is also that of the tip, the corner opposite."""
    outside = (domain.twins < 0).reshape(-1, 3)
    ears = np.flatnonzero(outside.sum(axis=1) == 2)
    return 3 * ears + np.argmin(outside[ears], axis=1)


def _coordinates(domain: Domain, base: Int, across: Int) -> tuple[Array, Array]:
    """The tip as `along (b - a) + away (far - a)`, where the edge a → b has the tip on its left, `far` on its right."""
    x, y = _apex(domain, base)
    from_b, depth = _apex(domain, across)
    away = -y / depth
    return x - away * (1.0 - from_b), away


def _apex(domain: Domain, half_edge: Int) -> tuple[Array, Array]:
    """The corner opposite a half-edge: its foot along it, from 0 to 1, and its height, in units of its length."""
    cotans = domain.corner_cotans.ravel()
    first, second = cotans[after(half_edge)], cotans[before(half_edge)]
    return first / (first + second), 1.0 / (first + second)
