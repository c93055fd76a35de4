"""Live: after any change the shell is where Solve would put it, and during a drag nearly there."""

from __future__ import annotations

import json
from threading import Event

import bpy

# isort: split
import numpy as np
import pytest

from .live_driver import EXACT, catch_up, live_disc, move, off_by, settle, state_of
from .scenes import add_group, boundary_edges, positions, quad_ring


@pytest.fixture
def live(addon):
    return addon.cmc_addon.live.live


@pytest.fixture
def plan(live):
    """A live plan at rest."""
    plan = live_disc()
    settle(live)
    return plan


def group(plan):
    return plan.data.cmc.groups[0]


def kind(plan):
    group(plan).kind = "FREE"


def membership(plan):
    attribute = plan.data.attributes["cmc_group"]
    for edge in boundary_edges(plan.data)[:8]:
        attribute.data[int(edge)].value = 0
    plan.data.update()


CHANGES = {
    "a tilt": lambda plan: setattr(group(plan), "tilt", 0.5),
    "a kind": kind,
    "membership": membership,
    "a new group": lambda plan: add_group(plan, "Flat", boundary_edges(plan.data)[-6:], "BINORMAL", tilt=1.0),
    "the size": lambda plan: setattr(plan.cmc, "size", "SPAN"),
    "H": lambda plan: (setattr(plan.cmc, "size", "MEAN_CURVATURE"), setattr(plan.cmc, "mean_curvature", 0.35)),
    "the blend": lambda plan: setattr(plan.cmc, "blend", 2.0),
    "flip": lambda plan: setattr(plan.cmc, "flip", True),
    "the sheet": lambda plan: setattr(plan.cmc, "sheet", "F_MINUS"),
    "the energy": lambda plan: (setattr(plan.cmc, "sites", "FACES"), setattr(plan.cmc, "energy", "MOBIUS")),
    "faces": lambda plan: setattr(plan.cmc, "combinatorics", "DUAL"),
    "a vertex": lambda plan: move(plan, 30, (0.1, -0.05, 0.0)),
    "the rim": lambda plan: move(plan, 100, (0.2, 0.1, 0.3)),
    "the object": lambda plan: setattr(plan, "location", (3.0, 1.0, 2.0)),
    "its scale": lambda plan: setattr(plan, "scale", (1.5, 1.0, 1.0)),
    "a modifier": lambda plan: (
        setattr(plan.modifiers.new("Finer", "SUBSURF"), "levels", 1), setattr(plan.cmc, "apply_modifiers", True)),
}


@pytest.mark.parametrize("what", CHANGES)
def test_it_follows(addon, live, plan, what):
    CHANGES[what](plan)
    catch_up(live)
    if plan.cmc.combinatorics == "PRIMAL":
        assert off_by(addon, plan) < 1e-3, "while it is dragged"
    settle(live)
    assert state_of(live, plan).problem == ""
    before = positions(getattr(plan.cmc, plan.cmc.sheet.lower()))
    assert bpy.ops.cmc.solve() == {"FINISHED"}
    after = positions(getattr(plan.cmc, plan.cmc.sheet.lower()))
    assert np.abs(after - before).max() < EXACT * np.linalg.norm(np.ptp(after, axis=0))


def test_all_that_is_wanted_follows(live, plan):
    for name in ("want_twin", "want_g", "want_gauss"):
        setattr(plan.cmc, name, True)
    settle(live)
    roles = ("f_plus", "f_minus", "g", "gauss")
    before = {role: positions(getattr(plan.cmc, role)) for role in roles}
    group(plan).tilt = 0.5
    catch_up(live)
    assert all(np.abs(positions(getattr(plan.cmc, role)) - before[role]).max() > 0.01 for role in roles)
    plan.cmc.want_g = False
    settle(live)
    assert plan.cmc.g.hide_viewport and not plan.cmc.gauss.hide_viewport


@pytest.mark.parametrize("mode", ["OBJECT", "EDIT"])
def test_a_long_drag(addon, live, plan, mode):
    """Each update of a drag starts from the last one and reuses the factors of an earlier plan."""
    bpy.ops.object.mode_set(mode=mode)
    for _ in range(6):
        move(plan, 25, (0.05, 0.02, 0.0))
        move(plan, 110, (0.08, 0.0, 0.05))
        catch_up(live)
        assert state_of(live, plan).grade == addon.cmc_addon.live.update.QUICK
        assert off_by(addon, plan) < 1e-3
    settle(live)
    assert off_by(addon, plan) < EXACT
    bpy.ops.object.mode_set(mode="OBJECT")
    settle(live)
    assert off_by(addon, plan) < EXACT


def test_other_polygons(addon, live, plan):
    """A new topology, in edit mode, with a material and a custom layer of the result that stay."""
    plan.cmc.f_plus.data.materials.append(bpy.data.materials.new("Concrete"))
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.select_all(action="SELECT")
    bpy.ops.mesh.subdivide()
    catch_up(live)
    assert len(plan.cmc.f_plus.data.vertices) > 400
    move(plan, 12, (0.05, 0.0, 0.0))
    catch_up(live)
    settle(live)
    bpy.ops.object.mode_set(mode="OBJECT")
    assert off_by(addon, plan) < EXACT
    assert plan.cmc.f_plus.data.materials[0].name == "Concrete"


def test_a_ring_that_is_cut_open(addon, live):
    plan = quad_ring()
    plan.cmc.live = True
    settle(live)
    edges = boundary_edges(plan.data)
    rim = add_group(plan, "Inner", [e for e in edges if plan.data.edges[e].vertices[0] < 24], "BINORMAL", tilt=0.2)
    settle(live)
    rim.tilt = 0.6
    catch_up(live)
    settle(live)
    assert off_by(addon, plan) < EXACT


