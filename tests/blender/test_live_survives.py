"""Live survives what happens to its plan: undo, deletion, other files, modes, duplicates, linked data, two at once."""

from __future__ import annotations

import gc
import random
from contextlib import suppress

import bpy

# isort: split
import numpy as np
import pytest
from numpy.testing import assert_allclose

from .live_driver import EXACT, catch_up, live_disc, move, off_by, settle, start_update, state_of
from .scenes import activate, add_group, boundary_edges, link, positions


@pytest.fixture
def live(addon):
    return addon.cmc_addon.live.live


@pytest.fixture
def plan(live):
    """A live plan at rest."""
    plan = live_disc()
    settle(live)
    bpy.ops.ed.undo_push(message="Live")
    return plan


def group(plan):
    return plan.data.cmc.groups[0]


# --- undo ----------------------------------------------------------------------------------

def test_a_drag_is_one_step_of_undo(addon, live, plan):
    """Blender makes it when the mouse is released; it lacks later updates, which Live repeats after undo."""
    for tilt in (0.4, 0.5, 0.6):
        group(plan).tilt = tilt
        catch_up(live)
    bpy.ops.ed.undo_push(message="Tilt")
    settle(live)
    for step, tilt in ((bpy.ops.ed.undo, 0.3), (bpy.ops.ed.redo, 0.6), (bpy.ops.ed.undo, 0.3)):
        assert step() == {"FINISHED"}
        plan = bpy.data.objects["Disc"]
        assert group(plan).tilt == pytest.approx(tilt)
        settle(live)
        assert off_by(addon, plan) < EXACT


def test_undo_while_it_is_dragged(addon, live, plan):
    group(plan).tilt = 0.6
    bpy.ops.ed.undo_push(message="Tilt")
    group(plan).tilt = 0.9
    live.tick()
    bpy.ops.ed.undo()
    assert live.Live.running is None, "what is for later input is not written any more"
    plan = bpy.data.objects["Disc"]
    settle(live)
    assert off_by(addon, plan) < EXACT


def test_undo_in_edit_mode(addon, live, plan):
    before = positions(plan.cmc.f_plus)
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.select_all(action="SELECT")
    bpy.ops.ed.undo_push(message="Select")
    bpy.ops.transform.resize("EXEC_DEFAULT", True, value=(1.3, 1.0, 1.0))
    settle(live)
    assert off_by(addon, plan) < EXACT
    bpy.ops.ed.undo()
    plan = bpy.data.objects["Disc"]
    settle(live)
    assert off_by(addon, plan) < EXACT
    assert plan.mode == "EDIT"
    assert_allclose(positions(plan.cmc.f_plus), before, rtol=0, atol=1e-5)


def test_undo_of_the_switch(live, plan):
    plan.cmc.live = False
    bpy.ops.ed.undo_push(message="Off")
    settle(live)
    assert not live.Live.states
    bpy.ops.ed.undo()
    assert list(live.Live.states) == [bpy.data.objects["Disc"].session_uid]


def test_an_animated_plan(addon, live, plan):
    for frame, width in ((1, 1.0), (20, 2.0)):
        plan.scale.x = width
        plan.keyframe_insert("scale", frame=frame)
    settle(live)
    bpy.context.scene.frame_set(10)
    assert 1.2 < plan.scale.x < 1.8
    settle(live)
    assert off_by(addon, plan) < EXACT


# --- gone ----------------------------------------------------------------------------------

@pytest.mark.parametrize("how", ["removed", "deleted"])
def test_the_plan_is_deleted_while_it_is_dragged(addon, live, plan, how):
    start_update(live, lambda attempt: setattr(group(plan), "tilt", 0.6 + 0.001 * attempt))
    if how == "removed":
        bpy.data.objects.remove(plan)
    else:
        activate(plan)
        plan.select_set(True)
        bpy.ops.object.delete()
    settle(live)
    assert not live.Live.states and live.Live.running is None
    assert addon.cmc_addon.background.worker.Running.stop is None


def test_the_result_is_deleted_while_it_is_dragged(addon, live, plan):
    group(plan).tilt = 0.6
    live.tick()
    bpy.data.objects.remove(plan.cmc.f_plus)
    settle(live)
    assert off_by(addon, plan) < EXACT


def test_another_file(addon, live, plan, tmp_path):
    group(plan).tilt = 0.6
    catch_up(live)
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "live.blend"))
    group(plan).tilt = 0.9
    live.tick()
    bpy.ops.wm.read_factory_settings(use_empty=True)
    assert live.Live.running is None and not live.Live.states
    import addon_utils

    addon_utils.enable(addon.__name__, default_set=True)
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "live.blend"))
    plan = bpy.data.objects["Disc"]
    assert list(live.Live.states) == [plan.session_uid]
    settle(live)
    assert group(plan).tilt == pytest.approx(0.6) and off_by(addon, plan) < EXACT


def test_the_extension_is_switched_off(addon, live, plan):
    import addon_utils

    group(plan).tilt = 0.6
    live.tick()
    addon_utils.disable(addon.__name__)
    assert live.Live.running is None and not live.Live.states
    assert live._on_change not in bpy.app.handlers.depsgraph_update_post
    addon_utils.enable(addon.__name__, default_set=True)


# --- more than one -------------------------------------------------------------------------

def test_two_plans_take_turns(addon, live, plan):
    other = live_disc("Other", radius=2.0)
    for tilt in (0.4, 0.5, 0.6):
        group(plan).tilt, group(other).tilt = tilt, -tilt
        catch_up(live)
    settle(live)
    for ob in (plan, other):
        assert off_by(addon, ob) < EXACT


