"""Surfaces solved on the intrinsic Delaunay triangulation and carried back to the triangles of the plan."""

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from scipy.spatial import Delaunay

from solver import CmcSolver, ConditionError, Domain, conditions, shapes, solve_cmc
from solver.domain.sites import SITES


def stretched(shape, factor=12.0):
    """The same points and outline with needles for triangles: Delaunay in a stretched plane."""
    points = shape.positions[:, :2]
    faces = Delaunay(points * [1, factor]).simplices
    a, b, c = (points[faces[:, k]] for k in range(3))
    area = (b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]
    faces = np.where((area < 0)[:, None], faces[:, [0, 2, 1]], faces)[np.abs(area) > 1e-9]
    return Domain.from_positions(points, faces)


@pytest.mark.parametrize("sites", SITES)
def test_needles_give_the_surface_of_the_regular_mesh(sites):
    shape = shapes.disc(700)
    needles = stretched(shape)
    assert np.degrees(needles.corner_angles.min()) < 2
    energy = "cotan" if sites == "vertices" else "mobius"
    surfaces = []
    for domain, delaunay in ((shape.domain, False), (needles, True)):
        condition = conditions.twisted(domain, shape.positions, domain.boundary_edges, 1)
        surfaces.append(solve_cmc(domain, condition, sites=sites, energy=energy, delaunay=delaunay, tolerance=1e-10))
    regular, carried = surfaces
    assert_array_equal(carried.faces, needles.faces)
    assert carried.domain is needles and carried.graph.domain is not needles
    assert_allclose(carried.f_plus, regular.f_plus, rtol=0, atol=1e-7)
    assert_allclose(carried.normals, regular.normals, rtol=0, atol=1e-7)


@pytest.mark.parametrize("sites", SITES)
def test_an_annulus_of_needles_is_cut_open_in_its_own_triangles(sites):
    """Both triangulations of an open annulus: the period is the same, and each jumps by it across its own cut."""
    regular = shapes.annulus(0.4, 1.0, 500)
    points = regular.positions
    skewed = skew(regular.domain, points)
    energy = "cotan" if sites == "vertices" else "mobius"
    found = []
    for domain, delaunay in ((regular.domain, False), (skewed, True)):
        loops = sorted(domain.boundary_loop_edges, key=len)
        condition = conditions.binormal(domain, points, loops[1], 0.3)
        condition += conditions.fixed(domain, loops[0], [0.6, 0, 0.8])
        found.append(solve_cmc(domain, condition, sites=sites, energy=energy, delaunay=delaunay, tolerance=1e-9))
    plain, carried = found
    assert plain.is_open and carried.is_open
    assert_array_equal(carried.source[carried.faces], skewed.faces)
    assert_allclose(np.abs(carried.periods), np.abs(plain.periods), rtol=0, atol=1e-6)
    period = plain.periods[0]
    # the same surface on its cover: points differ by whole periods
    offset = carried.g[: skewed.vertex_count] - plain.g[: skewed.vertex_count]
    turns = (offset - offset[0]) @ period / (period @ period)
    assert_allclose(turns, np.rint(turns), rtol=0, atol=1e-5)
    copies = np.arange(skewed.vertex_count, len(carried.source))
    jump = carried.g[copies] - carried.g[carried.source[copies]]
    turns = jump @ period / (period @ period)
    assert_allclose(np.abs(turns), 1, rtol=0, atol=1e-5)
    # and within its triangles it is continuous
    sides = np.linalg.norm(carried.g[carried.faces] - carried.g[np.roll(carried.faces, 1, axis=1)], axis=2)
    assert sides.max() < 0.7 * np.linalg.norm(period) + 3 * np.median(sides)


def skew(domain, points, flips=300):
    """Flip edges the wrong way wherever the two triangles are convex: no longer Delaunay, the same boundary."""
    faces = domain.faces.copy()
    random = np.random.default_rng(3)
    for _ in range(flips):
        current = Domain.from_positions(points, faces)
        e = random.choice(current.interior_edges)
        left, right = current.edge_faces[e]
        i, j = current.edges[e]
        (k,), (m,) = np.setdiff1d(faces[left], [i, j]), np.setdiff1d(faces[right], [i, j])
        corners = points[[i, m, j, k]]
        turn = np.roll(corners, -1, axis=0) - corners
        crosses = turn[:, 0] * np.roll(turn, -1, axis=0)[:, 1] - turn[:, 1] * np.roll(turn, -1, axis=0)[:, 0]
        joined = (np.sort(current.edges, axis=1) == sorted((k, m))).all(axis=1).any()
        if crosses.min() > 1e-3 * np.abs(crosses).max() and not joined:
            faces[left], faces[right] = (m, k, i), (k, m, j)
    return Domain.from_positions(points, faces)


def test_normals_at_single_faces_have_no_successor():
    shape = shapes.disc(200)
    needles = stretched(shape)
    behind = int(needles.edge_faces[needles.boundary_edges[0], 0])
    solver = CmcSolver(needles, sites="faces", delaunay=True)
    with pytest.raises(ConditionError, match=f"face {behind}.*delaunay=False"):
        solver.solve(conditions.fixed_at_faces(needles, [behind], [0, 0, 1]))


def test_the_dual_mesh_is_that_of_the_delaunay_triangulation():
    shape = shapes.disc(400)
    needles = stretched(shape)
    condition = conditions.binormal(needles, shape.positions, needles.boundary_edges, 0.4)
    surface = solve_cmc(needles, condition, delaunay=True)
    mesh = surface.as_mesh("f+", "dual")
    assert len(mesh.polygons) == needles.vertex_count
    assert len(mesh.vertices) == len(surface.graph.domain.faces) + len(needles.boundary_edges)
