"""Surfaces completed by their symmetries, against exact ones: Delaunay's and the sphere."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from solver import Domain, Side, complete, conditions, shapes, side_plane, solve_cmc
from solver.measure import self_intersections
from tests.solver import fundamental_pieces as pieces
from tests.solver.sampled_surfaces import Delaunay

MESHES = (20, 40, 80)


def rates(errors) -> np.ndarray:
    """Orders of convergence between meshes, each twice as fine as the one before."""
    return np.log2(np.asarray(errors)[:-1] / np.asarray(errors)[1:])


def radii(points: np.ndarray, axis: int) -> np.ndarray:
    return np.linalg.norm(np.delete(points, axis, axis=1), axis=1)


@pytest.mark.parametrize("c", [0.2, 0.5, 1.0, 2.0, 4.0])
def test_nodoids_have_the_exact_radii_and_period(c):
    """f+ and f- glued periodically: necks √(1+c) - 1, bellies √(1+c) + 1, period 2√c (2E - 2K) (paper, Fig. 14)."""
    errors = []
    for columns in MESHES:
        piece = pieces.nodoid(c, columns)
        whole = complete(piece.surface, piece.sides, repeat=2)
        assert whole.sheets == ["f+", "f-", "f+", "f-"]
        assert whole.lattice.shape == (1, 3) and not whole.is_whole
        mesh, around = whole.mesh, radii(whole.mesh.vertices, 0)
        assert mesh.is_oriented
        assert len(mesh.vertices) == whole.vertex_count == 4 * piece.surface.domain.vertex_count - 3 * columns
        assert len(mesh.rim) == 2 * columns
        wanted = [np.sqrt(1 + c) - 1, np.sqrt(1 + c) + 1, 2 * pieces.nodoid_length(c)]
        errors.append(np.abs([around.min(), around.max(), np.linalg.norm(whole.lattice)] - np.array(wanted)))
    assert (rates(np.max(errors, axis=1)) > 1.7).all()
    assert np.max(errors[-1]) < 6e-3 * wanted[1]
    assert len(mesh.flipped_faces) == 0


@pytest.mark.parametrize("free", [False, True], ids=["mirrors", "mirror and free"])
@pytest.mark.parametrize("c", [-0.9, -0.7, -0.5, -0.3, -0.1])
def test_unduloids_have_the_exact_radii_and_period(c, free):
    """Between latitude circles: 1 ∓ √(1+c), period 4 E(1+c)."""
    errors = []
    for columns in MESHES:
        piece = pieces.unduloid(c, columns, free)
        whole = complete(piece.surface, piece.sides)
        assert len(whole.copies) == (4 if free else 2)
        assert set(whole.sheets) == ({"f+", "f-"} if free else {"f+"})
        mesh, around = whole.mesh, radii(whole.mesh.vertices, 2)
        assert mesh.is_oriented
        wanted = [1 - np.sqrt(1 + c), 1 + np.sqrt(1 + c), pieces.unduloid_period(c)]
        errors.append(np.abs([around.min(), around.max(), np.linalg.norm(whole.lattice)] - np.array(wanted)))
    assert (rates(np.max(errors, axis=1)) > 1.7).all()
    assert np.max(errors[-1]) < 6e-3 * wanted[1]
    assert len(mesh.flipped_faces) == 0


CONTINUED = {
    "mirror": lambda columns, sign: (pieces.unduloid(-0.5, columns), Delaunay(-0.5, np.pi / 2, sign)),
    "free": lambda columns, sign: (pieces.unduloid(-0.5, columns, free=True), Delaunay(-0.5, np.pi / 2, sign)),
    "tangent": lambda columns, sign: (pieces.nodoid(0.5, columns), Delaunay(0.5, 0.0, sign)),
}


@pytest.mark.parametrize("sheet", ["f+", "f-"])
@pytest.mark.parametrize("kind", CONTINUED)
def test_copies_continue_the_surface(kind, sheet):
    """Across a side lies the exact surface at the reflected parameters, with its normals; second order."""
    errors = []
    for columns in (20, 40):
        piece, exact = CONTINUED[kind](columns, 1 if sheet == "f+" else -1)
        surface = piece.surface
        t, s = piece.points[surface.source].T
        whole = complete(surface, [piece.sides[1]], sheet=sheet)
        beyond = whole.copies[1]
        assert whole.sheets == [sheet, sheet if kind == "mirror" else {"f+": "f-", "f-": "f+"}[sheet]]
        points = exact(t, s)[0]
        turn, shift = fitted(surface.sheet(sheet), points)
        far_points, far_normals = exact(t, 2 * s.max() - s)
        reached = beyond.points(surface.sheet(whole.sheets[1])) @ turn + shift
        sign = beyond.sheet * (1 if sheet == "f+" else -1)
        N = sign * surface.normals @ beyond.linear.T @ turn
        errors.append([np.abs(reached - far_points).max(), np.abs(N - far_normals).max()])
    assert np.max(errors[-1]) < 0.1 and (rates(errors) > 1.6).all()


def fitted(points: np.ndarray, targets: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The rotation R and shift for which points @ R + shift is nearest the targets."""
    a, b = points.mean(axis=0), targets.mean(axis=0)
    left, _, right = np.linalg.svd((points - a).T @ (targets - b))
    turn = left @ np.diag([1, 1, np.linalg.det(left @ right)]) @ right
    return turn, b - a @ turn


