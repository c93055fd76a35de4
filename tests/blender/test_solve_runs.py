"""Running Solve: settings, undo and redo, the kept solver, cancelling, errors."""

from __future__ import annotations

import threading

import bpy

# isort: split
import pytest

from .scenes import activate, add_group, boundary_edges, positions, quad_disc, snapshot
from .solved_plans import FINISHED, extent, solved


def test_settings_are_the_objects_unless_given():
    """The settings of a call win and stay with the plan; another plan does not get them."""
    plan, other = quad_disc("One"), quad_disc("Other")
    solved(plan, size="HEIGHT", height=2.0)
    assert (plan.cmc.size, plan.cmc.height) == ("HEIGHT", 2.0)
    assert extent(solved(plan))[2] == pytest.approx(2.0, rel=1e-5)
    solved(other)
    assert other.cmc.size == "MATCH_PLAN"


def test_every_setting_is_an_operator_property(addon):
    names = {p.identifier for p in bpy.ops.cmc.solve.get_rna_type().properties}
    assert set(addon.cmc_addon.properties.settings.SETTINGS) <= names
    names = {p.identifier for p in bpy.ops.cmc.solve_selection.get_rna_type().properties}
    assert {*addon.cmc_addon.properties.settings.SETTINGS, "kind", "tilt", "normal", "m"} <= names


@pytest.mark.parametrize("mode", ["OBJECT", "EDIT"])
def test_undo_and_redo(mode):
    quad_disc()
    bpy.ops.object.mode_set(mode=mode)
    bpy.ops.ed.undo_push(message="before")
    assert bpy.ops.cmc.solve("EXEC_DEFAULT", True) == FINISHED
    assert "Disc f+" in bpy.data.objects
    bpy.ops.ed.undo()
    assert "Disc f+" not in bpy.data.objects
    assert bpy.data.objects["Disc"].cmc.f_plus is None
    bpy.ops.ed.redo()
    plan = bpy.data.objects["Disc"]
    assert plan.cmc.f_plus == bpy.data.objects["Disc f+"]


def test_again_with_other_settings_after_undo():
    """What the redo panel does: undo, then the same call with changed properties, from the same plan."""
    quad_disc()
    bpy.ops.ed.undo_push(message="before")
    bpy.ops.cmc.solve("EXEC_DEFAULT", True)
    bpy.ops.ed.undo()
    activate(bpy.data.objects["Disc"])
    bpy.ops.cmc.solve("EXEC_DEFAULT", True, size="HEIGHT", height=2.0)
    assert [ob.name for ob in bpy.data.objects] == ["Disc", "Disc f+"]
    assert extent(positions(bpy.data.objects["Disc f+"]))[2] == pytest.approx(2.0, rel=1e-5)


def test_invoke_in_background_blocks():
    plan = quad_disc()
    assert bpy.ops.cmc.solve("INVOKE_DEFAULT") == FINISHED
    assert plan.cmc.f_plus is not None


def test_on_a_result_its_plan_is_solved():
    plan = quad_disc()
    solved(plan)
    activate(plan.cmc.f_plus)
    bpy.ops.cmc.solve(want_g=True)
    assert plan.cmc.g is not None
    assert plan.cmc.f_plus.cmc.f_plus is None
    assert len(bpy.data.objects) == 3


def test_nothing_running_to_cancel():
    assert bpy.ops.cmc.cancel() == {"CANCELLED"}


def test_a_second_solve_factors_nothing(addon, monkeypatch):
    """A plan that has not moved keeps its solver, whatever its conditions; a moved vertex makes a new one."""
    plan_cache = addon.cmc_addon.background.plan_cache
    made, real = [], plan_cache.CmcSolver
    monkeypatch.setattr(plan_cache, "CmcSolver", lambda domain, **kind: made.append(kind) or real(domain, **kind))
    plan_cache.forget()
    plan = quad_disc()
    solved(plan)
    add_group(plan, "Rim", boundary_edges(plan.data)[:5], "BINORMAL", tilt=0.3)
    solved(plan, size="HEIGHT", height=2.0)
    assert len(made) == 1
    plan.data.vertices[0].co.z = 0.1
    solved(plan)
    assert len(made) == 2


def test_cancelled_changes_nothing(addon, monkeypatch):
    solve, worker = addon.cmc_addon.tasks.solve, addon.cmc_addon.background.worker
    plan = quad_disc()
    solved(plan)
    add_group(plan, "Rim", boundary_edges(plan.data)[:5], "BINORMAL", tilt=0.3)
    real = solve.form.form

    def form(*args, **keywords):
        worker.cancel()
        return real(*args, **keywords)

    monkeypatch.setattr(solve.form, "form", form)
    before = snapshot()
    assert bpy.ops.cmc.solve() == {"CANCELLED"}
    assert snapshot() == before
    assert worker.Running.stop is None


def test_an_error_that_nobody_expected(addon, monkeypatch, capfd):
    """It ends in a sentence with its traceback in the console, and leaves nothing behind."""
    solve = addon.cmc_addon.tasks.solve

    def form(*args, **keywords):
        raise ZeroDivisionError("a mistake")

    monkeypatch.setattr(solve.form, "form", form)
    quad_disc()
    before = snapshot()
    with pytest.raises(RuntimeError) as caught:
        bpy.ops.cmc.solve()
    assert "An error of the program itself (ZeroDivisionError: a mistake); please report it" in str(caught.value)
    assert "Traceback" not in str(caught.value) and "Traceback" in capfd.readouterr().err
    assert snapshot() == before


def test_cancelled_while_it_measures(addon):
    """Nobody waits for work without further steps; the next solve starts when it has ended."""
    worker = addon.cmc_addon.background.worker
    order, gate, begun = [], threading.Event(), threading.Event()

    def slow(progress):
        begun.set()
        gate.wait(10.0)
        order.append("slow")

    first = worker.steps(slow, 1e-6, 0.01)
    assert next(first) is None
    assert begun.wait(10.0)
    worker.cancel()
    with pytest.raises(StopIteration) as end:
        next(first)
    assert end.value.value is None
    second = worker.steps(lambda progress: order.append("next"), 1e-6, 0.01)
    assert next(second) is None
    gate.set()
    for update in second:
        assert update is None
    assert order == ["slow", "next"]
