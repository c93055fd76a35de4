"""The lean of the rim against the horizon, on plans that stand or curve: exact normals, rates, vertical rims."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

from solver import ConditionError, Domain, conditions, shapes

E_X, E_Y, E_Z = np.eye(3)
TILTS = [0.0, np.radians(35), -0.4, np.pi / 2]


def cap(degrees: float, n: int = 400) -> tuple[Domain, np.ndarray]:
    """A cap of a unit sphere up to this angle from the pole, over an irregular disc; its rim is a circle."""
    disc = shapes.disc(n)
    radius = np.linalg.norm(disc.positions, axis=1, keepdims=True)
    angle = np.radians(degrees) * radius
    sideways = disc.positions * np.where(radius > 0, np.sin(angle) / np.where(radius > 0, radius, 1.0), 0.0)
    points = np.column_stack([sideways, np.cos(angle)])
    return Domain.from_positions(points, disc.domain.faces), points


def turned(axis: int, angle: float) -> np.ndarray:
    c, s = np.cos(angle), np.sin(angle)
    turn = np.eye(3)
    i, j = (axis + 1) % 3, (axis + 2) % 3
    turn[[i, i, j, j], [i, j, i, j]] = c, -s, s, c
    return turn


@pytest.mark.parametrize("tilt", TILTS)
@pytest.mark.parametrize("degrees", [30, 60, 90, 120])
def test_over_a_cap_the_rim_leans_from_the_vertical(degrees, tilt):
    domain, points = cap(degrees)
    condition = conditions.binormal(domain, points, domain.boundary_edges, tilt)
    sites, normals = condition.resolve()
    radial = points[sites, :2] / np.sin(np.radians(degrees))
    assert_allclose(normals[:, :2], np.cos(tilt) * radial, rtol=0, atol=1e-12)
    assert_allclose(normals[:, 2], np.sin(tilt), rtol=0, atol=1e-12)
    middles = points[domain.edges[condition.edges]].mean(axis=1)[:, :2]
    middles /= np.linalg.norm(middles, axis=1, keepdims=True)
    assert_allclose(condition.edge_normals[:, :2], np.cos(tilt) * middles, rtol=0, atol=1e-12)
    assert_allclose(condition.edge_normals[:, 2], np.sin(tilt), rtol=0, atol=1e-12)


@pytest.mark.parametrize("degrees", [30, 60])
def test_against_the_drawn_surface_the_rim_leans_from_its_faces(degrees):
    domain, points = cap(degrees, 3000)
    condition = conditions.binormal(domain, points, domain.boundary_edges, against="surface")
    assert condition.vertex_normals[:, 2].mean() == pytest.approx(-np.sin(np.radians(degrees)), abs=0.03)


def tilted_ring(n: int, shift: float) -> tuple[Domain, np.ndarray, np.ndarray]:
    """A ring on a paraboloid, its outer rim over an ellipse, climbing; the exact tangents at the outer vertices."""
    angle = 2 * np.pi * (np.arange(n) + shift * (-1.0) ** np.arange(n)) / n
    rims = [np.column_stack([2 * r * np.cos(angle), r * np.sin(angle)]) for r in (0.8, 1.0)]
    flat = np.vstack(rims)
    points = np.column_stack([flat, 0.5 * flat[:, 0] + 0.3 * flat[:, 0] * flat[:, 1]])
    k = np.arange(n)
    after = (k + 1) % n
    faces = np.concatenate([np.column_stack([k, n + k, n + after]), np.column_stack([k, n + after, after])])
    x, y = rims[1].T
    dx, dy = -2 * np.sin(angle), np.cos(angle)
    tangents = np.column_stack([dx, dy, 0.5 * dx + 0.3 * (dx * y + x * dy)])
    return Domain.from_positions(points, faces), points, tangents / np.linalg.norm(tangents, axis=1, keepdims=True)


@pytest.mark.parametrize("tilt", TILTS)
def test_on_a_climbing_rim_the_lean_is_second_order(tilt):
    errors = []
    for n in (40, 80, 160):
        domain, points, t = tilted_ring(n, 0.15)
        loop = next(k for k, loop in enumerate(domain.boundary_loops) if loop.max() >= n)
        sites, normals = conditions.binormal(domain, points, domain.boundary_loop_edges[loop], tilt).resolve()
        level = np.cross(t, E_Z)
        level /= np.linalg.norm(level, axis=1, keepdims=True)
        exact = np.cos(tilt) * level + np.sin(tilt) * np.cross(level, t)
        errors.append(np.abs(normals - exact[sites - n]).max())
    assert errors[0] < 0.05
    assert min(np.log2(np.array(errors[:-1]) / errors[1:])) > 1.8, errors


def barrel(degrees: float, columns: int = 24, rows: int = 6) -> tuple[Domain, np.ndarray]:
    """A vault over [-sin, sin] × [0, 3] whose arch goes from -degrees to +degrees of the vertical."""
    across = np.radians(degrees) * np.linspace(-1, 1, columns + 1)
    u, v = np.meshgrid(across, np.linspace(0, 3, rows + 1), indexing="ij")
    points = np.stack([np.sin(u), v, np.cos(u)], axis=-1).reshape(-1, 3)
    at = np.arange(len(points)).reshape(columns + 1, rows + 1)
    a, b, c, d = at[:-1, :-1], at[1:, :-1], at[1:, 1:], at[:-1, 1:]
    faces = np.concatenate([np.stack(t, axis=-1).reshape(-1, 3) for t in ((a, b, c), (a, c, d))])
    return Domain.from_positions(points, faces), points


@pytest.mark.parametrize("tilt", TILTS)
@pytest.mark.parametrize("degrees", [40, 75, 90])
def test_a_barrel_vault_has_vertical_springings_and_arches(degrees, tilt):
    domain, points = barrel(degrees)
    condition = conditions.binormal(domain, points, domain.boundary_edges, tilt)
    middles = points[domain.edges[condition.edges]].mean(axis=1)
    along = points[domain.edges[condition.edges, 1]] - points[domain.edges[condition.edges, 0]]
    arch = np.abs(along[:, 1]) < 1e-9
    outward = np.where(arch[:, None], np.sign(middles[:, 1:2] - 1.5) * E_Y, np.sign(middles[:, :1]) * E_X)
    angle = np.arctan2(middles[:, 0], middles[:, 2])
    upward = np.column_stack([np.sin(angle), 0 * angle, np.cos(angle)])  # of an arch: the drawn normal
    upward[~arch] = E_Z
    assert_allclose(condition.edge_normals, np.cos(tilt) * outward + np.sin(tilt) * upward, rtol=0, atol=1e-12)
    sites, normals = condition.resolve()
    inside = (np.abs(points[sites, 1] - 1.5) == 1.5) & (np.abs(points[sites, 0]) < np.abs(points[:, 0]).max() - 1e-9)
    x, y, z = points[sites[inside]].T
    exact = np.cos(tilt) * np.outer(np.sign(y - 1.5), E_Y) + np.sin(tilt) * np.column_stack([x, 0 * x, z])
    assert_allclose(normals[inside], exact, rtol=0, atol=1e-12)
    if tilt == 0.0:
        assert_allclose(normals[:, 2], 0.0, rtol=0, atol=1e-12)  # corners, too


@pytest.mark.parametrize("degrees", [0.0, 20, 60, 85])
def test_a_sloped_roof_leans_from_the_vertical(degrees):
    """Its rim climbs, and at 0° its normals are level all around: at right angles to the rim, outwards."""
    disc = shapes.disc(600)
    points = np.column_stack([disc.positions, np.zeros(len(disc.positions))]) @ turned(0, np.radians(degrees)).T
    sites, normals = conditions.binormal(disc.domain, points, disc.domain.boundary_edges).resolve()
    t = np.cross(turned(0, np.radians(degrees)) @ E_Z, points[sites])
    is_steep = np.abs(t[:, 2]) > np.cos(np.radians(16))
    assert_allclose(normals[~is_steep, 2], 0.0, rtol=0, atol=1e-12)
    assert_allclose(np.sum(normals * t, axis=1), 0.0, rtol=0, atol=0.02)
    assert (np.sum(normals * points[sites], axis=1) > 0).all()


def test_a_vertical_rim_has_the_drawn_normals_and_the_frame_turns_smoothly_to_them():
    """A standing disc: level all around, in the disc's plane at its sides, across it at its top and bottom."""
    steps = []
    for n in (3000, 12000):
        disc = shapes.disc(n)
        points = np.column_stack([disc.positions, np.zeros(len(disc.positions))]) @ turned(0, np.pi / 2).T
        condition = conditions.binormal(disc.domain, points, disc.domain.boundary_edges)
        loop = disc.domain.boundary_loops[0]
        sites, normals = condition.resolve()
        around = normals[np.searchsorted(sites, loop)]
        angle = np.arctan2(points[loop, 2], points[loop, 0])
        side = np.argmin(np.abs(angle))
        assert_allclose(around[side], E_X, rtol=0, atol=0.1)
        assert_allclose(np.abs(around[:, 2]).max(), 0.0, rtol=0, atol=np.sin(np.radians(15)))
        bottom = np.argmin(np.abs(angle + np.pi / 2))
        assert_allclose(around[bottom], -around[np.argmin(np.abs(angle - np.pi / 2))], rtol=0, atol=1e-9)
        assert_allclose(np.abs(around[bottom, 1]), 1.0, rtol=0, atol=1e-12)
        steps.append(np.linalg.norm(around - np.roll(around, 1, axis=0), axis=1).max())
    assert steps[1] < 0.6 * steps[0]


