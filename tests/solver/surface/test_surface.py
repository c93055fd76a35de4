"""From normals to f±: exact surfaces, rates, symmetries, holes, and the promises of the result."""

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
    mean_curvature_of,
    periods,
    shapes,
    solve_cmc,
)
from solver.domain.sites import SiteGraph
from solver.gauss.energies import ENERGIES
from solver.surface.averaging import AVERAGINGS
from solver.surface.conjugate import Conjugation, solve_dual_poisson
from solver.surface.vertex_fit import fit_weights
from tests.solver.exact_surfaces import Nodoid, cylinder, disc, hemisphere, rates

CONSISTENT = [name for name in AVERAGINGS if name != "area"]
COURTYARD = ([(0, 0), (4, 0), (4, 3), (0, 3)], [[(0.7, 0.7), (1.7, 0.7), (1.7, 1.7), (0.7, 1.7)]])


def rim(domain, points, tilt=0.0):
    return conditions.binormal(domain, points, domain.boundary_edges, tilt=tilt)


def once_twisted(domain, points):
    return conditions.twisted(domain, points, domain.boundary_edges, 1)


def centred(points):
    return points - points.mean(axis=0)


def worst(a, b):
    """Largest distance between corresponding points, translation aside."""
    return np.linalg.norm(centred(a) - centred(b), axis=1).max()


def curvature_errors(surface):
    """L² and L∞ errors of H over the area of f+."""
    H = mean_curvature_of(surface.f_plus, surface.faces, surface.normals)
    a, b, c = (surface.f_plus[surface.faces[:, k]] for k in range(3))
    areas = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    error = H - surface.mean_curvature
    return np.sqrt(np.average(error**2, weights=areas)), np.abs(error).max()


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
    for make in (rim, once_twisted):
        one = solve_cmc(domain, make(domain, flat), tolerance=1e-10)
        other = solve_cmc(domain, make(domain, flat @ turn.T), tolerance=1e-10)
        assert_allclose(other.normals, one.normals @ turn.T, rtol=0, atol=1e-9)
        assert_allclose(other.f_plus, one.f_plus @ turn.T, rtol=0, atol=1e-9)


def test_three_ways_to_the_conjugate_agree():
    """The sum of τ along a tree, the dual Poisson equation (both at circumcentres) and the P1 solve (at vertices)."""
    differences = []
    for n in (500, 2000):
        shape = shapes.disc(n)
        domain = shape.domain
        surface = solve_cmc(domain, once_twisted(domain, shape.positions), tolerance=1e-11)
        by_tree = centred(surface.conjugate.g)
        assert_allclose(solve_dual_poisson(surface.graph, surface.normals), by_tree, rtol=0, atol=1e-8)
        faces, edges = fit_weights(domain, np.arange(domain.vertex_count))
        conjugate = surface.conjugate
        fitted = faces @ np.repeat(conjugate.g, 3, axis=0) + edges @ np.repeat(conjugate.boundary_points, 2, axis=0)
        differences.append(worst(fitted, surface.g))
    assert rates(differences)[0] > 1.5


def test_tau_closes_exactly_as_far_as_the_map_is_harmonic():
    domain, points = disc(800)
    solver = CmcSolver(domain)
    loose = solver.solve(once_twisted(domain, points), tolerance=1e-2, max_iterations=2)
    tight = solver.solve(once_twisted(domain, points), tolerance=1e-12)
    assert tight.conjugate.closure_error < 1e-12 < loose.conjugate.closure_error
    random = np.random.default_rng(0).normal(size=(domain.vertex_count, 3))
    N = random / np.linalg.norm(random, axis=1, keepdims=True)
    conjugate = Conjugation(SiteGraph.of(domain, "vertices")).conjugate(N, ENERGIES["cotan"])
    torques = np.linalg.norm(np.cross(N, domain.laplacian @ N), axis=1)
    inside = np.setdiff1d(np.arange(domain.vertex_count), domain.boundary_vertices)
    assert_allclose(conjugate.closure_error, torques[inside].max(), rtol=1e-10, atol=0)


def test_edges_of_the_conjugate_are_orthogonal_to_both_normals():
    domain, points = disc(300)
    surface = solve_cmc(domain, once_twisted(domain, points))
    for end in domain.edges.T:
        assert_allclose(np.einsum("ij,ij->i", surface.conjugate.tau, surface.normals[end]), 0, rtol=0, atol=1e-14)


def test_boundary_points_complete_the_dual_polygons():
    """Figure 7: the dual polygon of a boundary vertex runs through its faces and a point on each of its two edges."""
    domain, points = disc(300)
    surface = solve_cmc(domain, once_twisted(domain, points))
    conjugate = surface.conjugate
    faces = domain.edge_faces[domain.boundary_edges, 0]
    across = conjugate.g[faces] - conjugate.boundary_points
    assert_allclose(across, conjugate.tau[domain.boundary_edges], rtol=0, atol=1e-14)
    on_faces = solve_cmc(domain, once_twisted(domain, points), sites="faces", energy="dual_cotan").conjugate
    assert on_faces.boundary_points.shape == (0, 3), "with normals on faces g is at the vertices already"


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


