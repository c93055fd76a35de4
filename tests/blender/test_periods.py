"""Close Gaps: each way to close, in place, with the layers; what moves; the messages; undo."""

from __future__ import annotations

import json
from types import SimpleNamespace

import bpy
import numpy as np
import pytest
from numpy.testing import assert_allclose

from .scenes import activate, add_group, boundary_edges, positions, quad_ring, snapshot, values
from .sidebar import draw

FINISHED = {"FINISHED"}
COLUMNS = 32


def court(**options):
    """A round plan around a court that is not in its middle, with a UV layer, a seam and two groups."""
    plan = quad_ring("Court", rings=5, columns=COLUMNS, inner=1.5, outer=4.0, **options)
    layer = plan.data.uv_layers.new(name="Drawing")
    layer.uv.foreach_set("vector", np.random.default_rng(1).random(2 * len(plan.data.loops)).astype(np.float32))
    for edge in plan.data.edges:
        edge.use_seam = edge.index % 7 == 0
    edges = boundary_edges(plan.data)
    inner = [e for e in edges if max(plan.data.edges[e].vertices) < COLUMNS]
    add_group(plan, "Court", inner, "BINORMAL", tilt=0.6)
    add_group(plan, "Street", sorted(set(edges) - set(inner)), "BINORMAL", tilt=0.9)
    return plan


@pytest.fixture
def plan():
    made = court()
    assert bpy.ops.cmc.solve() == FINISHED
    return made


def report(plan) -> dict:
    return json.loads(plan.cmc.report)


def sources_of(mesh) -> np.ndarray:
    """The plan's vertex that each vertex comes from, if the plan has their numbers as an attribute."""
    numbered = mesh.attributes.get("source")
    return np.arange(len(mesh.vertices)) if numbered is None else np.array(values(numbered))


def uv_corners(mesh) -> set:
    """Per corner: the plan's vertex by number, and its UV."""
    sources = sources_of(mesh)
    drawn = values(mesh.attributes["Drawing"])
    return {(int(sources[loop.vertex_index]), *np.round(uv, 6)) for loop, uv in zip(mesh.loops, drawn, strict=True)}


def seams(mesh) -> set:
    sources = sources_of(mesh)
    return {tuple(sorted(sources[list(edge.vertices)].tolist())) for edge in mesh.edges if edge.use_seam}


def test_solve_reports_the_gap_and_the_buttons(plan, addon):
    reported = report(plan)
    (hole,) = reported["holes"]
    assert reported["is_open"] and hole["name"] == "hole 1" and 0.02 < hole["relative"] < 1.0
    assert_allclose(hole["length"], reported["gap"], rtol=1e-9)
    text = addon.cmc_addon.panels.periods_text
    sentence = text.gap_sentence(reported)
    assert "is open by" in sentence and "Close Gaps" in sentence and "Repeat by Gaps" in sentence
    assert f"{100 * hole['relative']:.2g} %" in sentence
    rows = dict(text.gap_rows(reported))
    assert f"{hole['length']:.4g}"[:4] in rows["Hole 1"]
    units = addon.cmc_addon.properties.units
    assert units.vector_text([6.67e-5, -2.309, -2.7e-9]) == "(0.00, -2.31, 0.00) m"
    assert units.vector_text([0.0123, 123.4, 0.0]) == "(0, 123, 0) m"
    bpy.context.scene.unit_settings.system = "NONE"
    assert units.vector_text([0.0123, 123.4, 0.0]) == "(0, 123, 0)"


def test_the_arrow_leads_from_one_end_of_the_gap_to_the_other(plan, addon):
    start, along = addon.cmc_addon.drawing.result_layers.gaps(report(plan), np.zeros(3))
    assert start.shape == along.shape == (1, 3)
    shell = positions(plan.cmc.f_plus)
    for end in (start, start + along):
        assert np.linalg.norm(shell - end, axis=1).min() < 1e-4
    assert bpy.ops.cmc.close_periods() == FINISHED
    assert len(addon.cmc_addon.drawing.result_layers.gaps(report(plan), np.zeros(3))[0]) == 0


