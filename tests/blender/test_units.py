"""Scenes in millimetres, centimetres and inches: plans have the size that the documentation says, in metres."""

from __future__ import annotations

import json
import re
from itertools import pairwise

import bpy
import numpy as np
import pytest

from .sidebar import draw

FINISHED = {"FINISHED"}
SCENES = [("METRIC", 0.001), ("METRIC", 0.01), ("IMPERIAL", 0.0254), ("METRIC", 1.0)]


def set_units(system: str, scale: float) -> None:
    units = bpy.context.scene.unit_settings
    units.system, units.scale_length = system, scale


def size_in_metres(ob, scale: float) -> np.ndarray:
    return np.ptp([vertex.co for vertex in ob.data.vertices], axis=0) * scale


@pytest.mark.parametrize(("system", "scale"), SCENES)
def test_plans_are_as_large_as_in_metres(system, scale):
    set_units(system, scale)
    bpy.ops.cmc.add_plan(shape="RECTANGLE", columns=24)
    np.testing.assert_allclose(size_in_metres(bpy.context.object, scale)[:2], (10.0, 6.5), rtol=1e-3)
    bpy.ops.cmc.add_plan(shape="ANNULUS", columns=24)
    assert max(size_in_metres(bpy.context.object, scale)) == pytest.approx(8.0, rel=1e-2)


def widths(scale: float) -> list[float]:
    calls = [(bpy.ops.cmc.add_module, {"module": "HONEYCOMB", "edges": 6}), (bpy.ops.cmc.add_bubble, {"columns": 8}),
             (bpy.ops.cmc.add_plan, {"shape": "CYLINDER", "columns": 24})]
    found = []
    for call, settings in calls:
        assert call(**settings) == FINISHED
        ob = bpy.context.object
        found.append(max(size_in_metres(ob, scale)))
        found.append({"SPAN": ob.cmc.span, "RADIUS": ob.cmc.radius}.get(ob.cmc.size, 0.0) * scale)
    return found


def test_modules_and_bubbles_too():
    wanted = widths(1.0)
    set_units("METRIC", 0.001)
    np.testing.assert_allclose(widths(0.001), wanted, rtol=1e-4)


def test_a_size_that_is_given_is_in_blender_units():
    set_units("METRIC", 0.001)
    bpy.ops.cmc.add_plan(shape="RECTANGLE", columns=24, size=5.0)
    assert bpy.context.object.dimensions.x == pytest.approx(5.0, rel=1e-3)


def test_without_units_the_scale_does_not_count():
    set_units("NONE", 0.001)
    bpy.ops.cmc.add_plan(shape="RECTANGLE", columns=24)
    assert bpy.context.object.dimensions.x == pytest.approx(10.0, rel=1e-3)


def test_shell_of_a_millimetre_scene():
    set_units("METRIC", 0.001)
    bpy.ops.cmc.add_plan(shape="RECTANGLE", columns=16)
    plan = bpy.context.object
    assert bpy.ops.cmc.solve() == FINISHED
    report = json.loads(plan.cmc.report)
    assert report["unit_scale"] == pytest.approx(0.001) and report["converged"]
    assert report["sheets"]["f+"]["span"] > 10000.0


@pytest.mark.parametrize(("system", "scale", "H", "area", "span"), [
    ("METRIC", 1.0, "0.1 1/m", "200 m²", "10 m"),
    ("METRIC", 0.001, "100 1/m", "2 cm²", "1 cm"),
    ("IMPERIAL", 0.3048, "0.1 1/ft", "200 sq ft", "10"),
    ("IMPERIAL", 0.0254, "1.2 1/ft", "1.389 sq ft", "10"),
    ("NONE", 0.001, "0.1 per unit", "200", "10"),
])
def test_panel_texts_are_in_the_units_of_the_scene(addon, system, scale, H, area, span):
    set_units(system, scale)
    shown = {"span": 10.0, "rise": 2.0, "area": 200.0, "overhang": {"area_share": 7.9e-6, "largest_lean": 72.8},
             "mean_curvature": None, "distortion": None, "outline": None, "intersections": None}
    report = {"mean_curvature": 0.1, "sheet": "f+", "sheets": {"f+": shown}, "periods": []}
    panel = addon.cmc_addon.panels.results_panel
    rows = dict(panel.size_rows(report))
    assert rows["H"] == H and rows["Span"].startswith(span)
    assert rows["Area"] == area
    assert dict(panel.check_rows(report))["Overhang"] == "None"


