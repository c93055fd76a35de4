"""Angles of boundary groups end at half a turn, beyond which the solver takes a number for degrees."""

from __future__ import annotations

import bpy
import numpy as np
import pytest

from . import scenes


@pytest.mark.parametrize("degrees", [200.0, -180.0])
def test_a_tilt_past_half_a_turn_stops_there_and_solves(degrees):
    plan = scenes.quad_disc()
    rim = scenes.boundary_edges(plan.data)
    group = scenes.add_group(plan, "Rim", rim, "BINORMAL", tilt=np.radians(degrees))
    assert np.degrees(group.tilt) == pytest.approx(np.clip(degrees, -180.0, 180.0), abs=1e-4)
    scenes.activate(plan)
    assert bpy.ops.cmc.solve() == {"FINISHED"}
