"""Nets with flat panels: planar and parallel on f+, g and f-, to rounding."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from solver import ConditionError, panel_net, planarise, shapes, span_outline
from solver.nets.planarise import _Equations
from tests.solver.nets.net_checks import faults, gaps

PLANS = {
    "square": ([[0, 0], [4, 0], [4, 4], [0, 4]], 0.035, 0.15),
    "L": ([[0, 0], [4, 0], [4, 2], [2, 2], [2, 4], [0, 4]], 0.06, 0.2),
}


def net_over(name: str, count: int = 120):
    shape = shapes.polygon(PLANS[name][0], max_edge=0.2, corner_radius=0.5)
    return panel_net(span_outline(shape, shape.positions, mean_curvature=0.2), count=count)


@pytest.mark.parametrize("keep_rim", [False, True])
@pytest.mark.parametrize("name", PLANS)
def test_panels_are_flat_and_parallel(name, keep_rim):
    net = net_over(name)
    flat = planarise(net, keep_rim=keep_rim)
    assert flat.flatness < 1e-10 and not faults(flat)
    for part in (0.0, 0.5, 1.0):  # f+, g and f-
        offset = replace(flat, vertices=flat.vertices - part / flat.mean_curvature * flat.axes)
        assert gaps(offset).max() < 1e-9
    if not keep_rim:
        assert (flat.planarity / flat.diagonal).max() < 1e-9, "clipped panels, too"
    inside = {tuple(sorted(pair)) for panel in net.inner for pair in _pairs(flat.polygons[panel])}
    of_lines = flat.edges[flat.family >= 0]
    whole = np.array([tuple(sorted(pair)) in inside for pair in of_lines.tolist()])
    assert flat.torsion[whole].max() < 1e-9
    assert_allclose(np.linalg.norm(flat.axes, axis=1), 1.0, atol=0.015)
    side = np.median(net.side_lengths)
    inner = np.setdiff1d(np.arange(len(net.vertices)), net.rim)
    median, most = PLANS[name][1:]
    assert np.median(flat.moved[inner]) < median * side and flat.moved[inner].max() < most * side
    if keep_rim:
        assert flat.moved[net.rim].max() == 0.0
    else:
        assert 0.0 < flat.moved[net.rim].max() < 0.25 * side


def _pairs(polygon):
    corners = polygon.tolist()
    return zip(corners, corners[1:] + corners[:1], strict=True)


def test_the_derivatives():
    net = net_over("L", 60)
    equations = _Equations.of(net, False)
    random = np.random.default_rng(0)
    X, axes = net.vertices + 0.01 * random.normal(size=net.vertices.shape), net.normals
    step = random.normal(size=(len(X), 6))
    J = equations.jacobian(X, axes)
    base = np.linalg.norm
    h = 1e-6
    ahead, behind = (equations.residual(X + s * h * step[:, :3], axes + s * h * step[:, 3:]) for s in (1.0, -1.0))
    finite = (ahead - behind) / (2.0 * h)
    # distances are divided by an area that the derivative holds
    count = len(equations.planar)
    heights = equations.residual(X, axes)[:count]
    a, b, c, _ = (X[equations.planar[:, k]] for k in range(4))
    da, db, dc, _ = (step[equations.planar[:, k], :3] for k in range(4))
    normal = np.cross(b - a, c - a)
    turned = np.cross(db - da, c - a) + np.cross(b - a, dc - da)
    area = np.einsum("pi,pi->p", normal, turned) / base(normal, axis=1) ** 2
    finite[:count] += heights * area
    assert_allclose(J @ step.ravel(), finite, rtol=1e-6, atol=1e-7)


def test_cancelled():
    net = net_over("square", 60)
    seen = []

    def stop(step: int, left: float) -> bool:
        seen.append(left)
        return step < 1

    flat = planarise(net, progress=stop)
    assert len(seen) == 2 and seen[1] < seen[0]
    assert flat.flatness == pytest.approx(seen[1]) and flat.flatness > 1e-9


def test_from_the_net_itself_and_where_there_is_none():
    shape = shapes.polygon(PLANS["square"][0], max_edge=0.3, corner_radius=0.5)
    span = span_outline(shape, shape.positions, mean_curvature=0.2)
    assert panel_net(span, count=60, planar=True).flatness < 1e-10
    with pytest.raises(ConditionError, match="triangulate them"):
        panel_net(span, count=60, kind="diagonal", planar=True)
