"""Mirrors: admissible normals, corners where conditions meet, and minimisation under the constraint."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from solver import ConditionError, Domain, HarmonicSolver, Status, conditions, shapes, solve_cmc
from solver.domain.sites import SITES, SiteGraph
from solver.gauss import sphere
from solver.gauss.admissible import resolved
from solver.gauss.conditions import build
from solver.gauss.dirichlet import Dirichlet
from solver.gauss.energies import ENERGIES
from solver.gauss.methods import METHODS
from solver.gauss.mirror_start import side_normals
from solver.gauss.newton import newton
from solver.gauss.problem import EnergyProblem
from tests.solver.mirror_images import doubled, doubled_graph, half_disc, jittered_strip, reflect

SITES_AND_ENERGIES = [(sites, name) for name, energy in ENERGIES.items() for sites in energy.sites]
E_X, E_Y, E_Z = np.eye(3)


def half_dome(domain, points, arc, flat, tilt=0.2):
    plan = np.column_stack([points, np.zeros(len(points))])
    return conditions.binormal(domain, plan, arc, tilt=tilt) + conditions.mirror(domain, flat, -E_Y)


@pytest.fixture
def strip():
    return shapes.strip(2.0, 1.0, 8)


def mirrors(shape, **normals):
    total = conditions.Conditions()
    for side, normal in normals.items():
        total = total + conditions.mirror(shape.domain, shape.sides[side], normal)
    return total


# --- minimisation within the constraint --------------------------------------------------------


@pytest.mark.parametrize(("sites", "name"), SITES_AND_ENERGIES)
def test_gradient_and_hessian_against_finite_differences(sites, name):
    """E along exp_N in a direction that the mirrors allow: <PG, d> and <d, Hd>."""
    domain, points, arc, flat = half_disc(200)
    solver = HarmonicSolver(domain, sites=sites, energy=name)
    held = resolved(half_dome(domain, points, arc, flat), solver.graph)
    problem = EnergyProblem(solver.graph, solver.energy, solver.dirichlet(held.fixed), mirrors=held.mirrors)
    random = np.random.default_rng(5)
    N = held.pin(sphere.normalize(0.3 * random.normal(size=(solver.graph.count, 3)) + [0.2, 0.1, 1.0]))
    d = problem.project(N, random.normal(size=N.shape))
    assert len(held.mirrors.sites) > 5
    assert_allclose(N[held.mirrors.sites] @ E_Y, 0, rtol=0, atol=1e-15)
    assert_allclose(d[held.mirrors.sites] @ E_Y, 0, rtol=0, atol=1e-15)
    assert_allclose(sphere.dot(N, d), 0, rtol=0, atol=1e-14)
    here = problem.at(N)
    h = 1e-4
    there, back = (problem.at(sphere.exp(N, t * d)) for t in (h, -h))
    assert_allclose((there.energy - back.energy) / (2 * h), sphere.inner(here.tangent, d), rtol=1e-6, atol=0)
    curvature = (there.energy - 2 * here.energy + back.energy) / h**2
    assert_allclose(curvature, sphere.inner(d, problem.hessian(here)(d)), rtol=1e-5, atol=0)


@pytest.mark.parametrize(("sites", "name"), SITES_AND_ENERGIES)
def test_minimisation_is_that_on_the_doubled_graph(sites, name):
    """The graph and its image, glued at the sites on the mirror, all of them free there; from a start that has lost
    the symmetry."""
    domain, points, arc, flat = half_disc(130)
    solver = HarmonicSolver(domain, sites=sites, energy=name)
    condition = half_dome(domain, points, arc, flat)
    result = solver.solve(condition, tolerance=1e-10)
    held = result.admissible
    whole, image = doubled_graph(solver.graph, held.mirrors.sites)
    start = np.empty((whole.count, 3))
    start[image] = reflect(result.normals, E_Y)
    start[: solver.graph.count] = result.normals
    fixed = np.union1d(held.fixed, image[held.fixed])
    noise = 0.05 * np.random.default_rng(1).normal(size=start.shape)
    noise[fixed] = 0.0
    weights = np.abs(solver.energy.star(np.ones(len(whole.links)), whole))
    problem = EnergyProblem(whole, solver.energy, Dirichlet(whole, weights, fixed))
    twice = newton(problem, sphere.normalize(start + noise), tolerance=1e-10)
    assert twice.status is Status.CONVERGED
    assert_allclose(twice.N, start, rtol=0, atol=1e-7)
    assert_allclose(twice.history[-1].energy, 2 * result.energy, rtol=1e-12, atol=0)


def test_a_half_is_half_of_the_whole_disc():
    """With outward conormals: a tilted normal at the end of the mirror blends a little differently."""
    domain, points, arc, flat = half_disc(700)
    disc = shapes.disc(700)
    half = HarmonicSolver(domain).solve(half_dome(domain, points, arc, flat, tilt=0.0), tolerance=1e-10)
    rim = conditions.binormal(disc.domain, disc.positions, disc.domain.boundary_edges)
    whole = HarmonicSolver(disc.domain).solve(rim, tolerance=1e-10)
    places = {tuple(p): i for i, p in enumerate(np.round(disc.positions, 9))}
    same = [places[tuple(p)] for p in np.round(points, 9)]
    assert_allclose(half.normals, whole.normals[same], rtol=0, atol=1e-7)
    assert_allclose(half.energy, 0.5 * whole.energy, rtol=1e-10, atol=0)


@pytest.mark.parametrize("tilt", [0.3, -0.6])
def test_a_quarter_is_a_quarter_of_the_whole_plan(tilt):
    """Two mirrors that meet at the centre; with rims that lean out, too, where the way along them is the longer one."""
    shape, points = jittered_strip(2.0, 1.4, 9)
    right_top = np.concatenate([shape.sides["right"], shape.sides["top"]])
    quarter = conditions.binormal(shape.domain, points, right_top, tilt=tilt) + mirrors(shape, left=-E_X, bottom=-E_Y)
    result = HarmonicSolver(shape.domain).solve(quarter, tolerance=1e-10)
    assert_array_equal(result.admissible.corners, [0])
    assert_allclose(result.admissible.corner_normals, [E_Z], rtol=0, atol=1e-15)
    vertices, faces = doubled(*doubled(points, shape.domain.faces, 0), 1)
    plan = Domain.from_positions(vertices, faces)
    rim = conditions.binormal(plan, vertices, plan.boundary_edges, tilt=tilt)
    whole = HarmonicSolver(plan).solve(rim, tolerance=1e-10)
    assert_allclose(result.normals, whole.normals[: len(points)], rtol=0, atol=1e-7)
    assert_allclose(4 * result.energy, whole.energy, rtol=1e-10, atol=0)


@pytest.mark.parametrize("sites", SITES)
@pytest.mark.parametrize("method", METHODS)
def test_every_method_finds_the_same(sites, method):
    domain, points, arc, flat = half_disc(60)
    solver = HarmonicSolver(domain, sites=sites, energy="cotan" if sites == "vertices" else "mobius")
    condition = half_dome(domain, points, arc, flat)
    expected = solver.solve(condition, tolerance=1e-9)
    result = solver.solve(condition, method=method, tolerance=1e-7)
    assert result.status is Status.CONVERGED
    assert_allclose(result.normals, expected.normals, rtol=0, atol=1e-6)
    at = result.admissible.mirrors.sites
    assert_allclose(result.normals[at] @ E_Y, 0, rtol=0, atol=1e-14)


def quad_grid(count, corners):
    """The unit square in count² squares, each of two triangles: positions (V, 2) and domain."""
    x, y = (a.ravel() for a in np.meshgrid(np.arange(count + 1), np.arange(count + 1), indexing="ij"))
    first = ((count + 1) * x + y)[(x < count) & (y < count)]
    quads = np.column_stack([first, first + count + 1, first + count + 2, first + 1])
    points = np.column_stack([x, y]) / count
    return points, Domain.from_positions(points, np.concatenate([quads[:, c] for c in corners]))


def grid_dome(points, domain, tilt=0.4):
    """Mirrors along x = 0 and y = 0, a leaning rim elsewhere."""
    middle = points[domain.edges[domain.boundary_edges]].mean(axis=1)
    left, bottom = (domain.boundary_edges[middle[:, k] == 0] for k in (0, 1))
    plan = np.column_stack([points, np.zeros(len(points))])
    outer = domain.boundary_edges[(middle > 0).all(axis=1)]
    sides = conditions.mirror(domain, left, -E_X) + conditions.mirror(domain, bottom, -E_Y)
    return conditions.binormal(domain, plan, outer, tilt=tilt) + sides


@pytest.mark.parametrize("sites", ["faces", "faces_and_rim"])
def test_gauss_seidel_turns_the_halves_of_rectangles_within_their_mirrors(sites):
    points, domain = quad_grid(5, [[0, 1, 2], [0, 2, 3]])
    solver = HarmonicSolver(domain, sites=sites, energy="mobius")
    condition = grid_dome(points, domain)
    slow = solver.solve(condition, method="gauss_seidel", tolerance=1e-5, max_iterations=300)
    fast = solver.solve(condition, tolerance=1e-5)
    assert slow.status is Status.CONVERGED
    assert_allclose(slow.normals, fast.normals, rtol=0, atol=1e-4)
    at, planes = slow.admissible.mirrors.sites, slow.admissible.mirrors.normals
    assert_allclose(sphere.dot(slow.normals[at], planes), 0, rtol=0, atol=1e-14)


@pytest.mark.parametrize("sites", ["faces", "faces_and_rim"])
def test_ears_between_two_mirrors_lie_in_both(sites):
    """A face whose tip is the corner; the halves of squares share a normal, so all of a square does there."""
    points, domain = quad_grid(5, [[0, 1, 3], [1, 2, 3]])
    surface = solve_cmc(domain, grid_dome(points, domain), sites=sites, energy="mobius", tolerance=1e-8)
    assert surface.status is Status.CONVERGED
    if sites == "faces":
        ear = int(np.flatnonzero((domain.faces == 0).any(axis=1))[0])
        assert_array_equal(surface.harmonic.admissible.corners, [ear])
        assert_allclose(surface.harmonic.normals[ear], E_Z, rtol=0, atol=0)
    for axis, normal in ((0, E_X), (1, E_Y)):
        on = points[:, axis] == 0
        assert_allclose(np.ptp(surface.f_plus[on] @ normal), 0, rtol=0, atol=1e-7)
        assert_allclose(surface.normals[on] @ normal, 0, rtol=0, atol=1e-13)


@pytest.mark.parametrize("sites", SITES)
def test_a_rotation_of_space_rotates_the_map(sites):
    """Mirrors alone: honeycomb module; planes and signs turn with it."""
    shape, _ = jittered_strip(2.0, 1.0, 9)
    turn = np.linalg.qr(np.random.default_rng(2).normal(size=(3, 3)))[0]
    turn *= np.sign(np.linalg.det(turn))
    bisector = np.array([-np.sin(np.pi / 3), np.cos(np.pi / 3), 0.0])
    planes = {"bottom": -E_Y, "right": E_X, "top": -E_Z, "left": bisector}
    solver = HarmonicSolver(shape.domain, sites=sites)
    one = solver.solve(mirrors(shape, **planes), tolerance=1e-9)
    other = solver.solve(mirrors(shape, **{side: turn @ n for side, n in planes.items()}), tolerance=1e-9)
    assert_allclose(other.normals, one.normals @ turn.T, rtol=0, atol=1e-7)
    assert_allclose(other.energy, one.energy, rtol=1e-12, atol=0)


# --- which normals are allowed --------------------------------------------------------------


def test_degrees_of_freedom(strip):
    """Two on free sites, one on a mirror, none where it meets another or where a normal is fixed."""
    held = resolved(
        mirrors(strip, left=E_X, bottom=E_Y) + conditions.fixed(strip.domain, strip.sides["right"], E_X),
        SiteGraph.of(strip.domain, "vertices"),
    )
    on = {side: np.unique(strip.domain.edges[edges]) for side, edges in strip.sides.items()}
    assert_array_equal(held.corners, [0])
    assert_array_equal(held.fixed, np.union1d([0], on["right"]))
    assert_array_equal(held.mirrors.sites, np.setdiff1d(np.union1d(on["left"], on["bottom"]), held.fixed))
    assert_allclose(held.mirrors.flatten(np.ones((strip.domain.vertex_count, 3)))[on["left"][1:]], [[0, 1, 1]] * 4)


def test_one_plane_given_twice_is_one_mirror(strip):
    twice = mirrors(strip, left=E_X, bottom=E_Y) + mirrors(strip, left=-E_X)
    graph = SiteGraph.of(strip.domain, "vertices")
    one, other = resolved(twice, graph), resolved(mirrors(strip, left=E_X, bottom=E_Y), graph)
    assert_array_equal(one.fixed, other.fixed)
    assert_array_equal(one.mirrors.sites, other.mirrors.sites)
    assert not len(resolved(mirrors(strip, left=E_X, bottom=-E_X), graph).corners)


def test_fixed_goes_before_mirror_before_free(strip):
    graph = SiteGraph.of(strip.domain, "vertices")
    mirror = mirrors(strip, left=E_X)
    top_left = int(np.intersect1d(*(strip.domain.edges[strip.sides[side]] for side in ("top", "left")))[0])
    tangent = resolved(conditions.fixed(strip.domain, strip.sides["top"], E_X) + mirror, graph)
    assert_allclose(tangent.data[tangent.fixed == top_left], [E_X], rtol=0, atol=0)
    leaning = resolved(conditions.fixed(strip.domain, strip.sides["top"], [0.2, 1, 1]) + mirror, graph)
    assert_allclose(leaning.data[leaning.fixed == top_left], [[0, 0.5**0.5, 0.5**0.5]], rtol=0, atol=1e-15)
    exact = resolved(conditions.fixed_at(strip.domain, [top_left], [0.6, 0.8, 0]) + mirror, graph)
    assert_allclose(exact.data, [[0.6, 0.8, 0]], rtol=0, atol=1e-15)
    both = resolved(conditions.fixed(strip.domain, strip.sides["left"], E_X) + mirror, graph)
    assert len(both.fixed) == 5 and not len(both.mirrors.sites) and not len(both.sides.edges)
    free = resolved(mirror + conditions.free(strip.domain, strip.sides["outer"]), graph)
    assert len(free.mirrors.sites) == 5 and not len(free.fixed)


def test_signs_of_corners_follow_outward_normals_a_start_or_the_caller(strip):
    solver = HarmonicSolver(strip.domain)
    planes = {"left": -E_X, "bottom": -E_Y, "right": [1, 0, -1]}
    across = sphere.normalize(np.cross(-E_Y, [1, 0, -1])[None])[0]

    def corners(condition, **keywords):
        result = solver.solve(condition, **keywords)
        assert_array_equal(result.admissible.corners, [0, 8])
        assert_allclose(result.normals[[0, 8]], result.admissible.corner_normals, rtol=0, atol=0)
        return result

    result = corners(mirrors(strip, **planes))
    assert_allclose(result.normals[[0, 8]], [E_Z, across], rtol=0, atol=1e-15)
    assert_allclose(corners(mirrors(strip, **planes), side=-1).normals[[0, 8]], [-E_Z, -across], rtol=0, atol=1e-15)
    inwards = corners(mirrors(strip, **planes | {"left": E_X}))
    assert_allclose(inwards.normals[[0, 8]], [-E_Z, across], rtol=0, atol=1e-15)
    started = corners(mirrors(strip, **planes | {"left": E_X}), initial=result.normals)
    assert_allclose(started.normals, result.normals, rtol=0, atol=1e-6)
    chosen = mirrors(strip, **planes) + conditions.corner(strip.domain, [0], [0.1, 0, -1])
    for keywords in ({}, {"side": 1}, {"initial": result.normals}):
        assert_allclose(corners(chosen, **keywords).normals[0], -E_Z, rtol=0, atol=1e-15)


@pytest.mark.parametrize("sites", SITES)
def test_over_a_plan_corner_normals_point_to_its_upper_side(sites):
    """Whichever way the normals of the mirrors point."""
    points, domain = quad_grid(4, [[0, 1, 3], [1, 2, 3]])
    middle = points[domain.edges[domain.boundary_edges]].mean(axis=1)
    left, bottom = (domain.boundary_edges[middle[:, k] == 0] for k in (0, 1))
    outer = domain.boundary_edges[(middle > 0).all(axis=1)]
    rim = conditions.binormal(domain, np.column_stack([points, 0 * points[:, 0]]), outer)
    solver = HarmonicSolver(domain, sites=sites)
    for sign in (1, -1):
        given = rim + conditions.mirror(domain, left, sign * E_X) + conditions.mirror(domain, bottom, E_Y)
        for side in (1, -1):
            result = solver.solve(given, side=side)
            assert (side * result.normals[:, 2] > -1e-9).all()
            assert_allclose(result.admissible.sides.corner_normals, [side * E_Z], rtol=0, atol=1e-15)


def test_around_a_reflex_corner_the_normal_is_on_the_same_side():
    plan = shapes.polygon([(0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2)], max_edge=0.3)
    reflex = int(np.flatnonzero((plan.positions == [1, 1]).all(axis=1))[0])
    sides = plan.sides["side2"], plan.sides["side3"]
    held = resolved(
        conditions.mirror(plan.domain, sides[0], E_Y) + conditions.mirror(plan.domain, sides[1], E_X),
        SiteGraph.of(plan.domain, "vertices"),
    )
    assert_array_equal(held.corners, [reflex])
    assert_allclose(held.corner_normals, [E_Z], rtol=0, atol=1e-15)


def test_windings_choose_the_way_around(strip):
    """Between two ends 120° apart: the short way, the long way, and the long way in the other sense."""
    end = np.array([np.cos(2 * np.pi / 3), np.sin(2 * np.pi / 3), 0.0])
    ends = conditions.fixed(strip.domain, strip.sides["left"], E_X)
    ends = ends + conditions.fixed(strip.domain, strip.sides["right"], end)
    along = strip.domain.edges[strip.sides["bottom"]][:, 0][1:]
    for winding, degrees in [(0, 120), (1, 480), (-1, -240)]:
        side = conditions.mirror(strip.domain, strip.sides["bottom"], E_Z, winding)
        result = HarmonicSolver(strip.domain).solve(ends + side, max_iterations=0)
        angles = np.radians(degrees) * strip.positions[along, 0] / 2.0
        expected = np.column_stack([np.cos(angles), np.sin(angles), 0 * angles])
        assert_allclose(result.normals[along], expected, rtol=0, atol=1e-12)


def test_a_winding_starts_at_the_one_end_that_is_known_or_anywhere(strip):
    along = strip.domain.edges[strip.sides["bottom"]][:, 0][1:]
    side = conditions.mirror(strip.domain, strip.sides["bottom"], E_Z, 1)
    angles = np.pi * strip.positions[along, 0]
    turning = np.column_stack([np.cos(angles), np.sin(angles), 0 * angles])
    for end in ("left", "right"):
        held = side + conditions.fixed(strip.domain, strip.sides[end], E_X)
        result = HarmonicSolver(strip.domain).solve(held, max_iterations=0)
        assert_allclose(result.normals[along], turning, rtol=0, atol=1e-12)
    alone = HarmonicSolver(strip.domain).solve(side, max_iterations=0).normals[along]
    assert_allclose(alone @ alone.T, turning @ turning.T, rtol=0, atol=1e-12)


def test_opposite_ends_are_joined_over_the_pole():
    domain, points, arc, flat = half_disc(100)
    plan = np.column_stack([points, np.zeros(len(points))])
    for tilt, normal in [(0.0, -E_Y), (0.0, E_Y), (-0.3, E_Y)]:
        condition = conditions.binormal(domain, plan, arc, tilt=tilt) + conditions.mirror(domain, flat, normal)
        for side in (1, -1):
            result = HarmonicSolver(domain).solve(condition, side=side)
            top = int(np.argmin(np.linalg.norm(points, axis=1)))
            assert_allclose(result.normals[top], side * E_Z, rtol=0, atol=1e-3)


def test_mirrors_alone_with_one_direction_collapse(strip):
    result = solve_cmc(strip.domain, mirrors(strip, left=E_X, bottom=E_Y))
    assert result.harmonic.status is Status.COLLAPSED


def test_mirrors_are_carried_to_the_delaunay_triangulation():
    shape, points = jittered_strip(2.0, 1.0, 9)
    stretched = Domain.from_positions(points * [1.0, 2.5], shape.domain.faces)
    condition = conditions.mirror(stretched, shape.sides["bottom"], -E_Y)
    plan = np.column_stack([points * [1.0, 2.5], 0 * points[:, 0]])
    others = np.concatenate([shape.sides[side] for side in ("right", "top", "left")])
    condition = condition + conditions.binormal(stretched, plan, others, tilt=0.4)
    result = solve_cmc(stretched, condition, delaunay=True, tolerance=1e-10)
    rows = np.unique(stretched.edges[shape.sides["bottom"]])
    assert result.status is Status.CONVERGED
    assert_allclose(np.ptp(result.f_plus[rows] @ E_Y), 0, rtol=0, atol=1e-9)


def test_mirrors_go_with_their_edges_to_another_triangulation(strip):
    edges = np.full(len(strip.domain.edges), -1)
    edges[strip.domain.boundary_edges] = strip.domain.boundary_edges[::-1]
    carried = mirrors(strip, left=E_X).carried(edges)
    assert_array_equal(carried.mirrors, edges[strip.sides["left"]])
    assert_allclose(carried.mirror_normals, np.tile(E_X, (4, 1)), rtol=0, atol=0)


# --- errors -----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda s: mirrors(s, left=E_X), "no two in different planes meet"),
        (lambda s: mirrors(s, left=E_X, right=E_Y), "no two in different planes meet"),
        (lambda s: mirrors(s, left=E_X) + mirrors(s, left=E_Y), r"different planes hold edges"),
        (lambda s: mirrors(s, left=[0, 0, 0]), "zero or not finite"),
        (lambda s: mirrors(s, left=[E_X, E_Y]), r"one vector \(3,\)"),
        (lambda s: conditions.mirror(s.domain, s.sides["left"], E_X, winding=0.5), "whole number of turns"),
        (lambda s: conditions.mirror(s.domain, s.sides["left"], E_X, winding=np.nan), "whole number of turns"),
        (lambda s: conditions.mirror(s.domain, [2], E_X), "not on the boundary"),
        (lambda s: mirrors(s, left=E_X) + conditions.corner(s.domain, [0], E_Z), "vertex 0, where no two mirrors"),
        (lambda s: mirrors(s, left=E_X, bottom=E_Y) + conditions.corner(s.domain, [0], E_X), "vertex 0, where it is"),
        (lambda s: conditions.corner(s.domain, [999], E_X), "no vertex 999"),
        (
            lambda s: (
                conditions.mirror(s.domain, s.sides["left"][:2], E_X, 1)
                + conditions.mirror(s.domain, s.sides["left"][2:], E_X)
            ),
            "has the windings 0, 1",
        ),
    ],
)
def test_contradictions_are_refused(strip, make, message):
    with pytest.raises(ConditionError, match=message):
        HarmonicSolver(strip.domain).solve(make(strip))


def test_three_mirrors_at_a_face_are_refused():
    triangle = Domain.from_positions([(0, 0), (1, 0), (0, 1)], [(0, 1, 2)])
    total = conditions.Conditions()
    for pair, normal in zip([(0, 1), (1, 2), (2, 0)], np.eye(3), strict=True):
        total = total + conditions.mirror(triangle, [pair], normal)
    with pytest.raises(ConditionError, match="Three mirrors meet at face 0") as error:
        HarmonicSolver(triangle, sites="faces").solve(total)
    assert error.value.faces == (0,)


def test_mirrors_of_another_domain_are_refused(strip):
    other = shapes.strip(1.0, 1.0, 3)
    with pytest.raises(ConditionError, match="not on the boundary of this domain"):
        HarmonicSolver(other.domain).solve(mirrors(strip, left=E_X, top=E_Y))


def test_the_registry_builds_mirrors(strip):
    made = build("mirror", strip.domain, strip.positions, strip.sides["left"], normal=(2.0, 0.0, 0.0), winding=1.0)
    assert_allclose(made.mirror_normals, np.tile(E_X, (4, 1)), rtol=0, atol=0)
    assert_array_equal(made.windings, [1, 1, 1, 1])
    with pytest.raises(ConditionError, match="no parameter tilt"):
        build("mirror", strip.domain, strip.positions, strip.sides["left"], tilt=0.1)


def test_a_start_along_a_mirror_takes_the_long_way_only_to_be_on_the_right_side(strip):
    """With data that lean away, ends 90° apart turn the short way if the middle is level, the long way if below."""
    side = replace(mirrors(strip, bottom=E_X), up=E_Z)
    graph = SiteGraph.of(strip.domain, "vertices")
    middle = int(np.argmin(np.linalg.norm(strip.positions - [1.0, 0.0], axis=1)))
    for lean, expected in ((0.0, E_Y), (np.radians(20), -np.cos(np.radians(20)) * E_Y + np.sin(np.radians(20)) * E_Z)):
        held = side
        for name, angle in (("left", np.pi / 4 - lean), ("right", -np.pi / 4 - lean)):
            normal = [0.0, np.cos(angle), np.sin(angle)]
            held = held + conditions.fixed(strip.domain, strip.sides[name], normal)
        at, normals = side_normals(resolved(held, graph), held, graph, 1, leans=True)
        assert_allclose(normals[np.searchsorted(at, middle)], expected, rtol=0, atol=1e-12)
