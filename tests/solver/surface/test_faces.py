"""Normals on faces: conditions, conjugates, surfaces, beside those of normals on vertices."""

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from solver import (
    ConditionError,
    Conditions,
    Domain,
    HarmonicSolver,
    Status,
    conditions,
    conformal_distortion,
    mean_curvature_of,
    shapes,
    solve_cmc,
)
from solver.domain.sites import SiteGraph
from solver.gauss.energies import ENERGIES
from tests.solver.exact_surfaces import rates

ON_FACES = [name for name, energy in ENERGIES.items() if "faces" in energy.sites]


def faces_behind(domain, edges):
    return domain.edge_faces[edges, 0]


def test_edges_fix_the_faces_behind_them():
    shape = shapes.disc(200)
    domain, edges = shape.domain, shape.domain.boundary_edges
    behind, owners = faces_behind(domain, edges), SiteGraph.of(domain, "faces").owners
    sites, normals = conditions.fixed(domain, edges, [0, 3, 4]).resolve("faces", owners)
    assert_array_equal(sites, np.unique(behind))
    assert_allclose(normals, np.tile([0, 0.6, 0.8], (len(sites), 1)), rtol=0, atol=1e-15)
    one_each = np.column_stack([shape.positions[domain.edges[edges]].mean(axis=1)[:, :2], np.ones(len(edges))])
    sites, normals = conditions.fixed(domain, edges, one_each).resolve("faces", owners)
    expected = one_each[np.argsort(behind)] / np.linalg.norm(one_each, axis=1)[np.argsort(behind), None]
    assert_allclose(normals, expected, rtol=0, atol=1e-15)
    found = HarmonicSolver(domain, sites="faces").solve(conditions.fixed(domain, edges, one_each))
    assert_array_equal(found.normals[sites], normals)
    assert found.normals.shape == (len(domain.faces), 3)


def test_conditions_hold_in_the_middle_of_edges():
    """On the unit disc the conormal in the middle of an edge is radial, and θ is the angle of that middle."""
    shape = shapes.disc(300)
    domain, points = shape.domain, shape.positions
    middle = points[domain.edges[domain.boundary_edges]].mean(axis=1)[:, :2]
    middle /= np.linalg.norm(middle, axis=1)[:, None]
    order, owners = np.argsort(faces_behind(domain, domain.boundary_edges)), SiteGraph.of(domain, "faces").owners
    tilted = conditions.binormal(domain, points, domain.boundary_edges, 0.4)
    expected = np.column_stack([np.cos(0.4) * middle, np.full(len(middle), np.sin(0.4))])
    assert_allclose(tilted.resolve("faces", owners)[1], expected[order], rtol=0, atol=1e-12)
    start = points[domain.boundary_loops[0][0]]
    angle = np.mod(np.arctan2(middle[:, 1], middle[:, 0]) - np.arctan2(start[1], start[0]), 2 * np.pi)
    turned = conditions.twisted(domain, points, domain.boundary_edges, 2)
    expected = np.column_stack([np.cos(2 * angle)[:, None] * middle, np.sin(2 * angle)])
    assert_allclose(turned.resolve("faces", owners)[1], expected[order], rtol=0, atol=1e-12)
    flat = conditions.gauss_map(domain, points, domain.boundary_edges)
    assert_allclose(flat.resolve("faces", owners)[1], np.tile([0, 0, 1], (len(middle), 1)), atol=1e-12)


def test_normals_prescribed_one_by_one_belong_to_one_kind_of_site():
    domain = shapes.disc(100).domain
    face = int(faces_behind(domain, domain.boundary_edges)[0])
    vertex = int(domain.boundary_vertices[0])
    mixed = conditions.fixed(domain, domain.boundary_edges[1:], [0, 0, 1]) + conditions.fixed_at_faces(
        domain, [face], [1, 0, 0]
    )
    found = HarmonicSolver(domain, sites="faces").solve(mixed)
    assert_array_equal(found.normals[face], [1, 0, 0])
    with pytest.raises(ConditionError, match=f"face {face}") as error:
        HarmonicSolver(domain).solve(mixed)
    assert error.value.faces == (face,)
    with pytest.raises(ConditionError, match=f"vertex {vertex}") as error:
        HarmonicSolver(domain, sites="faces").solve(conditions.fixed_at(domain, [vertex], [1, 0, 0]))
    assert error.value.vertices == (vertex,)
    with pytest.raises(ConditionError, match=f"indices run from 0 to {len(domain.faces) - 1}"):
        conditions.fixed_at_faces(domain, [len(domain.faces)], [0, 0, 1])
    inside = int(np.setdiff1d(np.arange(len(domain.faces)), domain.edge_faces[domain.boundary_edges, 0])[0])
    with pytest.raises(ConditionError, match=f"face {inside}"):
        solve_cmc(domain, conditions.fixed_at_faces(domain, [inside], [0, 0, 1]), sites="faces")


