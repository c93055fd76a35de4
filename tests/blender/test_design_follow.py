"""Follow: the fitted shell follows the numbers of its plan, newest first, and leaves nothing behind."""

from __future__ import annotations

import time

import bpy

# isort: split
import numpy as np
import pytest
from numpy.testing import assert_allclose

from .design_scenes import FINISHED, fitted, report, small_disc
from .scenes import activate, positions


@pytest.fixture
def follow(addon):
    return addon.cmc_addon.live.follow


@pytest.fixture
def plan(follow):
    """A fitted plan whose shell follows."""
    plan = small_disc()
    plan.cmc.follow = True
    fitted(plan, fit_rise=0.4)
    run(follow)
    bpy.ops.ed.undo_push(message="fitted")
    return plan


def run(follow, seconds: float = 20.0) -> int:
    """Turn the crank as the timer does, until there is nothing more to do; how often."""
    ticks = 1
    while follow.tick() is not None:
        ticks += 1
        assert ticks < seconds / 0.005, "never ends"
        time.sleep(0.005)
    return ticks


def height(plan) -> float:
    return positions(plan.cmc.fit)[:, 2].max()


def test_the_shell_follows_its_number(follow, plan):
    """From flat to hemisphere and back, the outline kept."""
    for rise in (0.6, 1.0, 0.2):
        plan.cmc.fit_rise = rise
        run(follow)
        assert height(plan) == pytest.approx(4.0 * rise, rel=5e-3)
        assert report(plan)["distances"]["rim on curve"] < 0.01 * 8.0
        assert plan.cmc.fit_rise == pytest.approx(rise)
        ball = (4.0 + 4.0 * rise**2) / (2.0 * rise)
        points = positions(plan.cmc.fit) - [0, 0, height(plan) - ball]
        assert_allclose(np.linalg.norm(points, axis=1), ball, rtol=0.025, atol=0)


def test_other_settings_count_too(follow, plan):
    plan.cmc.hanging = True
    run(follow)
    assert positions(plan.cmc.fit)[:, 2].min() == pytest.approx(-1.6, rel=5e-3)
    plan.cmc.fit_volume = 40.0
    assert run(follow) == 1, "a number that is not chosen by does not count"
    plan.cmc.height_parameter = "VOLUME"
    run(follow)
    assert report(plan)["distances"]["volume"] < 0.05


@pytest.fixture
def written(addon, monkeypatch):
    """Every task that is written, and its fit."""
    task, written = addon.cmc_addon.tasks.fit_outline.FitTask, []
    real = task.write
    monkeypatch.setattr(task, "write", lambda self, *args: written.append((self, args[2].fit)) or real(self, *args))
    return written


def test_the_newest_number_wins(follow, plan, written):
    """A fit that is out of date is cut short, but not before it has got anywhere; on lines that is often its end."""
    for k in range(20):
        plan.cmc.fit_rise = 0.61 + 0.01 * k
        follow.tick()
    run(follow)
    assert height(plan) == pytest.approx(3.2, rel=5e-3)
    assert 2 <= len(written) < 20
    (first, cut), (last, whole) = written[0], written[-1]
    assert first.newer.is_set() and len(cut.history) < 10
    assert cut.status.value == "converged" or len(cut.history) >= 5
    assert last.settings.fit_rise == pytest.approx(0.8) and not last.newer.is_set() and whole.is_met


def test_it_goes_on_from_the_last_fit(follow, plan, written):
    for rise in (0.45, 0.5):
        plan.cmc.fit_rise = rise
        run(follow)
    (_, earlier), (task, _) = written
    assert task.initial is earlier
    plan.data.vertices[0].co.x += 0.1  # another plan: the last fit is none of it
    plan.cmc.fit_rise = 0.55
    run(follow)
    assert written[-1][0].initial is None
    assert height(plan) == pytest.approx(2.2, rel=5e-3)


def test_only_where_it_is_asked_for(follow, plan):
    before = positions(plan.cmc.fit)
    plan.cmc.follow = False
    plan.cmc.fit_rise = 0.8
    run(follow)
    assert_allclose(positions(plan.cmc.fit), before, rtol=0, atol=0)
    plan.cmc.follow = True  # what has been changed meanwhile counts
    run(follow)
    assert height(plan) == pytest.approx(3.2, rel=5e-3)
    never = small_disc("Never fitted")
    never.cmc.follow = True
    never.cmc.fit_rise = 0.8
    run(follow)
    assert never.cmc.fit is None


def test_one_step_of_undo(follow, plan):
    name = plan.name
    plan.cmc.fit_rise = 0.8
    bpy.ops.ed.undo_push(message="Rise")  # as the slider does
    run(follow)
    for step, rise in ((bpy.ops.ed.undo, 0.4), (bpy.ops.ed.redo, 0.8), (bpy.ops.ed.undo, 0.4)):
        step()
        step()
        plan = bpy.data.objects[name]
        assert plan.cmc.fit_rise == pytest.approx(rise) and height(plan) == pytest.approx(4.0 * rise, rel=5e-3)
    plan.cmc.fit_rise = 0.8  # the last fit was for this, but it is not what is there
    run(follow)
    assert height(plan) == pytest.approx(3.2, rel=5e-3)


def test_undo_while_it_runs(follow, plan, addon):
    """It stops; and the number that undo has brought back can be changed again."""
    name = plan.name
    plan.cmc.fit_rise = 0.8
    bpy.ops.ed.undo_push(message="Rise")
    follow.tick()
    bpy.ops.ed.undo()
    assert addon.cmc_addon.background.worker.Running.stop is None
    plan = bpy.data.objects[name]
    assert height(plan) == pytest.approx(1.6, rel=5e-3)
    plan.cmc.fit_rise = 0.8
    run(follow)
    assert height(plan) == pytest.approx(3.2, rel=5e-3)


@pytest.mark.parametrize("what", ["plan", "fit"])
def test_deleted_while_it_runs(follow, plan, what, addon):
    plan.cmc.fit_rise = 0.8
    follow.tick()
    bpy.data.objects.remove(plan if what == "plan" else plan.cmc.fit)
    before = sorted(ob.name for ob in bpy.data.objects)
    run(follow)
    assert sorted(ob.name for ob in bpy.data.objects) == before
    assert addon.cmc_addon.background.worker.Running.stop is None


def test_it_gives_way_to_a_solve(follow, plan):
    plan.cmc.fit_rise = 0.8
    follow.tick()
    activate(plan)
    assert bpy.ops.cmc.solve() == FINISHED
    run(follow)
    assert plan.cmc.f_plus is not None
    assert height(plan) == pytest.approx(3.2, rel=5e-3)


def test_what_goes_wrong_is_said(follow, plan):
    plan.cmc.fit_to = "CURVE"
    run(follow)
    assert "'Disc' has no curve" in follow.problem_of(plan)
    plan.cmc.fit_to = "OUTLINE"
    run(follow)
    assert follow.problem_of(plan) == ""


def test_a_new_file_forgets(follow, plan, addon):
    plan.cmc.fit_rise = 0.8
    follow.tick()
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    assert addon.cmc_addon.tasks.fit_outline.Latest.fit is None
    assert follow.tick() is None and addon.cmc_addon.background.worker.Running.stop is None


def test_a_tick_is_short(follow, plan):
    """Whatever the fit does, the window is stopped only to write its shell."""
    longest = 0.0
    plan.cmc.fit_rise = 0.9
    going = True
    while going:
        start = time.perf_counter()
        going = follow.tick() is not None
        longest = max(longest, time.perf_counter() - start)
        time.sleep(0.002)
    assert longest < 0.25
