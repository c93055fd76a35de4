"""Intrinsic Delaunay triangulations: the same metric, better triangles; edges that share their vertices, too."""

from __future__ import annotations

import sys

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from scipy.spatial import Delaunay

from solver import Domain, MeshError, conditions, shapes, solve_cmc
from solver.domain import delaunay
from solver.domain.delaunay import Retriangulation, carried_cut, intrinsic_delaunay, speed_note
from solver.domain.flips import Flips
from solver.domain.topology import CutSurface, Homology
from solver.domain.trees import Tree
from solver.shells.form import form
from solver.shells.plan import Plan, Settings
from solver.surface import averaging
from tests.solver import meshes, tiny_domains

WITH_HOLES = (
    [(0, 0), (4, 0), (4, 3), (0, 3)],
    [[(0.5, 0.5), (1.5, 0.5), (1.5, 1.5), (0.5, 1.5)], [(2.3, 1.2), (3.4, 1.2), (3.4, 2.4), (2.3, 2.4)]],
)


def sheared_grid(columns: int = 20, rows: int = 6, shear: float = 3.3) -> tuple[np.ndarray, np.ndarray]:
    x, y = (a.ravel() for a in np.meshgrid(np.arange(columns), np.arange(rows), indexing="ij"))
    i, j = (a.ravel() for a in np.meshgrid(np.arange(columns - 1), np.arange(rows - 1), indexing="ij"))
    o = i * rows + j
    faces = np.concatenate([np.column_stack([o, o + rows, o + rows + 1]), np.column_stack([o, o + rows + 1, o + 1])])
    return np.column_stack([x + shear * y, y]).astype(float), faces


def stretched(factor: float, n: int = 400, seed: int = 3) -> tuple[np.ndarray, np.ndarray]:
    """Random points in a square, triangulated well, then drawn apart in y: needles."""
    points = np.random.default_rng(seed).random((n, 2)) * [1.0, factor]
    return points, stretched_faces(points, 1.0 / factor)


def stretched_faces(points: np.ndarray, factor: float) -> np.ndarray:
    """Triangles that would be good ones if y were `factor` times as large; counter-clockwise."""
    faces = Delaunay(points * [1.0, factor]).simplices
    a, b, c = (points[faces[:, k]] for k in range(3))
    twice = (b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]
    faces = np.where((twice < 0)[:, None], faces[:, ::-1], faces)
    return faces[np.abs(twice) > 1e-9 * np.abs(twice).max()]


def thin_strip() -> tuple[np.ndarray, np.ndarray]:
    """Fans across a strip, 40 times as long as wide, with vertices at its two long sides only."""
    n = 30
    x = np.linspace(0, 40, n)
    points = np.concatenate([np.column_stack([x, 0 * x]), np.column_stack([x, 0 * x + 1])])
    k = np.arange(n - 1)
    # all of the bottom hangs on the first vertex of the top, all of the top on the last one of the bottom
    faces = np.concatenate([np.column_stack([k, k + 1, 0 * k + n]), np.column_stack([n + k + 1, n + k, 0 * k + n - 1])])
    return points, faces


