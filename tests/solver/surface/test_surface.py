"""Surfaces of constant mean curvature against exact ones: convergence, symmetry, scale, arguments."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from solver import (
    CmcSolver,
    ConditionError,
    Domain,
    Status,
    conditions,
    conformal_distortion,
    periods,
    shapes,
    solve_cmc,
)
from solver.surface.averaging import AVERAGINGS
from tests.solver.exact_surfaces import Nodoid, cylinder, disc, hemisphere, rates
from tests.solver.rim_conditions import once_twisted, rim
from tests.solver.surface_errors import centred, curvature_errors, worst

CONSISTENT = [name for name in AVERAGINGS if name != "area"]


@pytest.mark.parametrize("averaging", CONSISTENT)
def test_the_disc_becomes_a_hemisphere_of_radius_two(averaging):
    errors, points_left = [], []
    for n in (500, 2000, 8000):
        domain, points = disc(n)
        surface = solve_cmc(domain, rim(domain, points), averaging=averaging)
        errors.append(worst(surface.f_plus, 2 * hemisphere(points)))
        points_left.append(np.ptp(surface.f_minus, axis=0).max())
    assert rates(errors).min() > 1.7 and rates(points_left).min() > 1.7
    assert surface.is_degenerate("f-") and not surface.is_degenerate("f+")


def test_the_other_side_is_the_mirror_image():
    """Mirrored normals reverse τ: g and f± are the images of g and f∓ under a half turn about the vertical."""
    domain, points = disc(1200)
    up, down = (solve_cmc(domain, rim(domain, points), side=side, tolerance=1e-11) for side in (1, -1))
    assert_allclose(down.normals, up.normals * [1, 1, -1], rtol=0, atol=1e-9)
    assert_allclose(centred(down.f_minus), centred(up.f_plus) * [-1, -1, 1], rtol=0, atol=1e-8)
    assert down.is_degenerate("f+") and up.is_degenerate("f-")


@pytest.mark.parametrize("outline", [[(0, 0), (3, 0), (3, 2), (0, 2)], [(0, 0), (8, 0), (8, 1), (0, 1)]])
def test_flat_plans_become_shells_that_rise(outline):
    shape = shapes.polygon(outline, max_edge=0.1, corner_radius=0.3)
    surface = solve_cmc(shape.domain, rim(shape.domain, shape.positions))
    extent = np.ptp(surface.f_plus, axis=0)
    assert surface.status is Status.CONVERGED and extent[2] > 0.1 * extent[:2].max()
    assert surface.f_plus[shape.domain.boundary_vertices, 2].max() < surface.f_plus[:, 2].max()


@pytest.mark.parametrize("averaging", CONSISTENT)
def test_the_nodoid_from_a_wound_start(averaging):
    exact = Nodoid(0.5)
    errors = {name: [] for name in ("normals", "g", "f+", "f-")}
    for columns in (24, 48, 96):
        domain, points = cylinder(exact.height, columns)
        first, second = domain.boundary_loops
        ends = conditions.fixed_at(domain, first, [1, 0, 0]) + conditions.fixed_at(domain, second, [-1, 0, 0])
        surface = solve_cmc(domain, ends, degree=-1, averaging=averaging)
        assert surface.status is Status.CONVERGED and not surface.is_open
        N, g = exact(points)
        turn = rotation_about_x(N, surface.normals)
        N, g = N @ turn.T, g @ turn.T
        errors["normals"].append(np.abs(surface.normals - N).max())
        errors["g"].append(worst(surface.g, g))
        errors["f+"].append(worst(surface.f_plus, g + N))
        errors["f-"].append(worst(surface.f_minus, g - N))
    for name, values in errors.items():
        # one pair of meshes may lie a little off the trend; the trend is second order
        assert rates(values).mean() > 1.7, name


def rotation_about_x(N, turned):
    """The rotation about e₁ that brings N nearest to `turned` (the phase of a nodoid is its own choice)."""
    angle = np.angle(np.sum((turned[:, 1] + 1j * turned[:, 2]) * np.conj(N[:, 1] + 1j * N[:, 2])))
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[1, 0, 0], [0, c, -s], [0, s, c]])


def test_curvature_and_conformality_converge_on_jittered_discs():
    """m = 1, default average: H first order in L² (and nearly in L∞), ½ (Q + 1/Q) - 1 second order."""
    l2, linf, distortion = [], [], []
    for n in (2000, 8000, 32000):
        domain, points = disc(n, jitter=0.2)
        surface = solve_cmc(domain, once_twisted(domain, points))
        Q = conformal_distortion(domain, surface.f_plus)
        l2.append(curvature_errors(surface)[0])
        linf.append(curvature_errors(surface)[1])
        distortion.append(np.average(0.5 * (Q + 1 / Q) - 1, weights=domain.face_areas))
    assert rates(l2).min() > 0.9 and rates(linf).mean() > 0.75 and rates(distortion).min() > 1.8
    assert l2[-1] < 2.5e-3


def test_the_area_average_does_not_converge_on_jittered_meshes():
    """Eq. 11 stays selectable under its name; this is why it is not the default."""
    errors = []
    for n in (2000, 8000):
        domain, points = disc(n)
        errors.append(curvature_errors(solve_cmc(domain, rim(domain, points), averaging="area"))[0])
    assert min(errors) > 0.02 and rates(errors)[0] < 0.5


def test_rotating_the_data_rotates_the_result():
    domain, points = disc(800)
    turn = np.linalg.qr(np.random.default_rng(3).normal(size=(3, 3)))[0]
    turn *= np.sign(np.linalg.det(turn))
    flat = np.column_stack([points, 0 * points[:, 0]])

    def as_drawn(domain, points):
        return conditions.binormal(domain, points, domain.boundary_edges, against="surface")

    for make in (as_drawn, once_twisted):
        one = solve_cmc(domain, make(domain, flat), tolerance=1e-10)
        other = solve_cmc(domain, make(domain, flat @ turn.T), tolerance=1e-10)
        assert_allclose(other.normals, one.normals @ turn.T, rtol=0, atol=1e-9)
        assert_allclose(other.f_plus, one.f_plus @ turn.T, rtol=0, atol=1e-9)


@pytest.mark.parametrize("mean_curvature", [0.05, 0.5, 3.0])
def test_the_mean_curvature_asked_for_is_the_one_obtained(mean_curvature):
    domain, points = disc(2000)
    surface = solve_cmc(domain, rim(domain, points, 0.2), mean_curvature=mean_curvature)
    assert_allclose(surface.scale, 0.5 / mean_curvature, rtol=1e-15, atol=0)
    assert surface.mean_curvature == pytest.approx(mean_curvature, rel=1e-15)
    assert curvature_errors(surface)[0] < 2e-3 * mean_curvature
    for sign, sheet in ((1, surface.f_plus), (-1, surface.f_minus)):
        assert_allclose(sheet, surface.g + sign * surface.scale * surface.normals, rtol=1e-12, atol=1e-12)
    assert_allclose(surface.g[domain.boundary_vertices].mean(axis=0), 0, rtol=0, atol=1e-10 / mean_curvature)


@pytest.mark.parametrize("value", [0.0, -0.5, np.nan, np.inf])
def test_mean_curvatures_that_make_no_surface_are_refused(value):
    domain, points = disc(60)
    with pytest.raises(ConditionError, match="mean curvature"):
        solve_cmc(domain, rim(domain, points), mean_curvature=value)


def test_simply_connected_surfaces_keep_the_faces_of_the_domain():
    domain, points = disc(300)
    surface = solve_cmc(domain, rim(domain, points))
    assert_array_equal(surface.faces, domain.faces)
    assert_array_equal(surface.source, np.arange(domain.vertex_count))
    assert periods(surface).shape == (0, 3) and surface.gap == 0


@pytest.mark.parametrize("free", ["left", "top"])
def test_free_sides_need_no_factor_of_their_own(free):
    """With a free side the P1 solve uses the natural condition there; it must agree with the fit."""
    shape = shapes.strip(2.0, 1.0, 40)
    edges = np.setdiff1d(shape.domain.boundary_edges, shape.sides[free])
    condition = conditions.binormal(shape.domain, shape.positions, edges, tilt=0.5)
    one, other = (solve_cmc(shape.domain, condition, averaging=name) for name in CONSISTENT)
    assert worst(one.f_plus, other.f_plus) < 0.02 * np.ptp(one.f_plus, axis=0).max()


def test_a_cached_solver_gives_the_same_surface():
    domain, points = disc(600)
    solver = CmcSolver(domain)
    solver.solve(rim(domain, points, 0.4))
    again = solver.solve(rim(domain, points, 0.1))
    fresh = solve_cmc(domain, rim(domain, points, 0.1))
    assert_array_equal(again.f_plus, fresh.f_plus)


def test_normals_inside_are_refused():
    domain, points = disc(200)
    inside = int(np.setdiff1d(np.arange(domain.vertex_count), domain.boundary_vertices)[3])
    condition = rim(domain, points) + conditions.fixed_at(domain, [inside], [0, 0, 1])
    with pytest.raises(ConditionError, match=f"vertex {inside}") as caught:
        solve_cmc(domain, condition)
    assert caught.value.vertices == (inside,)


def test_a_cancelled_solve_still_gives_its_surface():
    domain, points = disc(600)
    surface = solve_cmc(domain, rim(domain, points), progress=lambda step, residual: step < 1)
    assert surface.status is Status.CANCELLED and np.isfinite(surface.f_plus).all()


def test_unknown_names_are_refused():
    domain, points = disc(60)
    wrong = ({"averaging": "nosuch"}, {"energy": "nosuch"}, {"energy": "mobius"}, {"sites": "nosuch"}, {"method": "no"})
    for arguments in wrong:
        with pytest.raises(ConditionError):
            solve_cmc(domain, rim(domain, points), **arguments)
    with pytest.raises(ConditionError, match="f\\+"):
        solve_cmc(domain, rim(domain, points)).sheet("nosuch")


def test_sheets_as_meshes():
    domain, points = disc(60)
    surface = solve_cmc(domain, rim(domain, points))
    mesh = surface.as_mesh("f+")
    assert_array_equal(mesh.vertices, surface.f_plus)
    assert_array_equal(np.stack(mesh.polygons), surface.faces)
    with pytest.raises(ConditionError, match="primal"):
        surface.as_mesh("f+", combinatorics="nosuch")


def test_it_works_on_a_curved_plan():
    """A domain need not be flat: a shallow cap as drawn surface, its own Gauss map as the data, gives a cap again."""
    domain, points = disc(4000)
    cap = hemisphere(0.4 * points)
    drawn = Domain.from_positions(cap, domain.faces)
    sites = drawn.boundary_vertices
    surface = solve_cmc(drawn, conditions.fixed_at(drawn, sites, cap[sites]))
    assert_allclose(surface.normals, cap, rtol=0, atol=2e-3)
    assert worst(surface.f_plus, 2 * cap) < 4e-3
