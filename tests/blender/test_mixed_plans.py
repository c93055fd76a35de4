"""The plans of `tests.mixed_plans` in Blender: their sides as groups, solved and dragged."""

from __future__ import annotations

import json

import numpy as np
import pytest

from tests.mixed_plans import LINE_OFF, MIXED_PLANS, MixedPlan, misses

from .live_driver import EXACT, catch_up, move, off_by, settle, state_of
from .scenes import add_group, mesh_object, positions
from .solved_plans import solved

DRAGGED = 0.02
"""How far a line may be off by the span while it is dragged."""


def drawn(mixed: MixedPlan, max_edge: float = 0.28):
    """The plan in the scene, and its mesh."""
    from cmc_formfinding.solver import shapes

    points, triangles, pairs = mixed.mesh(shapes, max_edge)
    plan = mesh_object("Hall", points, triangles)
    plan.cmc.default_kind = "LINE"
    plan.cmc.size, plan.cmc.rise = "RISE", mixed.rise
    edge_of = {frozenset(edge.vertices): edge.index for edge in plan.data.edges}
    for name, (kind, parameters) in mixed.sides.items():
        edges = [edge_of[frozenset(pair)] for pair in pairs[name].tolist()]
        turned = {key: value if key == "normal" else np.radians(value) for key, value in parameters.items()}
        add_group(plan, name, edges, kind.upper(), **turned)
    return plan, (points, triangles, pairs)


@pytest.mark.parametrize("mixed", MIXED_PLANS, ids=lambda mixed: mixed.name)
def test_every_side_is_as_asked_or_told(addon, mixed):
    plan, mesh = drawn(mixed)
    points = solved(plan)
    report = json.loads(plan.cmc.report)
    assert report["converged"], report["sentence"]
    assert mixed.off_line(points, *mesh) < (LINE_OFF if mixed.is_fitted else 1e-3)
    assert ("sides" in report, "span" in report) == (mixed.is_fitted, not mixed.is_fitted)
    assert not misses(report, {warning["code"] for warning in report["warnings"]})


def lean_more(plan, _mesh) -> None:
    """By a degree."""
    group = plan.data.cmc.groups[0]
    if group.kind in ("LEAN", "BINORMAL"):
        name = {"LEAN": "angle", "BINORMAL": "tilt"}[group.kind]
        setattr(group, name, getattr(group, name) + np.radians(1.0))
    elif group.kind == "PLANE":
        _, y, z = group.normal
        tilt = np.arctan2(z, -y) + np.radians(1.0)
        group.normal = (0.0, -np.cos(tilt), np.sin(tilt))


def rise_more(plan, _mesh) -> None:
    plan.cmc.rise += 0.01


def raise_a_point(plan, mesh) -> None:
    """On the line at the back, half an edge up."""
    back = int(np.abs(mesh[0][:, :2] - [9.0, 12.0]).sum(axis=1).argmin())
    move(plan, back, (0.0, 0.0, 0.02))
    mesh[0][back, 2] += 0.02


@pytest.mark.parametrize("mixed", MIXED_PLANS, ids=lambda mixed: mixed.name)
def test_live_is_whole_while_dragged_and_at_rest_where_a_solve_is(addon, mixed):
    live = addon.cmc_addon.live.live
    plan, mesh = drawn(mixed, 0.7)
    plan.cmc.live = True
    settle(live)
    for change in (lean_more, rise_more, raise_a_point):
        for _ in range(2):
            change(plan, mesh)
            catch_up(live)
            assert state_of(live, plan).problem == ""
            assert len(plan.cmc.f_plus.data.vertices) == len(mesh[0]), "torn open"
            assert mixed.off_line(positions(plan.cmc.f_plus), *mesh) < DRAGGED
        settle(live)
        assert off_by(addon, plan) < EXACT
