"""Conformal distortion: how far a map from a domain into space is from conformal, face by face."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from ..domain.shape import DomainLike, as_domain
from ..errors import MeshError
from ..linalg import as_numbers
from ..signatures import checked
from .arrays import Array, dot, double_areas, edge_vectors, points_in_space, triangles_of


@checked
def conformal_distortion(domain: DomainLike, vertices: ArrayLike, faces: ArrayLike | None = None) -> Array:
    """Quasi-conformal distortion Q = σ₁ / σ₂ >= 1 of each face: the ratio of the map's singular values.

    The map is the affine one from the face's own layout in the domain (`domain.layout`, (F, 3, 2)) to its
    triangle in space (paper, Sec. 6). domain: a Domain, or a Shape. `vertices` (n, 2|3); `faces` (F, 3) index them,
    face by face as the domain's (the default), for surfaces that are cut open. -> (F,), without unit; 1 where the map
    is conformal. A face that is collapsed in space gives nan. Raises `MeshError` where the shapes do not match.
    """
    flat = as_domain(domain)
    return distortion_of_layout(flat.layout, vertices, flat.faces if faces is None else faces)


def distortion_of_layout(layout: ArrayLike, vertices: ArrayLike, faces: ArrayLike) -> Array:
    """As `conformal_distortion`, from the planar corners (F, 3, 2) of each face instead of a domain."""
    points = points_in_space(vertices)
    triangles = triangles_of(faces, len(points))
    corners = as_numbers(layout, "The layout", MeshError)
    if corners.shape != (len(triangles), 3, 2):
        raise MeshError(f"{len(triangles)} faces, but a layout of shape {corners.shape}; give (faces, 3, 2).")
    u, v = edge_vectors(points, triangles)
    plane = np.ascontiguousarray(corners.transpose(1, 2, 0))
    return _ratio(plane[1] - plane[0], plane[2] - plane[0], u, v)


def _ratio(p: Array, q: Array, u: Array, v: Array) -> Array:
    """Q of the linear maps that send the plane vectors p, q (2, F) to u, v (3, F).

    With the pulled back metric C: σ₁² = ½ (tr C + R), σ₁σ₂ = sqrt(det C), R² = (C_xx - C_yy)² + 4 C_xy².
    Nothing cancels, so Q - 1 is exact to rounding; the textbook c + sqrt(c² - 1) would lose half of the digits.
    """
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        area = p[0] * q[1] - p[1] * q[0]
        x = (q[1] * u - p[1] * v) / area
        y = (p[0] * v - q[0] * u) / area
        xx, xy, yy = dot(x, x), dot(x, y), dot(y, y)
        jacobian = double_areas(u, v) / np.abs(area)
        ratio = 0.5 * (xx + yy + np.hypot(xx - yy, 2.0 * xy)) / jacobian
    return np.where(np.isfinite(ratio), np.maximum(ratio, 1.0), np.nan)


def distortion_energy(ratio: ArrayLike) -> Array:
    """½ (Q + 1/Q) - 1 >= 0: quadratic in Q - 1, zero where the map is conformal. Same shape as `ratio`."""
    Q = np.asarray(ratio, dtype=np.float64)
    return (Q - 1.0) ** 2 / (2.0 * Q)
