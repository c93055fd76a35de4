"""Principal curvatures and directions at vertices against exact surfaces, and Gauss curvature against angles."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

from solver import conditions, shapes, solve_cmc, vertex_principal_curvatures
from solver.errors import MeshError
from solver.measure import gauss_curvature_of, principal_curvatures, vertex_gauss_curvature, vertex_mean_curvature
from tests.solver.sampled_surfaces import NODOID, NODOID_TWIN, UNDULOID, UNDULOID_TWIN, Sample, cylinder, sample, sphere

DELAUNAY = {"nodoid": NODOID, "nodoid f-": NODOID_TWIN, "unduloid": UNDULOID, "unduloid f-": UNDULOID_TWIN}


def mesh(surface, n: int, jitter: float = 0.2) -> Sample:
    return sample(surface, n, n, (2.0, 2.0), jitter)


def curvatures(m: Sample):
    return vertex_principal_curvatures(m.points, m.faces, m.normals)


def inside(m: Sample) -> np.ndarray:
    return ((m.parameters > 1e-9) & (m.parameters < 2.0 - 1e-9)).all(axis=1)


def rms(values) -> float:
    return float(np.sqrt(np.mean(np.square(values))))


def rates(errors) -> np.ndarray:
    return np.log2(np.asarray(errors)[:-1] / np.asarray(errors)[1:])


@pytest.mark.parametrize(("jitter", "least"), [(0.0, 1.4), (0.2, 0.95)])
@pytest.mark.parametrize("name", DELAUNAY)
def test_lines_run_along_parallels_and_meridians(name, jitter, least):
    """Directions, k1 and K converge: with order 1.5 (2 inside) on a regular mesh, 1 on a jittered one."""
    errors, surface = [], DELAUNAY[name]
    for n in (16, 32, 64):
        m = mesh(surface, n, jitter)
        found, t = curvatures(m), m.parameters[:, 0]
        parallel, meridian = surface.curvatures(m.parameters[:, 1])
        around = np.stack([-np.sin(t), np.cos(t), 0.0 * t], axis=1)
        line = np.where((parallel > meridian)[:, None], found.direction1, found.direction2)
        defined = found.strength > 0.0
        assert defined.mean() > 0.95
        errors.append(
            [
                rms(np.linalg.norm(np.cross(line, around), axis=1)[defined]),
                rms(found.k1 - np.maximum(parallel, meridian)),
                rms(found.gauss - parallel * meridian),
                rms(vertex_gauss_curvature(m.points, m.faces, m.normals) - parallel * meridian),
            ]
        )
    assert (rates(errors).min(axis=0) > least).all(), rates(errors)
    assert defined.all() and errors[-1][0] < 4e-3


def test_of_second_order_inside_a_regular_mesh():
    errors = []
    for n in (16, 32, 64):
        m = mesh(UNDULOID, n, 0.0)
        parallel, meridian = UNDULOID.curvatures(m.parameters[:, 1])
        errors.append(np.abs(curvatures(m).gauss - parallel * meridian)[inside(m)].max())
    assert (rates(errors) > 1.9).all(), rates(errors)


def test_a_sphere_has_no_directions():
    m = mesh(sphere, 16)
    found = curvatures(m)
    assert not found.strength.any() and not found.direction1.any() and not found.direction2.any()
    assert_allclose(found.k1, 0.5, atol=3e-3)
    assert_allclose(found.gauss, 0.25, atol=3e-3)
    assert_allclose(vertex_gauss_curvature(m.points, m.faces, m.normals), 0.25, rtol=1e-10)


def test_nor_has_a_hemisphere_that_was_solved_for():
    """What is left of k1 - k2 is that of the mesh; the faces themselves do have directions, at random."""
    plan = shapes.disc(600)
    rim = conditions.binormal(plan.domain, plan.positions, plan.sides["outer"])
    dome = solve_cmc(plan.domain, rim)
    found = vertex_principal_curvatures(dome.f_plus, dome.faces, dome.normals)
    assert not found.strength.any()
    assert np.abs(principal_curvatures(dome.f_plus, dome.faces, dome.normals).umbilicity).max() > 1e-3


def test_noise_has_no_directions():
    """Normals that are a little off at random bend every face somehow; of a surface with directions they stay known."""
    shares, off = [], 0.01 * np.random.default_rng(4).normal(size=(625, 3))
    for surface in (sphere, UNDULOID):
        m = mesh(surface, 24)
        normals = (m.normals + off) / np.linalg.norm(m.normals + off, axis=1, keepdims=True)
        assert principal_curvatures(m.points, m.faces, normals).umbilicity.min() > 1e-3
        shares.append((vertex_principal_curvatures(m.points, m.faces, normals).strength > 0.0).mean())
    assert shares[0] < 0.15 and shares[1] > 0.97


def test_a_cylinder_bends_around_and_not_along():
    m = mesh(cylinder, 32)
    found = curvatures(m)
    assert_allclose(found.k1, 1.0, atol=3e-3)
    assert_allclose(found.k2, 0.0, atol=1e-3)
    assert_allclose(np.abs(found.direction2[:, 2]), 1.0, atol=1e-3)
    assert_allclose(found.strength, 1.0)


def test_frames_are_square_to_the_normals():
    m = mesh(NODOID, 12)
    found = curvatures(m)
    for a, b, expected in (
        (found.direction1, found.direction1, 1.0),
        (found.direction2, found.direction2, 1.0),
        (found.direction1, found.direction2, 0.0),
        (found.direction1, m.normals, 0.0),
        (found.direction2, m.normals, 0.0),
    ):
        assert_allclose(np.einsum("ni,ni->n", a, b), expected, atol=1e-12)
    assert (found.k1 >= found.k2).all()


def test_a_turned_scaled_and_flipped_surface():
    m = mesh(UNDULOID, 10)
    turn = np.linalg.qr(np.random.default_rng(2).normal(size=(3, 3)))[0]
    here, there = curvatures(m), vertex_principal_curvatures(10.0 * m.points @ turn, m.faces, m.normals @ turn)
    assert_allclose(there.k1, 0.1 * here.k1, rtol=1e-9, atol=1e-12)
    along = np.einsum("ni,ni->n", there.direction1, here.direction1 @ turn)
    assert_allclose(np.abs(along), 1.0, atol=1e-9)
    back = vertex_principal_curvatures(m.points, m.faces[:, [1, 0, 2]], -m.normals)
    assert_allclose(back.k1, -here.k2, rtol=1e-9, atol=1e-12)
    assert_allclose(np.abs(np.einsum("ni,ni->n", back.direction1, here.direction2)), 1.0, atol=1e-9)


@pytest.mark.parametrize("name", DELAUNAY)
def test_gauss_curvature_is_what_angles_lack_of_a_full_turn(name):
    """∫ φ K with K = det S on the faces, and Σ φ (2π - Σ angles) over the vertices, for a φ that is 0 along the rim."""
    errors = []
    for n in (16, 32, 64):
        m = mesh(DELAUNAY[name], n)
        bump = np.sin(0.5 * np.pi * m.parameters).prod(axis=1)
        turned = gauss_curvature_of(m.points, m.faces, m.normals) * m.areas @ bump[m.faces].mean(axis=1)
        errors.append(abs(turned - bump @ angle_defects(m)) / abs(turned))
    assert (rates(errors) > 0.9).all() and errors[-1] < 0.01, errors


def angle_defects(m: Sample) -> np.ndarray:
    """2π less the angles around each vertex (n,)."""
    corners = m.points[m.faces]
    sides = np.roll(corners, -1, axis=1) - corners
    unit = sides / np.linalg.norm(sides, axis=2, keepdims=True)
    angles = np.pi - np.arccos(np.einsum("fki,fki->fk", unit, np.roll(unit, 1, axis=1)).clip(-1, 1))
    return 2.0 * np.pi - np.bincount(m.faces.ravel(), angles.ravel(), len(m.points))


def test_mean_curvature_is_the_trace():
    m = mesh(NODOID_TWIN, 32)
    assert_allclose(curvatures(m).mean, vertex_mean_curvature(m.points, m.faces, m.normals), atol=2e-2)


def test_vertices_without_a_proper_face():
    m = mesh(UNDULOID, 6)
    points, normals = np.vstack([m.points, [[0, 0, 9]]]), np.vstack([m.normals, [[0, 0, 1]]])
    last = len(m.points)
    faces = np.vstack([m.faces, [[0, last, last]]])
    found, to_plain = vertex_principal_curvatures(points, faces, normals), curvatures(m)
    assert np.isnan(found.k1[last]) and found.strength[last] == 0.0 and not found.direction1[last].any()
    assert_allclose(found.k1[:last], to_plain.k1, rtol=1e-12)


def test_no_faces_and_wrong_shapes():
    none = vertex_principal_curvatures(np.zeros((0, 3)), np.zeros((0, 3), int), np.zeros((0, 3)))
    assert none.k1.shape == (0,) and none.direction1.shape == (0, 3)
    m = mesh(sphere, 4)
    with pytest.raises(MeshError, match=r"25 vertices, but normals of shape \(24, 3\)"):
        vertex_principal_curvatures(m.points, m.faces, m.normals[1:])
