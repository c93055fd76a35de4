"""Moulds: the law of spherical moulds on five shells, and panels laid on the moulds that were found."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

from solver import ConditionError, moulds, panel_net, shapes, span_outline
from solver.errors import Interrupted
from solver.nets.assembly import net_of
from solver.nets.field import line_field
from solver.nets.moulds import _laid, covered
from solver.nets.patches import frames, height, local, quads, quartic, samples, sphere_quartic
from tests.solver.nets import exact_sheets as exact
from tests.solver.nets.test_panel_net import span

SHELLS = {
    "square": lambda: panel_net(span("square", 0.2), count=300),
    "its twin": lambda: panel_net(span("square", 0.2), count=300, sheet="f-"),
    "L": lambda: panel_net(span("L", 0.2), count=400),
    "hanging ring": lambda: panel_net(span("ring", -0.4, 0.3), count=300),
    "nodoid": lambda: net_of(line_field(exact.nodoid(64)[0], None, 300, "principal", "f+")),
}


def shapes_of(net):
    panels = quads(net)
    points = samples(net, panels)
    return local(points, *frames(net, panels, points))


@pytest.mark.parametrize("name", SHELLS)
def test_all_panels_depart_from_one_sphere_alike(name):
    net = SHELLS[name]()
    off = _laid(sphere_quartic(net.mean_curvature), shapes_of(net))
    assert np.median(off) == pytest.approx(net.sphere_gap, rel=0.04)
    assert_allclose(np.quantile(off, [0.1, 0.9]), net.sphere_gap, rtol=0.1)
    areas = net.area[quads(net)]
    assert areas.max() > 2.0 * areas.min(), "though their sizes differ"


def test_panels_lie_on_their_moulds():
    net = SHELLS["L"]()
    panels = quads(net)
    counts = []
    for part in (1.2, 0.5, 0.2):
        tolerance = part * net.sphere_gap
        numbers, off = covered(net, tolerance)
        assert (off[panels] <= tolerance).all()
        assert (numbers[panels] >= 0).all() and (np.delete(numbers, panels) == -1).all()
        assert np.array_equal(np.unique(numbers[panels]), np.arange(numbers.max() + 1))
        assert np.array_equal(moulds(net, tolerance), numbers)
        counts.append(numbers.max() + 1)
    assert counts[0] <= 2 and counts[0] <= counts[1] <= counts[2] > 4


def test_a_moved_panel_lies_on_its_own_surface():
    net = SHELLS["square"]()
    points = shapes_of(net)[:40]
    surface = quartic(points[0], np.ones(25))
    angle = 0.05
    turned = points[0] @ np.array([[np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0], [0, 0, 1]]).T
    own = _laid(surface, points[:1])[0]
    assert _laid(surface, (turned + [0.01, -0.01, 0.01])[None])[0] < own + 0.02 * net.sphere_gap
    assert _laid(surface, (points[0] * [-1.0, -1.0, 1.0])[None])[0] < own + 0.02 * net.sphere_gap
    assert (_laid(surface, points) >= 0.0).all()


def test_heights_and_slopes():
    random = np.random.default_rng(3)
    coefficients = random.normal(size=15)
    x, y = random.uniform(-1.0, 1.0, (2, 50))
    z, zx, zy = height(coefficients, x, y)
    assert_allclose(quartic(np.stack([x, y, z], axis=1), np.ones(50)), coefficients, rtol=1e-9)
    h = 1e-6
    assert_allclose(zx, (height(coefficients, x + h, y)[0] - height(coefficients, x - h, y)[0]) / (2 * h), atol=1e-7)
    assert_allclose(zy, (height(coefficients, x, y + h)[0] - height(coefficients, x, y - h)[0]) / (2 * h), atol=1e-7)


def test_samples_lie_on_the_surface():
    sheet, _ = exact.catenoid(96)
    net = net_of(line_field(sheet, None, 200, "principal", "f+"))
    points = samples(net, quads(net)).reshape(-1, 3)
    assert np.abs(np.hypot(points[:, 0], points[:, 1]) - np.cosh(points[:, 2])).max() < 2e-4


def test_cancelled():
    with pytest.raises(Interrupted):
        moulds(SHELLS["square"](), 1e-4, progress=lambda count, left: count < 1)


def test_refusals():
    shape = shapes.polygon([[0, 0], [4, 0], [4, 4], [0, 4]], max_edge=0.4, corner_radius=0.8)
    surface = span_outline(shape, shape.positions, mean_curvature=0.2)
    with pytest.raises(ConditionError, match="sheets f\\+ and f-"):
        moulds(panel_net(surface, count=50, sheet="g"), 0.01)
    with pytest.raises(ConditionError, match="tolerance of moulds"):
        moulds(panel_net(surface, count=50), 0.0)


def test_few_moulds_serve_a_ring():
    net = SHELLS["hanging ring"]()
    assert moulds(net, 0.25 * net.sphere_gap).max() + 1 <= 3


def test_the_sphere_of_the_law():
    x, y = np.random.default_rng(1).uniform(-0.3, 0.3, (2, 50))
    z, _, _ = height(sphere_quartic(0.8), x, y)
    exact_z = np.sqrt(1.0 / 0.8**2 - x**2 - y**2) - 1.0 / 0.8
    assert_allclose(z, exact_z, atol=0.8**5 * 0.18**3 / 10.0)
