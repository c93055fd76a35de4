"""Modules between mirrors: unduloids, honeycombs and other grids of tubes."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from scipy.special import ellipe, ellipk

from solver import Domain, MeshError, Side, complete, conditions, mean_curvature_of, shapes, solve_cmc
from solver.catalogue import modules
from solver.measure import self_intersections
from tests.solver import fundamental_pieces as pieces

MESHES = (0.24, 0.12, 0.06)
NODE = ("axis", "bisector", "floor")
HEXAGON = ("bisector", "end", "floor")


def rates(errors) -> np.ndarray:
    """Orders of convergence between meshes, each twice as fine as the one before."""
    return np.log2(np.asarray(errors)[:-1] / np.asarray(errors)[1:])


def plane(whole, name):
    return next(plane for plane in whole.planes if plane.name == name)


def heights(whole, points, name):
    return points @ plane(whole, name).normal - plane(whole, name).offset


def neck(whole) -> np.ndarray:
    """Distances of the end of a node's tube from its axis."""
    points = whole.piece("f+")[plane(whole, "end").cut_vertices]
    return np.hypot(heights(whole, points, "axis"), heights(whole, points, "floor"))


def missing_edges(whole) -> int:
    """Edges of sides across which there is no copy: what the rim is to consist of."""
    edges = [len(side.cut_vertices) - 1 for side in whole.planes]  # every side is an open arc
    return int(((whole.neighbours < 0) * edges).sum())


def curvature_error(mesh) -> float:
    """L² of H - ½ over ½, on the faces that do not touch the rim."""
    a, b, c = (mesh.vertices[mesh.faces[:, k]] for k in range(3))
    areas = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    areas[np.isin(mesh.faces, mesh.rim).any(axis=1)] = 0.0
    H = np.nan_to_num(mean_curvature_of(mesh.vertices, mesh.faces, mesh.normals))
    return float(np.sqrt(areas @ (H - 0.5) ** 2 / areas.sum()) / 0.5)


@pytest.mark.parametrize("make", [
    *(lambda h, k=k: modules.node(k, 4.0, max_edge=h) for k in (2, 3, 4, 6)),
    lambda h: modules.capital(0.4, max_edge=h / 4),
    lambda h: modules.capital(0.4, eighth=True, max_edge=h / 4),
])  # fmt: skip
def test_corners_of_the_plans_are_those_of_the_surface(make):
    """Product of the outward normals of neighbouring sides, and angles of the mesh: 2 k copies around every corner."""
    module = make(0.2)
    piece = pieces.between_mirrors(module)
    corners = complete(piece.surface, piece.sides).corners
    assert len(corners) == len(module.normals)
    assert_allclose([corner.plane_angle * corner.order for corner in corners], np.pi, atol=1e-9)
    assert_allclose([corner.turns for corner in corners], 1.0, atol=1e-9)
    for corner in corners:
        a, b = (module.normals[name] for name in corner.sides)
        N = np.cross(a, b) / np.linalg.norm(np.cross(a, b))
        assert_allclose(piece.surface.normals[corner.vertex], N, atol=1e-9)


@pytest.mark.parametrize("c", [-0.9, -0.5, -0.1])
def test_a_quarter_of_a_tube_is_an_unduloid(c):
    """Four mirrors and a rectangle of the right shape, nothing else. Radii 1 ∓ √(1+c), period 4 E(1+c)."""
    errors = []
    for h in MESHES:
        piece = pieces.between_mirrors(modules.node(2, 2 * ellipk(1 + c) / (np.pi / 2), max_edge=h))
        whole = complete(piece.surface, piece.sides)
        assert len(whole.copies) == 8 and len(whole.mesh.flipped_faces) == 0
        points = whole.piece("f+")
        around = np.hypot(heights(whole, points, "axis"), heights(whole, points, "floor"))
        found = [around.min(), around.max(), np.linalg.norm(whole.lattice)]
        errors.append(np.abs(np.array(found) - [1 - np.sqrt(1 + c), 1 + np.sqrt(1 + c), 4 * ellipe(1 + c)]).max())
        assert whole.mesh.largest_gap < 1e-6
    assert errors[-1] < 0.03 and rates(errors).mean() > 1.7


