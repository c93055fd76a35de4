"""Enneper's surface, catenoids and zones: lines in space, and rings whose conformal type is unknown."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.integrate import solve_ivp

from solver import shapes, span_outline
from solver.fitting.curves import Curve
from tests.solver.exact_surfaces import disc, rates
from tests.solver.spanned_plans import (
    catenoid,
    catenoid_error,
    distortion,
    enneper,
    enneper_error,
    inside_curvature,
    raised,
    ring,
    sphere_error,
)


def radius_of_hole(span) -> float:
    hole = min(span.domain.boundary_loops, key=len)
    return float(np.linalg.norm(span.positions[hole], axis=1).mean())


def test_enneper_from_a_shifted_line():
    t = 0.3 + 2 * np.pi * np.arange(400) / 400
    errors = []
    for n in (120, 480, 1920):
        domain, points = disc(n)
        span = span_outline(domain, points, enneper(0.9 * np.exp(1j * t))[::-1])
        assert span.ok, span.message
        errors.append(enneper_error(span.points))
    assert rates(errors).mean() > 1.5 and errors[-1] < 2e-3, errors
    assert np.abs(np.median(inside_curvature(span))) < 2e-3


@pytest.mark.parametrize(("height", "worst"), [(0.4, 3e-4), (0.7, 2e-3)])
def test_a_catenoid_finds_its_conformal_type(height, worst):
    """The catenoid c cosh is conformal to the plane ring whose radii have the logarithms of z / c."""
    waist, middle = catenoid(height, 0.6)
    arc = height / waist
    errors, radii = [], []
    for n in (500, 2000):
        domain, points = ring(n, 0.6)
        span = span_outline(domain, raised(domain, points, height))
        assert span.ok, span.message
        errors.append(catenoid_error(span.points, waist, middle))
        radii.append(radius_of_hole(span))
    assert rates(errors).mean() > 1.5 and errors[-1] < worst, errors
    assert_allclose(radii[-1], np.exp(-arc), rtol=5e-3)


def test_a_zone_of_a_sphere_and_its_modulus():
    errors, moduli = [], []
    for n in (500, 2000):
        domain, points = ring(n, 0.6)
        span = span_outline(domain, raised(domain, points, 0.5), mean_curvature=0.93165455511)
        assert span.ok, span.message
        errors.append(sphere_error(span.points, -0.39, np.hypot(1.0, 0.39)))
        moduli.append(radius_of_hole(span))
    assert rates(errors)[0] > 1.7 and errors[-1] < 6e-4, errors
    assert_allclose(moduli, 0.4473, rtol=1e-3)
    assert distortion(span) < 2e-4


def test_holes_that_keep_the_type_of_the_plan_are_off():
    domain, points = ring(500, 0.6)
    kept = span_outline(domain, raised(domain, points, 0.4), holes="keep")
    assert kept.domain is domain
    assert distortion(kept) > 20 * distortion(span_outline(domain, raised(domain, points, 0.4)))


def test_a_courtyard_lies_on_both_its_lines():
    angle = 2 * np.pi * np.arange(48) / 48
    circle = np.column_stack([np.cos(angle), np.sin(angle)])
    plan = shapes.polygon(circle, holes=[0.4 * circle + [0.15, 0.1]], max_edge=0.1)
    span = span_outline(plan, plan.positions, mean_curvature=0.5)
    assert span.ok, span.message
    rim = plan.domain.boundary_vertices
    far = [Curve(span.points[loop] * [1, 1, 0], closed=True) for loop in plan.domain.boundary_loops]
    drawn = np.column_stack([plan.positions, np.zeros(len(plan.positions))])[rim]
    off = np.min([np.linalg.norm(line.closest(drawn).points - drawn, axis=1) for line in far], axis=0)
    assert off.max() < 2e-3 and np.abs(span.points[rim, 2]).max() < 1e-12
    assert_allclose(np.median(inside_curvature(span)), 0.5, rtol=0.02)


def test_a_narrow_neck_is_found_and_one_that_closes_is_refused():
    """Circles of radius 1 and 0.6 bound a catenoid up to the height 1.0122; the search refines the plan there."""
    waist, middle = catenoid(0.9, 0.6)
    domain, points = ring(1000, 0.6)
    span = span_outline(domain, raised(domain, points, 0.9))
    assert span.ok, span.message
    assert span.faces.shape == domain.faces.shape and len(span.points) == domain.vertex_count
    assert catenoid_error(span.points, waist, middle) < 5e-3
    assert_allclose(np.linalg.norm(span.points[:, :2], axis=1).min(), waist, rtol=5e-3)
    for height in (1.05, 1.3):
        closed = span_outline(domain, raised(domain, points, height))
        assert not closed.ok and "the neck" in closed.message


def test_a_band_of_an_unduloid():
    """ψ'² = sin² ψ - 0.4, r = sin ψ - ψ', z = ∫ sin² ψ + cos ψ (the paper's f+), from the bulge towards the neck."""
    first = [0.5 * np.pi, -np.sqrt(0.6), 0.0]

    def slopes(_, y: np.ndarray) -> list[float]:
        return [y[1], np.sin(y[0]) * np.cos(y[0]), np.sin(y[0]) ** 2]

    way = solve_ivp(slopes, (0, 1), first, dense_output=True, rtol=1e-10)
    psi, slope, along = way.sol(np.linspace(0, 1, 400))
    radius, height = np.sin(psi) - slope, along + np.cos(psi)
    t = 2 * np.pi * np.arange(200) / 200
    circle = np.column_stack([np.cos(t), np.sin(t), 0 * t])
    errors = []
    for n in (500, 2000):
        domain, points = ring(n, 0.5)
        lines = [
            circle * radius[k] + [0, 0, height[k]]
            for k in (0 if np.linalg.norm(points[loop[0]]) > 0.9 else -1 for loop in domain.boundary_loops)
        ]
        span = span_outline(domain, points, lines, mean_curvature=0.5)
        assert span.ok, span.message
        far = np.linalg.norm(span.points[:, :2], axis=1) - np.interp(span.points[:, 2], height, radius)
        errors.append(np.abs(far).max())
    assert errors[-1] < 2e-3 and rates(errors)[0] > 1.5, errors
    assert_allclose(radius_of_hole(span), np.exp(-1.0), rtol=3e-3)
