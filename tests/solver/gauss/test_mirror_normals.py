"""Admissible normals at mirrors: corners where conditions meet, windings, contradictions."""

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
from solver.gauss.mirror_start import side_normals
from tests.solver.mirror_images import half_disc, jittered_strip
from tests.solver.mirror_sides import E_X, E_Y, E_Z, mirrors, quad_grid


@pytest.fixture
def strip():
    return shapes.strip(2.0, 1.0, 8)


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
        (lambda s: conditions.mirror(s.domain, s.sides["left"], E_X, winding=np.nan), "winding must be a number"),
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