@pytest.mark.parametrize("length", [1.5, 1.9, 2.3, 2.7, 3.1])
def test_honeycombs(length):
    """Fig. 16: one hexagonal ring of 72 copies, and 3 × 3 cells; closed away from the rim, embedded. H and sizes on a
    node, 12 copies."""
    curvature, sizes = [], []
    for h in MESHES:
        piece = pieces.between_mirrors(modules.node(3, length, max_edge=h))
        node = complete(piece.surface, piece.sides, around=[NODE])
        assert max(plane.relative for plane in node.planes) < 1e-6
        assert node.mesh.largest_gap < 1e-6
        assert len(node.copies) == 12 and len(node.mesh.flipped_faces) == 0
        curvature.append(curvature_error(node.mesh))
        sizes.append([neck(node).max(), np.linalg.norm(complete(piece.surface, piece.sides).lattice[0])])
        if h == MESHES[0]:
            check_ring(complete(piece.surface, piece.sides, around=[NODE, HEXAGON]))
            check_patch(complete(piece.surface, piece.sides, repeat=(3, 3)))
    assert curvature[-1] < 0.03 and rates([curvature[0], curvature[2]]) / 2 > 1.0
    assert (rates(np.abs(np.diff(sizes, axis=0))) > 1.5).all()  # the neck and the period, by differences
    assert np.ptp(neck(node)) < 0.1 * neck(node).max()


def check_ring(ring):
    mesh = ring.mesh
    assert len(ring.copies) == 72 and mesh.is_oriented
    assert mesh.largest_gap < 1e-6 and len(mesh.flipped_faces) == 0
    domain = Domain.from_positions(mesh.vertices, mesh.faces)
    assert domain.euler_characteristic == -6
    assert len(domain.boundary_loops) == 6 and domain.genus == 1
    assert len(mesh.rim) == missing_edges(ring)
    assert len(self_intersections(mesh.vertices, mesh.faces)) == 0


def check_patch(patch):
    mesh = patch.mesh
    assert len(patch.copies) == 9 * 24 and patch.lattice.shape == (2, 3) and mesh.is_oriented
    first, second = patch.lattice
    assert_allclose(np.linalg.norm(first), np.linalg.norm(second), rtol=1e-6)
    assert_allclose(abs(first @ second), 0.5 * first @ first, rtol=1e-6)
    assert len(mesh.rim) == missing_edges(patch)
    assert mesh.largest_gap < 1e-6 and len(mesh.flipped_faces) == 0
    Domain.from_positions(mesh.vertices, mesh.faces)  # connected and manifold, or it raises


def test_a_patch_of_honeycomb_is_embedded():
    piece = pieces.between_mirrors(modules.node(3, 2.3, max_edge=0.16))
    mesh = complete(piece.surface, piece.sides, repeat=3).mesh
    assert len(self_intersections(mesh.vertices, mesh.faces)) == 0


@pytest.mark.parametrize(("tubes", "length", "count"), [(4, 2.6, 16), (6, 3.8, 24)])
def test_other_grids_of_tubes(tubes, length, count):
    piece = pieces.between_mirrors(modules.node(tubes, length, max_edge=0.16))
    whole = complete(piece.surface, piece.sides, repeat=2)
    assert len(whole.copies) == 4 * count
    cosine = whole.lattice[0] @ whole.lattice[1] / (whole.lattice[0] @ whole.lattice[0])
    assert_allclose(abs(cosine), 0.0 if tubes == 4 else 0.5, atol=1e-6)
    assert whole.mesh.is_oriented and len(whole.mesh.flipped_faces) == 0
    assert len(whole.mesh.rim) == missing_edges(whole)
    assert len(self_intersections(whole.mesh.vertices, whole.mesh.faces)) == 0


def test_a_right_angle_in_the_place_of_sixty_degrees_converges_slowly():
    """What the true corner angle is for: the plan of two tubes with the mirrors of three."""
    misses = []
    for module in (modules.node(3, 2.2, max_edge=0.16), wrong_angle()):
        piece = pieces.between_mirrors(module)
        whole = complete(piece.surface, piece.sides)
        at = next(corner for corner in whole.corners if set(corner.sides) == {"bisector", "axis"})
        misses.append(at.turns)
        assert whole.mesh.largest_gap < 1e-6  # the seams close all the same
    assert_allclose(misses, [1.0, 1.5], atol=0.01)


