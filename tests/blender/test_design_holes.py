"""Fit to Outline over plans with courtyards: closed where it can be, its rims on their lines, layers kept."""

from __future__ import annotations

import bpy

# isort: split
import numpy as np
import pytest

from .design_scenes import fitted, off_line, report
from .scenes import activate, positions, quad_ring, values


def circle(radius: float, centre=(0.0, 0.0, 0.0), count: int = 48) -> np.ndarray:
    t = 2 * np.pi * np.arange(count) / count
    return np.column_stack([radius * np.cos(t), radius * np.sin(t), 0 * t]) + centre


def splines(name: str, *loops: np.ndarray) -> bpy.types.Object:
    """A curve object with these closed polylines."""
    data = bpy.data.curves.new(name, "CURVE")
    data.dimensions = "3D"
    for loop in loops:
        spline = data.splines.new("POLY")
        spline.points.add(len(loop) - 1)
        spline.points.foreach_set("co", np.column_stack([loop, np.ones(len(loop))]).ravel())
        spline.use_cyclic_u = True
    ob = bpy.data.objects.new(name, data)
    bpy.context.scene.collection.objects.link(ob)
    return ob


def courtyard(**options):
    """A round plan around a court that is not in its middle: a shell with given tilts would not close."""
    return quad_ring("Court", rings=5, columns=32, inner=1.5, outer=4.0, **options)


@pytest.fixture
def plan():
    return courtyard()


def rims(points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Points of the inner and the outer rim of the plan (its first and its last ring)."""
    return points[:32], points[-32:]


def test_a_courtyard_closes(plan, addon):
    drawn = positions(plan)
    points = fitted(plan, fit_rise=0.3)
    assert len(plan.cmc.fit.data.vertices) == len(plan.data.vertices), "it is not cut open"
    for rim, line in zip(rims(points), rims(drawn), strict=True):
        assert off_line(rim, line).max() < 0.05 * 8.0
    assert report(plan)["distances"]["period"] < 1e-3 * 8.0
    assert "Gap" in dict(addon.cmc_addon.panels.design_panel.design_rows(report(plan)))


def test_layers_stay(plan):
    layer = plan.data.uv_layers.new(name="Drawing")
    layer.uv.foreach_set("vector", np.random.default_rng(1).random(2 * len(plan.data.loops)).astype(np.float32))
    fitted(plan, fit_rise=0.3)
    assert values(plan.cmc.fit.data.attributes["Drawing"]) == values(plan.data.attributes["Drawing"])


def test_each_spline_is_for_its_loop(plan):
    """The court's spline lies higher than its rim; whichever comes first."""
    inner, outer = circle(1.5, (0.8, 0.0, 0.5)), circle(4.0)
    splines("Lines", inner, outer)
    points = fitted(plan, curve="Lines", fit_rise=0.4)
    court, rim = rims(points)
    assert court[:, 2].mean() - rim[:, 2].mean() == pytest.approx(0.5, abs=0.15)
    off = report(plan)["distances"]["rim on curve"]
    assert max(off_line(court, inner).max(), off_line(rim, outer).max()) <= off < 0.005 * 8.0


def test_one_spline_is_for_the_outer_rim(plan):
    splines("Line", circle(4.0, (0.0, 0.0, -0.2)))
    points = fitted(plan, curve="Line", fit_rise=0.4)
    court, rim = rims(points)
    assert court[:, 2].mean() - rim[:, 2].mean() == pytest.approx(0.2, abs=0.1)


def test_more_splines_than_loops(plan):
    splines("Many", circle(4.0), circle(1.0), circle(0.5, (2.0, 0, 0)))
    activate(plan)
    with pytest.raises(RuntimeError, match="There are 3 curves, but the plan's boundary has 2 loops"):
        bpy.ops.cmc.fit_outline(curve="Many")
    assert plan.cmc.fit is None


def test_a_remaining_gap_is_reported(addon, plan, monkeypatch):
    """And the layers go over the cut."""
    monkeypatch.setattr(addon.cmc_addon.tasks.fit_outline, "_FIRST_SLICE", 1)
    monkeypatch.setattr(addon.cmc_addon.tasks.fit_outline, "LIMIT", 1)
    layer = plan.data.uv_layers.new(name="Drawing")
    layer.uv.foreach_set("vector", np.random.default_rng(1).random(2 * len(plan.data.loops)).astype(np.float32))
    fitted(plan, fit_rise=1.0, limit_tilt=True)
    reported = report(plan)
    assert not reported["met"] and reported["distances"]["period"] > 1e-3 * 8.0
    assert len(plan.cmc.fit.data.vertices) > len(plan.data.vertices), "it is cut open"
    drawn, kept = (set(values(ob.data.attributes["Drawing"])) for ob in (plan, plan.cmc.fit))
    assert kept == drawn, "a quad that is cut has two triangles' corners"
