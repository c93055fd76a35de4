"""Sizing and placing a surface over its plan: exact answers for known similarities."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

from solver.surface.placement import (
    FREE_SIZES,
    GROUNDS,
    PlacementError,
    Plane,
    Rule,
    Similarity,
    place,
    plan_plane,
    procrustes,
    rim_weights,
    span,
)

N = 24
ANGLES = 2 * np.pi * np.arange(N) / N
E_Z = np.array([0.0, 0.0, 1.0])


def circle(radius: float, height: float = 0.0) -> np.ndarray:
    return np.column_stack([radius * np.cos(ANGLES), radius * np.sin(ANGLES), np.full(N, height)])


def dome() -> np.ndarray:
    """Hemisphere of radius 2 (H = ½): rim in rows 0…N-1, then a parallel and the apex."""
    return np.vstack([circle(2.0), circle(2.0 * np.cos(0.7), 2.0 * np.sin(0.7)), [[0.0, 0.0, 2.0]]])


def turn(axis: np.ndarray, angle: float) -> np.ndarray:
    k = np.cross(np.eye(3), axis)
    return np.eye(3) + np.sin(angle) * k + (1 - np.cos(angle)) * k @ k


@pytest.fixture
def cloud() -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(3)
    return rng.normal(size=(17, 3)), rng.uniform(0.2, 3.0, size=17)


def test_procrustes_recovers_scale_and_translation(cloud):
    points, weights = cloud
    scale, rotation, translation = procrustes(points, 3.25 * points + [1, -2, 5], weights)
    assert_allclose(scale, 3.25, rtol=1e-13)
    assert_allclose(rotation, np.eye(3), atol=0)
    assert_allclose(translation, [1, -2, 5], rtol=1e-12)


@pytest.mark.parametrize("angle", [0.4, 2.9, -1.7])
@pytest.mark.parametrize("axis", [E_Z, np.array([0.6, 0.0, 0.8]), np.array([0.0, 1.0, 0.0])])
def test_procrustes_recovers_a_turn_about_the_axis(cloud, axis, angle):
    points, weights = cloud
    wanted = turn(axis, angle)
    scale, rotation, translation = procrustes(points, 0.5 * points @ wanted.T + [3, 1, 2], weights, axis)
    assert_allclose(rotation, wanted, atol=1e-13)
    assert_allclose(scale, 0.5, rtol=1e-12)
    assert_allclose(translation, [3, 1, 2], rtol=1e-12)


def test_procrustes_is_the_least_squares_solution(cloud):
    """Against lstsq in the unknowns (s, t), with weights that matter."""
    points, weights = cloud
    targets = np.random.default_rng(4).normal(size=points.shape) + points
    root = np.sqrt(weights)[:, None]
    matrix = np.concatenate([np.column_stack([root * points[:, [k]], root * np.eye(3)[k]]) for k in range(3)])
    right = np.concatenate([(root * targets)[:, k] for k in range(3)])
    expected = np.linalg.lstsq(matrix, right, rcond=None)[0]
    scale, _, translation = procrustes(points, targets, weights)
    assert_allclose([scale, *translation], expected, rtol=1e-11)
    assert abs(procrustes(points, targets, np.ones(17))[0] - scale) > 1e-3


def test_turn_is_stationary(cloud):
    """Turning a little further, either way, is worse, for points that match only roughly."""
    points, weights = cloud
    targets = np.random.default_rng(5).normal(size=points.shape) + 2 * points @ turn(E_Z, 0.8).T

    def misfit(rotation):
        p = points @ rotation.T
        scale, _, translation = procrustes(p, targets, weights)
        return np.sum(weights[:, None] * (scale * p + translation - targets) ** 2)

    _, rotation, _ = procrustes(points, targets, weights, E_Z)
    best = misfit(rotation)
    assert best < misfit(turn(E_Z, 1e-3) @ rotation)
    assert best < misfit(turn(E_Z, -1e-3) @ rotation)


def test_procrustes_of_a_mirrored_target_is_negative(cloud):
    points, weights = cloud
    assert_allclose(procrustes(points, -2 * points, weights)[0], -2, rtol=1e-12)


def test_dome_on_a_level_plan():
    drawn = circle(5.0, 1.5) + [10, 20, 0]
    plane = Plane(np.array([10.0, 20.0, 1.5]), E_Z)
    placement = place(dome(), np.arange(N), drawn, np.ones(N), plane, Rule())
    placed = placement.points(dome())
    assert_allclose(placement.scale, 2.5, rtol=1e-14)
    assert_allclose(placed[:N], drawn, atol=1e-13)
    assert_allclose(placed[-1], [10, 20, 1.5 + 5], atol=1e-13)
    assert not placement.mirrored


@pytest.mark.parametrize(
    ("size", "value", "scale"),
    [("span", 12, 3), ("height", 5, 2.5), ("rise", 1.5, 3 * 0.25), ("radius", 8, 4), ("mean_curvature", 0.125, 4)],
)
def test_sizes_of_the_dome(size, value, scale):
    """The hemisphere of radius 2: span 4, height 2, 1/H = 2, H = ½. The drawn circle has radius 1."""
    plane = Plane(np.zeros(3), E_Z)
    placement = place(dome(), np.arange(N), circle(1.0), np.ones(N), plane, Rule(size=size, value=value))
    assert_allclose(placement.scale, scale, rtol=1e-14)
    assert_allclose(placement.points(dome())[:N], circle(2.0 * scale), atol=1e-13)


def test_size_counts_from_the_curvature_of_what_it_is_given():
    plane = Plane(np.zeros(3), E_Z)
    placement = place(
        10 * dome(),
        np.arange(N),
        circle(1),
        np.ones(N),
        plane,
        Rule(size="radius", value=8),
        mean_curvature=0.05,
    )
    assert_allclose(placement.scale, 0.4, rtol=1e-14)


def test_flip_mirrors_and_keeps_the_ground_rule():
    drawn = circle(4.0, 1.0)
    plane = Plane(np.array([0, 0, 1.0]), E_Z)
    for ground, apex, rim in [("rim", -3.0, 1.0), ("lowest", 1.0, 5.0)]:
        placement = place(dome(), np.arange(N), drawn, np.ones(N), plane, Rule(flip=True, ground=ground))
        placed = placement.points(dome())
        assert placement.mirrored
        assert_allclose(placed[-1], [0, 0, apex], atol=1e-13)
        assert_allclose(placed[:N, 2], rim, atol=1e-13)
        assert_allclose(placement.directions(E_Z), -E_Z)


def test_ground_under_a_rim_that_hangs_below_its_mean():
    points = dome()
    points[:N, 2] = 0.3 * np.cos(2 * ANGLES)
    plane = Plane(np.array([0, 0, 7.0]), E_Z)
    heights = {
        ground: place(points, np.arange(N), circle(2, 7), np.ones(N), plane, Rule("span", 4, ground)).points(points)[
            :, 2
        ]
        for ground in GROUNDS
    }
    assert_allclose(heights["lowest"].min(), 7, atol=1e-13)
    assert_allclose(heights["rim"][:N].mean(), 7, atol=1e-13)
    assert_allclose(heights["rim"][:N].min(), 6.7, atol=1e-13)


@pytest.mark.parametrize("flip", [False, True])
@pytest.mark.parametrize("size", sorted(set(FREE_SIZES) - {"rise"}))  # its extents are along axes
def test_sloped_plan_is_the_level_one_turned(size, flip):
    """Turning plan, surface and plane together turns the result: only the plane's normal is special."""
    turned, shift = turn(np.array([0.6, 0.8, 0.0]), 0.5), np.array([3.0, -1.0, 2.0])
    rule = Rule(size=size, value=1.5, flip=flip, rotate=True)
    level = place(dome(), np.arange(N), circle(5.0), np.ones(N), Plane(np.zeros(3), E_Z), rule)
    plane = Plane(shift, turned @ E_Z)
    sloped = place(dome() @ turned.T, np.arange(N), circle(5.0) @ turned.T + shift, np.ones(N), plane, rule)
    assert_allclose(sloped.points(dome() @ turned.T), level.points(dome()) @ turned.T + shift, atol=1e-12)