def test_the_newest_wins(addon, live, plan, monkeypatch):
    """Twenty quick changes give a few updates, each newer than the one before, the last one for the last change."""
    tasks, reported = addon.cmc_addon.live.update, []
    for cls in (tasks.QuickTask, tasks.FullTask):
        def write(self, *args, real=cls.write):
            reported.append(self.reading.solve.groups[0].parameters["tilt"])
            return real(self, *args)
        monkeypatch.setattr(cls, "write", write)
    for k in range(20):
        group(plan).tilt = 0.31 + 0.01 * k
        live.tick()
    settle(live)
    assert reported == sorted(reported) and len(reported) < 20
    assert reported[-1] == pytest.approx(0.5)
    assert off_by(addon, plan) < EXACT


def test_slow_measures_are_made_once(addon, live, plan, monkeypatch):
    import importlib

    sheet = importlib.import_module(f"{addon.__name__}.solver.measure.sheet")
    calls, real = [], sheet.self_intersections
    monkeypatch.setattr(sheet, "self_intersections", lambda *args: calls.append(1) or real(*args))
    before = plan.cmc.report
    for tilt in (0.4, 0.45, 0.5):
        group(plan).tilt = tilt
        catch_up(live)
    assert not calls and plan.cmc.report == before
    settle(live)
    assert len(calls) == 2, "once each sheet"
    assert json.loads(plan.cmc.report)["message"]


def test_large_plans_get_a_coarse_update_first(addon, live, plan, monkeypatch):
    monkeypatch.setattr(live, "limit", lambda: 50)
    grades, write = [], live._write
    monkeypatch.setattr(live, "_write", lambda *args: grades.append(args[3].grade) or write(*args))
    group(plan).tilt = 0.6
    catch_up(live)
    assert off_by(addon, plan) < 0.05
    settle(live)
    work = addon.cmc_addon.live.update
    assert grades == [work.COARSE, work.QUICK, work.FINAL]
    assert off_by(addon, plan) < EXACT


def test_what_is_at_rest_gives_way(addon, live, plan, monkeypatch):
    """A change cancels the last update at once, here one that waits, since it could end before the tick looks."""
    group(plan).tilt = 0.4
    catch_up(live)
    released, task = Event(), addon.cmc_addon.live.update.FullTask
    work = task.work
    monkeypatch.setattr(task, "work", lambda self, progress: released.wait(30.0) and work(self, progress))
    state = state_of(live, plan)
    state.since = state.served = 0.0
    live.tick()
    assert live.Live.running is not None and live.Live.can_wait
    group(plan).tilt = 0.5
    live.tick()
    assert live.Live.running is None or not live.Live.can_wait
    released.set()
    settle(live)
    assert off_by(addon, plan) < EXACT


def test_nothing_without_being_asked(live, plan):
    plan.cmc.live = False
    settle(live)
    assert not live.Live.states
    before = positions(plan.cmc.f_plus)
    group(plan).tilt = 0.6
    settle(live)
    assert np.array_equal(positions(plan.cmc.f_plus), before)
    plan.cmc.live = True
    settle(live)
    assert np.abs(positions(plan.cmc.f_plus) - before).max() > 0.01


def test_at_rest_there_are_no_ticks(live, plan):
    assert settle(live) == 1
    plan.select_set(True)
    plan.name = "Hall"
    assert settle(live) <= 2 and live.Live.running is None


@pytest.mark.parametrize("how", ["edit mode", "modifiers"])
def test_reading_is_not_taken_for_a_change(live, plan, how):
    """Reading such a plan tells Blender that it has changed, which must not be read again."""
    if how == "edit mode":
        bpy.ops.object.mode_set(mode="EDIT")
    else:
        plan.modifiers.new("Finer", "SUBSURF").levels = 1
        plan.cmc.apply_modifiers = True
    move(plan, 30, (0.02, 0.0, 0.0))
    settle(live)
    for _ in range(3):
        bpy.context.view_layer.update()
        live.tick()
    bpy.context.view_layer.update()
    assert not state_of(live, plan).is_dirty and settle(live) == 1


def test_colours_go_along(addon, live, plan):
    plan.cmc.colour_by = "MEAN_CURVATURE"
    group(plan).tilt = 0.5
    catch_up(live)
    mesh = plan.cmc.f_plus.data
    assert "cmc_mean_curvature" in mesh.attributes and "cmc_gauss_curvature" not in mesh.attributes
    settle(live)
    assert "cmc_gauss_curvature" in mesh.attributes


OTHER_SHELLS = {
    "sites": "VERTICES", "energy": "MOBIUS", "delaunay": True, "averaging": "AREA", "method": "FLOW", "side": "BACK",
    "shell": "BUBBLE", "sheet": "F_MINUS", "combinatorics": "CORNER", "want_twin": True,
}
"""Settings that say which shell is meant, and another value of each."""


@pytest.mark.parametrize("name", OTHER_SHELLS)
def test_another_shell_begins_anew(addon, live, plan, monkeypatch, name):
    """Not from the map at hand, though that of another energy, say, could be continued."""
    plan.cmc.sites = "FACES"
    settle(live)
    continued, update = [], addon.cmc_addon.live.update.update
    spy = lambda *args, **options: continued.append(name) or update(*args, **options)  # noqa: E731
    monkeypatch.setattr(addon.cmc_addon.live.update, "update", spy)
    setattr(plan.cmc, name, OTHER_SHELLS[name])
    catch_up(live)
    assert not continued
    plan.cmc.combinatorics = "PRIMAL"
    settle(live)
    group(plan).tilt = 0.5
    catch_up(live)
    assert continued
