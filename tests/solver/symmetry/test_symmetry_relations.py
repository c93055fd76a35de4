"""Conditions on sides, the group they generate, and the messages where they contradict each other."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

from solver import (
    CmcError,
    ConditionError,
    Domain,
    MeshError,
    Side,
    complete,
    conditions,
    shapes,
    side_plane,
    solve_cmc,
)
from solver.domain.gluing import check_glued, doubled, glue, glued_domain
from solver.symmetry.isometries import Isometry, across, cell, generate, lattice, translation
from solver.symmetry.sides import SidePlane, SymmetryError
from tests.solver import fundamental_pieces as pieces


def plane(normal, offset: float, kind: str = "mirror") -> SidePlane:
    n = np.asarray(normal, dtype=float) / np.linalg.norm(normal)
    none = np.zeros(0, dtype=int)
    return SidePlane("p", kind, n, offset, offset * n, 0.0, 0.0, 0.0, none, np.zeros(0))


def everything(copy: Isometry) -> bool:
    return True


ROOT = np.sqrt(3.0)
TRIANGLE = [plane((0, 1, 0), 0), plane((1, 0, 0), 1), plane((-ROOT, 1, 0), 0)]


@pytest.mark.parametrize(("planes", "count"), [
    ([plane((1, 0, 0), 2.0)], 2),
    ([plane((1, 0, 0), 1.0), plane((0, 1, 0), 0), plane((0, 0, 1), 3)], 8),
    ([plane((0, 1, 0), 0), plane((-np.sin(0.2 * np.pi), np.cos(0.2 * np.pi), 0), 0)], 10),
    ([plane((1, 0, 0), 1.0, "tangent"), plane((0, 1, 0), 0)], 4),
    ([plane((1, 1, 0), 0), plane((1, -1, 0), 0), plane((0, 1, 1), 0), plane((0, 1, -1), 0)], 24),
])  # fmt: skip
def test_finite_groups_have_their_order(planes, count):
    copies, all_of_them = generate([across(p) for p in planes], 1e-3, everything, 1000)
    assert all_of_them and len(copies) == count
    unit, basis = cell([across(p) for p in planes], 1e-3, 1000)
    assert len(unit) == count and len(basis) == 0


@pytest.mark.parametrize(("planes", "count", "lengths"), [
    ([plane((0, 0, 1), 0), plane((0, 0, 1), 1.5)], 2, [3.0]),
    ([plane((0, 0, 1), 0, "tangent"), plane((0, 0, 1), 1.5, "tangent")], 2, [3.0]),
    ([plane((0, 0, 1), 0), plane((0, 0, 1), 1.5, "tangent")], 4, [6.0]),
    (TRIANGLE, 12, [2 * ROOT, 2 * ROOT]),
    ([*TRIANGLE, plane((0, 0, 1), 0.7)], 24, [2 * ROOT, 2 * ROOT]),
    ([*TRIANGLE, plane((0, 0, 1), 0.7), plane((0, 0, 1), 0.2)], 24, [1.0, 2 * ROOT, 2 * ROOT]),
    ([plane((1, 0, 0), 0), plane((1, 0, 0), 1), plane((0, 1, 0), 0), plane((0, 1, 0), 3)], 4, [2.0, 6.0]),
    ([plane((1, 0, 0), 0), plane((1, 0, 0), 2), plane((1, 0, 0), 3)], 2, [2.0]),
])  # fmt: skip
def test_unit_cells_and_lattices(planes, count, lengths):
    unit, basis = cell([across(p) for p in planes], 1e-3, 1000)
    assert len(unit) == count
    assert_allclose(np.linalg.norm(basis, axis=1), lengths, atol=1e-9)
    # translated, the cell is the group: every copy of a large part of it is one of these
    some, _ = generate([across(p) for p in planes], 1e-3, everything, 200)
    for copy in some:
        same = [u for u in unit if np.allclose(u.linear, copy.linear) and u.sheet == copy.sheet]
        assert len(same) == 1
        times = np.linalg.lstsq(basis.T, copy.translation - same[0].translation, rcond=None)[0]
        assert_allclose(times, np.round(times), atol=1e-6)


def test_a_lattice_is_found_among_its_vectors_whatever_the_noise():
    random = np.random.default_rng(11)
    basis = np.array([[2.0, 0.1, 0.0], [0.4, 3.0, -0.2], [0.0, 0.5, 3.5]])
    times = random.integers(-5, 6, size=(40, 3))
    noisy = times @ basis + 1e-5 * random.normal(size=(40, 3))
    found = lattice(noisy, 1e-2)
    assert_allclose(abs(np.linalg.det(found)), abs(np.linalg.det(basis)), rtol=1e-3)
    assert_allclose(np.round(found @ np.linalg.inv(basis)), found @ np.linalg.inv(basis), atol=1e-3)


def test_copies_without_a_common_measure_are_refused():
    planes = [plane((1, 0, 0), 0), plane((1, 0, 0), 1), plane((1, 0, 0), 1 + np.sqrt(2))]
    with pytest.raises(SymmetryError, match="no common measure"):
        cell([across(p) for p in planes], 1e-3, 1000)
    with pytest.raises(SymmetryError, match="directions"):
        cell([across(plane((0, 1, 0), 0)), across(plane((np.sin(1.0), np.cos(1.0), 0), 0))], 1e-3, 100)


def test_isometries_compose():
    mirror, turn = across(plane((1, 2, 2), 0.3)), across(plane((0, 1, 0), -2, "tangent"))
    points = np.random.default_rng(2).normal(size=(5, 3))
    both = mirror.then(turn)
    assert_allclose(both.points(points), mirror.points(turn.points(points)), atol=1e-12)
    assert (mirror.sheet, turn.sheet, both.sheet) == (1, -1, -1)
    assert mirror.flipped and turn.flipped and not both.flipped
    assert_allclose(mirror.then(mirror).points(points), points, atol=1e-12)
    centre = SidePlane("c", "free", None, np.nan, np.array([1.0, 0, 2]), 0, 0, 0, np.zeros(0, int), np.zeros(0))
    assert_allclose(across(centre).points(points), 2 * centre.point - points, atol=1e-12)
    assert across(centre).sheet == -1 and across(centre).flipped
    assert_allclose(translation((1, 2, 3)).points(points), points + [1, 2, 3])


@pytest.fixture(scope="module")
def eighth():
    return pieces.sphere_eighth(12)


@pytest.fixture(scope="module")
def tube():
    return pieces.unduloid(-0.5, 16)


def tilted(side: Side, degrees: float) -> Side:
    a, c = np.radians(degrees), np.asarray(side.normal, dtype=float)
    return Side(side.name, side.edges, side.kind, np.cos(a) * c + np.sin(a) * np.roll(c, 1))


def test_mirrors_whose_angle_never_closes_are_named(eighth):
    left, front, floor = eighth.sides
    with pytest.raises(SymmetryError, match=r"'left' and 'front' meet at vertex 0.*86\.\d+°.*180°/k") as caught:
        complete(eighth.surface, [tilted(left, 4.0), front, floor])
    assert caught.value.vertices == (0,)


def test_a_side_is_what_it_is_said_to_be(eighth, tube):
    left = eighth.sides[0]
    with pytest.raises(SymmetryError, match="not orthogonal to its plane along side 'left'"):
        side_plane(eighth.surface, Side("left", left.edges, "mirror", (0, 0, 1)))
    nodoid = pieces.nodoid(0.5, 16)
    with pytest.raises(SymmetryError, match=r"'end' do not define the plane of a mirror side; give its normal"):
        side_plane(nodoid.surface, Side("end", nodoid.sides[0].edges, "mirror"))
    with pytest.raises(SymmetryError, match="not tangent to its plane along side 'left'"):
        side_plane(eighth.surface, Side("left", left.edges, "tangent", (0, 1, 0)))
    with pytest.raises(SymmetryError, match=r"Side 'top' does not lie in a plane or at a point"):
        complete(tube.surface, [Side("top", tube.sides[1].edges, "free")])
    with pytest.raises(SymmetryError, match="three numbers"):
        side_plane(eighth.surface, Side("left", left.edges, "mirror", (0, 0, 0)))
    with pytest.raises(ConditionError, match='kind of side "wall"'):
        side_plane(eighth.surface, Side("left", left.edges, "wall"))
    with pytest.raises(SymmetryError, match="no edges"):
        side_plane(eighth.surface, Side("left", []))


def test_the_normal_is_read_off_the_surface(eighth):
    for side in eighth.sides:
        given, found = side_plane(eighth.surface, side), side_plane(eighth.surface, Side("s", side.edges))
        assert_allclose(np.abs(found.normal @ given.normal), 1.0, atol=2e-3)
        assert_allclose(found.offset * np.sign(found.normal @ given.normal), given.offset, atol=0.02)


def test_sides_that_contradict_each_other_are_named(eighth):
    left, front, floor = eighth.sides
    domain, points = eighth.surface.domain, eighth.points
    with pytest.raises(SymmetryError, match="'left' and 'again' both have"):
        complete(eighth.surface, [left, Side("again", left.edges, normal=(1, 0, 0))])
    with pytest.raises(SymmetryError, match="Two sides are called 'left'"):
        complete(eighth.surface, [left, Side("left", front.edges)])
    with pytest.raises(SymmetryError, match="no side 'roof'"):
        complete(eighth.surface, [left, front], coplanar=[("left", "roof")])
    with pytest.raises(SymmetryError, match="'left' and 'front' cannot lie in one plane"):
        complete(eighth.surface, [left, front, floor], coplanar=[("left", "front")])
    two = conditions.fixed(domain, left.edges, (1, 0, 0)) + conditions.fixed(domain, front.edges, (0, 1, 0))
    touching = solve_cmc(domain, two)
    with pytest.raises(SymmetryError, match=r"'left' and 'front'.*cannot touch two planes"):
        complete(touching, [Side("left", left.edges, "tangent"), Side("front", front.edges, "tangent")])
    leaning = conditions.mirror(domain, left.edges, (1, 0, 0)) + conditions.fixed(domain, front.edges, (0.05, 1, 0))
    surface = solve_cmc(domain, leaning, initial=np.tile([0.0, 0.5, 1.0], (len(points), 1)))
    with pytest.raises(SymmetryError, match=r"'left' and 'front'.*must be at 90°"):
        complete(surface, [left, Side("front", front.edges, "tangent")])


def test_parallel_mirrors_meant_as_one_plane_give_an_offset_not_a_torn_mesh(tube):
    """Bottom and top of a tube: half a period apart, a translation; forced into one plane, it is reported."""
    apart = complete(tube.surface, tube.sides)
    assert apart.offsets == [] and len(apart.lattice) == 1
    forced = complete(tube.surface, tube.sides, coplanar=[("bottom", "top")])
    (offset,) = forced.offsets
    assert set(offset.sides) == {"bottom", "top"}
    assert_allclose(offset.distance, pieces.unduloid_period(-0.5) / 2, rtol=0.05)
    assert len(forced.copies) == 2 and forced.is_whole
    mesh = forced.mesh
    assert mesh.is_closed and mesh.is_oriented  # a torus, topologically
    assert max(gap.largest for gap in mesh.gaps) > 0.9 * offset.distance


def test_choices_that_lead_nowhere_are_refused(tube):
    surface, sides = tube.surface, tube.sides
    for wrong, message in {
        "sheet": (dict(sheet="g"), "choose f"),
        "box": (dict(box=[(50, 50, 50), (60, 60, 60)]), "No copy has its centre"),
        "shape": (dict(box=[(0, 0, 0), (0, 1, 1)]), "lowest and its highest"),
        "crowded": (dict(box=[(-9, -9, -99), (9, 9, 99)], copies=5), "more than 5 copies"),
        "count": (dict(copies=0), "number of copies"),
        "around": (dict(around=[("bottom", "top")]), "have no end"),
        "name": (dict(around=[("bottom", "side")]), "no side 'side'"),
        "times": (dict(repeat=(2, 2)), "1 translations"),
        "vector": (dict(translations=[(0, 0, 0)]), "none of them zero"),
        "narrow": (dict(tolerance=0), "tolerance must be"),
        "blurred": (dict(tolerance=np.nan), "tolerance must be"),
        "letters": (dict(around=["top"]), "lists of names"),
        "word": (dict(coplanar=["top"]), "lists of names"),
        "plane vector": (dict(translations=[1, 2]), "vectors"),
        "written": (dict(box="all"), "numbers in a regular array"),
        "both": (dict(around=[("top",)], box=[(-1, -1, -1), (1, 1, 1)]), "exclude each other"),
    }.values():
        with pytest.raises(SymmetryError, match=message):
            complete(surface, sides, **wrong)
    with pytest.raises(SymmetryError, match="no sides to continue across"):
        complete(surface)
    with pytest.raises(SymmetryError, match="no translation"):
        complete(surface, sides[:1], repeat=3)
    assert issubclass(SymmetryError, CmcError)


def test_a_side_that_a_cut_divides_is_refused():
    """Four mirrors around a hole along which the normals lean to one side: the period is across one of them."""
    angle = np.linspace(0, 2 * np.pi, 24, endpoint=False)
    hole = np.column_stack([1 + 0.4 * np.cos(angle), 1 + 0.4 * np.sin(angle)])
    plan = shapes.polygon([(0, 0), (2, 0), (2, 2), (0, 2)], holes=[hole], max_edge=0.2)
    domain, sides, held = plan.domain, [], conditions.Conditions()
    for k, normal in enumerate([(0, -1, 0), (1, 0, 0), (0, 1, 0), (-1, 0, 0)]):
        sides.append(Side(f"side{k}", plan.sides[f"side{k}"], normal=normal))
        held += conditions.mirror(domain, sides[-1].edges, normal)
    ring = np.concatenate([edges for name, edges in plan.sides.items() if name.startswith("hole")])
    x = plan.positions[domain.edges[ring]].mean(axis=1)[:, 0] - 1.0
    surface = solve_cmc(domain, held + conditions.binormal(domain, plan.positions, ring, tilt=0.2 + 1.2 * x))
    assert surface.is_open
    parts = [len(set(surface.source[side_plane(surface, side).cut_vertices])) for side in sides]
    divided = [s for s, n in zip(sides, parts, strict=True) if n < len(side_plane(surface, s).cut_vertices)]
    assert len(divided) == 1
    with pytest.raises(SymmetryError, match=f"'{divided[0].name}' lies in two planes.*close the period"):
        complete(surface, sides, copies=4)
    rest = [side for side in sides if side is not divided[0]]
    mesh = complete(surface, rest, copies=6).mesh
    assert mesh.is_oriented and mesh.largest_gap < 1e-6


def test_points_have_no_copies(eighth):
    """Constant normals fulfil the conditions of mirrors and free sides; of a sphere f- is its centre."""
    domain, (left, _, floor) = eighth.surface.domain, eighth.sides
    nothing = solve_cmc(domain, conditions.fixed(domain, floor.edges, (0, 1, 0)))
    for side in (Side("left", left.edges, normal=(1, 0, 0)), Side("left", left.edges, "free")):
        with pytest.raises(SymmetryError, match="surface is a point"):
            side_plane(nothing, side)
    with pytest.raises(SymmetryError, match="Sheet f- of this surface is a point"):
        complete(eighth.surface, eighth.sides, sheet="f-")
    with pytest.raises(SymmetryError, match="normal of side 'left' must be numbers"):
        side_plane(eighth.surface, Side("left", left.edges, normal="x"))  # pyright: ignore[reportArgumentType]


def test_a_domain_and_its_mirror_image():
    shape = shapes.strip(2.0, 1.0, 8)
    domain = shape.domain
    both = doubled(domain, shape.sides["right"])
    assert both.euler_characteristic == 1 and len(both.faces) == 2 * len(domain.faces)
    assert both.vertex_count == 2 * domain.vertex_count - len(shape.sides["right"]) - 1
    assert_allclose(both.area, 2 * domain.area)
    assert_allclose(both.edge_lengths[: len(domain.edge_lengths)], domain.edge_lengths)
    ring = glued_domain(domain, [False, True], [(0, 1, shape.sides["right"]), (1, 0, shape.sides["left"])])
    assert ring.euler_characteristic == 0 and len(ring.boundary_loops) == 2
    u = np.random.default_rng(1).normal(size=both.vertex_count)
    assert_allclose(both.laplacian @ np.ones_like(u), 0.0, atol=1e-12)


def test_pieces_too_coarse_to_be_glued_are_refused():
    """An edge inside that joins two vertices of one side would be two edges between them, and four faces."""
    faces = np.array([[0, 1, 2], [0, 2, 3]])
    domain = Domain.from_positions(np.array([[0.0, 0], [2, 0], [2, 2], [0, 2]]), faces)
    glued = glue(faces, 4, [False, True], [(0, row, 1, row) for row in (0, 1, 2)])
    with pytest.raises(MeshError, match=r"faces 0, 1 of the piece.*subdivide"):
        check_glued(glued)
    assert len(domain.faces) == 2
    along_one_edge = glue(faces, 4, [False, True], [(0, row, 1, row) for row in (0, 1)])
    check_glued(along_one_edge)
    assert along_one_edge.vertex_count == 6
    assert_allclose(along_one_edge.mean(np.arange(8.0).reshape(2, 4, 1))[:, 0], [2, 3, 2, 3, 6, 7])
