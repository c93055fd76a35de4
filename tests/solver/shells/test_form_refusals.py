"""Bad plans and settings that `form` refuses: the message names the group, the vertices, the way out."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from solver.errors import CmcError, ConditionError, MeshError
from solver.io.polygons import triangulate_polygons
from solver.shells.form import form
from solver.shells.plan import Group, Plan, Settings
from solver.surface.placement import PlacementError
from tests.solver.drawn_plans import boundary_pairs, disc, grid


def tetrahedron() -> Plan:
    corners = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1.0]])
    return Plan(corners, np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]]))


def with_group(*groups: Group) -> Plan:
    return replace(disc(3), groups=groups)


RIM = np.array([[19, 20], [20, 21]])


@pytest.mark.parametrize(
    ("plan", "error", "message", "vertices"),
    [
        (tetrahedron(), MeshError, "The mesh is closed", []),
        (
            Plan(np.eye(3), np.array([[0, 1, 2]])),
            MeshError,
            r"\(1 triangle\) has no vertex inside",
            [],
        ),
        (grid(1, 3), MeshError, r"\(6 triangles\) has no vertex inside its boundary.*run Mesh Plan", []),
        (
            with_group(Group("inner", [[0, 1], [19, 20]])),
            ConditionError,
            r'Group "inner": No boundary edge joins vertices 0, 1',
            [0, 1],
        ),
        (with_group(Group("far", [[19, 99]])), ConditionError, r'Group "far": There is no vertex 99', [99]),
        (
            with_group(Group("one", RIM), Group("two", RIM[1:, ::-1])),
            ConditionError,
            'edge between vertices 20, 21 is in two groups, "one" and "two"',
            [20, 21],
        ),
        (
            with_group(Group("flat", RIM, "plane", {"normal": (0, 0, 0)})),
            ConditionError,
            r'Group "flat": .*zero or not finite',
            [],
        ),
        (
            with_group(Group("odd", RIM, "binormal", {"lean": 3})),
            ConditionError,
            r"Group \"odd\": .* has no parameter lean",
            [],
        ),
        (with_group(Group("odd", RIM, "spline")), ConditionError, r"Group \"odd\": There is no boundary", []),
    ],
)
def test_messages(plan, error, message, vertices):
    with pytest.raises(error, match=message) as caught:
        form(plan)
    assert list(caught.value.vertices) == vertices


def test_all_edges_free():
    plan = disc(3)
    with pytest.raises(ConditionError, match="All boundary edges are free"):
        form(replace(plan, groups=[Group("all", boundary_pairs(plan), "free")]))
    with pytest.raises(ConditionError, match="All boundary edges are free"):
        form(plan, Settings(default_kind="free"))


def test_opposite_planes_that_meet_are_named():
    groups = [
        Group("up", RIM[:1], "plane", {"normal": (0, 0, 1)}),
        Group("down", RIM[1:], "plane", {"normal": (0, 0, -1)}),
    ]
    with pytest.raises(ConditionError) as caught:
        form(with_group(*groups))
    assert list(caught.value.vertices) == [20]


@pytest.mark.parametrize(
    "settings", [{"sheet": "g"}, {"default_kind": "spline"}, {"size": "large"}, {"size": "radius", "value": -2}]
)
def test_settings_are_checked(settings):
    with pytest.raises(CmcError, match=r"There is no|must be a positive number|needs a value"):
        Settings(**settings)


def test_flat_all_around_is_a_collapse():
    with pytest.raises(PlacementError, match="normals are all the same, so the surface shrinks to a point"):
        form(disc(), Settings(default_tilt=np.pi / 2))


def moebius(columns: int = 12) -> Plan:
    """A closed strip of three rows of vertices with half a turn."""
    t = 2 * np.pi * np.arange(columns) / columns
    width = np.array([-0.4, 0.0, 0.4])
    radius = 2 + width * np.cos(t / 2)[:, None]
    points = np.stack([radius * np.cos(t)[:, None], radius * np.sin(t)[:, None], width * np.sin(t / 2)[:, None]], 2)
    index = np.vstack([np.arange(3 * columns).reshape(columns, 3), [[2, 1, 0]]])
    quads = [
        [index[i, j], index[i + 1, j], index[i + 1, j + 1], index[i, j + 1]] for i in range(columns) for j in range(2)
    ]
    return Plan(points.reshape(-1, 3), triangulate_polygons(points.reshape(-1, 3), quads)[0])


def two_discs() -> Plan:
    one, other = disc(3), disc(3, centre=(20, 0, 0))
    count = len(one.positions)
    return Plan(np.vstack([one.positions, other.positions]), np.vstack([one.triangles, other.triangles + count]))


def with_nan() -> Plan:
    plan = disc(3)
    plan.positions[5, 1] = np.nan
    return plan


@pytest.mark.parametrize(
    ("plan", "message"),
    [
        (two_discs(), "component"),
        (moebius(), "one-sided, like a Möbius strip"),
        (with_nan(), "vertex 5"),
        (Plan(np.zeros((0, 3)), np.zeros((0, 3), dtype=int)), "no|empty"),
        (Plan(disc(3).positions, np.vstack([disc(3).triangles, [[0, 1, 2]]])), "face"),
    ],
)
def test_meshes_that_are_no_surface(plan, message):
    with pytest.raises(MeshError, match=message):
        form(plan)


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"sites": "edges"}, 'no kind of sites "edges"; known are vertices, faces'),
        ({"method": "guess"}, 'no method "guess"; known are newton'),
        ({"combinatorics": "triple"}, 'no combinatorics "triple"; known are primal, dual, corner'),
        ({"energy": "mobius"}, "'mobius' is not defined for normals on vertices; choose cotan"),
    ],
)
def test_choices_are_checked(settings, message):
    with pytest.raises(CmcError, match=message):
        Settings(**settings)