FLAT = {
    "a sheared grid": sheared_grid,
    "needles": lambda: stretched(30.0),
    "finer needles": lambda: stretched(1e3),
    "a thin strip": thin_strip,
}
DOMAINS = {name: lambda make=make: Domain.from_positions(*make()) for name, make in FLAT.items()} | {
    "a stretched annulus": lambda: Domain.from_positions(
        shapes.annulus(0.4, 1.0, 300).positions * [1, 5], shapes.annulus(0.4, 1.0, 300).domain.faces
    ),
    "two holes, stretched": lambda: Domain.from_positions(
        shapes.polygon(*WITH_HOLES, max_edge=0.3).positions * [1, 7],
        shapes.polygon(*WITH_HOLES, max_edge=0.3).domain.faces,
    ),
    "a twisted sphere": lambda: Domain.from_positions(*_twisted_sphere()),
    "a torus in space": lambda: Domain.from_positions(*meshes.torus(20, 8, 0.8, 14)),
    "a torus of one vertex": lambda: tiny_domains.small_torus(1, 1, (1.0, 0.0), (5.3, 1.0)),
    "a torus of nine vertices": lambda: tiny_domains.small_torus(3, 3, (1.0, 0.0), (5.3, 1.0)),
    "seven vertices": lambda: tiny_domains.seven_vertex_torus((1.0, 0.0), (2.03, 0.1)),
    "a cylinder of one column": lambda: tiny_domains.small_cylinder(1, (1.0, 0.0), (3.3, 1.0)),
    "a cylinder of two columns": lambda: tiny_domains.small_cylinder(2, (1.0, 0.0), (3.3, 1.0)),
    "a cylinder of three columns": lambda: tiny_domains.small_cylinder(3, (1.0, 0.0), (3.3, 1.0)),
    "a tube": lambda: tiny_domains.helix(9, (0.4, 1.0), (1.8, 2.0)),
}


def _twisted_sphere():
    points, faces = meshes.sphere(300, 0.3)
    return meshes.twisted(points, 20.0), faces


@pytest.fixture(params=DOMAINS)
def domain(request) -> Domain:
    return DOMAINS[request.param]()


@pytest.fixture
def without_libigl(monkeypatch) -> None:
    monkeypatch.setitem(sys.modules, "igl", None)  # makes the import fail


@pytest.fixture(params=["libigl", "our flips"])
def way(request) -> None:
    if request.param == "our flips":
        request.getfixturevalue("without_libigl")
    assert (delaunay._libigl() is None) == (request.param == "our flips")


def cone_angles(domain: Domain) -> np.ndarray:
    return np.bincount(domain.faces.ravel(), domain.corner_angles.ravel())


def opposite_angles(domain: Domain) -> np.ndarray:
    """(n,) sum of the two angles opposite each interior edge."""
    return np.bincount(domain.face_edges.ravel(), domain.corner_angles.ravel())[domain.interior_edges]


def as_list(domain: Domain) -> tuple[np.ndarray, np.ndarray]:
    """Edges by their vertices and lengths, in an order that no numbering changes."""
    pairs = np.sort(domain.edges, axis=1)
    order = np.lexsort((np.round(domain.edge_lengths, 9), *pairs.T))
    return pairs[order], domain.edge_lengths[order]


def test_there_is_something_to_do(domain):
    assert domain.cotan_weights[domain.interior_edges].min() < -0.1


@pytest.mark.usefixtures("way")
def test_every_interior_edge_is_delaunay(domain):
    new = intrinsic_delaunay(domain).domain
    assert opposite_angles(new).max() <= np.pi + 1e-10
    assert new.cotan_weights[new.interior_edges].min() >= -1e-12


@pytest.mark.usefixtures("way")
def test_the_metric_stays(domain):
    """Area, the angles around each vertex, the boundary; and how many vertices, faces, handles and loops."""
    new = intrinsic_delaunay(domain).domain
    assert_allclose(new.area, domain.area, rtol=1e-9, atol=0)
    assert_allclose(cone_angles(new), cone_angles(domain), rtol=0, atol=1e-7)
    assert (new.vertex_count, len(new.faces), new.genus) == (domain.vertex_count, len(domain.faces), domain.genus)
    assert len(new.boundary_loops) == len(domain.boundary_loops)
    for mine, theirs in zip(new.boundary_loops, domain.boundary_loops, strict=True):
        assert_array_equal(mine, theirs)


@pytest.mark.usefixtures("way")
def test_boundary_edges_are_followed(domain):
    new, edges = intrinsic_delaunay(domain).domain, intrinsic_delaunay(domain).edges
    rim = domain.boundary_edges
    assert_array_equal(new.edges[edges[rim]], domain.edges[rim])
    assert_array_equal(new.edge_lengths[edges[rim]], domain.edge_lengths[rim])
    assert_array_equal(np.sort(edges[rim]), new.boundary_edges)
    assert (edges[domain.interior_edges] == -1).all() and len(edges) == len(domain.edges)