# --- every panel ---------------------------------------------------------------------------

def annulus():
    bpy.ops.cmc.add_plan(shape="ANNULUS", columns=32)
    bpy.ops.cmc.solve()


def tube():
    bpy.ops.cmc.add_plan(shape="CYLINDER", columns=32)
    bpy.ops.cmc.solve()
    bpy.ops.cmc.tile_periods()


def honeycomb():
    bpy.ops.cmc.add_module(module="HONEYCOMB", edges=8)
    bpy.ops.cmc.solve()
    bpy.ops.cmc.complete()


def hall():
    bpy.ops.cmc.add_plan(columns=12)
    bpy.ops.cmc.solve()


def nearest():
    bpy.ops.mesh.primitive_grid_add(x_subdivisions=8, y_subdivisions=8, size=metres(8.0))
    plan = bpy.context.object
    for vertex in plan.data.vertices:
        vertex.co.z = metres(2.0) - (vertex.co.x**2 + vertex.co.y**2) / metres(20.0)
    bpy.ops.cmc.approximate_surface()


def metres(length: float) -> float:
    return length / bpy.context.scene.unit_settings.scale_length


MADE = [hall, nearest, annulus, tube, honeycomb]


def numbers_of(texts) -> dict[str, str]:
    """The rows of all panels, name and value."""
    return {name: value for name, value in pairwise(texts) if re.search(r"\d", value)}


@pytest.mark.parametrize("make", MADE, ids=lambda make: make.__name__)
@pytest.mark.parametrize(("system", "scale", "unit"), [
    ("METRIC", 0.001, r"(µm|mm|cm|m|km)[²³]?\b|1/m"), ("IMPERIAL", 0.0254, r"\d['\"]|sq ft|cu ft|thou|\bft\b|1/ft"),
])
def test_every_length_has_the_unit_of_the_scene(make, system, scale, unit, capfd):
    """In rows, sentences and reports; and none is in metres where the scene is in inches, nor a power of ten."""
    set_units(system, scale)
    make()
    rows = numbers_of([text.replace("\u00a0", " ") for text in draw().texts])
    lengths = {name: value for name, value in rows.items() if name in names()}
    assert len(lengths) > 3
    for name, value in lengths.items():
        assert re.search(unit, value), (name, value)
    said = " ".join([*draw().texts, capfd.readouterr().out]).replace("\u00a0", " ")
    assert not re.search(r"\d(?:e[-+]\d+)\s*(?:long|apart|off|m\b|%)", said), said
    for words in ("is {} long", "up to {} apart", "stays up to {} off", "is {} off at most", "missed by {}"):
        for found in re.findall(words.format(r"([\d.]+\S*(?: \S+)?)"), said):
            assert re.search(unit, found), (words, found)


def names() -> set[str]:
    """The names of rows that are lengths, areas and curvatures."""
    return {
        "Span", "Rise", "Area", "Radius 1/H", "H", "Rim", "Off Outline", "Deviation", "Off Rim",
        "Off Surface", "Plane At", "Gap", "Hole 1", "Automatic",
    }


def test_noise_is_none():
    """Off Plane 0 m (1.1e-08 %), Seams 0 m apart: lengths below the accuracy of the solve are not numbers."""
    honeycomb()
    rows = dict(pairwise(draw().texts))
    assert rows["Off Plane"] == "None"
    tube()
    rows = dict(pairwise(draw().texts))
    assert rows["Seams"] == "Closed"


def test_motions_of_holes_are_lengths(capfd):
    set_units("METRIC", 0.001)
    annulus()
    assert bpy.ops.cmc.solve(close_by="HOLE") == FINISHED
    moved = capfd.readouterr().out.partition("Holes moved: ")[2]
    assert re.match(r"\S*( \d)? ?x -?[\d.]+ (m|cm|mm)\b", moved), moved