@pytest.mark.parametrize("energy", ON_FACES)
def test_the_conjugate_has_flat_triangles_with_the_normals_and_closes(energy):
    shape = shapes.disc(600)
    domain = shape.domain
    condition = conditions.twisted(domain, shape.positions, domain.boundary_edges, 1)
    surface = solve_cmc(domain, condition, sites="faces", energy=energy, tolerance=1e-11)
    assert surface.status is Status.CONVERGED
    g, N, tau = surface.conjugate.g, surface.harmonic.normals, surface.conjugate.tau
    assert g.shape == (domain.vertex_count, 3) and surface.conjugate.closure_error < 1e-11
    i, j = domain.edges.T
    assert_allclose(g[j] - g[i], tau, rtol=0, atol=1e-10)
    corners = g[domain.faces]
    area = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    assert_allclose(np.cross(area, N), 0, rtol=0, atol=1e-10)


@pytest.mark.parametrize("energy", ["dual_cotan", "mobius"])
def test_the_hemisphere_on_a_disc_that_is_narrower_by_half_a_triangle(energy):
    """m = 0: g = N and f- a point on every disc. The radius is the one at which the prescribed normals would hold."""
    errors, sizes, widths = [], [], []
    for n in (500, 2000, 8000):
        shape = shapes.disc(n)
        domain, points = shape.domain, shape.positions
        condition = conditions.binormal(domain, points, domain.boundary_edges)
        surface = solve_cmc(domain, condition, sites="faces", energy=energy, tolerance=1e-9)
        x, y = (surface.normals[:, k] / (1 + surface.normals[:, 2]) for k in (0, 1))
        flat = points[:, :2]
        radius = np.sum(flat**2) / np.sum(flat * np.column_stack([x, y]))
        widths.append(1 - radius)
        p = flat / radius
        s = (p**2).sum(axis=1)
        hemisphere = np.column_stack([2 * p, 1 - s]) / (1 + s)[:, None]
        centred = surface.g - (surface.g - hemisphere).mean(axis=0)
        errors.append(np.sqrt(np.mean((centred - hemisphere) ** 2)))
        sizes.append(np.ptp(surface.f_minus, axis=0).max())
    # the last ring of circumcentres is not quite round, which the energies answer to at first order
    assert all(rate > 0.8 for rate in rates(errors)) and all(rate > 0.8 for rate in rates(sizes))
    assert all(rate > 0.9 for rate in rates(widths))


@pytest.mark.parametrize("energy", ["dual_cotan", "mobius"])
def test_mean_curvature_and_distortion_converge(energy):
    curvature, distortion = [], []
    for n in (600, 2400, 9600):
        shape = shapes.disc(n)
        domain = shape.domain
        condition = conditions.twisted(domain, shape.positions, domain.boundary_edges, 1)
        surface = solve_cmc(domain, condition, sites="faces", energy=energy)
        H = mean_curvature_of(surface.f_plus, surface.faces, surface.normals)
        Q = conformal_distortion(domain, surface.f_plus)
        curvature.append(np.sqrt(np.average((H - 0.5) ** 2, weights=domain.face_areas)))
        distortion.append(np.sqrt(np.average((0.5 * (Q + 1 / Q) - 1) ** 2, weights=domain.face_areas)))
    assert min(rates(curvature)) > 0.9 and min(rates(distortion)) > 1.8


def test_f_plus_and_minus_are_offsets_by_unit_normals():
    shape = shapes.disc(400)
    domain = shape.domain
    condition = conditions.binormal(domain, shape.positions, domain.boundary_edges, 0.4)
    surface = solve_cmc(domain, condition, sites="faces", energy="mobius", mean_curvature=0.25)
    assert_allclose(np.linalg.norm(surface.normals, axis=1), 1, rtol=0, atol=1e-14)
    assert_allclose(surface.f_plus - surface.g, 2 * surface.normals, rtol=0, atol=1e-12)
    assert_allclose(surface.g[domain.boundary_vertices].mean(axis=0), 0, rtol=0, atol=1e-12)
    assert_allclose(surface.g, 2 * (surface.conjugate.g - surface.centre), rtol=0, atol=1e-12)


