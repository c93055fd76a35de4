"""Solve, Solve from Selection, Flip, Cancel: what they form, their settings, undo, and how they run."""

from __future__ import annotations

import json
import threading

import bpy

# isort: split
import numpy as np
import pytest
from numpy.testing import assert_allclose

from .scenes import activate, add_group, boundary_edges, mesh_object, positions, quad_disc, quad_ring, snapshot, values

FINISHED = {"FINISHED"}


def solved(plan, role="f_plus", **settings) -> np.ndarray:
    """World points of a result after a solve."""
    activate(plan)
    assert bpy.ops.cmc.solve(**settings) == FINISHED
    return positions(getattr(plan.cmc, role))


def extent(points: np.ndarray) -> np.ndarray:
    return np.ptp(points, axis=0)


@pytest.mark.parametrize("mode", ["OBJECT", "EDIT"])
def test_a_disc_becomes_a_hemisphere(mode):
    """Outward conormals: f+ is the hemisphere over the disc, with its normals and its curvature 1/R."""
    plan = quad_disc(rings=12, columns=48)
    bpy.ops.object.mode_set(mode=mode)
    points = solved(plan)
    assert plan.mode == mode
    assert_allclose(np.linalg.norm(points, axis=1), 4.0, rtol=0, atol=0.03)
    assert_allclose(points[:, 2].min(), 0.0, rtol=0, atol=1e-6)
    mesh = plan.cmc.f_plus.data
    normals = np.array(values(mesh.attributes["cmc_normal"]))
    assert_allclose(np.linalg.norm(normals, axis=1), 1.0, rtol=0, atol=1e-6)
    assert_allclose(normals, points / 4.0, rtol=0, atol=0.02)
    curvature = np.array(values(mesh.attributes["cmc_mean_curvature"]))
    assert_allclose(np.median(curvature), 0.25, rtol=0.01, atol=0)
    outward = np.array([polygon.normal for polygon in mesh.polygons])
    centres = np.array([polygon.center for polygon in mesh.polygons])
    assert (np.einsum("ij,ij->i", outward, centres) > 0).all()
    assert all(polygon.use_smooth for polygon in mesh.polygons)


def test_polygons_of_any_kind():
    """Triangles, quads and hexagons in one plan; every one of them is a polygon of the result."""
    n = 6
    points = [(x - n / 2, y - n / 2, 0.0) for y in range(n + 1) for x in range(n + 1)]
    faces = []
    for y in range(n):
        for x in range(0, n, 2):
            a = y * (n + 1) + x
            b = a + n + 1
            if y % 3 == 0:
                faces.append((a, a + 1, a + 2, b + 2, b + 1, b))
            elif y % 3 == 1:
                faces += [(a, a + 1, b + 1, b), (a + 1, a + 2, b + 2, b + 1)]
            else:
                faces += [(a, a + 1, b + 1), (a, b + 1, b), (a + 1, a + 2, b + 2, b + 1)]
    plan = mesh_object("Any", points, faces)
    shell = solved(plan)
    drawn = [tuple(p.vertices) for p in plan.data.polygons]
    assert [tuple(p.vertices) for p in plan.cmc.f_plus.data.polygons] == drawn
    inside = np.setdiff1d(np.arange(49), np.unique([plan.data.edges[e].vertices for e in boundary_edges(
        plan.data)]))
    assert (shell[inside, 2] > 0.1).all()
    assert shell[:, 2].max() > 0.1 * n


def test_transforms_are_respected():
    """A rotated and unevenly scaled object gives what its own points in world space give."""
    plan = quad_disc("Moved", rings=6)
    plan.location, plan.rotation_euler, plan.scale = (5.0, 3.0, 2.0), (0.0, 0.0, 0.7), (2.0, 1.0, 1.0)
    bpy.context.view_layer.update()
    baked = mesh_object("Baked", positions(plan), [tuple(p.vertices) for p in plan.data.polygons])
    assert_allclose(solved(plan), solved(baked), rtol=0, atol=1e-4)
    assert tuple(plan.cmc.f_plus.location) == pytest.approx((5.0, 3.0, 2.0))
    assert tuple(plan.cmc.f_plus.scale) == (1.0, 1.0, 1.0)