@pytest.mark.usefixtures("way")
def test_a_delaunay_domain_stays_the_same(domain):
    once = intrinsic_delaunay(domain)
    twice = intrinsic_delaunay(once.domain)
    assert_array_equal(twice.domain.faces, once.domain.faces)
    assert_array_equal(twice.domain.edge_lengths, once.domain.edge_lengths)
    rim = once.domain.boundary_edges
    assert_array_equal(twice.edges[rim], rim)


@pytest.mark.usefixtures("way")
def test_the_energy_falls(domain):
    """Of all triangulations of the vertices the Delaunay one has the least Dirichlet energy (Rippa)."""
    new = intrinsic_delaunay(domain).domain
    values = np.random.default_rng(5).normal(size=(domain.vertex_count, 4))
    before = np.einsum("vi,vi->i", values, domain.laplacian @ values)
    after = np.einsum("vi,vi->i", values, new.laplacian @ values)
    assert (after <= before * (1 + 1e-9)).all()


@pytest.mark.parametrize("name", FLAT)
def test_triangles_of_the_plane_stay_triangles_of_the_plane(name):
    """Where the plan is convex, edges are straight, and linear functions harmonic."""
    points, faces = FLAT[name]()
    new = intrinsic_delaunay(Domain.from_positions(points, faces)).domain
    a, b, c = (points[new.faces[:, k]] for k in range(3))
    twice = (b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]
    assert_allclose(new.face_areas, 0.5 * twice, rtol=1e-4, atol=0)  # lengths do not tell a needle better
    lengths = np.linalg.norm(points[new.edges[:, 1]] - points[new.edges[:, 0]], axis=1)
    assert_allclose(new.edge_lengths, lengths, rtol=1e-9, atol=0)
    inside = np.setdiff1d(np.arange(len(points)), new.boundary_vertices)
    scale = np.abs(new.laplacian).max() * np.abs(points).max()
    assert_allclose((new.laplacian @ points)[inside], 0, rtol=0, atol=1e-10 * scale)


def test_is_the_delaunay_triangulation_of_the_plane():
    """Inside of a ring of many vertices the points have one Delaunay triangulation, whatever they start from."""
    random = np.random.default_rng(2)
    angle = 2 * np.pi * np.arange(60) / 60
    points = np.concatenate([np.column_stack([np.cos(angle), np.sin(angle)]), 0.85 * (random.random((80, 2)) - 0.5)])
    points[60:, 1] *= 0.5
    start = stretched_faces(points, 30.0)
    best = np.unique(np.sort(Delaunay(points).simplices, axis=1), axis=0)
    new = intrinsic_delaunay(Domain.from_positions(points, start)).domain
    inner = lambda faces: {tuple(face) for face in np.sort(faces, axis=1).tolist() if max(face) >= 60}  # noqa: E731
    assert inner(start) != inner(best)
    assert inner(new.faces) == inner(best)


@pytest.mark.parametrize("vertices", [1, 9])
def test_a_lattice_has_its_shortest_vectors_for_edges(vertices):
    """(1, 0), (5.3, 1) generate the same lattice as (1, 0), (0.3, 1)."""
    n = round(vertices**0.5)
    new = intrinsic_delaunay(tiny_domains.small_torus(n, n, (1.0, 0.0), (5.3, 1.0))).domain
    lengths = np.sort(new.edge_lengths).reshape(3, -1)
    assert_allclose(lengths, np.repeat([[1.0], [1.09**0.5], [1.49**0.5]], vertices, axis=1), rtol=1e-12, atol=0)