@pytest.mark.parametrize("side", [1, -1])
def test_sides_on_faces(side):
    shape = shapes.polygon([[0, 0], [4, 0], [4, 4], [2, 4], [2, 2], [0, 2]], max_edge=0.25, corner_radius=0.3)
    domain = shape.domain
    condition = conditions.binormal(domain, shape.positions, domain.boundary_edges)
    found = HarmonicSolver(domain, sites="faces", energy="mobius").solve(condition, side=side)
    free = np.setdiff1d(np.arange(len(domain.faces)), faces_behind(domain, domain.boundary_edges))
    assert found.status is Status.CONVERGED and (side * found.normals[free, 2]).min() > 0


def test_a_wound_start_finds_the_nodoid_on_faces():
    energies = []
    for columns in (24, 48):
        shape = shapes.cylinder(2 * np.pi, 3.3132763405, columns)
        domain = shape.domain
        condition = conditions.fixed(domain, shape.sides["bottom"], [1, 0, 0]) + conditions.fixed(
            domain, shape.sides["top"], [-1, 0, 0]
        )
        found = HarmonicSolver(domain, sites="faces", energy="mobius").solve(condition, degree=1)
        assert found.status is Status.CONVERGED
        assert_allclose(found.degree, 1, rtol=0, atol=1e-9)
        energies.append(found.energy)
    exact = 14.2059
    assert abs(energies[1] - exact) < 0.7 * abs(energies[0] - exact) < 1.5


def test_a_bubble_is_grafted_on_faces():
    shape = shapes.disc(3000)
    condition = conditions.twisted(shape.domain, shape.positions, shape.domain.boundary_edges, 1)
    solver = HarmonicSolver(shape.domain, sites="faces", energy="mobius")
    small = solver.solve(condition)
    large = solver.solve(condition, degree=small.degree + 1, max_iterations=0)
    assert abs(large.degree - small.degree - 1) < 0.1


def test_free_edges_on_faces():
    """A strip between two planes: nothing happens along it, whatever the energy; tau vanishes on the free sides."""
    shape = shapes.strip(2.0, 1.0, 24)
    domain = shape.domain
    condition = conditions.fixed(domain, shape.sides["left"], [0, 0, 1]) + conditions.fixed(
        domain, shape.sides["right"], [1, 0, 0]
    )
    surface = solve_cmc(domain, condition, sites="faces", energy="mobius", tolerance=1e-10)
    free = np.concatenate([shape.sides["bottom"], shape.sides["top"]])
    fixed = faces_behind(domain, np.concatenate([shape.sides["left"], shape.sides["right"]]))
    free = free[~np.isin(faces_behind(domain, free), fixed)]
    assert_allclose(surface.conjugate.tau[free], 0, rtol=0, atol=1e-8)
    assert_allclose(surface.normals[:, 1], 0, rtol=0, atol=1e-8)


def test_ears_are_unfolded():
    """Two corners of a grid have triangles with two sides on the boundary; their tips continue the surface."""
    n = 16
    x, y = np.meshgrid(np.arange(n + 1) / n, np.arange(n + 1) / n)
    points = np.column_stack([x.ravel() + 0.2 * y.ravel(), y.ravel()])
    a = (np.arange(n)[:, None] * (n + 1) + np.arange(n)).ravel()
    faces = np.concatenate([np.stack([a, a + 1, a + n + 1], axis=1), np.stack([a + 1, a + n + 2, a + n + 1], axis=1)])
    domain = Domain.from_positions(points, faces)
    behind = faces_behind(domain, domain.boundary_edges)
    assert (np.bincount(behind) == 2).sum() == 2
    condition = conditions.gauss_map(domain, bowl(points), domain.boundary_edges)
    surface = solve_cmc(domain, condition, sites="faces", energy="mobius", tolerance=1e-10)
    i, j = domain.edges.T
    assert_allclose(surface.conjugate.g[j] - surface.conjugate.g[i], surface.conjugate.tau, rtol=0, atol=1e-9)
    Q = conformal_distortion(domain, surface.f_plus)
    assert np.nanmax(Q) < 1.5


