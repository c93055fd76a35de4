"""Caps of spheres: exact answers for every H and volume, from wrong parametrisations, by every number."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from solver import conformal_distortion, shapes, span_outline
from tests.solver.exact_surfaces import disc, rates
from tests.solver.spanned_plans import cap_error, distortion, inside_curvature, sphere_error


def circle(count: int, first: float = 0.0) -> np.ndarray:
    t = first + 2 * np.pi * np.arange(count) / count
    return np.column_stack([np.cos(t), np.sin(t), 0 * t])


def crowded_circle(count: int) -> np.ndarray:
    """Points of the circle, clockwise, starting anywhere, three times as close on one side."""
    t = 2 * np.pi * np.arange(count) / count
    t = 1.3 - t - 0.5 * np.sin(t)
    return np.column_stack([np.cos(t), np.sin(t), 0 * t])


@pytest.mark.parametrize("H", [0.1, 0.5, 0.8, 0.95])
def test_points_are_of_second_order(H):
    errors, off = [], []
    for n in (120, 480, 1920):
        domain, points = disc(n)
        span = span_outline(domain, points, crowded_circle(300), mean_curvature=H)
        assert span.ok, span.message
        assert_allclose(np.linalg.norm(span.points[domain.boundary_vertices], axis=1), 1.0, rtol=0, atol=1e-6)
        errors.append(cap_error(span.points, H))
        off.append(distortion(span))
    assert rates(errors).mean() > 1.5, errors
    assert errors[-1] < 1e-3 / (1.0 - H**2) ** 0.5 and off[-1] < 1e-3
    assert span.history[-1].solves < 80


def test_the_film_of_a_flat_line_is_flat():
    domain, points = disc(300)
    span = span_outline(domain, points, crowded_circle(200))
    assert span.ok and span.mean_curvature == 0.0
    assert np.abs(span.points[:, 2]).max() < 1e-12
    assert np.abs(conformal_distortion(span.domain, span.points) - 1).max() < 0.2


@pytest.mark.parametrize("part", [0.3, 1.0, 1.8])
def test_volumes_up_to_and_beyond_the_half_sphere(part):
    """The cap of a volume: its H by Newton on the height."""
    wanted = part * 2 * np.pi / 3
    h = np.roots([np.pi / 6, 0, np.pi / 2, -wanted])
    h = float(h[np.abs(h.imag) < 1e-9].real[0])
    radius = (1 + h**2) / (2 * h)
    errors = []
    for n in (480, 1920):
        domain, points = disc(n)
        span = span_outline(domain, points, volume=wanted)
        assert span.ok, span.message
        errors.append(sphere_error(span.points, h - radius, radius))
        assert_allclose(span.mean_curvature, 1 / radius, rtol=0.03)
    assert rates(errors)[0] > 1.6 and errors[-1] < 6e-3, errors


def test_rise_and_height_are_those_of_the_crown():
    domain, points = disc(480)
    low = span_outline(domain, points, rise=0.4)
    high = span_outline(domain, points + [3.0, -2.0], circle(100) * 1.0 + [3.0, -2.0, 5.0], height=0.4)
    assert low.ok and high.ok
    assert_allclose(low.points[:, 2].max(), 0.4, rtol=1e-5)
    assert_allclose(high.points[:, 2].max(), 5.4, rtol=1e-6)
    assert_allclose(low.mean_curvature, 2 * 0.4 / (1 + 0.4**2), rtol=5e-3)
    again = span_outline(domain, points, rise=0.42, initial=low)
    assert again.ok and again.history[-1].solves < 0.8 * low.history[-1].solves


@pytest.mark.parametrize("number", [{"mean_curvature": 0.7}, {"rise": 0.6}, {"volume": 1.3}])
def test_hanging_is_standing_upside_down(number):
    domain, points = disc(300)
    stands = span_outline(domain, points, **number)
    hangs = span_outline(domain, points, **{name: -value for name, value in number.items()})
    assert stands.ok and hangs.ok
    assert_allclose(hangs.points * [1, 1, -1], stands.points, rtol=0, atol=1e-12)
    assert_allclose(hangs.normals * [-1, -1, 1], stands.normals, rtol=0, atol=1e-6)
    assert hangs.mean_curvature == pytest.approx(-stands.mean_curvature, abs=1e-12)


def test_the_unit_and_the_place_do_not_matter():
    domain, points = disc(300)
    one = span_outline(domain, points, mean_curvature=0.8)
    other = span_outline(domain, 500.0 * points + [3e4, 0], mean_curvature=0.8 / 500)
    assert len(one.history) == len(other.history)
    assert_allclose(other.points / 500 - [60, 0, 0], one.points, rtol=0, atol=1e-8)


def test_measured_curvature_and_normals():
    errors = []
    for n in (480, 1920):
        domain, points = disc(n)
        span = span_outline(domain, points, mean_curvature=0.8)
        errors.append(np.abs(inside_curvature(span) / 0.8 - 1).mean())
        radial = span.points + [0, 0, np.sqrt(1 / 0.64 - 1)]
        assert np.linalg.norm(span.normals - 0.8 * radial, axis=1).max() < 0.02
    assert errors[-1] < 2e-3 and rates(errors)[0] > 0.9


def test_too_large_a_curvature_is_refused_with_the_largest():
    domain, points = disc(300)
    span = span_outline(domain, points, mean_curvature=1.2)
    assert not span.ok and span.status.value == "no surface"
    assert "the largest is about 1.0" in span.message
    assert_allclose(span.mean_curvature, 1.0, rtol=0.02)
    near = span_outline(domain, points, mean_curvature=0.999)
    assert near.ok, near.message
    assert near.points[:, 2].max() < 1.0


def test_the_largest_curvature_is_that_of_a_surface():
    """Around this courtyard larger volumes crowd the rim: their multipliers, up to 0.75, are of no surface."""
    star = np.array([[0, 0], [3, -0.4], [4.2, 1], [3.4, 1.6], [4, 3], [2.4, 2.6], [1, 3.4], [0.6, 2], [-0.6, 1.2]])
    court = np.array([[1.6, 0.9], [1.5, 1.9], [2.4, 1.8], [2.5, 1.0]])
    plan = shapes.polygon(star, holes=[court], max_edge=0.16, corner_radius=0.25)
    span = span_outline(plan, plan.positions, mean_curvature=0.8)
    assert "the largest is about 0.6" in span.message, span.message
    near = span_outline(plan, plan.positions, mean_curvature=0.95 * span.mean_curvature)
    assert near.ok, near.message


def test_a_square_plan_spans_an_ellipse():
    plan = shapes.polygon([[-1, -1], [1, -1], [1, 1], [-1, 1]], max_edge=0.12)
    line = circle(200) * [2.0, 1.0, 1.0]
    span = span_outline(plan, plan.positions, line, mean_curvature=0.3)
    assert span.ok, span.message
    rim = span.points[plan.domain.boundary_vertices]
    assert_allclose(np.linalg.norm(rim / [2.0, 1.0, 1.0], axis=1), 1.0, rtol=0, atol=1e-5)
    assert distortion(span) < 2e-3
    thin = span_outline(plan, plan.positions, circle(300) * [20.0, 1.0, 1.0])
    assert not thin.ok and ("Mesh a new plan" in thin.message or "the map to it distorts" in thin.message)


def test_progress_counts_steps_and_cancels():
    domain, points = disc(300)
    seen: list[tuple[int, float]] = []
    span = span_outline(domain, points, mean_curvature=0.8, progress=lambda *step: seen.append(step))
    assert [step for step, _ in seen] == list(range(len(seen))) and seen[-1][1] < 1e-4
    stopped = span_outline(domain, points, mean_curvature=0.8, progress=lambda step, _: step < 2)
    assert stopped.status.value == "cancelled" and len(stopped.history) == 3
    assert_array_equal(stopped.faces, span.faces)