def test_a_shell_that_is_cut_open_has_the_layers_of_the_plan():
    plan = court()
    count = len(plan.data.vertices)
    plan.data.attributes.new("source", "INT", "POINT").data.foreach_set("value", np.arange(count))
    assert bpy.ops.cmc.solve() == FINISHED
    shell = plan.cmc.f_plus.data
    assert len(shell.vertices) > count
    assert uv_corners(shell) == uv_corners(plan.data), "UVs are continuous across the cut"
    assert seams(shell) == seams(plan.data)


@pytest.mark.parametrize("way", ["NORMALS", "TILTS", "HOLE", "BOTH"])
def test_a_court_closes_in_place(plan, way):
    shell, drawn = plan.cmc.f_plus, positions(plan)
    groups = [(g.name, g.kind, g.tilt) for g in plan.data.cmc.groups]
    material = bpy.data.materials.new("Stone")
    shell.data.materials.append(material)
    before, (hole,) = report(plan)["gap"], report(plan)["holes"]
    assert bpy.ops.cmc.close_periods(close_by=way) == FINISHED
    reported = report(plan)
    assert plan.cmc.f_plus == shell and shell.data.materials[0] == material
    assert len(shell.data.vertices) == len(plan.data.vertices), "welded"
    assert len(shell.data.polygons) == len(plan.data.polygons)
    assert uv_corners(shell.data) == uv_corners(plan.data) and seams(shell.data) == seams(plan.data)
    closing = reported["closing"]
    assert closing["gap_before"] == hole["relative"], "one gap, one number"
    assert closing["closed"] and not reported["is_open"] and reported["gap"] < 1e-7 * before
    assert plan.cmc.message.split(":")[0] == closing["message"].split(":")[0] and plan.cmc.close_by == way
    assert [(g.name, g.kind, g.tilt) for g in plan.data.cmc.groups] == groups
    moved = positions(plan) - drawn
    if way in ("HOLE", "BOTH"):
        hole = moved[:COLUMNS]
        turn = np.radians(closing["moved"]["twist"])
        shift = np.array([closing["moved"]["x"], closing["moved"]["y"], 0.0])
        assert_allclose(hole.mean(axis=0), shift, atol=1e-5)
        assert np.abs(hole - shift).max() < 1.6 * abs(turn) + 1e-4
        assert not moved[-COLUMNS:].any(), "the outer rim stays"
        assert np.linalg.norm(shift) > 0.02
    else:
        assert not moved.any() and closing["largest_turn"] > 0.5
    H = np.median(values(shell.data.attributes["cmc_mean_curvature"]))
    assert_allclose(H, reported["mean_curvature"], rtol=0.15)


def test_the_panel_lists_the_changes(plan, addon):
    assert bpy.ops.cmc.close_periods(close_by="BOTH", close_size=True) == FINISHED
    rows = dict(addon.cmc_addon.panels.periods_text.closing_rows(report(plan)))
    assert set(rows) == {
        "Gap Before", "Gap Now", "Normals Turned", "Hole X", "Hole Y", "Hole Twist", "Hole Size", "Steps"}
    assert "°" in rows["Normals Turned"] and rows["Hole Size"].startswith("×")
    assert dict(addon.cmc_addon.panels.periods_text.gap_rows(report(plan)))["Hole 1"] == "Closed"
    assert addon.cmc_addon.panels.periods_text.gap_sentence(report(plan)) == ""


def test_solve_gives_the_shell_with_its_gap_again(plan):
    before = positions(plan.cmc.f_plus)
    assert bpy.ops.cmc.close_periods() == FINISHED
    assert bpy.ops.cmc.solve() == FINISHED
    assert_allclose(positions(plan.cmc.f_plus), before, atol=1e-4)
    assert "closing" not in report(plan)


