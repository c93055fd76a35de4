"""The quasi-conformal distortion of linear maps known by their singular values, and of conformal surfaces."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

from solver import shapes
from solver.domain.domain import Domain
from solver.errors import MeshError
from solver.measure import conformal_distortion, distortion_energy, distortion_of_layout
from tests.solver.sampled_surfaces import NODOID, UNDULOID_TWIN, cylinder, grid, sample, sphere


def rotation(random, n):
    return np.linalg.qr(random.normal(size=(n, n)))[0]


@pytest.mark.parametrize("ratio", [1.0, 1.0 + 1e-9, 1.5, 40.0])
def test_linear_maps(ratio):
    random = np.random.default_rng(5)
    layout = random.normal(size=(200, 3, 2))
    linear = rotation(random, 3)[:, :2] @ np.diag([0.3 * ratio, 0.3]) @ rotation(random, 2)
    corners = layout @ linear.T + 5.0
    Q = distortion_of_layout(layout, corners.reshape(-1, 3), np.arange(600).reshape(200, 3))
    assert_allclose(Q, ratio, rtol=1e-9)
    assert (Q >= 1.0).all()


def test_agrees_with_the_singular_values():
    random = np.random.default_rng(6)
    layout, corners = random.normal(size=(100, 3, 2)), random.normal(size=(100, 3, 3))
    Q = distortion_of_layout(layout, corners.reshape(-1, 3), np.arange(300).reshape(100, 3))
    for f in range(100):
        plane = (layout[f, 1:] - layout[f, 0]).T
        space = (corners[f, 1:] - corners[f, 0]).T
        large, small = np.linalg.svd(space @ np.linalg.inv(plane), compute_uv=False)
        assert Q[f] == pytest.approx(large / small, rel=1e-9)


@pytest.mark.parametrize("surface", [sphere, NODOID, UNDULOID_TWIN])
def test_conformal_surfaces_converge(surface):
    errors = []
    for n in (16, 32, 64):
        m = sample(surface, n, n, (2.0, 2.0), 0.2)
        Q = conformal_distortion(Domain.from_positions(m.parameters, m.faces), m.points)
        l2 = np.sqrt(np.average((Q - 1) ** 2, weights=m.areas))
        errors.append([l2, np.average(distortion_energy(Q), weights=m.areas)])
    rates = np.log2(np.array(errors[:-1]) / np.array(errors[1:]))
    assert (rates > (0.9, 1.8)).all(), rates


def test_an_isometry_has_none():
    points, faces = grid(7, 5, 3.0, 2.0, 0.2)
    Q = conformal_distortion(Domain.from_positions(points, faces), points)
    assert_allclose(Q, 1.0, atol=1e-12)
    m = sample(cylinder, 64, 4, (2.0, 2.0), 0.0)
    assert_allclose(conformal_distortion(Domain.from_positions(m.parameters, m.faces), m.points), 1.0, atol=1e-3)


def test_a_cut_surface_brings_its_own_faces():
    points, faces = grid(4, 3, 1.0, 1.0)
    domain = Domain.from_positions(points, faces)
    rows = np.arange(3 * len(faces)).reshape(-1, 3)
    Q = conformal_distortion(domain, points[faces].reshape(-1, 2) * (1.0, 3.0), rows)
    assert_allclose(Q, 3.0, rtol=1e-12)


def test_a_shape_serves_as_domain():
    shape = shapes.disc(60)
    stretched = shape.positions * (2.0, 1.0)
    assert_allclose(conformal_distortion(shape, stretched), 2.0, rtol=1e-12)
    with pytest.raises(MeshError, match="A Domain or a Shape is needed here, not list"):
        conformal_distortion([shape], stretched)


def test_energy_is_quadratic():
    assert_allclose(distortion_energy([1.0, 2.0, 1.0 + 1e-6]), [0.0, 0.25, 5e-13], rtol=1e-5)


def test_collapsed_faces_are_nan():
    layout = np.tile([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]], (3, 1, 1))
    points = np.array([[0, 0, 0], [1, 0, 0], [2, 0, 0], [0, 1, 0]], dtype=float)
    Q = distortion_of_layout(layout, points, np.array([[0, 1, 2], [0, 0, 0], [0, 1, 3]]))
    assert np.isnan(Q[:2]).all()
    assert Q[2] == pytest.approx(1.0)


def test_error_on_a_layout_that_does_not_match():
    with pytest.raises(MeshError, match=r"1 faces, but a layout of shape \(2, 3, 2\)"):
        distortion_of_layout(np.zeros((2, 3, 2)), np.eye(3), np.array([[0, 1, 2]]))