def test_an_edge_may_join_a_vertex_to_itself():
    """Around a tube whose vertices are further apart along it than around it."""
    u, v = (0.4, 1.0), (1.8, 2.0)
    domain = tiny_domains.helix(12, u, v)
    new = intrinsic_delaunay(domain).domain
    closed = new.edges[:, 0] == new.edges[:, 1]
    assert not (domain.edges[:, 0] == domain.edges[:, 1]).any()
    assert_allclose(new.edge_lengths[closed], 1.0, rtol=1e-12, atol=0)  # v - 2 u, the circumference
    assert closed.sum() >= 6
    # height along the tube is linear, and so harmonic: an edge from a vertex to itself weighs nothing
    height = tiny_domains.helix_height(12, u, v)
    inside = np.setdiff1d(np.arange(12), new.boundary_vertices)
    assert_allclose((new.laplacian @ height)[inside], 0, rtol=0, atol=1e-12)
    assert_allclose(new.laplacian.sum(axis=1), 0, rtol=0, atol=1e-12)


@pytest.mark.parametrize("name", ["a sheared grid", "needles", "two holes, stretched", "a twisted sphere"])
def test_our_flips_and_libigl_agree(name):
    domain = DOMAINS[name]()
    ours, theirs = as_list(Flips(domain).domain()), as_list(delaunay._flipped_by(delaunay._libigl(), domain))
    assert_array_equal(ours[0], theirs[0])
    assert_allclose(ours[1], theirs[1], rtol=1e-9, atol=0)


def test_libigl_does_what_it_can(monkeypatch):
    """Our flips, which are slow, run for coarse domains and for those with holes only."""
    monkeypatch.setattr(delaunay, "Flips", lambda domain: pytest.fail("libigl was not used"))
    for name in ("a sheared grid", "needles", "a twisted sphere"):
        assert intrinsic_delaunay(DOMAINS[name]()).flips is None


@pytest.mark.parametrize("name", ["a torus in space", "seven vertices", "a tube"])
def test_contradicting_tables_of_libigl_are_rejected(name):
    """On the way these have vertices with two edges only."""
    assert delaunay._flipped_by(delaunay._libigl(), DOMAINS[name]()) is None


@pytest.mark.parametrize("shear", [2, 3, 5])
@pytest.mark.parametrize("height", [0.1, 0.31, 0.7])
def test_squares_are_not_flipped_back_and_forth(shear, height):
    """Sheared rectangles come to stand upright in `shear` rounds; which diagonal they have then is left at that."""
    domain = tiny_domains.small_torus(3, 3, (0.7, 0.0), (shear * 0.7, height))
    assert len(Flips(domain).history) // 3 == 9 * shear


def test_both_ways_agree(domain, request):
    """On the Laplacian, which does not depend on diagonals between four vertices on a circle, and the boundary."""
    theirs = intrinsic_delaunay(domain)
    request.getfixturevalue("without_libigl")
    ours = intrinsic_delaunay(domain)
    scale = np.abs(theirs.domain.laplacian).max()
    assert_allclose(ours.domain.laplacian.toarray(), theirs.domain.laplacian.toarray(), rtol=0, atol=1e-7 * scale)
    rim = domain.boundary_edges
    assert_array_equal(ours.domain.edges[ours.edges[rim]], theirs.domain.edges[theirs.edges[rim]])
    assert (ours.flips is None) == (theirs.flips is None)


@pytest.mark.parametrize(("sites", "energy"), [("vertices", "cotan"), ("faces", "mobius")])
def test_surfaces_of_both_ways_agree(sites, energy, request):
    """A disc of needles."""
    plan = shapes.disc(300)
    domain = Domain.from_positions(plan.positions, stretched_faces(plan.positions[:, :2], 15.0))
    rim = conditions.twisted(domain, plan.positions, domain.boundary_edges, 1)
    theirs = solve_cmc(domain, rim, sites=sites, energy=energy, delaunay=True, tolerance=1e-10)
    request.getfixturevalue("without_libigl")
    ours = solve_cmc(domain, rim, sites=sites, energy=energy, delaunay=True, tolerance=1e-10)
    assert np.degrees(domain.corner_angles.min()) < 2
    assert_allclose(ours.f_plus, theirs.f_plus, rtol=0, atol=1e-8)
    assert_array_equal(ours.faces, domain.faces)


