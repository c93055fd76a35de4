"""Colour ramps and ranges: contrast, centre and outliers."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose


@pytest.fixture
def maps(addon):
    from cmc_formfinding.cmc_addon.properties import colour_maps

    return colour_maps


def lightness(srgb) -> np.ndarray:
    """CIE L* of sRGB colours (n, 3)."""
    c = np.asarray(srgb)
    light = np.where(c <= 0.04045, c / 12.92, ((c + 0.055) / 1.055) ** 2.4) @ [0.2126, 0.7152, 0.0722]
    return np.where(light > 0.008856, 116.0 * np.cbrt(light) - 16.0, 903.3 * light)


# What eyes without one of the three kinds of cones see, of linear light (Viénot, Brettel, Mollon 1999).
_BLIND = {
    "protan": [[0.11238, 0.88762, 0.0], [0.11238, 0.88762, 0.0], [0.00401, -0.00401, 1.0]],
    "deutan": [[0.29275, 0.70725, 0.0], [0.29275, 0.70725, 0.0], [-0.02234, 0.02234, 1.0]],
}


def test_the_sequential_ramp_gets_evenly_darker(maps):
    L = lightness(maps.Range(0.0, 1.0).colours(np.linspace(0, 1, 50)))
    assert (np.diff(L) < 0).all()
    assert L[0] > 90 and L[-1] < 25
    assert_allclose(L, np.linspace(L[0], L[-1], 50), atol=6.0)


def test_the_diverging_ramp_is_alike_on_both_sides(maps):
    L = lightness(maps.Range(-1.0, 1.0, 0.0).colours(np.linspace(-1, 1, 101)))
    assert L.argmax() == 50 and L[50] > 90
    assert (np.diff(L[:51]) > 0).all() and (np.diff(L[50:]) < 0).all()
    assert_allclose(L, L[::-1], atol=5.0)


@pytest.mark.parametrize("eyes", _BLIND)
def test_its_sides_differ_without_red_or_green(maps, eyes):
    """Two numbers on different sides differ in the remaining channels."""
    values = np.array([0.3, 0.6, 1.0])
    ramp = maps.Range(-1.0, 1.0, 0.0)
    one, other = (maps.linear(ramp.colours(v)) @ np.transpose(_BLIND[eyes]) for v in (values, -values))
    assert (np.abs(one - other).max(axis=1) > 0.08).all()


def test_ends_centre_and_unknown(maps):
    ramp = maps.Range(1.0, 3.0, 2.0)
    found = ramp.colours([1.0, 2.0, 3.0, 0.0, 9.0, np.nan])
    table = maps.RAMPS["diverging"]
    assert_allclose(found[[0, 1, 2]], table[[0, 3, 6]])
    assert_allclose(found[[3, 4]], table[[0, 6]])
    assert_allclose(found[5], maps.NOT_KNOWN)


def test_one_sided_numbers_have_one_side_of_the_ramp(maps):
    values = np.linspace(0.5, 2.0, 100)
    found = maps.fit_around_zero(values)
    assert (found.low, found.centre) == (0.0, 0.0) and found.high == pytest.approx(1.97, abs=0.02)
    assert found.places(values).min() > 0.5 and found.places(found.high) == 1.0
    both = maps.fit_around_zero(np.linspace(-0.5, 2.0, 100))
    assert both.places(0.0) == 0.5 and 0.3 < both.places(both.low) < 0.5


def test_a_range_about_a_target(maps):
    """As wide on both sides, without the two numbers that are far off; at least as wide as required."""
    values = np.concatenate([np.linspace(0.9, 1.3, 998), [-50.0, 90.0]])
    found = maps.fit_about(values, 1.0, 0.01)
    assert found.low == pytest.approx(2.0 - found.high)
    assert found.high == pytest.approx(1.29, abs=0.01)
    assert found.below and found.above
    exact = maps.fit_about(np.full(20, 1.0), 1.0, 0.01)
    assert (exact.low, exact.high, exact.below, exact.above) == (0.99, 1.01, False, False)


def test_fixed_ranges(maps):
    values = np.linspace(0, 1, 11)
    found = maps.fixed_range(values, 0.8, 0.2, None)
    assert (found.low, found.high, found.below, found.above) == (0.2, 0.8, True, True)
    assert maps.fixed_range(values, 0.0, 1.0, 5.0).centre == 0.5
    empty = maps.fixed_range(values, 2.0, 2.0, None)
    assert empty.high > empty.low


@pytest.mark.parametrize("values", [[], [np.nan], [0.0], [1.0, 1.0]])
def test_hardly_any_numbers(maps, values):
    for found in (
        maps.fit_about(values, 1.0, 0.1), maps.fit_around_zero(values), maps.fit_from(values, 1.0, 0.1)
    ):
        assert found.high > found.low
        assert np.isfinite(found.colours(values)).all()


def test_ticks_and_decimals(maps):
    assert maps.Range(0.0, 1.0, 0.4).ticks() == [0.0, 0.4, 1.0]
    assert maps.Range(0.0, 1.0, 0.01).ticks() == [0.0, 1.0]
    assert maps.decimals([0.0, 0.4, 1.0]) == 2
    assert maps.decimals([1000.0, 3000.0]) == 0
    assert maps.decimals([0.1001, 0.1002]) == 5


def test_the_table_is_the_ramp(maps):
    values = np.append(np.random.default_rng(5).uniform(-2.0, 2.0, 200), np.nan)
    for ramp in (maps.Range(-1.0, 1.5, 0.2), maps.Range(-1.0, 1.5)):
        found = ramp.linear_colours(values)
        assert (found.shape, found.dtype) == ((201, 4), np.float32)
        assert_allclose(found[:, :3], maps.linear(ramp.colours(values)), atol=2e-3)
        assert (found[:, 3] == 1.0).all()


def test_known_rims_fade_out(maps):
    """A row of points, the first one known: its colour, half of it, none."""
    ramp, places = maps.Range(0.0, 1.0), np.array([[0.0, 0, 0], [1, 0, 0], [2, 0, 0], [3, 0, 0]])
    found = ramp.faded_colours([1.0, np.nan, np.nan, np.nan], places, 2.0)
    grey, dark = maps.linear(maps.NOT_KNOWN), maps.linear(maps.RAMPS["sequential"][-1])
    assert_allclose(found[:, :3], [dark, 0.5 * (dark + grey), grey, grey], atol=1e-6)
    for values in ([np.nan] * 4, [0.0, 0.2, 0.4, 0.6]):
        assert_allclose(ramp.faded_colours(values, places, 2.0), ramp.linear_colours(values))


def test_linear_light(maps):
    assert_allclose(maps.linear([0.0, 0.5, 1.0]), [0.0, 0.21404, 1.0], atol=1e-5)