def test_no_turn_unless_asked():
    quarter = turn(E_Z, 0.7)
    plane = Plane(np.zeros(3), E_Z)
    points = dome() * [1.5, 1.0, 1.0]
    drawn = 2 * points[:N] @ quarter.T
    still = place(points, np.arange(N), drawn, np.ones(N), plane, Rule())
    turned = place(points, np.arange(N), drawn, np.ones(N), plane, Rule(rotate=True))
    assert_allclose(still.linear, np.eye(3), atol=0)
    assert_allclose(turned.linear, quarter, atol=1e-13)
    assert_allclose(turned.points(points)[:N], drawn, atol=1e-12)
    assert still.scale < turned.scale


def test_a_point_is_not_blown_up():
    plane = Plane(np.zeros(3), E_Z)
    point = np.zeros((N + 1, 3)) + 1e-12 * np.random.default_rng(0).normal(size=(N + 1, 3))
    for size in ("match_plan", "span", "height"):
        with pytest.raises(PlacementError, match=r"f- shrinks to a point on its boundary"):
            place(point, np.arange(N), circle(1), np.ones(N), plane, Rule(size=size), name="f-")


@pytest.mark.parametrize("factors", [[-1, -1, 1], [1, -1, 1]])
def test_a_boundary_that_does_not_follow_the_plan_is_matched_in_size_only(factors):
    """Opposite to the outline (best scale -½), or run through the other way round (best scale 0)."""
    plane = Plane(np.zeros(3), E_Z)
    points = dome() * factors
    placement = place(points, np.arange(N), circle(3), np.ones(N), plane, Rule())
    assert_allclose(placement.scale, 1.5, rtol=1e-12)
    assert_allclose(placement.likeness, min(factors[0], 0), atol=1e-12)
    turned = place(dome() * [-1, -1, 1], np.arange(N), circle(3), np.ones(N), plane, Rule(rotate=True))
    assert_allclose(turned.likeness, 1, rtol=1e-12)
    assert_allclose(turned.points(dome() * [-1, -1, 1])[:N], circle(3), atol=1e-12)


