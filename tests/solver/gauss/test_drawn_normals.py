"""The normals of a drawn surface along its rim: second order, on jittered meshes too, and shells that keep them."""

from __future__ import annotations

import numpy as np
from numpy.testing import assert_allclose

from solver import Domain, conditions, solve_cmc
from solver.gauss.drawn_normals import drawn_normals
from tests.solver.exact_surfaces import disc, hemisphere, rates

CAP = np.tan(np.radians(30.0))  # stereographic radius of the cap of 60 degrees


def cap(n: int) -> tuple[Domain, np.ndarray]:
    """A cap of the unit sphere on a jittered mesh, whose points are their own normals."""
    flat, points = disc(n)
    on_sphere = hemisphere(CAP * points)
    return Domain.from_positions(on_sphere, flat.faces), on_sphere


def saddle(n: int) -> tuple[Domain, np.ndarray, np.ndarray]:
    """z = x² - y² + x y² over the disc, and its normals; no symmetry makes odd errors vanish."""
    flat, plane = disc(n)
    x, y = plane.T
    points = np.column_stack([x, y, x**2 - y**2 + x * y**2])
    normals = np.column_stack([-2 * x - y**2, 2 * y - 2 * x * y, np.ones_like(x)])
    return Domain.from_positions(points, flat.faces), points, normals / np.linalg.norm(normals, axis=1, keepdims=True)


def test_normals_of_a_saddle_at_its_rim_are_second_order():
    errors = []
    for n in (400, 1600, 6400):
        domain, points, normals = saddle(n)
        sites, found = conditions.gauss_map(domain, points, domain.boundary_edges).resolve()
        errors.append(np.abs(found - normals[sites]).max())
    assert rates(errors).min() > 1.7 and errors[-1] < 2e-3


def test_a_shell_that_keeps_the_planes_of_a_cap_is_that_cap():
    """Positions as near as with exact normals: 1.8e-3, 4.3e-4, 1.1e-4 on regular meshes."""
    errors = []
    for n in (400, 1600, 6400):
        domain, points = cap(n)
        shell = solve_cmc(
            domain, conditions.gauss_map(domain, points, domain.boundary_edges), tolerance=1e-9, mean_curvature=1.0
        )
        moved = shell.f_plus / np.linalg.norm(shell.f_plus - shell.f_plus.mean(axis=0), axis=1).max()
        moved = moved * np.linalg.norm(points - points.mean(axis=0), axis=1).max()
        errors.append(np.linalg.norm(moved - moved.mean(axis=0) - points + points.mean(axis=0), axis=1).max())
    assert rates(errors).min() > 1.6 and errors[-1] < 5e-4


def test_a_mesh_too_small_for_a_quadratic_keeps_the_mean():
    points = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0.5], [0, 1, 0]])
    domain = Domain.from_positions(points, np.array([[0, 1, 2], [0, 2, 3]]))
    faces = np.cross(points[domain.faces[:, 1]] - points[domain.faces[:, 0]],
                     points[domain.faces[:, 2]] - points[domain.faces[:, 0]])  # fmt: skip
    found = drawn_normals(domain, points)
    assert_allclose(found[1], faces[0] / np.linalg.norm(faces[0]), atol=1e-12)
    assert_allclose(np.linalg.norm(found, axis=1), 1.0)


def test_a_flat_sheet_has_one_normal():
    domain, points = disc(300)
    assert_allclose(drawn_normals(domain, np.column_stack([points, 0 * points[:, 0]])), [[0, 0, 1]] * len(points))


def test_a_fan_of_many_edges_keeps_the_mean():
    """All ends of a fan are within two edges of each other; fitting to them took a minute and 4.6 GB for 3,000."""
    count = 3000
    angles = 2.0 * np.pi * np.arange(count) / count
    points = np.vstack([[0.0, 0.0, 0.3], np.column_stack([np.cos(angles), np.sin(angles), 0.0 * angles])])
    ends = np.arange(count)
    domain = Domain.from_positions(points, np.column_stack([0 * ends, 1 + ends, 1 + (ends + 1) % count]))
    normals = drawn_normals(domain, points)[1:]
    slope = np.array([0.3, 1.0]) / np.hypot(0.3, 1.0)
    assert_allclose(normals, np.column_stack([slope[0] * points[1:, :2], 0 * ends + slope[1]]), atol=1e-4)