def test_a_ring_with_symmetric_data_closes():
    shape = shapes.annulus(0.5, 1.0, 1500)
    surface = solve_cmc(shape.domain, rim(shape.domain, shape.positions))
    assert surface.status is Status.CONVERGED and not surface.is_open
    assert surface.gap < 1e-3 * np.ptp(surface.f_plus, axis=0).max()
    assert len(surface.f_plus) == shape.domain.vertex_count


@pytest.mark.parametrize("averaging", AVERAGINGS)
def test_a_courtyard_off_centre_is_cut_and_its_gap_named(averaging):
    shape = shapes.polygon(*COURTYARD, max_edge=0.08, corner_radius=0.3)
    surface = solve_cmc(shape.domain, rim(shape.domain, shape.positions), averaging=averaging)
    domain, n = shape.domain, len(surface.source)
    assert surface.status is Status.GAP and surface.is_open and n > domain.vertex_count
    assert f"{surface.gap:.4g}" in surface.message
    assert_array_equal(surface.source[surface.faces], domain.faces)
    extra = np.arange(domain.vertex_count, n)
    jumps = surface.f_plus[extra] - surface.f_plus[surface.source[extra]]
    assert_allclose(np.linalg.norm(jumps, axis=1), surface.gap, rtol=1e-9, atol=0)
    if averaging != "area":
        assert curvature_errors(surface)[0] < 0.05


def test_the_seam_is_not_seen_in_the_curvature():
    """Faces at the cut are as good as the others: where the domain is cut is an accident."""
    shape = shapes.polygon(*COURTYARD, max_edge=0.1, corner_radius=0.3)
    surface = solve_cmc(shape.domain, rim(shape.domain, shape.positions))
    H = mean_curvature_of(surface.f_plus, surface.faces, surface.normals)
    at_seam = (np.bincount(surface.source) > 1)[shape.domain.faces].any(axis=1)
    at_rim = np.isin(shape.domain.faces, shape.domain.boundary_vertices).any(axis=1)
    assert np.abs(H - 0.5)[at_seam & ~at_rim].max() < 3 * np.abs(H - 0.5)[~at_seam & ~at_rim].max()


def test_small_periods_are_projected_out_and_reported():
    shape = shapes.polygon(*COURTYARD, max_edge=0.15, corner_radius=0.3)
    surface = solve_cmc(shape.domain, rim(shape.domain, shape.positions), period_tolerance=10.0)
    assert not surface.is_open and surface.status is Status.CONVERGED
    assert len(surface.f_plus) == shape.domain.vertex_count
    assert surface.gap > 0.1 and periods(surface).shape == (1, 3)


def test_the_period_does_not_depend_on_the_mesh():
    gaps = []
    for edge in (0.08, 0.04):
        shape = shapes.polygon(*COURTYARD, max_edge=edge, corner_radius=0.3)
        gaps.append(solve_cmc(shape.domain, rim(shape.domain, shape.positions)).gap)
    assert_allclose(gaps[0], gaps[1], rtol=0.02, atol=0)


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


@pytest.mark.parametrize("name", ["disc", "annulus"])
def test_linear_functions_are_reproduced_by_the_fit(name):
    if name == "disc":
        domain, points = disc(800)
    else:
        shape = shapes.annulus(0.4, 1.0, 800)
        domain, points = shape.domain, shape.positions
    values = lambda x: x @ np.array([[1.0, 2.0, 3.0], [0.5, -1.0, 2.0]]) + 1.0  # noqa: E731
    a, b, c = (points[domain.faces[:, k]] for k in range(3))
    ab, ac = b - a, c - a
    twice = 2 * (ab[:, 0] * ac[:, 1] - ab[:, 1] * ac[:, 0])
    squares = np.sum(ab**2, axis=1), np.sum(ac**2, axis=1)
    centre = a + np.column_stack(
        [
            (squares[0] * ac[:, 1] - squares[1] * ab[:, 1]) / twice,
            (squares[1] * ab[:, 0] - squares[0] * ac[:, 0]) / twice,
        ]
    )
    faces, edges = fit_weights(domain, np.arange(domain.vertex_count))
    midpoints = points[domain.edges[domain.boundary_edges]].mean(axis=1)
    fitted = faces @ np.repeat(values(centre), 3, axis=0) + edges @ np.repeat(values(midpoints), 2, axis=0)
    assert_allclose(fitted, values(points), rtol=0, atol=1e-11)
