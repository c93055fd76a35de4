"""Nets on random plans: 60 rounded ones, some with sharp corners."""

from __future__ import annotations

import pytest

from solver import panel_net
from tests.solver.nets.net_checks import faults
from tests.solver.nets.random_plans import shell

ROUNDED, SHARP = range(60), range(1000, 1010)


@pytest.mark.parametrize("seed", ROUNDED)
def test_rounded_plans(seed):
    surface = shell(seed, vertices=400)
    if surface is None:
        pytest.skip("no surface over this plan")
    kind = ("principal", "diagonal")[seed % 2]
    for count in ((100, 300), (300, 1000))[seed // 2 % 2]:
        assert not faults(panel_net(surface, count=count, kind=kind)), count


@pytest.mark.parametrize("seed", SHARP)
def test_sharp_plans(seed):
    surface = shell(seed, vertices=400, rounded=False)
    if surface is None:
        pytest.skip("no surface over this plan")
    assert not faults(panel_net(surface, count=300))
