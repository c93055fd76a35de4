"""Solve in a window, a little at a time: ticks, Escape, plans that change meanwhile."""

from __future__ import annotations

import bpy

# isort: split
import pytest

from .scenes import quad_disc, snapshot
from .solved_plans import FINISHED


class Hand:
    """Stands in for Blender's operator; the test calls its ticks."""

    def __init__(self, addon, context):
        solve = addon.cmc_addon.operators.solve
        for name in ("modal", "_advance", "_cleanup", "_fail", "_report_cancelled", "read_task", "progress_of"):
            setattr(self, name, getattr(solve.TaskOperator, name).__get__(self))
        self.context, self.reports = context, []
        self.task_settings = lambda plan: addon.cmc_addon.tasks.solve.settings_of(plan.cmc)
        self.selection = lambda: None
        self.bl_label, self._about = "Solve", 0
        self._work, self._timer = solve.TaskOperator.steps(self, context, 0.0), None

    def report(self, kind, text):
        self.reports.append((kind, text))

    def tick(self, kind="TIMER", value="NOTHING"):
        return self.modal(self.context, Event(kind, value))


class Event:
    def __init__(self, kind, value):
        self.type, self.value = kind, value


@pytest.fixture
def hand(addon):
    return Hand(addon, bpy.context)


def test_ticks_until_finished(hand):
    plan = quad_disc(rings=8, columns=32)
    seen, result = [], {"RUNNING_MODAL"}
    while result == {"RUNNING_MODAL"}:
        result = hand.tick()
        seen.append(bpy.context.window_manager.cmc.progress)
    assert result == FINISHED
    assert plan.cmc.f_plus is not None
    assert seen == sorted(seen)
    assert not bpy.context.window_manager.cmc.running


def test_escape_cancels(addon, hand):
    quad_disc(rings=8, columns=32)
    before = snapshot()
    assert hand.tick() == {"RUNNING_MODAL"}
    assert hand.tick("MOUSEMOVE") == {"PASS_THROUGH"}
    assert hand.tick("ESC", "PRESS") == {"CANCELLED"}
    assert snapshot() == before
    assert addon.cmc_addon.background.worker.Running.stop is None
    addon.cmc_addon.background.worker.Running.thread.join(10.0)
    assert not addon.cmc_addon.background.worker.Running.thread.is_alive()


def finish(hand):
    result = {"RUNNING_MODAL"}
    while result == {"RUNNING_MODAL"}:
        result = hand.tick()
    return result


def test_a_plan_changed_meanwhile(hand):
    plan = quad_disc()
    hand.tick()
    plan.data.vertices[0].co.z += 1.0
    assert finish(hand) == {"CANCELLED"}
    assert "'Disc' was changed while it was being solved" in hand.reports[-1][1]
    assert list(bpy.data.objects) == [plan]


def test_a_plan_deleted_meanwhile(hand):
    plan = quad_disc()
    hand.tick()
    bpy.data.objects.remove(plan)
    assert finish(hand) == {"CANCELLED"}
    assert "'Disc' was deleted" in hand.reports[-1][1]


def test_a_plan_renamed_meanwhile(hand):
    plan = quad_disc()
    hand.tick()
    plan.name = "Hall"
    assert finish(hand) == FINISHED
    assert plan.cmc.f_plus.name == "Hall f+"


def test_one_at_a_time(addon, hand):
    quad_disc()
    hand.tick()
    with pytest.raises(RuntimeError, match="A solve is running"):
        bpy.ops.cmc.solve()
    assert finish(hand) == FINISHED
