"""How a fit is run: in slices that are shown as they end, with one count of the evaluations over all of them."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from importlib import import_module

import pytest

from .design_scenes import cap, report, small_disc, wavy
from .scenes import activate


@dataclass(frozen=True)
class Stage:
    """What a slice needs to know of a fit."""

    status: object
    is_met: bool = True
    history: list[float] = field(default_factory=list)


def stages(addon, outcomes):
    """A call that gives (status, met, evaluations) in turn, and the list of what it was called with."""
    status_of = import_module(f"{addon.__name__}.solver.fitting.fit").FitStatus
    calls, made = [], []

    def call(*, initial, max_evaluations, progress):
        calls.append((initial, max_evaluations))
        name, met, count = outcomes[len(calls) - 1]
        for k in range(count):
            progress(k + 1, 0.5)
        made.append(Stage(status_of[name], met, [float(len(calls))] * count))
        return made[-1]

    return call, calls, made


def test_slices_double_and_each_is_shown(addon):
    fit_outline = addon.cmc_addon.tasks.fit_outline
    outcomes = [("EVALUATION_LIMIT", False, 10), ("EVALUATION_LIMIT", False, 20), ("CONVERGED", True, 7)]
    call, calls, made = stages(addon, outcomes)
    shown, counts = [], []
    result = fit_outline.in_slices(call, None, lambda count, value: counts.append(count), shown.append)
    assert [size for _, size in calls] == [10, 20, 40]
    assert [initial for initial, _ in calls] == [None, *made[:2]]
    assert shown == made[:2], "the last one is the result"
    assert result.history == [1.0] * 10 + [2.0] * 20 + [3.0] * 7 and result.status is made[-1].status
    assert counts == list(range(1, 38))


def test_a_goal_that_is_not_met_ends_it_too(addon):
    fit_outline = addon.cmc_addon.tasks.fit_outline
    call, calls, made = stages(addon, [("NO_SURFACE", False, 4)])
    shown = []
    result = fit_outline.in_slices(call, None, lambda *_: None, shown.append)
    assert len(calls) == 1 and not shown and result.history == [1.0] * 4 and result.status is made[0].status


def test_a_cancelled_slice_ends_it(addon):
    fit_outline = addon.cmc_addon.tasks.fit_outline
    call, calls, _ = stages(addon, [("CANCELLED", False, 2)])
    shown = []
    assert len(fit_outline.in_slices(call, None, lambda *_: None, shown.append).history) == 2
    assert len(calls) == 1 and not shown


@pytest.mark.parametrize(("match", "near"), [("TANGENT_PLANES", 0.0), ("POSITION", 100.0)])
def test_an_approximation_is_shown_after_five_evaluations(addon, monkeypatch, match, near):
    """Then it continues from there, with the weight of nearness only where places count."""
    import bpy

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
    import bpy

    approximate, calls = addon.cmc_addon.tasks.approximate, []
    fit_gauss_map = approximate.fit_gauss_map

    def found_at_once(*arguments, **options):
        calls.append(options)
        return replace(fit_gauss_map(*arguments, **options), status=approximate.FitStatus.CONVERGED)

    monkeypatch.setattr(approximate, "fit_gauss_map", found_at_once)
    activate(wavy())
    bpy.ops.cmc.approximate_surface(match=match)
    assert len(calls) == stages_run


def test_the_report_of_a_fit_leaves_out_the_slow_measure():
    """Self-intersections are for Solve."""
    import bpy

    plan, surface = small_disc(), cap("Other")
    for ob, operator in ((plan, bpy.ops.cmc.fit_outline), (surface, bpy.ops.cmc.approximate_surface)):
        activate(ob)
        assert operator() == {"FINISHED"}
        (sheet,) = report(ob)["sheets"].values()
        assert sheet["intersections"] is None and sheet["mean_curvature"] is not None
        assert sheet["outline"] is not None