def test_a_mirrored_plan_stands_up_too():
    plan = quad_disc(rings=6)
    expected = solved(plan)
    plan.scale = (-1.0, 1.0, 1.0)
    points = solved(plan)
    assert_allclose(points[:, 2], expected[:, 2], rtol=0, atol=1e-5)
    mesh = plan.cmc.f_plus.data
    assert all(p.normal.dot(p.center) > 0 for p in mesh.polygons)


def test_far_from_the_origin():
    plan = quad_disc(rings=6)
    expected = solved(plan)
    plan.location = (1000.0, -2000.0, 50.0)
    assert_allclose(solved(plan) - [1000.0, -2000.0, 50.0], expected, rtol=0, atol=2e-3)


def test_modifiers_if_chosen():
    """The result then has the modified plan's polygons, and is that of the plan with the modifier applied."""
    plan = quad_disc(columns=16)
    plan.modifiers.new("Subdivision", "SUBSURF").levels = 1
    assert len(solved(plan)) == 81
    points = solved(plan, apply_modifiers=True)
    assert not plan.cmc.f_plus.modifiers
    bpy.ops.object.modifier_apply(modifier="Subdivision")
    assert_allclose(solved(plan, apply_modifiers=False), points, rtol=0, atol=1e-5)


# --- size and place ------------------------------------------------------------------------

SIZES = {
    "span": ({"size": "SPAN", "span": 20.0}, lambda p, ob: extent(p)[:2].max(), 20.0, 0.01),
    "rise": ({"size": "RISE", "rise": 3.0}, lambda p, ob: extent(p)[2], 3.0, 1e-5),
    "radius": ({"size": "RADIUS", "radius": 7.0}, lambda p, ob: 1 / report(ob)["target"], 7.0, 1e-6),
    "H": ({"size": "MEAN_CURVATURE", "mean_curvature": 0.5}, lambda p, ob: report(ob)["target"], 0.5, 1e-6),
}


def report(plan) -> dict:
    import json

    found = json.loads(plan.cmc.f_plus["cmc_report"])
    return found["sheets"]["f+"]["mean_curvature"]


@pytest.mark.parametrize("name", SIZES)
def test_sizes(name):
    settings, measure, expected, tolerance = SIZES[name]
    plan = quad_disc(rings=8, columns=32)
    assert measure(solved(plan, **settings), plan) == pytest.approx(expected, rel=tolerance)


