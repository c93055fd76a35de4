"""Wente's cylinders (paper, Sec. 5.3.3, Figures 13 and 15): exact heights, closing, the family, messages."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.integrate import quad
from scipy.special import ellipj, ellipk

from solver import ConditionError, complete, side_plane, wente
from solver.catalogue import wente_heights
from solver.catalogue.wente_heights import wente_height
from tests.solver.exact_surfaces import rates

EXACT = {60: (2.0891548753, 25.2087), 120: (1.6248255393, 26.8240)}  # degrees → height, energy of the whole cylinder


@pytest.mark.parametrize(("angle", "height"), [(degrees, known[0]) for degrees, known in EXACT.items()])
def test_exact_heights(angle, height):
    assert_allclose(wente_height(np.radians(angle)), height, rtol=0, atol=1e-10)


def test_the_turn_is_the_integral_it_is_said_to_be():
    """∫ 2 cosh(ω/2) with tanh(ω/4) = c cn, in closed form and by quadrature; 240° for the three lobes of θ = 12.79°."""
    around = wente_heights._around()
    assert_allclose(np.degrees(around), 65.354955354, rtol=0, atol=1e-9)
    for theta in np.radians([2.0, 12.78980929, 21.4807, 24.0]):
        m, c2 = np.sin(theta) ** 2, np.tan(theta) * np.tan(around)
        speed = 2.0 * np.sqrt(np.sin(2.0 * around) / np.sin(2.0 * (theta + around)))
        turn = quad(lambda u, m=m, c2=c2: 2.0 / (1.0 - c2 * ellipj(u, m)[1] ** 2) - 1.0, 0.0, ellipk(m))[0]
        assert_allclose(wente_heights._turn(theta), 4.0 * turn / speed, rtol=1e-8, atol=0)
    assert_allclose(np.degrees(wente_heights._turn(np.radians(12.78980929))), 240.0, rtol=0, atol=1e-6)


def test_heights_fall_from_spheres_to_a_straight_cylinder():
    heights = [wente_height(np.radians(angle)) for angle in (1e-4, 1, 30, 60, 90, 120, 150, 179, 179.9999)]
    assert (np.diff(heights) < 0).all() and heights[0] < 2.2289 and heights[-1] < 3e-3


def test_height_and_energy_converge_at_second_order():
    """From a start 10 % off, in six steps of Newton's method at most."""
    height, energy = EXACT[120]
    errors = []
    for n in (12, 24, 48):
        bubble = wente(np.radians(120), n, height=1.1 * height)
        assert bubble.closed and len(bubble.closing.gaps) - 1 <= 6 and bubble.closing.gaps[-1] < 1e-10
        errors.append([bubble.height / height - 1.0, 1.0 - 4.0 * bubble.surface.harmonic.energy / energy])
    assert (rates(errors) > 1.8).all() and (np.array(errors) > 0).all() and max(errors[-1]) < 0.005


def test_small_angles_converge_to_the_exact_height():
    height = wente_height(np.radians(75))
    errors = [wente(np.radians(75), n).height / height - 1.0 for n in (18, 36)]
    assert rates(errors) > 1.8 and 0 < errors[-1] < 0.03


@pytest.mark.parametrize(("angle", "columns", "cylinders"), [(75, 18, 24), (90, 14, 4), (108, 10, 10), (165, 8, 24)])
def test_the_family_closes_from_its_own_start(angle, columns, cylinders):
    bubble = wente(np.radians(angle), columns)
    assert bubble.closed and not bubble.collapsed and len(bubble.closing.gaps) <= 4
    assert bubble.cylinders == cylinders and f"{cylinders} cylinders" in bubble.message
    assert np.abs(bubble.surface.normals[:, 2]).max() > 0.98
    assert 1.0 < bubble.height / wente_height(np.radians(angle)) < 1.15
    edges = bubble.positions[bubble.domain.edges]
    assert_allclose(np.linalg.norm(edges[:, 0] - edges[:, 1], axis=1), bubble.domain.edge_lengths, rtol=1e-12, atol=0)
    assert_allclose(np.ptp(bubble.positions, axis=0), [0.5 * np.pi, bubble.height], rtol=1e-12, atol=0)
    planes = [side_plane(bubble.surface, side) for side in bubble.sides]
    assert all(plane.missed < 1e-6 for plane in planes[:1] + planes[2:])
    assert_allclose(planes[0].offset, planes[1].point[2], rtol=0, atol=5e-3)


def test_angles_that_never_end():
    bubble = wente(2.0, 10)
    assert bubble.closed and bubble.cylinders is None and "never ends" in bubble.message


def test_a_strip_of_bubbles():
    """Off the height that closes, one period of the strip after the other goes along the axis (Figure 13)."""
    bubble = wente(np.radians(120), 12, height=1.2, closed=False)
    assert bubble.closing is None and not bubble.closed and "as given" in bubble.message
    assert_allclose(bubble.height, 1.2, rtol=1e-12, atol=0)
    strip = complete(bubble.surface, bubble.sides[:2], repeat=3)
    assert len(strip.copies) == 12 and strip.lattice.shape == (1, 3)
    assert_allclose(strip.lattice[0, :2], 0, rtol=0, atol=1e-9)
    gap = side_plane(bubble.surface, bubble.sides[1]).point[2] - side_plane(bubble.surface, bubble.sides[0]).offset
    assert_allclose(abs(strip.lattice[0, 2]), 4.0 * abs(gap), rtol=1e-9, atol=0)


def test_a_collapsed_map_is_named_with_the_way_out():
    bubble = wente(np.radians(60), 12)
    assert bubble.collapsed and not bubble.closed
    assert "collapsed into one plane" in bubble.message and "29 columns" in bubble.message
    assert_allclose(bubble.positions[:, 1].max(), bubble.height, rtol=1e-12, atol=0)
    assert not wente(np.radians(60), 29).collapsed


def test_closing_can_be_watched_scaled_and_cancelled():
    seen = []
    bubble = wente(np.radians(120), 8, mean_curvature=2.0, progress=lambda step, gap: seen.append(gap))
    assert len(seen) == len(bubble.closing.gaps) and seen[-1] < 1e-10
    assert_allclose(bubble.surface.scale, 0.25, rtol=1e-12, atol=0)
    assert not wente(np.radians(120), 8, progress=lambda step, gap: False).closed


@pytest.mark.parametrize("angle", [0.0, np.pi, -1.0, 120, np.nan])
def test_other_angles_are_refused(angle):
    with pytest.raises(ConditionError, match="radians"):
        wente(angle, 12)


@pytest.mark.parametrize("options", [{"columns": 3}, {"columns": 8.5}, {"columns": 12, "height": -1.0}])
def test_senseless_numbers_are_refused(options):
    with pytest.raises(ConditionError, match=r"columns|height"):
        wente(2.0, **options)
