"""Sides of a plan: parts of groups, those that the shell continues across, planes that the edges suggest."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

from solver import ConditionError, JobError, shapes
from solver.shells.plan import Group, Plan
from solver.shells.plan_sides import goes_on, own_plane, plan_sides


def flat(shape) -> np.ndarray:
    return np.column_stack([shape.positions, np.zeros(len(shape.positions))])


def test_a_group_in_two_places_is_two_sides():
    strip = shapes.strip(2.0, 1.0, 6)
    domain = strip.domain
    ends = [strip.sides["left"], strip.sides["right"]]
    group = Group("Ends", domain.edges[np.concatenate(ends)], "mirror", {"normal": (2.0, 0.0, 0.0)})
    sides = plan_sides(Plan(flat(strip), domain.faces, groups=[group]), domain)
    assert [side.name for side in sides] == ["Ends 1", "Ends 2"]
    found = sorted(np.sort(side.edges).tolist() for side in sides)
    assert found == sorted(np.sort(edges).tolist() for edges in ends)
    assert_allclose(sides[0].normal, (1, 0, 0), atol=1e-15)


def test_mirrors_and_planes_go_on_unless_they_say_otherwise():
    edges = np.zeros((0, 2), dtype=int)
    expected = {"mirror": True, "plane": True, "free": False, "binormal": False}
    assert {kind: goes_on(Group("g", edges, kind)) for kind in expected} == expected
    assert not goes_on(Group("g", edges, "mirror", goes_on=False))
    assert goes_on(Group("g", edges, "free", goes_on=True))


def test_sides_that_are_none_are_refused():
    strip = shapes.strip(2.0, 1.0, 6)
    groups = [Group(name, strip.domain.edges[strip.sides[name]], kind) for name, kind in
              (("left", "binormal"), ("right", "mirror"))]  # fmt: skip
    plan = Plan(flat(strip), strip.domain.faces, groups=groups)
    assert [side.name for side in plan_sides(plan, strip.domain)] == ["right"]
    with pytest.raises(JobError, match="There is no group \"top\" to continue across; there are left, right"):
        plan_sides(plan, strip.domain, ["top"])
    with pytest.raises(JobError, match="cannot continue across \"left\": it must be a mirror, a plane or free"):
        plan_sides(plan, strip.domain, ["left"])
    plan.groups = groups[:1]
    with pytest.raises(JobError, match="no side to continue across"):
        plan_sides(plan, strip.domain)


def test_the_plane_of_straight_edges_stands_on_the_plan_and_faces_away_from_it():
    turn = np.linalg.qr(np.random.default_rng(2).normal(size=(3, 3)))[0]
    strip = shapes.strip(2.0, 1.0, 6)
    away = {"left": (-1, 0, 0), "right": (1, 0, 0), "bottom": (0, -1, 0), "top": (0, 1, 0)}
    for name, normal in away.items():
        found = own_plane(strip.domain, flat(strip) @ turn.T, strip.sides[name])
        assert_allclose(found, turn @ normal, atol=1e-12)


def test_the_plane_of_curved_edges_is_their_own_and_faces_down():
    disc = shapes.disc(200)
    assert_allclose(own_plane(disc.domain, flat(disc), disc.sides["outer"]), (0, 0, -1), atol=1e-12)
    quarter = disc.sides["outer"][:8]
    bowl = flat(disc) + [0.0, 0.0, 1.0] * (0.3 * disc.positions[:, :1])
    assert_allclose(own_plane(disc.domain, bowl, quarter), np.array([0.3, 0, -1]) / np.hypot(0.3, 1), atol=1e-12)


def test_edges_in_no_plane_give_none():
    disc = shapes.disc(200)
    wave = flat(disc)
    wave[:, 2] = 0.3 * np.sin(3 * np.arctan2(disc.positions[:, 1], disc.positions[:, 0]))
    with pytest.raises(ConditionError, match="do not lie in a plane"):
        own_plane(disc.domain, wave, disc.sides["outer"])
    with pytest.raises(ConditionError, match="no edges to take a plane from"):
        own_plane(disc.domain, flat(disc), [])