def test_ground():
    """With tilted boundary planes the lowest point is inside; it, or the rim, is on the plan's plane."""
    plan = quad_disc(rings=8, columns=32)
    plan.location.z = 1.5
    rim = boundary_edges(plan.data)
    add_group(plan, "Low", rim[: len(rim) // 2], "BINORMAL", tilt=-0.6)
    lowest = solved(plan, ground="LOWEST")
    assert lowest[:, 2].min() == pytest.approx(1.5, abs=1e-5)
    outline = np.unique([plan.data.edges[e].vertices for e in rim])
    rim_heights = solved(plan, ground="RIM")[outline, 2]
    assert rim_heights.mean() == pytest.approx(1.5, abs=0.02)
    assert rim_heights.min() < 1.5 - 0.1


def test_flip_hangs_and_stands():
    plan = quad_disc(rings=6)
    up = solved(plan)
    assert bpy.ops.cmc.flip() == FINISHED
    down = positions(plan.cmc.f_plus)
    assert plan.cmc.flip
    assert extent(down)[2] == pytest.approx(extent(up)[2], rel=1e-5)
    summit = np.argmax(up[:, 2])
    assert down[summit, 2] == pytest.approx(down[:, 2].min())
    bpy.ops.cmc.flip()
    assert_allclose(positions(plan.cmc.f_plus), up, rtol=0, atol=1e-5)


def test_the_sheet_that_is_shown():
    """With tilted planes f- is a surface as well: shown, it is placed over the plan, f+ by the same map."""
    plan = quad_disc(rings=8, columns=32)
    rim = boundary_edges(plan.data)
    add_group(plan, "Tilted", rim[: len(rim) // 2], "BINORMAL", tilt=0.7)
    solved(plan, sheet="F_MINUS", want_twin=True)
    minus = positions(plan.cmc.f_minus)
    assert minus[:, 2].min() == pytest.approx(0.0, abs=1e-5)
    assert not plan.cmc.f_plus.hide_viewport
    solved(plan, sheet="F_PLUS", want_twin=False)
    assert positions(plan.cmc.f_plus)[:, 2].min() == pytest.approx(0.0, abs=1e-5)
    assert plan.cmc.f_minus.hide_viewport


def test_g_and_the_gauss_image():
    plan = quad_disc(rings=8, columns=32)
    plus = solved(plan, want_g=True, want_gauss=True)
    gauss = positions(plan.cmc.gauss)
    normals = np.array(values(plan.cmc.f_plus.data.attributes["cmc_normal"]))
    radius = np.linalg.norm(gauss - gauss.mean(axis=0) * 0, axis=1)
    assert_allclose(gauss, radius[:, None] * normals, rtol=0, atol=1e-4)
    # f+ = g + N/(2H): the Gauss image is of radius 1/(2H)
    g = positions(plan.cmc.g)
    assert_allclose(plus - g, gauss, rtol=0, atol=1e-4)
    assert "cmc_mean_curvature" not in plan.cmc.g.data.attributes


# --- groups and selection ------------------------------------------------------------------

def test_groups_of_every_kind():
    """Normals at the rim are what the groups say; boundary edges in no group are vertical."""
    plan = quad_disc(rings=8, columns=32)
    edges = {frozenset(e.vertices): e.index for e in plan.data.edges}
    rim = [edges[frozenset((225 + k, 225 + (k + 1) % 32))] for k in range(32)]
    add_group(plan, "Plane", rim[0:4], "PLANE", normal=(0.6, 0.0, 0.8))
    add_group(plan, "Tilt", rim[8:12], "BINORMAL", tilt=np.pi / 6)
    add_group(plan, "Free", rim[16:20], "FREE")
    solved(plan)
    normals = np.array(values(plan.cmc.f_plus.data.attributes["cmc_normal"]))[225:]
    assert_allclose(normals[1:4], [(0.6, 0.0, 0.8)] * 3, rtol=0, atol=1e-5)
    assert_allclose(normals[9:12, 2], 0.5, rtol=0, atol=1e-5)
    assert_allclose(normals[24:31, 2], 0.0, rtol=0, atol=1e-5)
    assert (np.abs(normals[17:20, 2]) > 1e-3).all()


def select(plan, edges) -> None:
    for edge in plan.data.edges:
        edge.select = edge.index in edges


@pytest.mark.parametrize("kind, parameters", [
    ("BINORMAL", {"tilt": 0.6}), ("PLANE", {"normal": (0.0, 0.6, 0.8)})])
def test_solve_from_selection(kind, parameters):
    """With nothing set up: the same as a group of the selected boundary edges."""
    plan, other = quad_disc("One", rings=6), quad_disc("Other", rings=6)
    rim = boundary_edges(plan.data)
    add_group(other, "Group", rim[:7], kind, **parameters)
    expected = solved(other)
    select(plan, {*rim[:7].tolist(), 0, 1, 2})  # of the selection only the boundary counts
    activate(plan)
    bpy.ops.cmc.solve_selection(kind=kind, **parameters)
    assert_allclose(positions(plan.cmc.f_plus), expected, rtol=0, atol=1e-6)
    assert not plan.data.cmc.groups


def test_solve_from_selection_in_edit_mode():
    import bmesh

    plan = quad_disc(rings=6)
    rim = boundary_edges(plan.data)
    select(plan, {*rim[:7].tolist()})
    bpy.ops.cmc.solve_selection(tilt=0.6)
    expected = positions(plan.cmc.f_plus)
    bpy.ops.object.mode_set(mode="EDIT")
    bm = bmesh.from_edit_mesh(plan.data)
    bm.edges.ensure_lookup_table()
    for edge in bm.edges:
        edge.select = edge.index in rim[:7]
    bpy.ops.cmc.solve_selection(tilt=0.6)
    assert_allclose(positions(plan.cmc.f_plus), expected, rtol=0, atol=1e-6)


def test_selection_goes_before_groups():
    """Edges that are in a group and selected follow the selection, the group's others the group."""
    plan, other = quad_disc("One", rings=6), quad_disc("Other", rings=6)
    rim = boundary_edges(plan.data)
    add_group(plan, "All", rim, "BINORMAL", tilt=0.3)
    add_group(other, "First", rim[:7], "BINORMAL", tilt=0.6)
    add_group(other, "Rest", rim[7:], "BINORMAL", tilt=0.3)
    select(plan, set(rim[:7].tolist()))
    activate(plan)
    bpy.ops.cmc.solve_selection(tilt=0.6)
    assert_allclose(positions(plan.cmc.f_plus), solved(other), rtol=0, atol=1e-6)


# --- settings, undo, running ---------------------------------------------------------------

def test_settings_are_the_objects_unless_given():
    """The settings of a call win and stay with the plan; another plan does not get them."""
    plan, other = quad_disc("One"), quad_disc("Other")
    solved(plan, size="RISE", rise=2.0)
    assert (plan.cmc.size, plan.cmc.rise) == ("RISE", 2.0)
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
    bpy.ops.cmc.solve("EXEC_DEFAULT", True, size="RISE", rise=2.0)
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
    solved(plan, size="RISE", rise=2.0)
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


def test_only_our_own_errors_are_caught(addon, monkeypatch):
    """A bug of ours shows its traceback and leaves nothing behind."""
    solve = addon.cmc_addon.tasks.solve

    def form(*args, **keywords):
        raise ZeroDivisionError("a mistake")

    monkeypatch.setattr(solve.form, "form", form)
    quad_disc()
    before = snapshot()
    with pytest.raises(RuntimeError, match=r"Traceback(.|\n)*ZeroDivisionError"):
        bpy.ops.cmc.solve()
    assert snapshot() == before


# --- the window's way: a little at a time --------------------------------------------------

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


def test_a_ring_is_cut_open_and_says_so():
    """The surface over an eccentric ring does not close: more vertices, the same polygons, a warning."""
    plan = quad_ring(rings=6, columns=36)
    rim = boundary_edges(plan.data)
    inner = [e for e in rim if max(plan.data.edges[e].vertices) < 36]
    add_group(plan, "Inner", inner, "BINORMAL", tilt=0.8)
    solved(plan)
    mesh = plan.cmc.f_plus.data
    assert len(mesh.vertices) > len(plan.data.vertices)
    quads = [polygon for polygon in mesh.polygons if len(polygon.vertices) == 4]
    torn = len(plan.data.polygons) - len(quads)
    assert len(mesh.polygons) == len(plan.data.polygons) + torn
    assert torn < 0.05 * len(plan.data.polygons)
    assert "has a gap" in plan.cmc.message
    # cut, it hangs together: one boundary more would be one loop less
    assert len(plan.data.vertices) - len(plan.data.edges) + len(plan.data.polygons) == 0
    assert len(mesh.vertices) - len(mesh.edges) + len(mesh.polygons) == 1


def test_angles_of_neighbouring_groups_blend_over_a_length():
    """With a blend the normals at the rim turn gradually; without one they jump between two groups."""
    plan = quad_disc(rings=8, columns=64)
    half = [e for e in boundary_edges(plan.data) if plan.data.edges[e].vertices[0] % 64 < 32]
    add_group(plan, "Half", half, "BINORMAL", tilt=0.8)
    steps = []
    for blend in (0.0, 8.0):
        solved(plan, blend=blend)
        normals = np.array(values(plan.cmc.f_plus.data.attributes["cmc_normal"]))[-64:]
        steps.append(np.abs(np.diff(np.append(normals[:, 2], normals[0, 2]))).max())
    assert steps[0] > 0.3 and steps[1] < 0.15


def test_the_message_says_how_even_the_curvature_is(addon):
    """The measured error of the shown sheet; a coarser plan has a larger one."""
    errors = []
    for rings in (4, 8):
        plan = quad_disc(f"Disc {rings}", rings=rings, columns=8 * rings)
        edges = boundary_edges(plan.data)
        add_group(plan, "Half", edges[: len(edges) // 2], "BINORMAL", tilt=0.3)
        solved(plan)
        report = json.loads(plan.cmc.report)
        errors.append(report["sheets"]["f+"]["mean_curvature"]["relative_l2"])
        assert plan.cmc.message == report["message"] == f"Done. Curvature is even to {100 * errors[-1]:.2g} %."
    assert errors[1] < errors[0] < 1.0
