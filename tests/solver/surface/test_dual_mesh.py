"""The dual complex and the corner complex (Figure 5): counts, orientation, planes, sheets, convergence."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from solver import ConditionError, Domain, conditions, shapes, solve_cmc
from solver.domain.topology import Homology
from solver.surface.cmc_surface import COMBINATORICS
from solver.surface.dual_mesh import CornerValues, corner_mesh, dual_mesh
from tests.solver.exact_surfaces import disc, hemisphere, moved, rates

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


def directed_edges(polygons):
    """(m, 2) rows of each step of each polygon, and the polygon of each (m,)."""
    steps = np.concatenate([np.stack([p, np.roll(p, -1)], axis=1) for p in polygons])
    return steps, np.repeat(np.arange(len(polygons)), [len(p) for p in polygons])


def assert_manifold(polygons, count):
    """Every edge in one polygon or, walked both ways, in two; one fan of polygons at each row. χ, boundary edges."""
    steps, owner = directed_edges(polygons)
    assert all(len(np.unique(p)) == len(p) >= 3 for p in polygons)
    assert_array_equal(np.unique(steps), np.arange(count))
    place = {(a, b): n for n, (a, b) in enumerate(steps.tolist())}
    assert len(place) == len(steps), "two polygons walk an edge in the same direction"
    twin = np.array([place.get((b, a), -1) for a, b in steps.tolist()])
    joined = np.flatnonzero(twin >= 0)
    # a step starts a corner of its polygon; the corner at its end is that of the step that follows
    follower = {(int(p), int(a)): n for n, (p, (a, _)) in enumerate(zip(owner, steps, strict=True))}
    after = np.array([follower[int(owner[n]), int(steps[n, 1])] for n in range(len(steps))])
    graph = coo_array((np.ones(len(joined)), (joined, after[twin[joined]])), shape=(len(steps), len(steps)))
    assert connected_components(graph, directed=False)[0] == count, "a row joins several fans of polygons"
    edges = len(steps) - len(joined) // 2
    return count - edges + len(polygons), int((twin < 0).sum())


def volume(points, polygons):
    """Signed volume inside a closed surface, its polygons divided from their centres."""
    total = 0.0
    for p in polygons:
        q = points[p]
        total += np.einsum("ij,ij->", np.cross(q, np.roll(q, -1, axis=0)), np.broadcast_to(q.mean(axis=0), q.shape))
    return total / 6.0


def area_vectors(points, polygons):
    centred = [points[p] - points[p].mean(axis=0) for p in polygons]
    return np.array([0.5 * np.cross(q, np.roll(q, -1, axis=0)).sum(axis=0) for q in centred])


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
def test_counts_of_the_corner_complex(domain, sites):
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
    """With normals on vertices: on g, and on f± of the corner complex; closed along the boundary too."""
    surface, _ = twisted("vertices")
    N = surface.harmonic.normals
    dual = surface.as_mesh("g", "dual")
    assert len(dual.polygons) == len(N) and off_plane(dual.vertices, dual.polygons, N) < 1e-8
    for sheet in ("f+", "f-", "g"):
        mesh = surface.as_mesh(sheet, "corner")
        assert off_plane(mesh.vertices, mesh.polygons[-len(N) :], N) < 1e-8


def test_triangles_are_orthogonal_to_the_normals_of_their_faces():
    """With normals on faces: on g itself, and on f± of the corner complex; corners of a vertex on a sphere about g."""
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
    assert_allclose(mesh.interpolate_corners(points[surface.domain.faces]), place, rtol=0, atol=1e-13)
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


def test_faces_of_the_corner_complex_turn_with_the_gauss_map():
    """Triangles of f+ over saddles, where neighbouring normals run the other way around, are upside down."""
    surface, _ = twisted("vertices", n=300)
    mesh, faces = surface.as_mesh("f+", "corner"), surface.domain.faces
    a, b, c = (surface.normals[faces[:, k]] for k in range(3))
    gauss = np.einsum("ij,ij->i", np.cross(b - a, c - a), a + b + c)
    turned = area_vectors(mesh.vertices, mesh.polygons[: len(faces)])
    assert (gauss > 0).any() and (gauss < 0).any()
    assert_array_equal(np.einsum("ij,ij->i", turned, a + b + c) > 0, gauss > 0)


@pytest.mark.parametrize("builder", BUILDERS)
def test_normals_that_cancel_are_left_zero(builder):
    """Where a vertex averages opposite normals there is no unit normal; the others have length one."""
    domain = DOMAINS["disc"]()
    corners, _ = random_corners(domain, "vertices")
    complex_ = BUILDERS[builder](corners)
    normals = complex_.normals.copy()
    normals[3] = 0.0
    lengths = np.linalg.norm(replace(complex_, normals=normals).mesh(complex_.conjugate).normals, axis=1)
    assert lengths[3] == 0.0
    assert_allclose(np.delete(lengths, 3), 1.0, rtol=1e-12, atol=0)
