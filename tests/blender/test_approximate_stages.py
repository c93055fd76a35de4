"""How an approximation is run: shown after a first look, from which it goes on."""

from __future__ import annotations

from dataclasses import replace

import bpy
import pytest

from .approximate_scenes import approximated, cap, report, wavy
from .scenes import activate


@pytest.mark.parametrize(("match", "near"), [("TANGENT_PLANES", 0.0), ("POSITION", 100.0)])
def test_an_approximation_is_shown_after_five_evaluations(addon, monkeypatch, match, near):
    """Then it continues from there, with the weight of nearness only where places count."""
    approximate, calls = addon.cmc_addon.tasks.approximate, []
    fit_gauss_map = approximate.fit_gauss_map

    def spy(*arguments, **options):
        calls.append((options["max_evaluations"], options["near"], options["initial"] is None))
        return fit_gauss_map(*arguments, **options)

    monkeypatch.setattr(approximate, "fit_gauss_map", spy)
    surface = wavy()
    activate(surface)
    bpy.ops.cmc.approximate_surface(match=match, near=100.0)
    assert calls == [(5, 0.0, True), (approximate.LIMIT, near, False)]


@pytest.mark.parametrize(("match", "stages_run"), [("TANGENT_PLANES", 1), ("POSITION", 2)])
def test_tangent_planes_found_at_once_need_no_second_look_but_places_do(addon, monkeypatch, match, stages_run):
    approximate, calls = addon.cmc_addon.tasks.approximate, []
    fit_gauss_map = approximate.fit_gauss_map

    def found_at_once(*arguments, **options):
        calls.append(options)
        return replace(fit_gauss_map(*arguments, **options), status=approximate.FitStatus.CONVERGED)

    monkeypatch.setattr(approximate, "fit_gauss_map", found_at_once)
    activate(wavy())
    bpy.ops.cmc.approximate_surface(match=match)
    assert len(calls) == stages_run


def test_the_report_leaves_out_the_slow_measure():
    """Self-intersections are for Solve."""
    surface = cap()
    approximated(surface)
    (sheet,) = report(surface)["sheets"].values()
    assert sheet["intersections"] is None and sheet["mean_curvature"] is not None and sheet["outline"] is not None
