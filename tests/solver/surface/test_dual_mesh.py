"""Dual mesh and corner mesh (Figure 5): counts, orientation, cuts, Voronoi cells."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from scipy.spatial import cKDTree

from solver import Domain, shapes
from solver.domain.topology import Homology
from solver.surface.dual_mesh import CornerValues, corner_mesh, dual_mesh
from tests.solver.exact_surfaces import moved
from tests.solver.polygon_meshes import area_vectors, assert_manifold, directed_edges

HOLES = (
    [(0, 0), (4, 0), (4, 3), (0, 3)],
    [[(0.5, 0.5), (1.5, 0.5), (1.5, 1.5), (0.5, 1.5)], [(2.3, 1.2), (3.4, 1.2), (3.4, 2.4), (2.3, 2.4)]],
)


def one_vertex_torus() -> Domain:
    """A parallelogram with opposite sides glued: two faces, three edges, all with the same vertex at their ends."""
    a, b, c, d = np.array([[0, 0], [1, 0], [1.3, 0.9], [0.3, 0.9]])
    corners = np.array([[a, b, c], [a, c, d]])
    return Domain.from_corners(np.zeros((2, 3), dtype=int), corners, face_edges=[[0, 1, 2], [2, 0, 1]])


def genus_two() -> Domain:
    """A regular octagon with sides glued as a b a⁻¹ b⁻¹ c d c⁻¹ d⁻¹, divided from its centre: two vertices."""
    sides = [0, 1, 0, 1, 2, 3, 2, 3]
    faces = np.tile([0, 1, 1], (8, 1))
    spokes = 4 + np.arange(8)
    face_edges = np.column_stack([sides, np.roll(spokes, -1), spokes])
    return Domain.from_edge_lengths(faces, np.tile([0.7, 1.0, 1.0], (8, 1)), face_edges=face_edges)


DOMAINS = {
    "disc": lambda: shapes.disc(300).domain,
    "annulus": lambda: shapes.annulus(0.4, 1.0, 400).domain,
    "two holes": lambda: shapes.polygon(*HOLES, max_edge=0.3).domain,
    "cylinder": lambda: shapes.cylinder(2 * np.pi, 2.0, 12).domain,
    "torus": lambda: shapes.torus(3.0, 2.0, 8).domain,
    "coarse torus": lambda: shapes.torus(3.0, 2.0, 3).domain,
    "one-vertex torus": one_vertex_torus,
    "genus two": genus_two,
    "sphere": lambda: shapes.sphere(100).domain,
}
SITES = ("vertices", "faces")
BUILDERS = {"dual": dual_mesh, "corner": corner_mesh}


@pytest.fixture(params=DOMAINS)
def domain(request):
    return DOMAINS[request.param]()


def unit(vectors):
    return vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)


def random_corners(domain, sites, is_open=False, seed=0):
    """Random normals and a random conjugate with random periods; the form (E, 3) that it integrates.

    With sites at faces the form is the difference of g along each edge, `g_head - g_tail`.
    """
    random = np.random.default_rng(seed)
    homology = Homology.of(domain)
    k = len(homology.generators) if is_open else 0
    periods, faces = random.normal(size=(k, 3)), len(domain.faces)
    crossings = homology.crossings[:, :k]
    if sites == "vertices":
        g = random.normal(size=(faces, 3))
        left, right = domain.edge_faces.T
        form = g[left] - g[right] + crossings @ periods
        points = random.normal(size=(len(domain.boundary_edges), 3))
        form[domain.boundary_edges] = g[left[domain.boundary_edges]] - points
        values = np.broadcast_to(g[:, None], (faces, 3, 3))
        normals = unit(random.normal(size=(domain.vertex_count, 3)))[domain.faces]
    else:
        g, points = random.normal(size=(domain.vertex_count, 3)), None
        values = g[domain.faces]
        if is_open:
            sheets = homology.sheets
            values = (g[sheets.source] + sheets.offsets @ periods)[sheets.faces]
        behind = domain.half_edges[:, 0]
        tail, head = (behind - behind % 3 + (behind + step) % 3 for step in (1, 2))
        form = values.reshape(-1, 3)[head] - values.reshape(-1, 3)[tail]
        normals = np.broadcast_to(unit(random.normal(size=(faces, 3)))[:, None], (faces, 3, 3))
    weights = random.dirichlet([1.0, 1.0, 1.0], faces)
    rim = unit(random.normal(size=(len(domain.boundary_edges), 3)))
    return CornerValues(domain, values, normals, weights, rim, points, crossings, periods), form


def volume(points, polygons):
    """Signed volume inside a closed surface, its polygons divided from their centres."""
    total = 0.0
    for p in polygons:
        q = points[p]
        total += np.einsum("ij,ij->", np.cross(q, np.roll(q, -1, axis=0)), np.broadcast_to(q.mean(axis=0), q.shape))
    return total / 6.0


@pytest.mark.parametrize("sites", SITES)
def test_counts_of_the_dual(domain, sites):
    """A polygon a vertex, as many corners as faces and boundary edges around it; the Euler characteristic stays."""
    corners, _ = random_corners(domain, sites)
    dual = dual_mesh(corners)
    faces, rim = len(domain.faces), len(domain.boundary_edges)
    assert len(dual.polygons) == domain.vertex_count and len(dual.source) == faces + rim
    around = np.bincount(domain.faces.ravel()) + np.bincount(
        domain.edges[domain.boundary_edges].ravel(), minlength=domain.vertex_count
    )
    assert_array_equal([len(p) for p in dual.polygons], around)
    if domain.vertex_count > 9:  # on the coarsest domains a face meets a polygon twice
        euler, boundary = assert_manifold(dual.polygons, faces + rim)
        assert euler == domain.euler_characteristic and boundary == rim


@pytest.mark.parametrize("sites", SITES)
def test_counts_of_the_corner_mesh(domain, sites):
    corners, _ = random_corners(domain, sites)
    mesh = corner_mesh(corners)
    faces, rim = len(domain.faces), len(domain.boundary_edges)
    sizes = Counter(len(p) for p in mesh.polygons[: faces + len(domain.interior_edges)])
    euler, boundary = assert_manifold(mesh.polygons, len(mesh.source))
    assert euler == domain.euler_characteristic
    if sites == "vertices":
        assert len(mesh.polygons) == faces + len(domain.edges) + domain.vertex_count
        assert len(mesh.source) == 3 * faces + 2 * rim and boundary == 2 * rim
    else:
        fans = np.bincount(domain.faces.ravel())
        assert len(mesh.polygons) == faces + len(domain.interior_edges) + (fans >= 3).sum()
        assert len(mesh.source) == 3 * faces
    assert sizes == {3: faces, 4: len(domain.interior_edges)}


@pytest.mark.parametrize("sites", SITES)
def test_dual_polygons_begin_and_end_with_the_boundary(sites):
    """Figure 7: boundary edge out, faces counter-clockwise, boundary edge in; only the edge that closes it is free."""
    domain = DOMAINS["annulus"]()
    polygons = dual_mesh(random_corners(domain, sites)[0]).polygons
    rim, faces = domain.boundary_edges, len(domain.faces)
    for v in domain.boundary_vertices:
        polygon = polygons[v]
        assert domain.edges[rim[polygon[0] - faces], 0] == v and domain.edges[rim[polygon[-1] - faces], 1] == v
        assert (polygon[1:-1] < faces).all()
        assert domain.edge_faces[rim[polygon[0] - faces], 0] == polygon[1]
        assert domain.edge_faces[rim[polygon[-1] - faces], 0] == polygon[-2]
    steps, _ = directed_edges(polygons)
    directed = set(map(tuple, steps.tolist()))
    free = {(a, b) for a, b in directed if (b, a) not in directed}
    assert free == {(polygons[v][-1], polygons[v][0]) for v in domain.boundary_vertices}


@pytest.mark.parametrize("builder", BUILDERS)
@pytest.mark.parametrize("sites", SITES)
def test_polygons_are_whole_on_the_sheets_of_an_open_surface(domain, sites, builder):
    """Along every polygon g changes by the form that it integrates, across the cuts as elsewhere."""
    corners, form = random_corners(domain, sites, is_open=True)
    mesh = BUILDERS[builder](corners)
    if sites == "faces" and builder == "dual":
        form = steps_of_averages(corners)
    steps, owner = directed_edges(mesh.polygons)
    change = mesh.conjugate[steps[:, 1]] - mesh.conjugate[steps[:, 0]]
    if sites == "vertices" or builder == "dual":  # the edges that close the polygons of the boundary are of no form
        closed = np.arange(-domain.vertex_count, 0)[domain.boundary_vertices] + len(mesh.polygons)
        change = change[~(np.isin(owner, closed) & (np.diff(owner, append=-1) != 0))]
    known = cKDTree(np.concatenate([form, -form, np.zeros((1, 3))]))
    assert known.query(change)[0].max() < 1e-12
    assert_manifold(mesh.polygons, len(mesh.source))


def steps_of_averages(corners):
    """(E, 3) from the average of g in the face on the left of each edge to that on its right, or to its midpoint."""
    domain = corners.domain
    average = np.einsum("fc,fcx->fx", corners.weights, corners.conjugate)
    left, right = domain.edge_faces.T
    half_edges = domain.half_edges[:, 0]
    ends = [half_edges - half_edges % 3 + (half_edges + step) % 3 for step in (1, 2)]
    middle = corners.conjugate.reshape(-1, 3)[np.stack(ends)].mean(axis=0)
    across = average[right] - corners.crossings @ corners.periods
    return np.where(right[:, None] < 0, middle, across) - average[left]


@pytest.mark.parametrize("builder", BUILDERS)
@pytest.mark.parametrize("sites", SITES)
def test_polygons_are_oriented_like_the_triangles(sites, builder):
    """A sphere turned outside out encloses the same positive volume by its triangles and by either complex."""
    shape = shapes.sphere(600)
    domain, points = shape.domain, shape.positions
    faces = len(domain.faces)
    centres = points[domain.faces].mean(axis=1)
    on_faces, on_vertices = np.broadcast_to(centres[:, None], (faces, 3, 3)), points[domain.faces]
    g, N = (on_faces, on_vertices) if sites == "vertices" else (on_vertices, on_faces)
    nothing, points_of_rim = np.zeros((0, 3)), np.zeros((0, 3)) if sites == "vertices" else None
    weights, crossings = np.full((faces, 3), 1 / 3), np.zeros((len(domain.edges), 0))
    corners = CornerValues(domain, g, N, weights, nothing, points_of_rim, crossings, nothing)
    mesh = BUILDERS[builder](corners)
    enclosed = volume(mesh.conjugate + mesh.normals, mesh.polygons)
    assert_allclose(enclosed, volume(2 * points, list(domain.faces)), rtol=0.05, atol=0)
    f_plus = mesh.conjugate + mesh.normals
    outwards = [f_plus[p].mean(axis=0) for p in mesh.polygons]
    assert (np.einsum("px,px->p", area_vectors(f_plus, mesh.polygons), outwards) > 0).all()


def flat_torus(columns, jitter):
    """A torus 3 × 2 with moved vertices, and the unrolled positions (F, 3, 2) of its corners."""
    shape = shapes.torus(3.0, 2.0, columns)
    size = np.array([3.0, 2.0])
    points = moved(shape.positions, np.ones(len(shape.positions)), jitter * 3.0 / columns, 5)
    corners = points[shape.domain.faces]
    corners -= size * np.round((corners - corners[:, :1]) / size)
    return Domain.from_corners(shape.domain.faces, corners, face_edges=shape.domain.face_edges), corners


@pytest.mark.parametrize("name", ["moved", "one-vertex torus"])
def test_the_dual_of_a_flat_torus_are_its_voronoi_cells(name):
    """g at circumcentres, its periods the sides of the torus: the cell of vertex i has area ¼ Σ w |e|²."""
    if name == "moved":
        domain, unrolled = flat_torus(8, 0.2)
    else:
        domain = one_vertex_torus()
        unrolled = np.array([[[0, 0], [1, 0], [1.3, 0.9]], [[0, 0], [1.3, 0.9], [0.3, 0.9]]])
    behind = domain.half_edges[:, 0]
    tail, head = (behind - behind % 3 + (behind + step) % 3 for step in (1, 2))
    along = unrolled.reshape(-1, 2)[head] - unrolled.reshape(-1, 2)[tail]
    form = domain.cotan_weights[:, None] * np.column_stack([-along[:, 1], along[:, 0], 0 * behind])
    homology = Homology.of(domain)
    g = homology.integrate(form)
    shape = (len(domain.faces), 3, 3)
    up, weights = np.broadcast_to([0.0, 0.0, 1.0], shape), np.full(shape[:2], 1 / 3)
    periods = homology.periods(form, g)
    values, rim = np.broadcast_to(g[:, None], shape), np.zeros((0, 3))
    corners = CornerValues(domain, values, up, weights, rim, None, homology.crossings, periods)
    dual = dual_mesh(corners)
    cells = np.zeros(domain.vertex_count)
    for end in domain.edges.T:
        np.add.at(cells, end, 0.25 * domain.cotan_weights * domain.edge_lengths**2)
    assert_allclose(area_vectors(dual.conjugate, dual.polygons)[:, 2], cells, rtol=0, atol=1e-12)
    assert_allclose(cells.sum(), domain.area, rtol=1e-12, atol=0)


def flat_corners(faces, face_edges):
    domain = Domain.from_edge_lengths(faces, np.ones((len(faces), 3)), face_edges=face_edges)
    return random_corners(domain, "vertices")[0]


def test_vertices_with_fewer_than_three_faces_have_no_polygon():
    """Two triangles glued along all sides, and a triangle rolled into a cone: polygons of two or one are left out."""
    pillow = flat_corners([[0, 1, 2], [0, 2, 1]], [[0, 1, 2], [0, 2, 1]])
    assert dual_mesh(pillow).polygons == []
    mesh = corner_mesh(pillow)
    assert Counter(map(len, mesh.polygons)) == {3: 2, 4: 3}
    assert assert_manifold(mesh.polygons, 6) == (2, 0)

    cone = flat_corners([[0, 1, 1]], [[0, 1, 1]])
    mesh = corner_mesh(cone)
    assert Counter(map(len, mesh.polygons)) == {3: 2, 4: 2}  # face, edge to the tip; rim, vertex on the rim
    assert len(mesh.source) == 5 and dual_mesh(cone).polygons == []


@pytest.mark.parametrize("builder", BUILDERS)
def test_normals_that_cancel_are_left_zero(builder):
    """Where a vertex averages opposite normals there is no unit normal; the others have length one."""
    domain = DOMAINS["disc"]()
    corners, _ = random_corners(domain, "vertices")
    mesh = BUILDERS[builder](corners)
    normals = mesh.normals.copy()
    normals[3] = 0.0
    lengths = np.linalg.norm(replace(mesh, normals=normals).mesh(mesh.conjugate).normals, axis=1)
    assert lengths[3] == 0.0
    assert_allclose(np.delete(lengths, 3), 1.0, rtol=1e-12, atol=0)