def wrong_angle(max_edge: float = 0.16) -> modules.Module:
    rectangle, three = modules.node(2, 2.0, max_edge=max_edge), modules.node(3, 2.2, max_edge=max_edge)
    return modules.Module(rectangle.shape, three.normals)


@pytest.mark.parametrize("wrong", [
    lambda: modules.node(1, 2.0, max_edge=0.1),
    lambda: modules.node(3, 1.0, max_edge=0.1),
    lambda: modules.node(3, 2.0, depth=-1.0, max_edge=0.1),
    lambda: modules.capital(1.0, max_edge=0.1),
    lambda: modules.capital(0.3, max_edge=0.0),
    lambda: modules.capital(0.8, oculus=0.7, max_edge=0.1),
    lambda: modules.vault(2, 0.5, max_edge=0.1),
    lambda: modules.vault(4, (0.5, 0.5), max_edge=0.1),
    lambda: modules.vault(4, 0.5, length=0.5, max_edge=0.1),
])  # fmt: skip
def test_impossible_plans_are_refused(wrong):
    with pytest.raises(MeshError, match=r"node|capital|vault"):
        wrong()


def test_sides_of_a_module_are_its_boundary():
    for module in (
        modules.node(3, 2.2, max_edge=0.2),
        modules.capital(0.3, max_edge=0.2),
        modules.capital(0.3, oculus=0.5, max_edge=0.2),
        modules.capital(0.3, oculus=0.5, eighth=True, max_edge=0.2),
        modules.vault(5, (0.2, 0.3, 0.4, 0.5, 0.6), length=1.5, max_edge=0.3),
    ):
        edges = np.concatenate(list(module.shape.sides.values()))
        assert_array_equal(np.sort(edges), module.shape.domain.boundary_edges)
        assert set(module.shape.sides) == set(module.normals)


def test_a_free_side_between_mirrors_is_a_point_of_their_planes():
    """An eighth of a tube, three mirrors and a free end: the group's relations hold to rounding."""
    c, errors = -0.5, []
    for h in MESHES:
        module = modules.node(2, ellipk(1 + c) / (np.pi / 2), max_edge=h)
        points = module.shape.positions * (np.pi / 2)
        # s = 0 at the bisector, t = 0 on top
        N = pieces.unduloid_normals(c, points[:, ::-1])[:, [2, 1, 0]]
        piece = pieces.between_mirrors(module, {"end": "free"}, initial=N)
        whole = complete(piece.surface, piece.sides)
        assert len(whole.copies) == 16 and sorted(set(whole.sheets)) == ["f+", "f-"]
        assert_allclose(np.linalg.norm(whole.lattice), 4 * ellipe(1 + c), rtol=0.03)
        end = plane(whole, "end")
        for name in ("axis", "floor"):
            assert_allclose(end.point @ plane(whole, name).normal, plane(whole, name).offset, atol=1e-12)
        assert whole.mesh.is_oriented and len(whole.mesh.rim) == missing_edges(whole)
        assert len(whole.mesh.flipped_faces) == 0
        errors.append(end.error)
    assert (rates(errors) > 1.2).all() and errors[-1] < 0.005


def test_the_wente_strip_goes_on_around_and_along():
    """Constant normals 120° apart on the ends of a cylinder (Fig. 13): six copies around, cut open along."""
    shape = shapes.cylinder(2 * np.pi, 1.2, 32)
    a, b = np.array([1.0, 0.0, 0.0]), np.array([-0.5, np.sqrt(0.75), 0.0])
    ends = conditions.fixed(shape.domain, shape.sides["bottom"], a) + conditions.fixed(
        shape.domain, shape.sides["top"], b
    )
    surface = solve_cmc(shape.domain, ends)
    assert surface.is_open
    sides = [Side("bottom", shape.sides["bottom"], "tangent"), Side("top", shape.sides["top"], "tangent")]
    whole = complete(surface, sides, repeat=2)
    assert len(whole.copies) == 12
    assert_allclose(np.abs(whole.lattice), np.abs(surface.periods), atol=1e-6)
    assert whole.mesh.is_oriented and whole.mesh.largest_gap < 1e-6
    assert set(whole.mesh.source[whole.mesh.rim.ravel()]) <= set(surface.source[surface.domain.vertex_count :])