def test_a_libigl_that_does_not_load_counts_as_missing(monkeypatch):
    """Such as a wheel for another system."""

    def broken(name):
        raise ImportError(f"{name}: wrong ELF class")

    monkeypatch.setattr(delaunay.importlib, "import_module", broken)
    new = intrinsic_delaunay(Domain.from_positions(*sheared_grid())).domain
    assert opposite_angles(new).max() <= np.pi + 1e-10


def test_a_note_recommends_libigl_for_large_meshes(monkeypatch, request):
    """No note where libigl would not help: on Delaunay meshes, around holes, on coarse domains."""
    needles, tidy = DOMAINS["needles"](), shapes.disc(300).domain
    monkeypatch.setattr(delaunay, "_LARGE", 18)
    assert speed_note(needles) is None
    request.getfixturevalue("without_libigl")
    assert "libigl is not installed" in speed_note(needles) and "pip install libigl" in speed_note(needles)
    assert speed_note(tidy) is None
    for name in ("two holes, stretched", "a torus of nine vertices", "a cylinder of three columns"):
        assert speed_note(DOMAINS[name]()) is None
    monkeypatch.setattr(delaunay, "_LARGE", len(needles.faces) + 1)
    assert speed_note(needles) is None


@pytest.mark.usefixtures("without_libigl")
def test_the_note_comes_with_the_shell(monkeypatch):
    points, faces = stretched(4.0, 150)
    plan = Plan(np.column_stack([points, 0 * points[:, 0]]), faces)
    chosen, usual = Settings(default_tilt=0.3, delaunay=True), Settings(default_tilt=0.3)
    notes = lambda settings: [note for note in form(plan, settings).warnings if "libigl" in note]  # noqa: E731
    assert notes(chosen) == []
    monkeypatch.setattr(delaunay, "_LARGE", 200)
    assert notes(chosen) == [speed_note(Domain.from_positions(points, faces))]
    assert notes(usual) == []


def test_needles_that_rounding_makes_flat_are_reported():
    """Ten million times as long as they are wide: some survive, for others the error names the vertices."""
    reported = 0
    for seed in range(60):
        try:
            domain = Domain.from_positions(*stretched(1e7, 60, seed))
        except MeshError:
            continue
        try:
            assert len(Flips(domain).domain().faces) == len(domain.faces)
        except MeshError as error:
            assert "so thin that rounding makes them flat" in str(error) and "solve without" in str(error)
            assert len(error.vertices) == 3 and set(error.vertices) <= set(range(60))
            reported += 1
    assert reported > 0


def cone() -> Domain:
    """One triangle, two of whose sides are glued: a cone whose rim is one edge from a vertex to itself."""
    return Domain.from_edge_lengths([[0, 1, 1]], [[1.0, 1.3, 1.3]], face_edges=[[0, 1, 1]])


def test_a_face_may_lie_on_both_sides_of_an_edge():
    domain = cone()
    assert (domain.euler_characteristic, len(domain.boundary_loops), domain.genus) == (1, 1, 0)
    assert intrinsic_delaunay(domain).domain is domain
    assert_array_equal(domain.boundary_loop_edges, [[0]])
    weight = 1 / np.tan(np.arccos(0.5 / 1.3))  # both angles opposite the glued side are at the base
    assert_allclose(domain.cotan_weights[1], weight, rtol=1e-12, atol=0)
    assert_allclose(domain.laplacian.toarray(), weight * np.array([[1, -1], [-1, 1]]), rtol=1e-12, atol=0)


def test_the_conjugate_of_a_cone_has_no_load():
    """Its two half-edges carry opposite products, which cancel."""
    N = np.array([[0.0, 0.0, 1.0], [0.6, 0.0, 0.8]])
    assert_allclose(averaging._galerkin_load(cone(), N), 0, rtol=0, atol=1e-15)


