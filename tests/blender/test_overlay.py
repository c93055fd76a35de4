"""The overlay's frame: for which objects it is drawn, and when it is computed again."""

from __future__ import annotations

import bpy
import numpy as np
import pytest

from .overlay_scenes import disc, frame, layers, only
from .scenes import activate, add_group, mesh_object

BAD = ["three faces", "flat", "not finite", "loose", "wire", "nothing", "all free", "closed"]


@pytest.mark.parametrize("what", BAD)
def test_bad_plans_are_drawn_as_far_as_possible(addon, what):
    points, faces = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)], [(0, 1, 2, 3)]
    if what == "three faces":
        points, faces = [*points, (0, 0, 1), (0, 0, -1)], [(0, 1, 2), (0, 1, 4), (0, 1, 5)]
    if what == "flat":
        points = [(k, 0, 0) for k in range(4)]
    if what == "not finite":
        points[0] = (float("nan"), 0, 0)
    if what == "loose":
        points = [*points, (9, 9, 9)]
    if what in ("wire", "nothing"):
        faces = []
    if what == "closed":
        points, faces = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)], [(0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3)]
    plan = mesh_object(what, [] if what == "nothing" else points, faces, [(0, 1), (1, 2)] if what == "wire" else [])
    add_group(plan, "rim", range(len(plan.data.edges)), "FREE" if what == "all free" else "BINORMAL")
    parts = frame(addon)
    has_lines = what not in ("nothing", "closed")
    assert bool(layers(parts)) == has_lines
    for layer in layers(parts):
        assert np.isfinite(layer.points).all()


def test_a_result_that_is_active_shows_its_plan(addon):
    plan = disc(tilt=0.4)
    bpy.ops.cmc.solve()
    activate(plan.cmc.f_plus)
    only("show_groups")
    assert len(layers(frame(addon))) == 1
    plan.hide_set(True)
    assert not layers(frame(addon)), "of a hidden plan nothing is drawn"


@pytest.fixture
def looked(addon, monkeypatch):
    """Calls that compute a rim."""
    calls = []
    original = addon.cmc_addon.drawing.overlay.prescribed_rim
    monkeypatch.setattr(addon.cmc_addon.drawing.overlay, "prescribed_rim", lambda *a: calls.append(1) or original(*a))
    return calls


def test_it_is_computed_once_per_change(addon, looked):
    plan = disc()
    first = frame(addon)
    for _ in range(3):
        assert frame(addon)[0].layers is first[0].layers
    assert len(looked) == 1
    plan.location.x += 3.0
    moved = frame(addon)
    assert moved[0].layers is first[0].layers and moved[0].matrix.translation.x == 3.0
    bpy.context.scene.cmc.arrow_scale = 0.5
    assert frame(addon)[0].layers is not first[0].layers
    assert len(looked) == 1, "to move a plan, or to change how it is drawn, changes nothing of it"
    for change in (
        lambda: setattr(plan.data.cmc.groups[0], "tilt", 0.3),
        lambda: setattr(plan.cmc, "blend", 1.0),
        lambda: setattr(plan, "scale", (1, 2, 1)),
        lambda: (setattr(plan.data.vertices[100].co, "x", 5.0), plan.data.update()),
        lambda: bpy.ops.object.mode_set(mode="EDIT"),
    ):
        before = len(looked)
        change()
        frame(addon), frame(addon)
        assert len(looked) == before + 1


def test_another_object_that_changes_costs_nothing(addon, looked):
    plan = disc(tilt=0.3)
    bpy.ops.cmc.solve()
    activate(plan)
    frame(addon)
    before = len(looked)
    plan.cmc.f_plus.data.vertices[0].co.z += 1.0
    plan.cmc.f_plus.data.update()
    frame(addon)
    assert len(looked) == before


def test_what_is_slow_waits_for_a_pause(addon, monkeypatch):
    cache = addon.cmc_addon.drawing.overlay_cache
    clock = [100.0]
    monkeypatch.setattr(cache.time, "perf_counter", lambda: clock[0])
    entry = cache._Entry("value", "key", done=100.0, cost=0.001)
    clock[0] = 100.01
    assert entry.is_due("other", clock[0]), "what is quick is not put off"
    slow = cache._Entry("value", "key", done=100.0, cost=0.2)
    for step in range(20):
        assert not slow.is_due(f"key {step}", 101.0 + 0.1 * step), "while it is dragged"
    assert not slow.is_due("key 19", 103.2)
    assert slow.is_due("key 19", 103.4)


def test_handlers_come_and_go(addon):
    names = ["depsgraph_update_post", "frame_change_post", "undo_post", "redo_post", "load_post"]
    before = [len(getattr(bpy.app.handlers, name)) for name in names]
    for _ in range(3):
        addon.cmc_addon.unregister()
        assert [len(getattr(bpy.app.handlers, name)) for name in names] < before
        addon.cmc_addon.register()
    assert [len(getattr(bpy.app.handlers, name)) for name in names] == before
    assert addon.cmc_addon.drawing.overlay_draw.Drawing.handle is None, "nothing is drawn in the background"
