"""Shells kept closed around holes: each way, in place, with the layers; what moves; the messages; left open."""

from __future__ import annotations

import json

import bpy
import numpy as np
import pytest
from numpy.testing import assert_allclose

from .scenes import add_group, boundary_edges, positions, quad_ring, snapshot, values
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
    """A court whose shell is left open."""
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


def test_a_shell_left_open_reports_its_gap(plan, addon):
    reported = report(plan)
    (hole,) = reported["holes"]
    assert reported["is_open"] and hole["name"] == "hole 1" and 0.02 < hole["relative"] < 1.0
    assert_allclose(hole["length"], reported["gap"], rtol=1e-9)
    text = addon.cmc_addon.panels.periods_text
    sentence = text.gap_sentence(reported)
    assert "is open by" in sentence
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
    assert bpy.ops.cmc.solve(keep_closed=True) == FINISHED
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
    assert bpy.ops.cmc.solve(keep_closed=True, close_by=way) == FINISHED
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
    assert not (positions(plan) - drawn).any(), "the drawing stays"
    adapted = shell.data.uv_layers.get("cmc_plan")
    assert (adapted is not None) == (way in ("HOLE", "BOTH"))
    if adapted is None:
        assert closing["largest_turn"] > 0.5
    else:
        shift = np.array([closing["moved"]["x"], closing["moved"]["y"]])
        assert np.linalg.norm(shift) > 0.02
        place = np.empty((len(plan.data.vertices), 2))
        place[[loop.vertex_index for loop in shell.data.loops]] = np.array(values(shell.data.attributes[adapted.name]))
        moved = place - drawn[:, :2]
        assert_allclose(moved[:COLUMNS].mean(axis=0), shift, atol=1e-5)
        assert np.abs(moved[-COLUMNS:]).max() < 1e-5, "the outer rim stays"
    H = np.median(values(shell.data.attributes["cmc_mean_curvature"]))
    assert_allclose(H, reported["mean_curvature"], rtol=0.15)


def test_the_panel_lists_the_changes(plan, addon):
    assert bpy.ops.cmc.solve(keep_closed=True, close_by="BOTH", close_size=True) == FINISHED
    rows = dict(addon.cmc_addon.panels.periods_text.closing_rows(report(plan)))
    assert set(rows) == {
        "Gap Before", "Gap Now", "Normals Turned", "Hole X", "Hole Y", "Hole Twist", "Hole Size", "Steps"}
    assert "°" in rows["Normals Turned"] and rows["Hole Size"].startswith("×")
    assert dict(addon.cmc_addon.panels.periods_text.gap_rows(report(plan)))["Hole 1"] == "Closed"
    assert addon.cmc_addon.panels.periods_text.gap_sentence(report(plan)) == ""


def test_a_new_plan_is_kept_closed_until_that_is_switched_off():
    plan = court()
    plan.cmc.property_unset("keep_closed")
    assert bpy.ops.cmc.solve() == FINISHED
    assert plan.cmc.keep_closed and report(plan)["closing"]["closed"]
    closed = positions(plan.cmc.f_plus)
    assert bpy.ops.cmc.solve() == FINISHED
    assert_allclose(positions(plan.cmc.f_plus), closed, atol=1e-6)
    plan.cmc.keep_closed = False
    assert bpy.ops.cmc.solve() == FINISHED
    assert "closing" not in report(plan) and report(plan)["is_open"]


def test_the_modes_of_a_closed_shell_are_counted():
    plan = court()
    assert bpy.ops.cmc.solve(keep_closed=True) == FINISHED
    assert bpy.ops.cmc.count_modes() == FINISHED
    assert (report(plan)["index"], report(plan)["nullity"]) == (0, 0) and report(plan)["closing"]["closed"]


def test_normals_elsewhere_than_on_vertices_leave_the_gap():
    plan = court()
    plan.cmc.keep_closed, plan.cmc.sites = True, "FACES"
    assert bpy.ops.cmc.solve() == FINISHED
    assert report(plan)["is_open"] and "closing" not in report(plan)


def test_a_remaining_gap_is_reported(plan, addon):
    """A hole that may only grow does not close it."""
    assert bpy.ops.cmc.solve(
        keep_closed=True, close_by="HOLE", close_shift=False, close_twist=False, close_size=True) == FINISHED
    reported = report(plan)
    assert not reported["closing"]["closed"] and reported["is_open"]
    assert len(plan.cmc.f_plus.data.vertices) > len(plan.data.vertices)
    sentence = addon.cmc_addon.panels.periods_text.gap_sentence(reported)
    assert sentence.startswith(reported["closing"]["message"]) and "is open by" in sentence
    assert reported["warnings"][0]["text"] == reported["closing"]["message"]


def refused(message: str, **options) -> None:
    before = snapshot()
    with pytest.raises(RuntimeError, match=message):
        bpy.ops.cmc.solve(**options)
    assert snapshot() == before


def test_a_plan_that_cannot_close_as_asked_is_refused():
    plan = court()
    plan.cmc.keep_closed = True
    refused("The holes need a motion", close_by="HOLE", close_shift=False, close_twist=False)
    plan.rotation_euler.x = np.pi / 2
    bpy.context.view_layer.update()
    refused("Holes can only move horizontally", close_by="BOTH")
    assert bpy.ops.cmc.solve(close_by="NORMALS") == FINISHED
    assert report(plan)["closing"]["closed"]


def test_in_edit_mode_and_after_tiling(plan):
    assert bpy.ops.cmc.tile_periods() == FINISHED and plan.cmc.f_plus.hide_viewport
    bpy.ops.object.mode_set(mode="EDIT")
    assert bpy.ops.cmc.solve(keep_closed=True) == FINISHED
    bpy.ops.object.mode_set(mode="OBJECT")
    assert report(plan)["closing"]["closed"]
    assert not plan.cmc.f_plus.hide_viewport and plan.cmc.completed.hide_viewport


# --- the panel -----------------------------------------------------------------------------


def test_results_and_gaps_of_an_open_and_of_a_closed_shell(plan):
    assert "is open by" in " ".join(draw("CMC_PT_results").texts)
    panel = draw("CMC_PT_periods")
    assert panel.operators == ["cmc.tile_periods"] and {"tile_as", "tile_repeat"} <= set(panel.props)
    assert "3" in panel.texts and f"{3 * len(plan.data.polygons):,}" in panel.texts
    assert bpy.ops.cmc.solve(keep_closed=True) == FINISHED
    closed = draw("CMC_PT_periods")
    assert closed.operators == ["cmc.tile_periods"] and "Closed" in closed.texts and "Normals Turned" in closed.texts
    assert "The surface closes" in " ".join(draw("CMC_PT_results").texts)


def test_the_options_show_how_it_closes(plan):
    assert "keep_closed" in draw("CMC_PT_shell").props
    assert "close_by" not in draw("CMC_PT_options").props
    plan.cmc.keep_closed, plan.cmc.close_by = True, "BOTH"
    assert {"close_by", "close_shift", "close_twist", "close_size", "close_weight"} <= set(draw("CMC_PT_options").props)
