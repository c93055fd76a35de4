"""Curvature of a triangle mesh from normals at its vertices: the Regge shape operator of paper, Sec. 4.3.2.

dN = df ∘ S. The lowest order Regge element on a face is the constant symmetric form b with b(e, e) = <dN_e, df_e>
on its three edges. Three numbers fix it, so no basis has to be assembled: with u = v1 - v0 and v = v2 - v0

    b(u, u) = b_01,   b(v, v) = b_02,   b(u, v) = ½ (b_01 + b_02 - b_12) = ½ (<dN_u, v> + <dN_v, u>),

and S = g⁻¹ b with the metric g of the face. This equals the paper's sum a_ij S_ij^k (a test compares them).
S has unit 1/length; a sphere of radius r with its outer normal has S = 1/r, so f± with ±N has H = +½ at scale 1.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ..errors import MeshError
from ..linalg import as_numbers
from .arrays import (
    Array,
    Indices,
    dot,
    double_areas,
    edge_vectors,
    points_in_space,
    range_text,
    triangles_of,
    vertex_means,
)


class PrincipalCurvatures(NamedTuple):
    """Principal curvatures (F,), `k1 >= k2`, in 1/length, and unit directions (F, 3) in the faces.

    A direction is a line: its sign means nothing. On degenerate faces everything is nan.
    """

    k1: Array
    k2: Array
    direction1: Array
    direction2: Array

    def __repr__(self) -> str:
        return f"PrincipalCurvatures({len(self.k1)} faces, k1 {range_text(self.k1)}, k2 {range_text(self.k2)})"

    @property
    def umbilicity(self) -> Array:
        """k1 - k2 (F,): where it is nearly zero, the directions mean nothing."""
        return self.k1 - self.k2


class _Form(NamedTuple):
    u: Array
    v: Array
    uu: Array
    uv: Array
    vv: Array
    double_area: Array


def _second_form(vertices: ArrayLike, faces: ArrayLike, normals: ArrayLike) -> _Form:
    points = points_in_space(vertices)
    triangles: Indices = triangles_of(faces, len(points))
    gauss = as_numbers(normals, "Normals", MeshError)
    if gauss.shape != points.shape:
        raise MeshError(f"{len(points)} vertices, but normals of shape {gauss.shape}; give one a vertex.")
    u, v = edge_vectors(points, triangles)
    du, dv = edge_vectors(gauss, triangles)
    with np.errstate(invalid="ignore", over="ignore"):
        mixed = 0.5 * (dot(du, v) + dot(dv, u))
        return _Form(u, v, dot(du, u), mixed, dot(dv, v), double_areas(u, v))


def mean_curvature_of(vertices: ArrayLike, faces: ArrayLike, normals: ArrayLike) -> Array:
    """Mean curvature ½ tr S of each face (paper, Sec. 4.3.2), the mean of the principal curvatures.

    `vertices` (n, 3), `faces` (F, 3), unit `normals` (n, 3) at the vertices -> (F,), in 1/length. The sign
    follows the normals, not the winding. Faces at the boundary need nothing special. Degenerate faces give
    nan. Raises `MeshError` where the shapes do not match or an index does not exist.
    """
    form = _second_form(vertices, faces, normals)
    with np.errstate(invalid="ignore", over="ignore"):
        uu, uv, vv = dot(form.u, form.u), dot(form.u, form.v), dot(form.v, form.v)
        return 0.5 * (vv * form.uu - 2.0 * uv * form.uv + uu * form.vv) / form.double_area**2


def gauss_curvature_of(vertices: ArrayLike, faces: ArrayLike, normals: ArrayLike) -> Array:
    """Gauss curvature det S of each face (F,), in 1/length²; all else as `mean_curvature_of`."""
    form = _second_form(vertices, faces, normals)
    with np.errstate(invalid="ignore", over="ignore"):
        return (form.uu * form.vv - form.uv**2) / form.double_area**2


def face_frames(vertices: ArrayLike, faces: ArrayLike) -> Array:
    """Orthonormal frame of each face (F, 2, 3): row 0 along the edge v0 -> v1, row 1 turned +90° in the face.

    Counter-clockwise faces make row 0 × row 1 the face normal. Degenerate faces give nan.
    """
    points = points_in_space(vertices)
    u, v = edge_vectors(points, triangles_of(faces, len(points)))
    return _frames(u, v, double_areas(u, v))


def _frames(u: Array, v: Array, double_area: Array) -> Array:
    length = np.where(np.isnan(double_area), np.nan, np.sqrt(dot(u, u)))
    x = u / length
    y = (v - dot(v, x) * x) * (length / double_area)
    return np.ascontiguousarray(np.stack([x, y]).transpose(2, 0, 1))


def shape_operator(vertices: ArrayLike, faces: ArrayLike, normals: ArrayLike) -> Array:
    """Regge shape operator S of each face, a symmetric 2×2 matrix in the frame of `face_frames`.

    Paper, Sec. 4.3.2: <dN(t), df(t)> = tᵀ S t exactly for the three edges t of the face. (F, 2, 2), in
    1/length. Arguments, errors and nan as `mean_curvature_of`.
    """
    xx, xy, yy = _shape_components(_second_form(vertices, faces, normals))
    return np.stack([np.stack([xx, xy], axis=-1), np.stack([xy, yy], axis=-1)], axis=-2)


def _shape_components(form: _Form) -> tuple[Array, Array, Array]:
    with np.errstate(invalid="ignore", over="ignore"):
        length = np.where(np.isnan(form.double_area), np.nan, np.sqrt(dot(form.u, form.u)))
        vx, vy = dot(form.u, form.v) / length, form.double_area / length
        xx = form.uu / length**2
        xy = (form.uv / length - vx * xx) / vy
        yy = (form.vv - 2.0 * vx * vy * xy - vx**2 * xx) / vy**2
    return xx, xy, yy


def principal_curvatures(vertices: ArrayLike, faces: ArrayLike, normals: ArrayLike) -> PrincipalCurvatures:
    """Principal curvatures k1 >= k2 of each face and their directions: eigenpairs of `shape_operator`.

    (F,), (F,), (F, 3), (F, 3). At umbilics the directions are arbitrary, but unit and orthogonal.
    Arguments, errors and nan as `mean_curvature_of`.
    """
    form = _second_form(vertices, faces, normals)
    xx, xy, yy = _shape_components(form)
    frames = _frames(form.u, form.v, form.double_area)
    mean, half = 0.5 * (xx + yy), 0.5 * (xx - yy)
    radius = np.hypot(half, xy)
    angle = 0.5 * np.arctan2(xy, half)
    cos, sin = np.cos(angle)[:, None], np.sin(angle)[:, None]
    x, y = frames[:, 0], frames[:, 1]
    return PrincipalCurvatures(mean + radius, mean - radius, cos * x + sin * y, cos * y - sin * x)


def vertex_mean_curvature(vertices: ArrayLike, faces: ArrayLike, normals: ArrayLike) -> Array:
    """Mean curvature at the vertices (n,): the mean of the faces around each, weighted by their areas.

    Arguments and errors as `mean_curvature_of`. At the boundary it is the mean over the faces there. Degenerate faces
    do not count; a vertex without other faces gives nan.
    """
    return vertex_means(mean_curvature_of(vertices, faces, normals), vertices, faces)


def vertex_gauss_curvature(vertices: ArrayLike, faces: ArrayLike, normals: ArrayLike) -> Array:
    """Gauss curvature at the vertices (n,), in 1/length²; all else as `vertex_mean_curvature`."""
    return vertex_means(gauss_curvature_of(vertices, faces, normals), vertices, faces)
