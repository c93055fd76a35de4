"""The Regge shape operator against its definition and against exact surfaces of mean curvature ½."""

from __future__ import annotations

from time import process_time

import numpy as np
import pytest
from numpy.testing import assert_allclose

from solver.errors import MeshError
from solver.measure import (
    face_frames,
    gauss_curvature_of,
    mean_curvature_of,
    principal_curvatures,
    shape_operator,
    vertex_mean_curvature,
)
from tests.solver.sampled_surfaces import (
    NODOID,
    NODOID_TWIN,
    UNDULOID,
    UNDULOID_TWIN,
    Delaunay,
    cylinder,
    sample,
    sphere,
)

DELAUNAY = {"nodoid": NODOID, "nodoid f-": NODOID_TWIN, "unduloid": UNDULOID, "unduloid f-": UNDULOID_TWIN}
SIZES = (16, 32, 64)


def mesh(surface, n, jitter=0.2):
    return sample(surface, n, n, (2.0, 2.0), jitter)


def arguments(m):
    return m.points, m.faces, m.normals


def l2(values, m):
    return np.sqrt(np.average(values**2, weights=m.areas))


def rates(errors):
    errors = np.asarray(errors)
    return np.log2(errors[:-1] / errors[1:])


def paper_shape_operator(points, normals):
    """Σ a_ij S_ij^k of paper, Sec. 4.3.2, with the tensors of the elements written out, in space (3, 3).

    The corner angles in the denominator are those at the ends of the edge ij, and t_ij runs from i to j.
    """
    normal = np.cross(points[1] - points[0], points[2] - points[0])
    normal /= np.linalg.norm(normal)
    total = np.zeros((3, 3))
    for k in range(3):
        i, j = (k + 1) % 3, (k + 2) % 3
        t_jk, t_ki, t_ij = (
            (points[b] - points[a]) / np.linalg.norm(points[b] - points[a]) for a, b in ((j, k), (k, i), (i, j))
        )
        n_jk, n_ki = np.cross(normal, t_jk), np.cross(normal, t_ki)
        sines = np.linalg.norm(np.cross(t_ij, t_ki)) * np.linalg.norm(np.cross(t_ij, t_jk))
        element = -(np.outer(n_jk, n_ki) + np.outer(n_ki, n_jk)) / (2 * sines)
        edge = points[j] - points[i]
        total += (normals[j] - normals[i]) @ edge / (edge @ edge) * element
    return total


def test_equals_the_elements_of_the_paper():
    random = np.random.default_rng(3)
    points, normals = random.normal(size=(2, 30, 3))
    faces = np.arange(30).reshape(10, 3)
    frames = face_frames(points, faces)
    shape = shape_operator(points, faces, normals)
    for f, face in enumerate(faces):
        expected = frames[f] @ paper_shape_operator(points[face], normals[face]) @ frames[f].T
        assert_allclose(shape[f], expected, rtol=1e-9, atol=1e-12)


def test_interpolates_the_normal_curvature_of_the_edges():
    m = mesh(NODOID, 8)
    shape, frames = shape_operator(*arguments(m)), face_frames(m.points, m.faces)
    for k in range(3):
        i, j = m.faces[:, (k + 1) % 3], m.faces[:, (k + 2) % 3]
        edge, turn = m.points[j] - m.points[i], m.normals[j] - m.normals[i]
        t = np.einsum("fac,fc->fa", frames, edge)
        assert_allclose(np.einsum("fa,fab,fb->f", t, shape, t), (edge * turn).sum(axis=1), rtol=1e-9, atol=1e-13)


def test_trace_determinant_and_eigenvectors_belong_together():
    m = mesh(UNDULOID, 12)
    shape = shape_operator(*arguments(m))
    p = principal_curvatures(*arguments(m))
    assert_allclose(mean_curvature_of(*arguments(m)), 0.5 * np.trace(shape, axis1=1, axis2=2), rtol=1e-10, atol=1e-12)
    assert_allclose(gauss_curvature_of(*arguments(m)), np.linalg.det(shape), rtol=1e-9, atol=1e-11)
    assert_allclose(np.stack([p.k2, p.k1], axis=1), np.linalg.eigvalsh(shape), rtol=1e-9, atol=1e-11)
    frames = face_frames(m.points, m.faces)
    for curvature, direction in ((p.k1, p.direction1), (p.k2, p.direction2)):
        d = np.einsum("fac,fc->fa", frames, direction)
        assert_allclose(np.einsum("fab,fb->fa", shape, d), curvature[:, None] * d, rtol=1e-9, atol=1e-11)
    assert_allclose((p.direction1 * p.direction2).sum(axis=1), 0.0, atol=1e-12)
    assert_allclose(np.cross(p.direction1, p.direction2), np.cross(frames[:, 0], frames[:, 1]), atol=1e-10)


def test_sphere_of_radius_two_has_mean_curvature_one_half():
    m = mesh(sphere, 12)
    assert_allclose(mean_curvature_of(*arguments(m)), 0.5, rtol=1e-11)
    assert_allclose(gauss_curvature_of(*arguments(m)), 0.25, rtol=1e-10)
    assert_allclose(principal_curvatures(*arguments(m)).umbilicity, 0.0, atol=1e-10)
    assert_allclose(vertex_mean_curvature(*arguments(m)), 0.5, rtol=1e-11)


