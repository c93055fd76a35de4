"""Add > Mesh > CMC > Vault: a shell on four feet that touches four walls."""

from __future__ import annotations

import json

import bpy
import numpy as np
import pytest
from numpy.testing import assert_allclose

from .scenes import positions
from .sidebar import draw

FINISHED = {"FINISHED"}


@pytest.mark.parametrize("slenderness", [0.0, 1.0])
def test_it_stands_on_the_floor_and_touches_the_walls(slenderness):
    assert bpy.ops.cmc.add_module(module="VAULT", slenderness=slenderness, edges=20) == FINISHED
    plan = bpy.context.object
    assert_allclose(plan.dimensions, (8.0, 8.0, 0.0), atol=1e-5)
    assert bpy.ops.cmc.solve() == FINISHED
    report = json.loads(plan.cmc.report)
    assert report["converged"] and report["warnings"] == []
    planes = {plane["name"]: plane for plane in report["planes"]}
    assert set(planes) == {f"{name}{k}" for name in ("Wall", "Foot") for k in range(4)}
    assert all(plane["relative"] < 1e-6 for plane in planes.values())
    feet = [planes[f"Foot{k}"]["offset"] for k in range(4)]
    assert_allclose(feet, feet[0], atol=2e-2)
    assert np.ptp(positions(plan.cmc.f_plus)[:, 2]) > 3.0


def test_it_is_not_repeated():
    """Walls and floor end it, so there is nothing to repeat and no complaint about that."""
    bpy.ops.cmc.add_module(module="VAULT", edges=12)
    assert "cmc.complete" not in draw().operators