def test_an_eighth_makes_the_sphere():
    errors, gaps = [], []
    for n in (8, 16, 32):
        piece = pieces.sphere_eighth(n)
        whole = complete(piece.surface, piece.sides)
        mesh = whole.mesh
        assert len(whole.copies) == 8 and whole.is_whole and mesh.is_closed
        assert Domain.from_positions(mesh.vertices, mesh.faces).euler_characteristic == 2
        assert len(mesh.flipped_faces) == 0
        centre = np.linalg.lstsq([p.normal for p in whole.planes], [p.offset for p in whole.planes], rcond=None)[0]
        errors.append(np.abs(np.linalg.norm(mesh.vertices - centre, axis=1) - 2).max())
        gaps.append(mesh.largest_gap)
    assert errors[-1] < 5e-3 and (rates(errors) > 1.4).all()
    assert gaps[-1] < 1e-3 and (rates(gaps) > 1.4).all()
    assert len(self_intersections(mesh.vertices, mesh.faces)) == 0
    assert {corner.sides: corner.order for corner in whole.corners} == {
        ("left", "front"): 2, ("front", "floor"): 2, ("floor", "left"): 2,
    }  # fmt: skip
    assert_allclose([corner.turns for corner in whole.corners], 1.0, atol=0.03)


def test_seams_of_the_nodoid_close_with_the_mesh():
    gaps = []
    for columns in (32, 64, 128):
        piece = pieces.nodoid(0.5, columns)
        mesh = complete(piece.surface, piece.sides).mesh
        gaps.append(max(gap.largest for gap in mesh.gaps))
    assert (np.array(gaps) < [1.2e-3, 1.6e-4, 3e-5]).all()
    assert (rates(gaps) > 2.0).all()


def test_a_free_side_is_one_point_of_g_and_lies_on_a_sphere():
    errors = []
    for columns in MESHES:
        piece = pieces.unduloid(-0.5, columns, free=True)
        plane = side_plane(piece.surface, piece.sides[1])
        assert plane.normal is None and np.isnan(plane.offset)
        for points in (piece.surface.f_plus, piece.surface.f_minus):
            distance = np.linalg.norm(points[plane.cut_vertices] - plane.point, axis=1)
            assert np.abs(distance - piece.surface.scale).max() < 1.01 * plane.error
        errors.append(plane.error)
    assert errors[-1] < 2e-3 and (rates(errors) > 1.5).all()


def test_the_planes_of_both_sheets_are_those_of_g_and_twice_the_scale_apart():
    piece = pieces.nodoid(0.5, 32)
    bottom, top = (side_plane(piece.surface, side) for side in piece.sides)
    assert_allclose(bottom.normal, (1, 0, 0), atol=1e-12)
    assert_allclose(top.normal, (-1, 0, 0), atol=1e-12)
    for plane in (bottom, top):
        sheets = piece.surface.f_plus, piece.surface.f_minus
        heights = [points[plane.cut_vertices] @ plane.normal for points in sheets]
        assert_allclose(heights[0] - plane.offset, piece.surface.scale, atol=1.01 * plane.error)
        assert_allclose(plane.offset - heights[1], piece.surface.scale, atol=1.01 * plane.error)
    assert_allclose(bottom.offset + top.offset, -pieces.nodoid_length(0.5), rtol=0.02)
    assert "bottom" in str(bottom) and "tangent" in str(bottom)


def test_scale_only_scales():
    """A surface of H = 5: the same copies, ten times smaller."""
    small = pieces.nodoid(0.5, 16)
    domain, sides = small.surface.domain, small.sides
    ends = conditions.fixed(domain, sides[0].edges, (1, 0, 0)) + conditions.fixed(domain, sides[1].edges, (-1, 0, 0))
    tiny = solve_cmc(domain, ends, degree=-1, mean_curvature=5.0)
    one, other = (complete(surface, sides, copies=3) for surface in (small.surface, tiny))
    assert one.sheets == other.sheets
    assert_allclose(one.mesh.vertices, 10 * other.mesh.vertices, atol=1e-9)
    assert_allclose(one.mesh.largest_gap, other.mesh.largest_gap, rtol=1e-6)