def test_it_solves_by_itself_and_keeps_what_was_chosen():
    plan = court()
    assert bpy.ops.cmc.close_periods(close_by="TILTS") == FINISHED
    assert report(plan)["closing"]["closed"] and plan.cmc.close_by == "TILTS"
    first = report(plan)["closing"]["largest_turn"]
    activate(plan.cmc.f_plus)
    assert bpy.ops.cmc.close_periods() == FINISHED, "with the shell active, too"
    assert_allclose(report(plan)["closing"]["largest_turn"], first, rtol=1e-6)


def test_a_plan_that_is_turned_and_moved_closes_by_its_hole():
    plan = court()
    plan.location, plan.rotation_euler.z, plan.scale = (5.0, -2.0, 1.0), 0.7, (1.5, 1.5, 1.5)
    bpy.context.view_layer.update()
    drawn = positions(plan)
    assert bpy.ops.cmc.close_periods(close_by="HOLE") == FINISHED
    closing = report(plan)["closing"]
    assert closing["closed"]
    shift = (positions(plan) - drawn)[:COLUMNS].mean(axis=0)
    assert_allclose(shift[:2], [closing["moved"]["x"], closing["moved"]["y"]], atol=1e-5)


def test_a_remaining_gap_is_reported(plan, addon):
    """A hole that may only grow does not close it."""
    assert bpy.ops.cmc.close_periods(
        close_by="HOLE", close_shift=False, close_twist=False, close_size=True) == FINISHED
    reported = report(plan)
    assert not reported["closing"]["closed"] and reported["is_open"]
    assert len(plan.cmc.f_plus.data.vertices) > len(plan.data.vertices)
    sentence = addon.cmc_addon.panels.periods_text.gap_sentence(reported)
    assert sentence.startswith(reported["closing"]["message"]) and "is open by" in sentence
    assert reported["warnings"][0]["text"] == reported["closing"]["message"]


@pytest.mark.parametrize("way", ["NORMALS", "HOLE"])
def test_undo(plan, way):
    name = plan.name
    bpy.ops.ed.undo_push(message="solved")
    before = snapshot()
    bpy.ops.cmc.close_periods("EXEC_DEFAULT", True, close_by=way)
    assert snapshot() != before
    bpy.ops.ed.undo()
    assert snapshot() == before
    activate(bpy.data.objects[name])
    assert bpy.ops.cmc.tile_periods() == FINISHED, "the shell that is there now is tiled, not the one undone"


def refused(message: str, **options) -> None:
    before = snapshot()
    with pytest.raises(RuntimeError, match=message):
        bpy.ops.cmc.close_periods(**options)
    assert snapshot() == before


def test_a_plan_that_cannot_close_is_refused(plan):
    refused("The holes need a motion", close_by="HOLE", close_shift=False, close_twist=False)
    plan.cmc.sites, plan.cmc.energy = "FACES", "MOBIUS"
    refused("Closing needs normals on vertices")


def test_plans_whose_vertices_cannot_be_moved(plan):
    plan.shape_key_add(name="Basis")
    refused("has shape keys", close_by="HOLE")
    plan.shape_key_clear()
    plan.modifiers.new("Bend", "SIMPLE_DEFORM")
    plan.cmc.apply_modifiers = True
    refused("with its modifiers applied", close_by="HOLE")
    plan.modifiers.clear()
    bpy.ops.object.mode_set(mode="EDIT")
    with pytest.raises(RuntimeError, match="is in edit mode"):
        bpy.ops.cmc.close_periods(close_by="BOTH")
    bpy.ops.object.mode_set(mode="OBJECT")


def test_a_wall_closes_by_its_normals_only(plan):
    plan.rotation_euler.x = np.pi / 2
    bpy.context.view_layer.update()
    refused("Holes can only move horizontally", close_by="BOTH")
    assert bpy.ops.cmc.close_periods(close_by="NORMALS") == FINISHED
    assert report(plan)["closing"]["closed"]


