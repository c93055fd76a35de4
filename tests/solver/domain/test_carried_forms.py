"""One-forms carried through flips, and integrals carried back to the domain, cuts and gaps included."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from solver import Domain, conditions, shapes, solve_cmc
from solver.domain.delaunay import Retriangulation, carried_cut, intrinsic_delaunay
from solver.domain.topology import CutSurface, Homology
from solver.domain.trees import Tree
from tests.solver import tiny_domains
from tests.solver.thin_domains import WITH_HOLES, sheared_grid

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