LATTICES = {
    "tube": lambda: (tiny_domains.helix(12, *TUBE), TUBE),
    "seven vertices": lambda: (tiny_domains.seven_vertex_torus(*FLAT_SEVEN), FLAT_SEVEN),
    "one vertex": lambda: (tiny_domains.small_torus(1, 1, *SHEARED), SHEARED),
    "one column": lambda: (tiny_domains.small_cylinder(1, *SHEARED), SHEARED),
    "nine vertices": lambda: (tiny_domains.small_torus(3, 3, *SHEARED), SHEARED),
}
TUBE, FLAT_SEVEN, SHEARED = ((0.4, 1.0), (1.8, 2.0)), ((1.0, 0.0), (2.03, 0.1)), ((1.0, 0.0), (5.3, 1.0))


@pytest.mark.parametrize("name", LATTICES)
def test_a_form_is_carried_through_the_flips(name):
    """The vector along each edge: on the new edges it is as long as the edge, and sums to zero around faces."""
    domain, basis = LATTICES[name]()
    result = intrinsic_delaunay(domain)
    new, vectors = result.domain, result.flips.carry(tiny_domains.edge_vectors(domain, *basis))
    assert_allclose(np.linalg.norm(vectors, axis=1), new.edge_lengths, rtol=1e-9, atol=0)
    sign = np.where(new.edge_faces[new.face_edges, 0] == np.arange(len(new.faces))[:, None], 1, -1)
    one_sided = (new.edge_faces[:, 0] == new.edge_faces[:, 1]).any()
    assert not one_sided
    around = (sign[:, :, None] * vectors[new.face_edges]).sum(axis=1)
    assert_allclose(around, 0, rtol=0, atol=1e-9)


def around_holes() -> tuple[Domain, np.ndarray, np.ndarray]:
    """A stretched plan with two holes, its positions, and a point in each hole."""
    plan = shapes.polygon(*WITH_HOLES, max_edge=0.3)
    points = plan.positions * [1, 7]
    return Domain.from_positions(points, plan.domain.faces), points, np.array([[1.0, 7.0], [2.85, 12.6]])


def turns(points: np.ndarray, edges: np.ndarray, centres: np.ndarray) -> np.ndarray:
    """(E, k) turns about each centre along straight edges."""
    z = (points[:, None] - centres) @ [1, 1j]
    return np.angle(z[edges[:, 1]] / z[edges[:, 0]]) / (2 * np.pi)