def test_in_edit_mode_and_after_tiling(plan):
    assert bpy.ops.cmc.tile_periods() == FINISHED and plan.cmc.f_plus.hide_viewport
    bpy.ops.object.mode_set(mode="EDIT")
    assert bpy.ops.cmc.close_periods() == FINISHED
    bpy.ops.object.mode_set(mode="OBJECT")
    assert report(plan)["closing"]["closed"]
    assert not plan.cmc.f_plus.hide_viewport and plan.cmc.completed.hide_viewport


def test_a_plan_without_a_hole():
    from .scenes import quad_disc

    quad_disc()
    refused("neither holes nor handles")


def test_esc_leaves_everything_as_it_was(plan, addon):
    """The work is stopped at its first step."""

    operators = addon.cmc_addon.operators.periods

    class Hand(operators.CMC_OT_close_periods.__mro__[1]):
        bl_label, names = "Close Periods", operators.CLOSE_SETTINGS
        read_task = operators.CMC_OT_close_periods.read_task
        progress_of = operators.CMC_OT_close_periods.progress_of
        properties = SimpleNamespace(is_property_set=lambda name: False)

        def __init__(self):
            self.reports = []
            self._work = self.steps(bpy.context, 0.0)  # asks at once, before the work can end

        def report(self, kind, text):
            self.reports.append(text)

    before, hand = snapshot(), Hand()
    tick = SimpleNamespace(type="TIMER", value="NOTHING")
    assert hand.modal(bpy.context, tick) == {"RUNNING_MODAL"}
    assert hand.modal(bpy.context, SimpleNamespace(type="ESC", value="PRESS")) == {"CANCELLED"}
    assert snapshot() == before and hand.reports == ["Close Periods was cancelled; nothing was changed."]
    again = Hand()
    run, messages = bpy.context.window_manager.cmc, set()
    while (ended := again.modal(bpy.context, tick)) == {"RUNNING_MODAL"}:
        messages.add(run.message)
        assert 0.0 <= run.progress < 1.0
    assert ended == FINISHED and all(text == "" or text.startswith("Step ") for text in messages)
    assert report(plan)["closing"]["closed"]


# --- the panel -----------------------------------------------------------------------------


def test_results_and_periods_of_a_gap_and_of_a_closed_shell(plan):
    shown = " ".join(draw("CMC_PT_results").texts)
    assert "is open by" in shown and "Close Gaps" in shown
    open_panel = draw("CMC_PT_periods")
    assert open_panel.operators == ["cmc.close_periods", "cmc.tile_periods"]
    assert {"close_by", "tile_as", "tile_repeat"} <= set(open_panel.props) and "close_shift" not in open_panel.props
    assert "3" in open_panel.texts and f"{3 * len(plan.data.polygons):,}" in open_panel.texts
    plan.cmc.close_by = "BOTH"
    assert {"close_shift", "close_twist", "close_size", "close_weight"} <= set(draw("CMC_PT_periods").props)
    assert bpy.ops.cmc.close_periods() == FINISHED
    closed = draw("CMC_PT_periods")
    assert closed.operators == ["cmc.close_periods"] and "Closed" in closed.texts and "Normals Turned" in closed.texts
    assert "The surface closes" in " ".join(draw("CMC_PT_results").texts)


def test_a_plan_that_cannot_be_moved_any_more(plan, addon):
    """Shape keys added while the work runs: the shell is refused, and nothing has changed."""
    from cmc_formfinding.solver.errors import CmcError

    tasks, settings = addon.cmc_addon.tasks.close_periods, addon.cmc_addon.properties.periods_settings
    wanted = SimpleNamespace(**{name: getattr(plan.cmc, name) for name in settings.CLOSE_SETTINGS})
    wanted.close_by = "HOLE"
    task = tasks.CloseTask.read(bpy.context, plan, wanted)
    result = task.work(lambda *_: True)
    assert result.converged and result.moved is not None
    plan.shape_key_add(name="Basis")
    before = snapshot()
    with pytest.raises(CmcError, match="has shape keys"):
        task.write(bpy.context, plan, result)
    assert snapshot() == before