def test_a_duplicate_has_results_of_its_own(addon, live, plan):
    before = positions(plan.cmc.f_plus)
    activate(plan)
    bpy.ops.object.select_all(action="DESELECT")
    plan.select_set(True)
    bpy.ops.object.duplicate()
    copy = bpy.context.object
    copy.location.x = 10.0
    group(copy).tilt = 0.8
    settle(live)
    assert copy.cmc.f_plus != plan.cmc.f_plus and copy.cmc.f_plus is not None
    assert_allclose(positions(plan.cmc.f_plus), before, rtol=0, atol=1e-6)
    assert off_by(addon, copy) < EXACT


def test_a_mesh_that_two_plans_share(addon, live, plan):
    """A tilt is the mesh's: both follow. The size is the object's."""
    other = link(bpy.data.objects.new("Other", plan.data))
    other.location.x = 10.0
    other.cmc.size, other.cmc.span, other.cmc.default_kind = "SPAN", 5.0, plan.cmc.default_kind
    other.cmc.live = True
    settle(live)
    group(plan).tilt = 0.6
    settle(live)
    for ob in (plan, other):
        assert off_by(addon, ob) < EXACT
    before = positions(plan.cmc.f_plus)
    other.cmc.span = 6.0
    settle(live)
    assert_allclose(positions(plan.cmc.f_plus), before, rtol=0, atol=1e-6)
    assert off_by(addon, other) < EXACT


def test_a_plan_of_another_file(live, plan, tmp_path):
    """It cannot be written: only a line in the panel says so."""
    path = str(tmp_path / "library.blend")
    bpy.data.libraries.write(path, {plan})
    bpy.ops.wm.read_factory_settings(use_empty=True)
    import addon_utils

    addon_utils.enable("cmc_formfinding", default_set=True)
    with bpy.data.libraries.load(path, link=True) as (_, wanted):
        wanted.objects = ["Disc"]
    linked = link(bpy.data.objects["Disc"])
    assert linked.cmc.live and not linked.is_editable
    settle(live)
    live.changed(linked)
    settle(live)
    assert "linked from another file" in live.problem_of(linked)


# --- problems ------------------------------------------------------------------------------

def test_a_problem_is_a_line_and_the_last_shell_stays(addon, live, plan):
    before = positions(plan.cmc.f_plus)
    add_group(plan, "Rest", boundary_edges(plan.data)[12:], "FREE")
    group(plan).kind = "FREE"
    settle(live)
    assert "free" in live.problem_of(plan)
    assert_allclose(positions(plan.cmc.f_plus), before, rtol=0, atol=0)
    group(plan).kind = "BINORMAL"
    settle(live)
    assert live.problem_of(plan) == "" and off_by(addon, plan) < EXACT


def test_a_plan_that_breaks_while_it_is_dragged(addon, live, plan):
    """A face without area on the way: the shell waits until it has one again."""
    here = np.array(plan.data.vertices[30].co)
    move(plan, 30, np.array(plan.data.vertices[31].co) - here)
    catch_up(live)
    assert live.problem_of(plan)
    move(plan, 30, here - np.array(plan.data.vertices[31].co))
    settle(live)
    assert live.problem_of(plan) == "" and off_by(addon, plan) < EXACT


def test_a_result_in_edit_mode(addon, live, plan):
    activate(plan.cmc.f_plus)
    bpy.ops.object.mode_set(mode="EDIT")
    group(plan).tilt = 0.6
    settle(live)
    assert "edit mode" in live.problem_of(plan)
    bpy.ops.object.mode_set(mode="OBJECT")
    group(plan).tilt = 0.61
    settle(live)
    assert off_by(addon, plan) < EXACT


def test_a_solve_by_hand_goes_first(addon, live, plan):
    group(plan).tilt = 0.6
    live.tick()
    assert bpy.ops.cmc.solve(flip=True) == {"FINISHED"}
    settle(live)
    assert plan.cmc.flip and off_by(addon, plan) < EXACT


# --- many edits ----------------------------------------------------------------------------

def test_many_edits(addon, live, plan):
    """As `benchmarks/live_session.py edits` does a thousand: nothing is left behind, and the end is right."""
    many_edits(live, "Disc", count=40, seed=3)
    plan = bpy.data.objects["Disc"]
    settle(live)
    assert off_by(addon, plan) < EXACT
    gc.collect()
    assert len(bpy.data.meshes) == 2 and len(bpy.data.objects) == 2
    assert state_of(live, plan).grade == addon.cmc_addon.live.update.FINAL


def many_edits(live, name: str, count: int, seed: int) -> None:
    """Tilts, H, vertices inside and on the rim, undo and redo; between them Live ticks, or not."""
    dice = random.Random(seed)
    for _ in range(count):
        plan = bpy.data.objects[name]
        what = dice.choice(["tilt", "tilt", "H", "vertex", "vertex", "undo", "redo"])
        if what == "tilt":
            group(plan).tilt = dice.uniform(-0.8, 0.8)
        elif what == "H":
            plan.cmc.size, plan.cmc.mean_curvature = "MEAN_CURVATURE", dice.uniform(0.1, 0.4)
        elif what == "vertex":
            index = dice.randrange(len(plan.data.vertices))
            move(plan, index, (dice.uniform(-0.05, 0.05), dice.uniform(-0.05, 0.05), 0.0))
        elif (bpy.ops.ed.undo if what == "undo" else bpy.ops.ed.redo).poll():
            with suppress(RuntimeError):  # there is nothing
                (bpy.ops.ed.undo if what == "undo" else bpy.ops.ed.redo)()
            continue
        bpy.ops.ed.undo_push(message=what)
        turn = dice.choice(["not", "once", "catch up"])
        if turn == "once":
            live.tick()
        elif turn == "catch up":
            catch_up(live)