def integrated(domain: Domain, sheets: CutSurface, form: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Values (V, d) on the first rows of the cut surface, and periods (k, d), of the integral of `form` (E, d)."""
    inside = domain.interior_edges
    half = np.concatenate([domain.half_edges[:, 0], domain.half_edges[inside, 1]])
    rows = sheets.faces.ravel()
    ends = np.column_stack([rows[half - half % 3 + (half + k) % 3] for k in (2, 1)])
    values = Tree.of(ends, len(sheets.source)).integrate(np.concatenate([form, -form[inside]]))
    first = values[: domain.vertex_count]
    periods = np.linalg.lstsq(sheets.offsets, values - first[sheets.source], rcond=None)[0]
    assert_allclose(first[sheets.source] + sheets.offsets @ periods, values, rtol=0, atol=1e-9)
    return first, periods


def increments(domain: Domain, faces: np.ndarray, values: np.ndarray) -> np.ndarray:
    """(E, d) of values on the rows of a cut surface, in the left face of each edge."""
    half, rows = domain.half_edges[:, 0], faces.ravel()
    start, end = (rows[half - half % 3 + (half + k) % 3] for k in (1, 2))
    return values[end] - values[start]


def assert_carried(domain: Domain, result: Retriangulation, old_form: np.ndarray, new_form: np.ndarray) -> None:
    """What `new_form` integrates to, carried to the old domain cut open, has the increments `old_form`."""
    homology = Homology.of(result.domain)
    values, periods = integrated(result.domain, homology.sheets, new_form)
    cut = carried_cut(domain, result, homology)
    assert_array_equal(cut.source[cut.faces], domain.faces)
    carried = values[cut.source] + cut.offsets @ periods
    assert_allclose(increments(domain, cut.faces, carried), old_form, rtol=0, atol=1e-9)
    right = domain.half_edges[domain.interior_edges, 1]
    rows = cut.faces.ravel()
    start, end = (rows[right - right % 3 + (right + k) % 3] for k in (2, 1))
    assert_allclose(carried[end] - carried[start], old_form[domain.interior_edges], rtol=0, atol=1e-9)


def test_turns_about_holes_are_carried_back():
    domain, points, centres = around_holes()
    result = intrinsic_delaunay(domain)
    assert_carried(domain, result, turns(points, domain.edges, centres), turns(points, result.domain.edges, centres))


@pytest.mark.parametrize("name", LATTICES)
def test_unrolled_positions_are_carried_back(name):
    domain, basis = LATTICES[name]()
    result = intrinsic_delaunay(domain)
    vectors = tiny_domains.edge_vectors(domain, *basis)
    assert_carried(domain, result, vectors, result.flips.carry(vectors))


def test_nothing_is_carried_on_a_disc_or_where_nothing_changed():
    domain = Domain.from_positions(*sheared_grid())
    result = intrinsic_delaunay(domain)
    cut = carried_cut(domain, result, Homology.of(result.domain))
    assert_array_equal(cut.faces, domain.faces)
    domain = intrinsic_delaunay(tiny_domains.helix(12, *TUBE)).domain
    homology = Homology.of(domain)
    cut = carried_cut(domain, intrinsic_delaunay(domain), homology)
    assert_array_equal(cut.offsets, homology.sheets.offsets)


@pytest.fixture(scope="module")
def two_plans():
    """A plan with two holes triangulated well, and with needles; its positions."""
    plan = shapes.polygon(*WITH_HOLES, max_edge=0.25, corner_radius=0.2)
    good = intrinsic_delaunay(plan.domain).domain
    bad = intrinsic_delaunay(Domain.from_positions(plan.positions * [1, 7], plan.domain.faces)).domain
    return good, Domain.from_positions(plan.positions, bad.faces), plan.positions


@pytest.mark.parametrize(("sites", "energy"), [("vertices", "cotan"), ("faces", "mobius")])
def test_a_gap_is_the_same_on_every_triangulation(two_plans, sites, energy):
    """A surface that does not close around its holes: from needles the Delaunay triangulation makes the good one."""
    good, bad, points = two_plans
    surfaces = []
    for domain, choice in ((good, False), (bad, True)):
        rim = conditions.binormal(domain, points, domain.boundary_edges, tilt=0.4)
        surfaces.append(solve_cmc(domain, rim, sites=sites, energy=energy, delaunay=choice, tolerance=1e-9))
    mine, theirs = surfaces[1], surfaces[0]
    assert mine.is_open and theirs.is_open
    assert_allclose(mine.gap, theirs.gap, rtol=1e-6, atol=0)
    assert_array_equal(mine.source[mine.faces], bad.faces)
    # edges that both triangulations have, the whole boundary among them, are the same edges of f+
    ours, others = (by_vertices(s.domain, s.faces, s.f_plus) for s in (mine, theirs))
    shared = ours.keys() & others.keys()
    assert len(shared) > len(good.boundary_edges) + 50
    both = np.array([[ours[key], others[key]] for key in shared])
    assert_allclose(both[:, 0], both[:, 1], rtol=0, atol=1e-6 * mine.gap)
    mesh = mine.as_mesh("f+")
    assert_array_equal(mesh.source, mine.source)
    assert_allclose(mesh.interpolate(points), points[mine.source], rtol=0, atol=1e-12)


def by_vertices(domain: Domain, rows: np.ndarray, values: np.ndarray) -> dict[tuple[int, int], np.ndarray]:
    """The increment of values on rows along each edge, from its lower vertex to its higher one."""
    along = increments(domain, rows, values)
    sign = np.where(domain.edges[:, 0] < domain.edges[:, 1], 1.0, -1.0)
    keys = np.sort(domain.edges, axis=1).tolist()
    return {tuple(key): step for key, step in zip(keys, sign[:, None] * along, strict=True)}
