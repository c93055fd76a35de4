"""Domains: the same triangles from positions, corners and lengths; refused meshes and the offenders named."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from solver import Domain, MeshError, shapes
from tests.solver.exact_surfaces import disc

SQUARE = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
SQUARE_FACES = [[0, 1, 2], [0, 2, 3]]
TETRAHEDRON = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]]


def moebius_strip(n: int = 9) -> tuple[np.ndarray, list[list[int]]]:
    angle = 2 * np.pi * np.arange(n) / n
    centre = np.column_stack([np.cos(angle), np.sin(angle), 0 * angle])
    across = np.column_stack([np.cos(angle / 2) * np.cos(angle), np.cos(angle / 2) * np.sin(angle), np.sin(angle / 2)])
    points = np.stack([centre - 0.3 * across, centre + 0.3 * across], axis=1).reshape(-1, 3)
    faces = []
    for k in range(n):
        a, b = 2 * k, 2 * k + 1
        c, d = (a + 2, b + 2) if k < n - 1 else (1, 0)
        faces += [[a, c, b], [b, c, d]]
    return points, faces


def test_three_ways_to_the_same_domain():
    domain, points = disc(300)
    corners = Domain.from_corners(domain.faces, points[domain.faces])
    lengths = Domain.from_edge_lengths(domain.faces, domain.side_lengths)
    for other in (corners, lengths):
        assert_allclose(other.cotan_weights, domain.cotan_weights, rtol=1e-9, atol=1e-9)
        assert_array_equal(other.edges, domain.edges)


def test_geometry_of_a_disc():
    domain, points = disc(500)
    a, b, c = (points[domain.faces[:, k]] for k in range(3))
    twice = (b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]
    assert_allclose(domain.face_areas, 0.5 * twice, rtol=1e-9, atol=0)
    assert_allclose(domain.corner_angles.sum(axis=1), np.pi, rtol=1e-12, atol=0)
    assert_allclose(domain.vertex_areas.sum(), domain.area, rtol=1e-12, atol=0)
    assert (domain.euler_characteristic, domain.genus, len(domain.boundary_loops)) == (1, 0, 1)


def test_layout_is_congruent_and_counter_clockwise():
    domain, _ = disc(300)
    sides = np.linalg.norm(domain.layout[:, [2, 0, 1]] - domain.layout[:, [1, 2, 0]], axis=2)
    assert_allclose(sides, domain.side_lengths, rtol=1e-9, atol=0)
    assert (domain.layout[:, 2, 1] > 0).all()


def test_laplacian_is_exact_on_linear_functions():
    """L u is zero inside for linear u, and u·Lu is twice its Dirichlet energy, the area."""
    domain, points = disc(700)
    inside = np.setdiff1d(np.arange(domain.vertex_count), domain.boundary_vertices)
    assert_allclose((domain.laplacian @ points)[inside], 0, rtol=0, atol=1e-12)
    assert_allclose(points[:, 0] @ domain.laplacian @ points[:, 0], domain.area, rtol=1e-12, atol=0)


def test_edges_have_their_left_face_on_the_left():
    domain, _ = disc(300)
    for side, (a, b) in ((0, (0, 1)), (1, (1, 0))):
        e = domain.interior_edges if side else np.arange(len(domain.edges))
        faces = domain.faces[domain.edge_faces[e, side]]
        starts = np.argmax(faces == domain.edges[e, a][:, None], axis=1)
        ahead = faces[np.arange(len(e)), (starts + 1) % 3]
        assert_array_equal(ahead, domain.edges[e, b])


def test_face_edges_are_opposite_their_corners():
    domain, _ = disc(300)
    for k in range(3):
        ends = np.sort(domain.faces[:, [(k + 1) % 3, (k + 2) % 3]], axis=1)
        assert_array_equal(np.sort(domain.edges[domain.face_edges[:, k]], axis=1), ends)


def test_twins_run_the_other_way():
    domain, _ = disc(300)
    start, end = domain.faces[:, [1, 2, 0]].ravel(), domain.faces[:, [2, 0, 1]].ravel()
    paired = np.flatnonzero(domain.twins >= 0)
    assert_array_equal(start[domain.twins[paired]], end[paired])
    assert_array_equal(domain.twins[domain.twins[paired]], paired)
    assert (domain.twins < 0).sum() == len(domain.boundary_edges)


def test_boundary_loops_keep_the_surface_on_the_left():
    shape = shapes.annulus(0.4, 1.0, 600)
    for loop, edges, sign in zip(shape.domain.boundary_loops, shape.domain.boundary_loop_edges, (1, -1), strict=True):
        x, y = shape.positions[loop].T
        area = 0.5 * np.sum(x * np.roll(y, -1) - y * np.roll(x, -1))
        assert np.sign(area) == sign
        assert loop[0] == loop.min()
        assert_array_equal(shape.domain.edges[edges, 0], loop)
        assert_array_equal(shape.domain.edges[edges, 1], np.roll(loop, -1))


def test_face_edges_distinguish_parallel_edges():
    """A torus of one column and two triangles: one vertex, three edges."""
    domain = Domain.from_edge_lengths([[0, 0, 0], [0, 0, 0]], np.ones((2, 3)), face_edges=[[0, 1, 2], [0, 1, 2]])
    assert (domain.vertex_count, len(domain.edges), domain.euler_characteristic, domain.genus) == (1, 3, 0, 1)


def test_the_size_of_the_mesh_does_not_matter():
    domain, points = disc(300)
    for factor in (1e-6, 1e6):
        scaled = Domain.from_positions(factor * points, domain.faces)
        assert_allclose(scaled.cotan_weights, domain.cotan_weights, rtol=1e-8, atol=1e-8)


def refused(vertices, faces) -> MeshError:
    with pytest.raises(MeshError) as caught:
        Domain.from_positions(vertices, faces)
    return caught.value


def test_refuses_an_empty_mesh():
    assert "no vertices" in str(refused(np.zeros((0, 3)), SQUARE_FACES))
    assert "no faces" in str(refused(SQUARE, np.zeros((0, 3), dtype=int)))


def test_refuses_wrong_shapes_and_types():
    assert "(F, 3)" in str(refused(SQUARE, [[0, 1, 2, 3]]))
    assert "integers" in str(refused(SQUARE, [[0.0, 1.0, 2.0]]))
    assert "(V, 2)" in str(refused(np.zeros((4, 4)), SQUARE_FACES))


@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_refuses_coordinates_that_are_not_finite(bad):
    points = SQUARE.copy()
    points[2, 1] = bad
    error = refused(points, SQUARE_FACES)
    assert error.vertices == (2,) and "vertex 2" in str(error)


def test_refuses_indices_out_of_range():
    error = refused(SQUARE, [[0, 1, 2], [0, 2, 7]])
    assert error.faces == (1,) and "vertex 7" in str(error)
    error = refused(SQUARE, [[0, 1, -2]])
    assert error.faces == (0,)


def test_refuses_a_face_that_repeats_a_vertex():
    error = refused(SQUARE, [[0, 1, 2], [0, 2, 3], [3, 3, 0]])
    assert error.faces == (2,) and "Face 2" in str(error)


def test_refuses_repeated_faces():
    error = refused(SQUARE, [[0, 1, 2], [0, 2, 3], [2, 0, 1]])
    assert error.faces == (0, 2) and "same vertices" in str(error)


def test_refuses_loose_vertices():
    error = refused(np.vstack([SQUARE, [[2.0, 2.0], [3.0, 3.0]]]), SQUARE_FACES)
    assert error.vertices == (4, 5)


def test_refuses_an_edge_with_three_faces():
    points = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1.0]])
    error = refused(points, [[0, 1, 2], [1, 0, 3], [0, 1, 4]])
    assert len(error.edges) == 1 and error.vertices == (0, 1) and "vertices 0, 1; 3 faces" in str(error)


def test_refuses_faces_oriented_against_each_other():
    error = refused(SQUARE, [[0, 1, 2], [0, 3, 2]])
    assert error.faces == (1,) and "Face 1 has the other orientation" in str(error) and "recalculate" in str(error)


def test_names_the_faces_to_turn_only():
    """Those of the smaller part, wherever they are."""
    shape = shapes.disc(60)
    faces = shape.domain.faces.copy()
    faces[[5, 17]] = faces[[5, 17]][:, ::-1]
    assert refused(shape.positions, faces).faces == (5, 17)


def test_components_that_touch_are_to_be_merged():
    left = np.array([[0, 0], [1, 0], [1, 1], [0, 1.0]])
    quads = np.array([[0, 1, 2], [0, 2, 3]])
    error = refused(np.vstack([left, left + [1, 0]]), np.vstack([quads, quads + 4]))
    assert "2 components that touch: vertices 1, 2, 4, 7 lie" in str(error) and "; merge them by distance" in str(error)
    assert error.vertices == (1, 2, 4, 7)
    tall = np.array([[1, 0], [2, 0], [2, 3], [1, 3.0]])
    error = refused(np.vstack([left, tall]), np.vstack([quads, quads + 4]))
    assert "vertices 1, 4 lie" in str(error) and "split the longer of their edges" in str(error)
    error = refused(np.vstack([left, left + [5, 0]]), np.vstack([quads, quads + 4]))
    assert "solve them one by one" in str(error)


def test_refuses_a_moebius_strip_as_one_sided():
    error = refused(*moebius_strip())
    assert "Möbius" in str(error) and len(error.edges) == 1


def test_refuses_several_components():
    points = np.vstack([SQUARE, SQUARE[:3] + 5])
    error = refused(points, [*SQUARE_FACES, [4, 5, 6]])
    assert error.faces == (2,) and "2 components" in str(error)


def test_refuses_a_vertex_where_parts_only_touch():
    ring = np.array([[0, 0], [1, 0], [1, 1], [0, 1], [-1, 0], [-1, -1], [0, -1]], dtype=float)
    faces = [[0, 1, 2], [0, 2, 3], [0, 4, 5], [0, 5, 6]]
    points = np.vstack([ring, [[2, -2.0]]])
    # two squares that share vertex 0 and hang together around the outside
    faces += [[1, 6, 7], [6, 5, 7], [1, 7, 2]]
    error = refused(points, faces)
    assert 0 in error.vertices


@pytest.mark.parametrize("third", [[0.5, 0.0], [0.5, 1e-12]])
def test_refuses_faces_without_area(third):
    error = refused(np.array([[0.0, 0.0], [1.0, 0.0], third]), [[0, 1, 2]])
    assert error.faces == (0,) and "no area" in str(error)


def test_refuses_corners_that_do_not_fit():
    corners = SQUARE[np.array(SQUARE_FACES)]
    corners[1] *= 1.1
    with pytest.raises(MeshError, match="different lengths") as caught:
        Domain.from_corners(SQUARE_FACES, corners)
    assert len(caught.value.edges) == 1


def test_refuses_lengths_that_make_no_triangle():
    with pytest.raises(MeshError, match="no area"):
        Domain.from_edge_lengths([[0, 1, 2]], [[1.0, 1.0, 2.0]])
    with pytest.raises(MeshError, match="not a positive number"):
        Domain.from_edge_lengths([[0, 1, 2]], [[1.0, -1.0, 1.0]])


def test_a_closed_mesh_is_a_domain():
    points = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1.0]])
    domain = Domain.from_positions(points, TETRAHEDRON)
    assert (domain.euler_characteristic, domain.genus, domain.boundary_loops) == (2, 0, [])


def test_refuses_arrays_that_are_not_numbers():
    assert "more corners than others" in str(refused(SQUARE, [[0, 1, 2], [0, 2]]))
    assert "must be numbers" in str(refused([["a", "b"]], [[0, 1, 2]]))
