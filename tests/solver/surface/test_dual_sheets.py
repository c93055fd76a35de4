"""Dual and corner sheets of solved surfaces: planes, distances, convergence, cuts."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from solver import ConditionError, conditions, shapes, solve_cmc
from solver.surface.cmc_surface import COMBINATORICS
from tests.solver.exact_surfaces import disc, hemisphere, rates
from tests.solver.polygon_meshes import area_vectors, assert_manifold, directed_edges

SITES = ("vertices", "faces")


def twisted(sites, n=600, turns=1):
    """A real surface over a jittered disc, solved to rounding; and the positions of its plan."""
    domain, points = disc(n)
    energy = "cotan" if sites == "vertices" else "mobius"
    condition = conditions.twisted(domain, points, domain.boundary_edges, turns)
    return solve_cmc(domain, condition, sites=sites, energy=energy, tolerance=1e-12, mean_curvature=0.25), points


def off_plane(points, polygons, normals):
    """Largest distance of a polygon's points from the plane through their mean with the normal given for it."""
    return max(np.abs((points[p] - points[p].mean(axis=0)) @ n).max() for p, n in zip(polygons, normals, strict=True))


def test_polygons_of_vertices_are_planar_and_orthogonal_to_their_normals():
    """With normals on vertices: on g, and on f± of the corner mesh; closed along the boundary too."""
    surface, _ = twisted("vertices")
    N = surface.harmonic.normals
    dual = surface.as_mesh("g", "dual")
    assert len(dual.polygons) == len(N) and off_plane(dual.vertices, dual.polygons, N) < 1e-8
    for sheet in ("f+", "f-", "g"):
        mesh = surface.as_mesh(sheet, "corner")
        assert off_plane(mesh.vertices, mesh.polygons[-len(N) :], N) < 1e-8


def test_triangles_are_orthogonal_to_the_normals_of_their_faces():
    """With normals on faces: on g itself, and on f± of the corner mesh; corners of a vertex on a sphere about g."""
    surface, _ = twisted("faces")
    N, faces = surface.harmonic.normals, surface.domain.faces
    assert off_plane(surface.g, faces, N) < 1e-8
    for sheet in ("f+", "f-"):
        mesh = surface.as_mesh(sheet, "corner")
        assert off_plane(mesh.vertices, mesh.polygons[: len(N)], N) < 1e-8
        sign = surface.scale if sheet == "f+" else -surface.scale
        assert_allclose(mesh.vertices - surface.g[mesh.source], sign * mesh.normals, rtol=0, atol=1e-12)


@pytest.mark.parametrize("sites", SITES)
def test_the_two_sheets_are_two_averaged_normals_apart(sites):
    """f+ - f- = 2 A_*(N) on the dual: the average over the corners of each face, N of the face if it has one."""
    surface, _ = twisted(sites, n=200)
    plus, minus, gauss = (surface.as_mesh(name, "dual") for name in ("f+", "f-", "gauss"))
    faces = len(surface.domain.faces)
    mean = plus.interpolate(surface.normals)[:faces] if sites == "vertices" else surface.harmonic.normals
    apart = 2 * surface.scale * mean
    assert_allclose((plus.vertices - minus.vertices)[:faces], apart, rtol=0, atol=1e-12)
    assert_allclose(plus.vertices - minus.vertices, 2 * gauss.vertices, rtol=0, atol=1e-12)
    assert_allclose(np.linalg.norm(plus.normals, axis=1), 1, rtol=1e-12, atol=0)


@pytest.mark.parametrize("sites", SITES)
def test_all_meshes_of_a_sheet_lie_in_one_place_and_face_one_way(sites):
    """The dual is where the triangles are, up to discretisation, and oriented as they are."""
    apart = []
    for n in (300, 1200):
        surface, _ = twisted(sites, n)
        triangles, dual = (surface.as_mesh("f+", name) for name in ("primal", "dual"))
        far = np.linalg.norm(dual.vertices - dual.interpolate(triangles.vertices), axis=1)
        apart.append(np.sqrt(np.mean(far**2)) / np.ptp(triangles.vertices, axis=0).max())
        for mesh in (triangles, dual):
            N = [mesh.normals[p].mean(axis=0) for p in mesh.polygons]
            assert (np.einsum("px,px->p", area_vectors(mesh.vertices, mesh.polygons), N) > 0).all()
    assert rates(apart)[0] > (1.7 if sites == "vertices" else 0.7) and apart[-1] < 2e-3


