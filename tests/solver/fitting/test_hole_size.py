"""Advice where the rim stays off its curve: the size of a ring's hole, and corners only where there are some."""

from __future__ import annotations

import re

import numpy as np
import pytest

from solver import fit_outline, shapes
from solver.fitting.fit import FitStatus
from solver.fitting.goals import Goals, OutlineOptions


def circle(radius: float, height: float, count: int = 60) -> np.ndarray:
    angle = 2 * np.pi * np.arange(count) / count
    return np.column_stack([radius * np.cos(angle), radius * np.sin(angle), np.full(count, height)])


def zone(inner: float, height: float) -> tuple[float, float]:
    """1/R, and the modulus, of the zone of a sphere between a circle of radius 1 and another one at this height.

    The modulus is the radius of the hole in the ring with radius 1 that is conformal to it.
    """
    below = (1 - inner**2 - height**2) / (2 * height)
    radius = np.hypot(1, below)
    low, high = (np.arctanh(z / radius) for z in (below, below + height))
    return 1 / radius, float(np.exp(low - high))


def fitted(hole: float, inner: float, height: float, **more):
    ring = shapes.annulus(inner=hole, outer=1.0, n=400)
    curves = [circle(1.0, 0.0), circle(inner, height)]
    first = np.linalg.norm(ring.positions[ring.domain.boundary_loops[0][0]])
    lines = curves if first > 0.99 else curves[::-1]
    return fit_outline(ring, ring.positions, lines, mean_curvature=zone(inner, height)[0], max_evaluations=150, **more)


def advised(message: str) -> tuple[str, float, float]:
    found = re.search(r"too (\w+) for this shell: make its radius about ([\d.]+) in place of ([\d.]+)\.", message)
    assert found, message
    return found[1], float(found[2]), float(found[3])


@pytest.mark.parametrize("inner, height, modulus", [(0.6, 0.5, 0.4472), (0.7, 0.3, 0.6054)])
def test_the_message_names_the_size_of_the_hole_that_would_do(inner, height, modulus):
    """A zone of a sphere lies on both circles, over the plan with its own conformal modulus only."""
    assert zone(inner, height)[1] == pytest.approx(modulus, abs=2e-4)
    fit = fitted(inner, inner, height)
    word, radius, drawn = advised(fit.message)
    assert (word, drawn) == ("large", pytest.approx(inner, rel=1e-3))
    assert radius == pytest.approx(modulus, rel=0.03)
    assert "corner" not in fit.message
    matched = fitted(radius, inner, height)
    assert matched.is_met, matched.message


@pytest.mark.parametrize("drawn", [0.4, 0.5])
def test_a_hole_may_be_too_small(drawn):
    word, radius, named = advised(fitted(drawn, 0.7, 0.3).message)
    assert (word, named) == ("small", pytest.approx(drawn, rel=1e-3))
    assert radius == pytest.approx(0.6054, rel=0.03)


def test_the_search_for_a_size_can_be_cancelled():
    calls = []
    fit = fitted(0.7, 0.7, 0.3, progress=lambda evaluation, value: calls.append(evaluation) or len(calls) < 60)
    assert len(calls) == 60 and fit.status is FitStatus.CONVERGED
    assert "the hole is too" not in fit.message and "choose a smaller mean curvature, or other sizes" in fit.message


@pytest.mark.parametrize("count, has_corners", [(4, True), (6, True), (24, False), (60, False)])
def test_corners_are_named_only_where_there_are_some(count, has_corners):
    disc = shapes.disc(200)
    points = np.column_stack([disc.positions, 0 * disc.positions[:, 0]])
    goals = Goals.of(disc.domain, points, OutlineOptions(circle(1.0, 0.0, count), mean_curvature=0.5))
    fit = type("Off", (), {"distances": {"rim on curve": 0.5}})
    (sentence,) = goals.unmet(fit)
    assert ("round its corners" in sentence) is has_corners
    assert "choose a smaller mean curvature" in sentence