@pytest.mark.parametrize(
    "size, value, ratio", [("radius", 1e-20, "5e-21"), ("span", 4e7, "1e.07"), ("mean_curvature", 1e-8, "5e.07")]
)
def test_a_size_that_leaves_its_plan_far_behind_is_refused(size, value, ratio):
    with pytest.raises(PlacementError, match=f"the shell is {ratio} times as large as its plan; choose another size"):
        place(dome(), np.arange(N), circle(2.0), np.ones(N), Plane(np.zeros(3), E_Z), Rule(size=size, value=value))


def test_a_flat_surface_has_no_height():
    with pytest.raises(PlacementError, match="f- has no height, so it cannot be sized by it"):
        flat = circle(2)
        place(flat, np.arange(N), flat, np.ones(N), Plane(np.zeros(3), E_Z), Rule(size="height"), name="f-")


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"size": "spam"}, 'no size "spam"; did you mean "span"'),
        ({"ground": "sea"}, 'no ground "sea"; known are lowest, rim'),
        ({"size": "span", "value": 0.0}, "span must be a positive number, from 1e-30 to 1e\\+30, not 0"),
        ({"size": "radius", "value": float("nan")}, "radius must be a positive number, .*, not nan"),
        ({"size": "rise", "value": 3.0}, "rise must be a number of at most 2 in size, not 3"),
    ],
)
def test_rules_name_what_is_wrong(settings, message):
    with pytest.raises(PlacementError, match=message):
        Rule(**settings)


def test_plane_of_a_level_plan_is_exact_and_looks_up():
    vertices = np.array([[0, 0, 3], [4, 0, 3], [4, 2, 3], [0, 2, 3.0]])
    for faces in ([[0, 1, 2], [0, 2, 3]], [[2, 1, 0], [3, 2, 0]]):
        plane = plan_plane(vertices, faces, [0, 1, 2, 3], np.ones(4))
        assert_allclose(plane.normal, E_Z, atol=0)
        assert_allclose(plane.origin, [2, 1, 3])


def test_plane_of_a_sloped_a_vertical_and_a_tubular_plan():
    square = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0.0]])
    faces = [[0, 1, 2], [0, 2, 3]]
    slope = turn(np.array([1.0, 0, 0]), 0.3)
    assert_allclose(plan_plane(square @ slope.T, faces, range(4), np.ones(4)).normal, slope @ E_Z, atol=1e-15)
    wall = turn(np.array([1.0, 0, 0]), np.pi / 2)
    assert_allclose(plan_plane(square @ wall.T, faces, range(4), np.ones(4)).normal, [0, -1, 0], atol=1e-15)
    tube = np.vstack([circle(1, 0), circle(1, 1)])
    i = np.arange(N)
    j = (i + 1) % N
    sides = np.vstack([np.column_stack([i, j, j + N]), np.column_stack([i, j + N, i + N])])
    assert_allclose(plan_plane(tube, sides, range(2 * N), np.ones(2 * N)).normal, E_Z, atol=0)


def test_rim_weights_are_half_the_edges_at_each_vertex():
    points = np.array([[9, 9, 9], [0, 0, 0], [3, 0, 0], [3, 4, 0.0]])
    vertices, weights = rim_weights(points, [[1, 2], [2, 3], [3, 1]])
    assert_allclose(vertices, [1, 2, 3])
    assert_allclose(weights, [4, 3.5, 4.5])


def test_uneven_edges_do_not_pull_the_placement():
    """A quarter of the outline drawn with many points must not count for more than its length."""
    t = np.sort(np.concatenate([np.linspace(0, 2 * np.pi, 80, endpoint=False), np.linspace(0.01, 1.5, 900)]))
    drawn = np.column_stack([np.cos(t), np.sin(t), 0 * t])
    index = np.arange(len(t))
    _, weights = rim_weights(drawn, np.column_stack([index, np.roll(index, -1)]))
    ellipse = drawn * [2.0, 1.0, 1.0]
    placement = place(ellipse, index, drawn, weights, Plane(np.zeros(3), E_Z), Rule())
    assert_allclose(placement.translation, 0, atol=2e-3)
    assert_allclose(placement.scale, (2 + 1) / (4 + 1), rtol=2e-3)


def test_span_is_seen_along_the_normal():
    points = np.array([[0, 0, 0], [3, 4, 50], [1, 1, -9.0]])
    assert_allclose(span(points, E_Z), 5, rtol=1e-14)
    assert_allclose(span(points, np.array([1.0, 0, 0])), np.hypot(3, 59), rtol=1e-14)
    t = np.linspace(0, 2 * np.pi, 5000)
    assert_allclose(span(np.column_stack([7 * np.cos(t), np.sin(t), t]), E_Z), 14, rtol=1e-6)
    assert span(points[:1], E_Z) == span(points[:0], E_Z) == 0.0


def test_similarity_defaults_to_the_identity():
    points = np.random.default_rng(1).normal(size=(5, 3))
    assert_allclose(Similarity().points(points), points, atol=0)
