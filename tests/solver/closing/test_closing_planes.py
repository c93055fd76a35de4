"""Sides along mirrors brought into one plane: their distance is a period, and closed like one."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from solver import CmcSolver, ConditionError, Side, close_periods, conditions, shapes, side_plane
from solver.closing.close import ClosingStatus
from solver.closing.closing_conditions import ClosingConditions
from solver.closing.closing_map import ClosingMap
from solver.closing.holes import hole
from solver.closing.moduli import tube
from solver.gauss.sphere import exp
from tests.solver.closing_plans import half_tube, ring


def sides_of(plan):
    return [[plan.left, plan.right]]


def length_of(plan, **stretch):
    return tube(plan.domain, plan.corners, plan.tube, (1, 0), **stretch)


def apart(surface, plan):
    planes = [side_plane(surface, side) for side in (plan.left, plan.right)]
    return planes[1].offset - planes[0].offset


@pytest.mark.parametrize("columns", [8, 16, 32])
def test_two_sides_on_one_mirror_close_by_the_length_of_a_tube(columns):
    """A tenth of the size apart; then in one plane, where the stretch that took them apart is undone."""
    plan = half_tube(columns)
    before = CmcSolver(plan.domain).solve(plan.held)
    size = np.linalg.norm(np.ptp(before.f_plus, axis=0))
    assert 0.09 < abs(apart(before, plan)) / size < 0.12
    closing = close_periods(plan.domain, plan.held, by="moduli", moduli=length_of(plan), coplanar=sides_of(plan))
    assert closing.closed and len(closing.gaps) <= 6 and 0.09 < closing.gaps[0] < 0.12
    assert list(closing.left) == ["'left' to 'right'"] and closing.left["'left' to 'right'"] < 1e-9
    assert_allclose(np.exp(closing.moduli), 1 / 1.35, rtol=1e-8)
    assert abs(apart(closing.surface, plan)) < 1e-8 * size
    again = CmcSolver(closing.domain).solve(closing.conditions, tolerance=1e-11)
    assert abs(apart(again, plan)) < 1e-8 * size
    assert 0.5 < closing.area_ratio < 2


def test_the_distance_of_planes_and_its_derivatives_against_differences():
    plan = half_tube(8)
    relations = ClosingConditions.of(plan.domain, plan.held, sides_of(plan))
    closing = ClosingMap(plan.held, relations, length_of(plan))
    surface = CmcSolver(plan.domain).solve(plan.held, tolerance=1e-12)
    at = lambda q, rim=closing.first: closing.at(np.array([q]), rim, None, 1e-12)  # noqa: E731
    here = at(0.2)
    assert_allclose(at(0.0).sums, apart(surface, plan), rtol=0, atol=1e-10)
    difference = (at(0.2 + 1e-4).sums - at(0.2 - 1e-4).sums) / 2e-4
    assert_allclose(closing.by_moduli(here)[:, 0], difference, rtol=1e-4)
    turn = np.cross(here.rim, np.random.default_rng(5).normal(size=here.rim.shape))
    turn[closing.lines(here.rim)[1]] = 0.0
    difference = (at(0.2, exp(here.rim, 1e-4 * turn)).sums - at(0.2, exp(here.rim, -1e-4 * turn)).sums) / 2e-4
    assert_allclose(closing.by_normals(here) @ turn.ravel(), difference, rtol=1e-4)


def test_a_range_without_a_root_ends_with_what_is_left():
    plan = half_tube()
    moduli = length_of(plan, stretch=(0.9, 1.5))
    closing = close_periods(plan.domain, plan.held, by="moduli", moduli=moduli, coplanar=sides_of(plan))
    assert closing.status is ClosingStatus.OUT_OF_RANGE and not closing.closed
    assert_allclose(np.exp(closing.moduli), 0.9)
    assert "end of their range" in closing.message and "The rest: 'left' to 'right' 0.0" in closing.message
    size = np.linalg.norm(np.ptp(closing.surface.f_plus, axis=0))
    assert_allclose(abs(apart(closing.surface, plan)) / size, closing.gaps[-1], rtol=0.1)
    assert 0.01 < closing.gaps[-1] < closing.gaps[0]


def arches(edge=0.08, holes=()):
    """A plan with two feet in the floor, half circles of unequal radii, and tilts along the rest."""
    angle = np.linspace(0, np.pi, 13)
    left = np.column_stack([-1.5 + 0.5 * np.sin(angle), 0.5 * np.cos(angle)])
    right = np.column_stack([1.5 - 0.3 * np.sin(angle), -0.3 * np.cos(angle)])
    outline = np.vstack([[[-1.5, -1], [1.5, -1]], right, [[1.5, 1], [-1.5, 1]], left])
    shape = shapes.polygon(outline, holes=holes, max_edge=edge)
    rim = shape.domain.boundary_edges
    middles = shape.positions[shape.domain.edges[rim]].mean(axis=1)
    far = np.hypot(1.5 - np.abs(middles[:, 0]), middles[:, 1])
    feet = {"a": rim[(far < 0.5) & (middles[:, 0] < 0)], "b": rim[(far < 0.3) & (middles[:, 0] > 0)]}
    rest = np.setdiff1d(rim, np.concatenate(list(feet.values())))
    held = conditions.binormal(shape.domain, shape.positions, rest, 0.3)
    for edges in feet.values():
        held += conditions.mirror(shape.domain, edges, (0, 0, -1))
    return shape, held, [Side(name, edges, normal=(0, 0, -1)) for name, edges in feet.items()]


WAYS = {
    "normals": ((), lambda shape: {}),
    "tilts": ((), lambda shape: {"positions": shape.positions}),
    "normals, around a courtyard": (([0.3, 0.1],), lambda shape: {}),
    "both": (([0.3, 0.1],), lambda shape: {"by": "both", "moduli": hole(shape.domain, shape.positions, 1)}),
}


@pytest.mark.parametrize("way", WAYS)
def test_feet_come_to_one_floor_by_the_normals_along_the_rest(way):
    """Together with the periods around courtyards, and with the least change that does it."""
    centres, given = WAYS[way]
    shape, held, feet = arches(holes=[ring(0.3, centre) for centre in centres])
    closing = close_periods(shape.domain, held, coplanar=[feet], **given(shape))
    planes = [side_plane(closing.surface, foot) for foot in feet]
    size = np.linalg.norm(np.ptp(closing.surface.f_plus, axis=0))
    assert closing.closed and closing.gaps[0] > 0.01 and len(closing.gaps) <= 10
    assert list(closing.left) == ["period 0"] * len(centres) + ["'a' to 'b'"]
    assert abs(planes[0].offset - planes[1].offset) < 1e-8 * size
    assert max(plane.relative for plane in planes) < 1e-9
    fixed, normals = closing.conditions.resolve()
    ends = np.isin(fixed, np.concatenate([shape.domain.edges[foot.edges].ravel() for foot in feet]))
    assert ends.sum() == 4
    assert_allclose(normals[ends, 2], 0, rtol=0, atol=1e-12)  # those at the ends of the mirrors stay in the planes
    assert np.abs(closing.surface.periods).max(initial=0.0) < 1e-7 and not closing.surface.is_open
    assert closing.turned.max() > 0.01


def test_pieces_of_one_side_are_brought_together_and_sides_that_touch_are_one():
    shape, held, feet = arches()
    whole = Side("feet", np.concatenate([feet[0].edges, feet[1].edges]))
    relations = ClosingConditions.of(shape.domain, held, [[whole]])
    assert relations.names == ("'feet' to 'feet'",) and relations.directions.shape == (1, 3)
    halves = [Side("left", feet[0].edges[:5]), Side("right", feet[0].edges[5:])]
    with pytest.raises(ConditionError, match="nothing to close"):
        ClosingConditions.of(shape.domain, held, [halves])


def test_sides_that_cannot_lie_in_one_plane_are_refused():
    plan = half_tube(8)
    shape, held, feet = arches(0.2)
    rest = np.setdiff1d(shape.domain.boundary_edges, np.concatenate([foot.edges for foot in feet]))
    walls = conditions.mirror(shape.domain, feet[0].edges, (0, 0, 1)) + conditions.mirror(
        shape.domain, rest[:9], (1, 0, 0)
    )
    cases = [
        (shape.domain, walls, [feet[0], Side("aside", rest[:9])], "'a' and 'aside'.*not parallel"),
        (shape.domain, held, [feet[0], Side("rest", rest)], "'rest'.*not all along a mirror"),
        (shape.domain, held, [feet[0], Side("b", feet[1].edges, "tangent")], "'b'.*not all along a mirror"),
    ]
    for domain, conditions_, group, message in cases:
        with pytest.raises(ConditionError, match=message):
            ClosingConditions.of(domain, conditions_, [group])
    with pytest.raises(ConditionError, match="nothing to close"):
        close_periods(shape.domain, held)
    with pytest.raises(ConditionError, match="No normals are prescribed"):
        close_periods(plan.domain, replace(plan.held, vertices=plan.held.vertices[:0], vertex_normals=np.zeros((0, 3))))