RECTANGLE, UP, DOWN = [[0, 0], [2, 0], [2, 1], [0, 1]], [[0, 0], [2, 0], [1, 2]], [[0, 2], [1, 0], [2, 2]]


@pytest.mark.parametrize("outline", [RECTANGLE, UP, DOWN])
def test_standing_polygons_have_normals_at_right_angles_to_their_rim(outline):
    shape = shapes.polygon(np.array(outline, dtype=float), max_edge=0.2)
    x, z = shape.positions.T
    points = np.column_stack([x, 0 * x, z])
    for tilt in TILTS:
        condition = conditions.binormal(shape.domain, points, shape.domain.boundary_edges, tilt)
        along = points[shape.domain.edges[condition.edges, 1]] - points[shape.domain.edges[condition.edges, 0]]
        for normals in (condition.edge_normals, condition.vertex_normals):
            assert_allclose(np.linalg.norm(normals, axis=1), 1.0, rtol=0, atol=1e-12)
        assert_allclose(np.sum(condition.edge_normals * along, axis=1), 0.0, rtol=0, atol=1e-12)


def test_on_level_plans_both_references_are_one():
    disc = shapes.disc(400)
    for height, sign in ((0.0, 1), (7.5, 1), (-2.0, -1)):
        points = np.column_stack([disc.positions * [1, sign], np.full(len(disc.positions), height)])
        for tilt in TILTS:
            horizon, surface = (
                conditions.binormal(disc.domain, points, disc.domain.boundary_edges, tilt, against=against)
                for against in conditions.AGAINST
            )
            assert_allclose(horizon.vertex_normals, surface.vertex_normals, rtol=0, atol=1e-15)
            assert_allclose(horizon.edge_normals, surface.edge_normals, rtol=0, atol=1e-15)


def test_up_may_be_another_direction():
    domain, points = cap(50)
    turn = turned(1, 1.1) @ turned(0, 0.4)
    upright = conditions.binormal(domain, points, domain.boundary_edges, 0.3)
    fallen = conditions.binormal(domain, points @ turn.T, domain.boundary_edges, 0.3, up=5.0 * turn @ E_Z)
    assert_allclose(fallen.vertex_normals, upright.vertex_normals @ turn.T, rtol=0, atol=1e-12)


@pytest.mark.parametrize("up", [(0, 0, 0), (0, 1), (0, 0, np.nan), "z"])
def test_an_upward_direction_without_a_direction_is_refused(up):
    disc = shapes.disc(100)
    with pytest.raises(ConditionError, match="upward direction"):
        conditions.binormal(disc, "outer", up=up)


def test_an_unknown_reference_is_refused():
    with pytest.raises(ConditionError, match=r"no reference for the lean .faces.; .*surface"):
        conditions.binormal(shapes.disc(100), "outer", against="faces")