def test_scale_and_sign():
    m = mesh(NODOID, 8)
    H = mean_curvature_of(*arguments(m))
    assert_allclose(mean_curvature_of(10.0 * m.points, m.faces, m.normals), 0.1 * H, rtol=1e-9, atol=1e-14)
    assert_allclose(mean_curvature_of(m.points, m.faces, -m.normals), -H, rtol=1e-14)
    assert_allclose(mean_curvature_of(m.points, m.faces[:, [1, 0, 2]], m.normals), H, rtol=1e-9, atol=1e-12)


def test_cylinder_bends_around_and_not_along():
    m = mesh(cylinder, 64, jitter=0.0)
    p = principal_curvatures(*arguments(m))
    assert_allclose(p.k1, 1.0, atol=1e-3)
    assert_allclose(p.k2, 0.0, atol=1e-12)
    assert_allclose(np.abs(p.direction2[:, 2]), 1.0, atol=1e-3)


@pytest.mark.parametrize("jitter", [0.0, 0.2])
@pytest.mark.parametrize("name", DELAUNAY)
def test_delaunay_surfaces_converge(name, jitter):
    surface: Delaunay = DELAUNAY[name]
    errors = []
    for n in SIZES:
        m = mesh(surface, n, jitter)
        H, p = mean_curvature_of(*arguments(m)), principal_curvatures(*arguments(m))
        parallel, meridian = surface.curvatures(m.centres[:, 1])
        around = np.stack([-np.sin(m.centres[:, 0]), np.cos(m.centres[:, 0]), 0 * H], axis=1)
        found = np.where((parallel > meridian)[:, None], p.direction1, p.direction2)
        errors.append(
            [
                l2(H - 0.5, m),
                l2(p.k1 - np.maximum(parallel, meridian), m),
                l2(p.k1 * p.k2 - parallel * meridian, m),
                l2(np.linalg.norm(np.cross(found, around), axis=1), m),
            ]
        )
    assert (rates(errors) > 0.9).all(), rates(errors)
    assert errors[-1][0] < 0.04
    assert errors[-1][3] < 0.02


@pytest.mark.parametrize("name", DELAUNAY)
def test_curvature_at_vertices_converges_too(name):
    errors = []
    for n in SIZES:
        m = mesh(DELAUNAY[name], n)
        errors.append(np.sqrt(np.mean((vertex_mean_curvature(*arguments(m)) - 0.5) ** 2)))
    assert (rates(errors) > 0.9).all(), rates(errors)


def test_curvature_at_vertices_is_the_area_mean_of_the_faces_around():
    m = mesh(UNDULOID, 5)
    H, areas = mean_curvature_of(*arguments(m)), m.areas
    expected = [
        np.average(H[around], weights=areas[around])
        for around in ((m.faces == v).any(axis=1) for v in range(len(m.points)))
    ]
    assert_allclose(vertex_mean_curvature(*arguments(m)), expected, rtol=1e-12)


def test_degenerate_faces_are_nan_and_nothing_else():
    m = mesh(sphere, 4)
    points, normals = np.vstack([m.points, [[0, 0, 9], [np.nan] * 3]]), np.vstack([m.normals, np.eye(3)[:2]])
    last = len(m.points)
    line = [[0, 0, 1], [0, last, last], [last, last, last], [0, 1, last + 1]]
    faces = np.vstack([m.faces, line])
    good = len(m.faces)
    H = mean_curvature_of(points, faces, normals)
    shape, p = shape_operator(points, faces, normals), principal_curvatures(points, faces, normals)
    assert np.isnan(H[good:]).all()
    assert np.isnan(shape[good:]).all()
    assert np.isnan(p.direction1[good:]).all()
    assert np.isnan(face_frames(points, faces)[good:]).all()
    assert_allclose(H[:good], 0.5, rtol=1e-10)
    at_vertices = vertex_mean_curvature(points, faces, normals)
    assert_allclose(at_vertices[:last], 0.5, rtol=1e-10)
    assert np.isnan(at_vertices[last:]).all()


def test_a_point_has_no_curvature():
    m = mesh(sphere, 4)
    assert np.isnan(mean_curvature_of(np.zeros_like(m.points), m.faces, m.normals)).all()
    assert np.isnan(vertex_mean_curvature(np.full_like(m.points, 1e3), m.faces, m.normals)).all()


def test_no_faces():
    empty = np.zeros((0, 3))
    assert mean_curvature_of(empty, np.zeros((0, 3), int), empty).shape == (0,)


def test_errors_name_the_offender():
    m = mesh(sphere, 4)
    with pytest.raises(MeshError, match=r"faces 1, 3 refer to missing vertices") as caught:
        faces = m.faces.copy()
        faces[1, 0], faces[3, 2] = -1, len(m.points)
        mean_curvature_of(m.points, faces, m.normals)
    assert caught.value.faces == (1, 3)
    with pytest.raises(MeshError, match=r"25 vertices, but normals of shape \(24, 3\)"):
        mean_curvature_of(m.points, m.faces, m.normals[1:])
    with pytest.raises(MeshError, match="vertices have shape"):
        mean_curvature_of(m.points.ravel(), m.faces, m.normals)
    with pytest.raises(MeshError, match="three indices a face"):
        mean_curvature_of(m.points, m.faces[:, :2], m.normals)


def test_a_hundred_thousand_faces_take_tens_of_milliseconds():
    m = mesh(sphere, 224, jitter=0.0)
    best = min(timed(lambda: mean_curvature_of(*arguments(m))) for _ in range(5))
    assert len(m.faces) > 100_000
    assert best < 0.2  # 0.025 s on an idle core


def timed(call):
    start = process_time()
    call()
    return process_time() - start
