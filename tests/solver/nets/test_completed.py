"""Nets that go on across mirrors: welded by adjacency, with umbilics as nodes where mirrors meet at 60°."""

from __future__ import annotations

import numpy as np
import pytest

from solver import ConditionError, Side, complete, conditions, modules, panel_net, planarise, solve_cmc
from tests.solver.nets.net_checks import gaps


@pytest.fixture(scope="module")
def honeycomb():
    module = modules.node(3, 2.4, max_edge=0.15)
    shape, normals = module.shape, module.normals
    held = sum((conditions.mirror(shape, name, normals[name]) for name in normals), conditions.Conditions())
    sides = [Side(name, shape.sides[name], "mirror", normals[name]) for name in normals]
    return complete(solve_cmc(shape, held), sides)


@pytest.mark.parametrize("count", [300, 1500])
def test_a_honeycomb(honeycomb, count):
    net = panel_net(honeycomb, count=count)
    assert not net.clipped.any() and {len(polygon) for polygon in net.polygons} == {4}
    assert net.counted == net.euler_characteristic == -2
    edges = np.sort(net.edges, axis=1)
    assert len(np.unique(edges, axis=0)) == len(edges) and not len(net.flipped)
    valence = np.bincount(net.edges.ravel())
    inner = np.setdiff1d(np.arange(len(net.vertices)), net.rim)
    assert (valence[inner] == 6).sum() == 4 and np.isin(valence[inner], (4, 6)).all()
    assert np.median(gaps(net)) < 1.5e-3
    ends = np.concatenate([np.column_stack([p, np.roll(p, -1)]) for p in net.polygons])
    assert len(np.unique(ends, axis=0)) == len(ends), "neighbours walk an edge in opposite directions"


def test_lines_go_on(honeycomb):
    """At each inner node of valence four opposite edges are of one family."""
    net = panel_net(honeycomb, count=300)
    count = np.zeros((len(net.vertices), 2), dtype=int)
    for (i, j), family in zip(net.edges, net.family, strict=True):
        if family >= 0:
            count[i, family] += 1
            count[j, family] += 1
    inner = np.setdiff1d(np.arange(len(net.vertices)), net.rim)
    regular = inner[count[inner].sum(axis=1) == 4]
    assert (count[regular] == 2).all()


def test_planar_panels(honeycomb):
    assert planarise(panel_net(honeycomb, count=300)).flatness < 1e-10


def test_refusals(honeycomb):
    with pytest.raises(ConditionError, match="principal nets go on"):
        panel_net(honeycomb, count=300, kind="diagonal")