def bowl(points):
    x, y = points[:, 0] - 0.5, points[:, 1] - 0.5
    return np.column_stack([x, y, -0.3 * (x**2 + y**2)])


def open_annulus(n):
    shape = shapes.annulus(0.4, 1.0, n)
    domain = shape.domain
    leaning = conditions.binormal(domain, shape.positions, shape.sides["outer"], 0.3)
    return domain, leaning + conditions.fixed(domain, shape.sides["inner"], [0.6, 0, 0.8])


def test_periods_agree_with_those_of_normals_on_vertices():
    misses = []
    for n in (400, 1600, 6400):
        domain, condition = open_annulus(n)
        exact = solve_cmc(domain, condition)
        surface = solve_cmc(domain, condition, sites="faces", energy="mobius")
        assert surface.is_open and surface.status is Status.GAP
        assert surface.g.shape == surface.normals.shape == (len(surface.source), 3)
        misses.append(np.abs(np.abs(surface.periods) - np.abs(exact.periods)).max())
    assert misses[-1] < 0.05 * exact.gap and min(rates(misses)) > 0.8


def test_an_open_surface_jumps_by_its_period():
    domain, condition = open_annulus(800)
    surface = solve_cmc(domain, condition, sites="faces", energy="mobius", tolerance=1e-8)
    copies = np.arange(domain.vertex_count, len(surface.source))
    jumps = surface.g[copies] - surface.g[surface.source[copies]]
    assert_allclose(np.abs(jumps), np.tile(np.abs(surface.periods), (len(jumps), 1)), rtol=0, atol=1e-8)


@pytest.mark.parametrize("sites", ["vertices", "faces"])
def test_small_periods_are_projected_out(sites):
    """Then g closes, and differs from tau by the harmonic part only, which is as small as the period."""
    domain, condition = open_annulus(800)
    open_one = solve_cmc(domain, condition, sites=sites)
    surface = solve_cmc(domain, condition, sites=sites, period_tolerance=10.0)
    assert not surface.is_open and len(surface.g) == domain.vertex_count
    assert_allclose(surface.periods, open_one.periods, rtol=1e-9, atol=0)
    g, tau = surface.conjugate.g, surface.conjugate.tau
    left, right = surface.graph.cells[(surface.graph.cells >= 0).all(axis=1)].T
    inside = surface.graph.edges[(surface.graph.cells >= 0).all(axis=1)]
    rest = (g[left] - g[right]) - tau[inside]
    assert 0 < np.abs(rest).max() < 0.5 * surface.gap
    mesh = surface.as_mesh("f+", "dual")
    assert np.isfinite(mesh.vertices).all()


def test_closed_surfaces_need_a_start():
    sphere = shapes.sphere(300)
    normals = sphere.positions[sphere.domain.faces].mean(axis=1)
    solver = HarmonicSolver(sphere.domain, sites="faces", energy="mobius")
    with pytest.raises(ConditionError, match="initial map"):
        solver.solve(Conditions())
    found = solver.solve(Conditions(), initial=normals, max_iterations=3)
    assert_allclose(found.degree, 1, rtol=0, atol=1e-9)


def test_wrong_maps_are_refused_by_name():
    domain = shapes.disc(100).domain
    condition = conditions.fixed(domain, domain.boundary_edges, [0, 0, 1])
    with pytest.raises(ConditionError, match=f"\\({len(domain.faces)}, 3\\)"):
        HarmonicSolver(domain, sites="faces").solve(condition, initial=np.ones((domain.vertex_count, 3)))
    with pytest.raises(ConditionError, match=r"vertices.*choose cotan"):
        HarmonicSolver(domain, energy="mobius")
    assert HarmonicSolver(domain, sites="faces").energy is ENERGIES["dual_cotan"]


def test_two_triangles_leave_nothing_to_solve_for():
    domain = Domain.from_positions([[0, 0], [1, 0], [1, 1], [0, 1]], [[0, 1, 2], [0, 2, 3]])
    with pytest.raises(ConditionError, match="at 2 faces, so none is unknown"):
        HarmonicSolver(domain, sites="faces").solve(conditions.fixed(domain, domain.boundary_edges, [0, 0, 1]))