@pytest.mark.parametrize("combinatorics", COMBINATORICS)
@pytest.mark.parametrize("sites", SITES)
def test_values_of_the_plan_come_to_every_mesh(sites, combinatorics):
    """What is linear on the plan is linear on the mesh; `source` is the nearest of the triangle's vertices, or its."""
    surface, points = twisted(sites, n=200)
    mesh = surface.as_mesh("f-", combinatorics)
    place = mesh.interpolate(points)
    linear = np.array([[2.0, -1.0, 0.3], [0.5, 3.0, 1.0]])
    assert_allclose(mesh.interpolate(points @ linear), place @ linear, rtol=0, atol=1e-12)
    assert (mesh.anchors == mesh.source[:, None]).any(axis=1).all()
    assert_array_equal(mesh.anchors, surface.domain.faces[mesh.triangles])
    assert_allclose(mesh.barycentric.sum(axis=1), 1, rtol=0, atol=1e-12)
    if combinatorics == "primal":
        assert_array_equal(place, points[mesh.source])
    if combinatorics == "dual":
        centres = place[: len(surface.domain.faces), None] - points[surface.domain.faces]
        radii = np.linalg.norm(centres, axis=2)  # of circumcircles
        assert_allclose(radii, np.broadcast_to(radii[:, :1], radii.shape), rtol=1e-9, atol=0)


def test_the_dual_converges_to_the_hemisphere():
    """Second order with the circumcentre as the place where normals are averaged, on f+ and on the point f-."""
    sphere, point = [], []
    for n in (500, 2000, 8000):
        domain, points = disc(n)
        surface = solve_cmc(domain, conditions.binormal(domain, points, domain.boundary_edges), tolerance=1e-9)
        mesh = surface.as_mesh("f+", "dual")
        difference = mesh.vertices - 2.0 * hemisphere(mesh.interpolate(points))
        sphere.append(np.linalg.norm(difference - difference.mean(axis=0), axis=1).max())
        point.append(np.ptp(surface.as_mesh("f-", "dual").vertices, axis=0).max())
    assert rates(sphere).mean() > 1.7 and rates(point).mean() > 1.7
    assert sphere[-1] < 2e-3


@pytest.mark.parametrize("combinatorics", COMBINATORICS)
@pytest.mark.parametrize("sites", SITES)
def test_a_courtyard_that_does_not_close_is_cut_open(sites, combinatorics):
    """The mesh of a ring with a gap is a disc, and whole polygons continue it across the cut."""
    shape = shapes.polygon(
        [(0, 0), (4, 0), (4, 3), (0, 3)], [[(0.7, 0.7), (1.7, 0.7), (1.7, 1.7), (0.7, 1.7)]], max_edge=0.25
    )
    domain = shape.domain
    energy = "cotan" if sites == "vertices" else "mobius"
    condition = conditions.binormal(domain, shape.positions, domain.boundary_edges)
    surface = solve_cmc(domain, condition, sites=sites, energy=energy, tolerance=1e-10)
    assert surface.is_open
    mesh = surface.as_mesh("f+", combinatorics)
    euler, _ = assert_manifold(mesh.polygons, len(mesh.vertices))
    assert euler == 1
    steps, _ = directed_edges(mesh.polygons)
    longest = np.linalg.norm(np.diff(mesh.vertices[steps], axis=1), axis=2).max()
    assert longest < 0.8 * surface.gap < surface.gap
    closed = solve_cmc(domain, condition, sites=sites, energy=energy, tolerance=1e-10, period_tolerance=10.0).as_mesh(
        "f+", combinatorics
    )
    assert assert_manifold(closed.polygons, len(closed.vertices))[0] == 0


def test_the_mesh_of_an_intrinsic_triangulation_has_its_dual():
    domain, points = disc(300, jitter=0.45)
    condition = conditions.binormal(domain, points, domain.boundary_edges)
    surface = solve_cmc(domain, condition, delaunay=True)
    triangles, dual = surface.as_mesh("f+"), surface.as_mesh("f+", "dual")
    assert (surface.graph.domain.faces != domain.faces).any()
    assert_array_equal(np.stack(triangles.polygons), domain.faces)
    assert_array_equal(triangles.source, np.arange(len(points)))
    assert_array_equal(dual.anchors, surface.graph.domain.faces[dual.triangles])
    assert assert_manifold(dual.polygons, len(dual.vertices))[0] == 1
    assert_array_equal(triangles.interpolate(points), points[triangles.source])


def test_unknown_sheets_and_combinatorics_are_refused():
    surface, _ = twisted("vertices", n=60)
    for name in COMBINATORICS:
        with pytest.raises(ConditionError, match="nosuch"):
            surface.as_mesh("nosuch", name)
    with pytest.raises(ConditionError, match="primal, dual, corner"):
        surface.as_mesh("f+", "nosuch")


def test_faces_of_the_corner_mesh_turn_with_the_gauss_map():
    """Triangles of f+ over saddles, where neighbouring normals run the other way around, are upside down."""
    surface, _ = twisted("vertices", n=300)
    mesh, faces = surface.as_mesh("f+", "corner"), surface.domain.faces
    a, b, c = (surface.normals[faces[:, k]] for k in range(3))
    gauss = np.einsum("ij,ij->i", np.cross(b - a, c - a), a + b + c)
    turned = area_vectors(mesh.vertices, mesh.polygons[: len(faces)])
    assert (gauss > 0).any() and (gauss < 0).any()
    assert_array_equal(np.einsum("ij,ij->i", turned, a + b + c) > 0, gauss > 0)