def test_copies_in_a_box_and_in_number():
    piece = pieces.unduloid(-0.5, 16)
    period = pieces.unduloid_period(-0.5)
    box = [(-3, -3, -0.26 * period), (3, 3, 2.76 * period)]
    inside = complete(piece.surface, piece.sides, box=box)
    heights = [copy.points(piece.surface.f_plus)[:, 2].mean() for copy in inside.copies]
    assert len(inside.copies) == 6 and np.ptp(heights) < 3 * period
    assert min(heights) >= box[0][2] and max(heights) <= box[1][2]
    counted = complete(piece.surface, piece.sides, copies=5)
    assert len(counted.copies) == 5
    assert counted.vertex_count == len(counted.mesh.vertices) == 5 * piece.surface.domain.vertex_count - 4 * 16
    assert counted.face_count == len(counted.mesh.faces)
    given = complete(piece.surface, piece.sides[1:], translations=[(0, 0, period)], repeat=3)
    assert_array_equal(given.neighbours[:, 0], [1, 0, 3, 2, 5, 4])  # the mirror below is not a side here


def test_surfaces_that_are_cut_open_go_on_across_the_cut():
    shape = shapes.annulus(0.4, 1.0, 300)
    outer = shape.sides["outer"]
    angle = np.arctan2(*shape.positions[shape.domain.edges[outer]].mean(axis=1).T[::-1])
    ends = conditions.binormal(shape.domain, shape.positions, outer, np.radians(50 + 35 * np.sin(angle)))
    ends += conditions.binormal(shape.domain, shape.positions, shape.sides["inner"], np.radians(-20))
    surface = solve_cmc(shape.domain, ends)
    assert surface.is_open
    strip = complete(surface, repeat=4)
    assert len(strip.copies) == 4
    assert_allclose(np.abs(strip.lattice), np.abs(surface.periods), atol=1e-12)
    mesh = strip.mesh
    assert mesh.largest_gap < 1e-12 and mesh.is_oriented and len(mesh.flipped_faces) == 0
    assert Domain.from_positions(mesh.vertices, mesh.faces).euler_characteristic == 1
    seam = len(surface.g) - surface.domain.vertex_count
    assert len(mesh.vertices) == 4 * len(surface.g) - 3 * seam


def test_what_is_known_at_vertices_and_corners_is_carried():
    piece = pieces.sphere_eighth(8)
    whole = complete(piece.surface, piece.sides)
    mesh, domain = whole.mesh, piece.surface.domain
    assert_array_equal(domain.faces.ravel()[mesh.corners], mesh.source[mesh.faces])
    assert_array_equal(np.bincount(mesh.copies), np.full(8, len(domain.faces)))
    folded = np.abs(mesh.vertices - mesh.vertices.mean(axis=0))
    assert_allclose(folded[: domain.vertex_count][mesh.source], folded, atol=0.02)


def test_plain_instances_of_the_piece_meet_without_a_gap():
    """Its sides are exactly in their planes; the rim of a patch, too."""
    for piece in (pieces.nodoid(0.5, 32), pieces.sphere_eighth(8), pieces.unduloid(-0.5, 16, free=True)):
        whole = complete(piece.surface, piece.sides, copies=7)
        assert whole.mesh.largest_gap > 1e-5
        shown = zip(whole.transforms(), whole.sheets, strict=True)
        placed = np.concatenate([whole.piece(name) @ matrix[:3, :3].T + matrix[:3, 3] for matrix, name in shown])
        assert_allclose(placed, whole.mesh.vertices[whole.members.ravel()], atol=1e-12)


def test_a_placed_surface_has_placed_copies():
    from solver.surface.placement import Similarity

    piece = pieces.unduloid(-0.5, 16, free=True)
    whole = complete(piece.surface, piece.sides)
    turn = np.linalg.qr(np.random.default_rng(5).normal(size=(3, 3)))[0]
    placed = Similarity(2.5, turn, np.array([1.0, -2.0, 0.5]))
    for copy, matrix, name in zip(whole.copies, whole.transforms(placed), whole.sheets, strict=True):
        points = piece.surface.sheet(name)
        image = placed.points(points) @ matrix[:3, :3].T + matrix[:3, 3]
        assert_allclose(image, placed.points(copy.points(points)), atol=1e-12)


def test_parts_of_one_plane_are_one_plane():
    """A side in two parts: the parts get one plane, and their measured distance is reported."""
    piece = pieces.sphere_eighth(16)
    left = piece.sides[0]
    parts = [Side("low", left.edges[:8], normal=(1, 0, 0)), Side("high", left.edges[8:], normal=(-1, 0, 0))]
    whole = complete(piece.surface, [*parts, *piece.sides[1:]])
    assert len(whole.copies) == 8 and whole.mesh.is_closed
    (offset,) = whole.offsets
    assert set(offset.sides) == {"low", "high"} and 1e-6 < offset.distance < 0.01
    low, high = whole.planes[:2]
    assert_allclose(low.offset, -high.offset, atol=1e-12)
