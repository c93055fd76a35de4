"""Nets of panels on spanning surfaces and exact ones: topology, planarity, curvature of their lines, sides."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from numpy.testing import assert_allclose

from solver import (
    ConditionError,
    Net,
    Shape,
    Span,
    curvature_lines,
    panel_net,
    preview_net,
    shapes,
    span_outline,
)
from solver.nets.assembly import net_of
from solver.nets.field import line_field
from solver.nets.isothermic import Isothermic
from solver.nets.quantise import _Lattice, quantised
from tests.solver.exact_surfaces import rates
from tests.solver.nets import exact_sheets as exact
from tests.solver.nets.net_checks import faults, gaps

SQUARE = [[0, 0], [4, 0], [4, 4], [0, 4]]
HOLES = [[[0.8, 0.8], [1.6, 0.8], [1.6, 1.6], [0.8, 1.6]], [[2.3, 2.2], [3.1, 2.2], [3.1, 3.0], [2.3, 3.0]]]
PLANS = {
    "square": lambda edge: shapes.polygon(SQUARE, max_edge=edge, corner_radius=0.8),
    "sharp square": lambda edge: shapes.polygon(SQUARE, max_edge=edge),
    "L": lambda edge: shapes.polygon(
        [[0, 0], [4, 0], [4, 2], [2, 2], [2, 4], [0, 4]], max_edge=0.9 * edge, corner_radius=0.4
    ),
    "rectangle": lambda edge: shapes.polygon(
        [[0, 0], [4, 0], [4, 1.3], [0, 1.3]], max_edge=0.6 * edge, corner_radius=0.3
    ),
    "courtyard": lambda edge: shapes.polygon(SQUARE, HOLES[:1], max_edge=edge, corner_radius=0.3),
    "two holes": lambda edge: shapes.polygon(SQUARE, HOLES, max_edge=edge, corner_radius=0.3),
    "ring": lambda edge: shapes.annulus(0.4, 1.0, int(20.0 / edge**2)),
}


@cache
def plan(name: str, edge: float = 0.2) -> Shape:
    return PLANS[name](edge)


@cache
def span(name: str, H: float, lift: float = 0.0, edge: float = 0.2) -> Span:
    """A span over a plan whose holes are lifted, or whose rim is wavy where there is none."""
    shape = plan(name, edge)
    x, y = shape.positions.T
    z = lift * np.sin(2.0 * x) * np.cos(y)
    if len(shape.domain.boundary_loops) > 1:
        z = np.zeros(len(x))
        for loop in shape.domain.boundary_loops[1:]:
            z[loop] = lift
    found = span_outline(shape, np.column_stack([x, y, z]), mean_curvature=H)
    assert found.ok, found.message
    return found


CASES = [
    ("square", 0.2, 0.0), ("square", -0.2, 0.3), ("square", 0.0, 0.3), ("sharp square", 0.2, 0.0),
    ("L", 0.2, 0.0), ("L", 0.0, 0.3), ("rectangle", 0.5, 0.0), ("courtyard", 0.2, 0.0), ("courtyard", -0.2, 0.3),
    ("courtyard", 0.0, 0.3), ("two holes", 0.2, 0.0), ("two holes", 0.0, 0.3), ("ring", 0.0, 0.3), ("ring", 0.4, 0.0),
    ("ring", -0.4, 0.3),
]


@pytest.mark.parametrize("kind", ["principal", "diagonal"])
@pytest.mark.parametrize("case", CASES, ids=lambda case: f"{case[0]}, H {case[1]}, lift {case[2]}")
def test_nets_are_right(case, kind):
    surface = span(*case)
    for count in (60, 300, 1000):
        net = panel_net(surface, count=count, kind=kind)
        assert not faults(net), count
        assert net.ok and 0.8 * count < len(net.polygons) < 1.25 * count
        if kind == "principal" and count == 300:
            few = net.orders.sum() <= 2
            assert np.median(gaps(net)) < (4e-4 if few else 1.5e-3)


def turned(surface: Span, count: int, angle: float) -> Net:
    """The net whose lines are turned by an angle against the curvature lines."""
    field = line_field(surface, None, count, "principal", "f+")
    coordinates = field.coordinates
    isothermic = Isothermic.of(coordinates.isothermic.cut, angle)
    step = float(np.sqrt(np.prod(coordinates.spacings)))
    return net_of(replace(field, coordinates=quantised(isothermic, step, []), sides=[]))


@pytest.mark.parametrize(
    ("name", "H", "lift", "times"), [("square", 0.2, 0.0, 5.0), ("L", 0.2, 0.0, 2.0), ("ring", 0.4, 0.0, 5.0)]
)
def test_principal_panels_are_flatter_than_turned_ones(name, H, lift, times):
    surface = span(name, H, lift, 0.13)
    net, other = panel_net(surface, count=300), turned(surface, 300, np.radians(4.0))
    assert not faults(other)
    assert np.median(gaps(other)) > times * np.median(gaps(net))


@pytest.mark.parametrize(
    "case", [("square", 0.2, 0.0), ("square", 0.0, 0.3), ("ring", -0.4, 0.3), ("L", 0.2, 0.0)], ids=str
)
def test_the_diagonal_net_has_normal_curvature_h(case):
    surface = span(*case, 0.1)
    net = panel_net(surface, count=300, kind="diagonal")
    whole = net.family >= 0
    largest = max(abs(case[1]), float(np.median(net.curvature)))
    assert np.median(net.normal_curvature[whole]) == pytest.approx(case[1], abs=5e-3 * largest)


def test_nodes_of_principal_nets_hardly_twist():
    torsion = []
    for count in (100, 400, 1600):
        torsion.append(float(np.median(panel_net(span("square", 0.2, 0.0, 0.1), count=count).torsion)))
    assert torsion[0] < 2e-3
    assert rates(torsion).mean() > 1.2
    assert np.median(panel_net(span("square", 0.2), count=100, kind="diagonal").torsion) > 20.0 * torsion[0]


@pytest.mark.parametrize(("make", "H"), [(exact.nodoid, 0.5), (exact.catenoid, 0.0)])
def test_sides_follow_the_law(make, H):
    """Sides are spacing / √(k1 - k2) along both families."""
    sheet, _ = make(64)
    net = net_of(line_field(sheet, None, 400, "principal", "f+"))
    assert not faults(net)
    ratios = []
    for panel in net.inner:
        p = net.vertices[net.polygons[panel]]
        side = np.linalg.norm(p - np.roll(p, -1, axis=0), axis=1).mean()
        ratios.append(side * np.sqrt(2.0 * (net.curvature[panel] - H)) / net.spacings.mean())
    assert_allclose(np.median(ratios), 1.0, atol=0.02)
    assert np.quantile(ratios, 0.95) - np.quantile(ratios, 0.05) < 0.06


def test_the_spacing_is_the_median_side():
    net = panel_net(span("square", 0.2), 0.25)
    assert net.spacing == pytest.approx(0.25)
    assert np.median(net.side_lengths) == pytest.approx(0.25, rel=0.25)


@pytest.mark.parametrize("size", [{"spacing": 0.2}, {"count": 400}], ids=str)
def test_a_preview_tells_the_net(size):
    surface = span("square", 0.2)
    preview, net = preview_net(surface, **size), panel_net(surface, **size)
    assert preview.spacing == pytest.approx(net.spacing, rel=0.15)
    assert preview.panels == pytest.approx(len(net.polygons), rel=0.35)
    assert preview.sphere_gap == pytest.approx(net.sphere_gap, rel=0.3)
    sides = net.side_lengths
    assert_allclose(preview.sides, np.quantile(sides[sides > 0.1], [0.05, 0.95]), rtol=0.35)


def test_exact_panels_on_a_catenoid():
    """Parallels and meridians of a surface of revolution bound planar trapezoids, and rims are lines of the net."""
    sheet, _ = exact.catenoid(96)
    net = net_of(line_field(sheet, None, 300, "principal", "f+"))
    assert {len(polygon) for polygon in net.polygons} == {4}
    assert np.degrees(net.deviation) < 0.02
    assert gaps(net).max() < 2e-4
    heights = net.vertices[:, 2]
    levels = np.unique(np.round(heights, 2))
    assert np.abs(heights[:, None] - levels).min(axis=1).max() < 5e-3


def test_sheets_share_the_combinatorics():
    surface = span("square", 0.2)
    on, off = (line_field(surface, None, 100, "principal", sheet) for sheet in ("f+", "g"))
    assert_allclose(on.coordinates.values, off.coordinates.values)
    net = panel_net(surface, count=100, sheet="g")
    assert net.sheet == "g" and net.ok and np.median(gaps(net)) < 1e-3


def test_arguments():
    surface = span("square", 0.2)
    with pytest.raises(ConditionError, match="either the spacing"):
        panel_net(surface)
    with pytest.raises(ConditionError, match="either the spacing"):
        panel_net(surface, 0.3, count=100)
    with pytest.raises(ConditionError, match="positive number"):
        panel_net(surface, -1.0)
    with pytest.raises(ConditionError, match='no kind of net "diagnal"; did you mean "diagonal"'):
        panel_net(surface, 0.3, kind="diagnal")
    with pytest.raises(ConditionError, match="No line crosses the surface"):
        panel_net(surface, 30.0)
    with pytest.raises(ConditionError, match="No line crosses the surface"):
        curvature_lines(surface, 30.0)
    with pytest.raises(ConditionError, match="choose a spacing of at least"):
        panel_net(surface, 1e-3)


def test_lines_run_from_rim_to_rim_or_close():
    surface = span("ring", 0.4)
    lines = curvature_lines(surface, 0.1)
    around = [line for line in lines if line.closed]
    across = [line for line in lines if not line.closed]
    assert {line.family for line in around} == {1} and {line.family for line in across} == {0}
    for line in across:
        radius = np.linalg.norm(line.ends[:, :2], axis=1)
        assert_allclose(np.sort(radius), [0.4, 1.0], atol=4e-3)
    exact_ones = curvature_lines(surface, 0.1, quantised=False)
    assert abs(len(exact_ones) - len(lines)) <= 2
    assert sum(line.length for line in exact_ones) == pytest.approx(sum(line.length for line in lines), rel=0.04)


def test_exact_lines_keep_their_distance():
    surface = span("L", 0.2)
    lines = curvature_lines(surface, 0.25, quantised=False)
    assert all(not line.closed and len(line.points) > 2 for line in lines)
    starts = [np.array([line.ends[0] for line in lines if line.family == family]) for family in (0, 1)]
    for points in starts:
        apart = np.linalg.norm(points[:, None] - points[None], axis=2) + np.eye(len(points))
        assert apart.min() > 0.05


def test_whole_numbers_are_near():
    """Against the nearest of all whole numbers around, on lattices that are far from square."""
    random = np.random.default_rng(5)
    box = np.stack(np.meshgrid(*[np.arange(-2, 3)] * 4, indexing="ij"), axis=-1).reshape(-1, 4)
    worse = []
    for _ in range(40):
        A = random.normal(size=(4, 4)) + np.eye(4)
        upper = np.linalg.cholesky(A @ A.T).T
        v = random.uniform(-5.0, 5.0, 4)
        numbers = _Lattice(upper).nearest(v)
        assert np.array_equal(numbers, np.rint(numbers))
        least = np.linalg.norm((numbers + box - v) @ upper.T, axis=1).min()
        worse.append(np.linalg.norm(upper @ (numbers - v)) / least)
    assert np.median(worse) == pytest.approx(1.0) and np.mean(worse) < 1.1
