"""Shells kept closed around their holes: by `form`, while the plan changes, and where nothing can close."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from solver import ClosingOptions, JobError, Plan, Settings, form, shapes
from solver.closing.close import ClosingStatus
from solver.shells.close import closed
from solver.shells.form import count_modes
from solver.shells.update import update
from tests.solver.closing_plans import ring

SETTINGS = Settings(close=ClosingOptions())


def court(outer: float = 50, inner: float = 35) -> Plan:
    shape = shapes.polygon(ring(1.2), holes=[ring(0.4, (0.25, 0.1))], max_edge=0.17)
    sides = {name: ("binormal", {"tilt": np.radians(t)}) for name, t in (("outer", outer), ("hole0", inner))}
    return Plan.from_shape(shape, sides)


@pytest.mark.parametrize("way", ["normals", "tilts", "hole", "both"])
def test_a_court_is_kept_closed_in_each_way(way):
    plan = court()
    open_shell = form(plan, intersections=False)
    assert not open_shell.closed and not open_shell.ok and open_shell.closing is None
    (before,) = open_shell.gaps
    shell = form(plan, Settings(close=ClosingOptions(way)))
    assert "gap" not in [note.code for note in shell.warnings]
    assert shell.closed and shell.ok and len(shell.source) == len(plan.positions)
    assert shell.closing is not None and shell.closing.ok and repr(shell.closing).startswith("Closing(ClosingResult(")
    assert_allclose(shell.closing.gap_before, before.relative, rtol=1e-12)
    assert before.relative > 0.1 and shell.gaps[0].relative < 1e-8 and shell.gaps[0].length < 1e-8
    assert shell.message == shell.closing.message and shell.message in shell.summary()
    moves = way in ("hole", "both")
    assert (shell.adapted_plan is not None) == moves
    if moves:
        assert np.abs(shell.adapted_plan - plan.positions[:, :2]).max() > 0.01
    else:
        assert_allclose(np.linalg.norm(shell.surface.harmonic.normals, axis=1), 1.0, rtol=1e-12)


def test_normals_change_less_than_where_only_tilts_may():
    """The least change over more freedom is not larger."""
    turned = []
    for way in ("normals", "tilts"):
        closing = form(court(), Settings(close=ClosingOptions(way)), intersections=False).closing
        assert closing is not None
        turned.append(np.sqrt(np.mean(closing.result.turned**2)))
    assert 0.01 < turned[0] < turned[1]


def test_the_solver_of_a_shell_whose_hole_moved_is_that_of_the_drawn_plan():
    plan, settings = court(), Settings(close=ClosingOptions("hole"))
    shell = form(plan, settings, intersections=False)
    again = form(plan, settings, solver=shell.solver, initial=shell.surface.harmonic.normals, intersections=False)
    assert again.solver is shell.solver
    assert_allclose(again.points(), shell.points(), atol=1e-6)


def test_modes_are_counted_at_the_closed_map():
    shell = form(court(), Settings(close=ClosingOptions(), count_modes=True), intersections=False)
    assert (shell.report.index, shell.report.nullity) == (0, 0)
    shell = form(court(), Settings(close=ClosingOptions("hole")), intersections=False)
    assert count_modes(court(), SETTINGS, shell).report.index == 0


def test_a_lean_dragged_stays_closed_and_rests_where_a_new_solve_ends():
    shell = form(court(), SETTINGS, intersections=False)
    last = shell.surface.harmonic.normals
    for tilt in (51.0, 54.0, 58.0):
        now = update(court(tilt), SETTINGS, shell.solver, last)
        assert now.ok and not now.surface.is_open and now.closing is not None
        last = now.last
    rest = form(court(58.0), SETTINGS, solver=shell.solver, initial=last, intersections=False)
    cold = form(court(58.0), SETTINGS, intersections=False)
    assert_allclose(rest.points(), cold.points(), atol=1e-6)
    assert_allclose(now.placed["f+"], cold.points(), atol=1e-3)


def test_where_nothing_is_open_nothing_changes():
    disc = Plan.from_shape(shapes.disc(200), {"outer": ("binormal", {"tilt": 0.5})})
    for way in ("normals", "hole"):
        settings = Settings(close=ClosingOptions(way))
        shell = form(disc, settings, intersections=False)
        assert shell.closed and shell.closing is None and not shell.gaps
        assert_allclose(shell.points(), form(disc, intersections=False).points())
    lines = form(replace(court(), groups=[]), replace(SETTINGS, default_kind="line"), intersections=False)
    assert lines.ok and lines.closed and lines.closing is None


def test_what_cannot_close_keeps_its_gap_and_says_so():
    shell = form(court(), Settings(close=ClosingOptions("hole", move=("size",), max_steps=2)), intersections=False)
    assert not shell.closed and not shell.ok and shell.closing is not None and not shell.closing.ok
    assert shell.warnings[0].code == "gap" and shell.warnings[0] == shell.message
    assert [note.code for note in shell.warnings].count("gap") == 1
    assert shell.gaps[0].relative == shell.closing.gap > 1e-3 and " and is " in shell.message


def test_settings_that_cannot_close_are_refused():
    for other in ({"sites": "faces"}, {"delaunay": True}):
        with pytest.raises(JobError, match="Closing needs normals on vertices"):
            form(court(), Settings(close=ClosingOptions(), **other))
    with pytest.raises(JobError, match=r"The plan has 1 hole; there is no hole 2"):
        form(court(), Settings(close=ClosingOptions("hole", holes=(2,))))
    steep = court()
    steep.positions = steep.positions[:, [0, 2, 1]]
    with pytest.raises(JobError, match="Holes can only move horizontally"):
        form(steep, Settings(close=ClosingOptions("hole")))


def test_closing_can_be_cancelled():
    solved = form(court(), intersections=False).surface
    closing = closed(court(), SETTINGS, solved, ClosingOptions(), progress=lambda step, gap: False)
    assert closing is not None and closing.result.status is ClosingStatus.CANCELLED and closing.gap > 0.1


def test_a_plan_without_prescribed_normals_has_nothing_that_could_change():
    solved = form(court(), intersections=False).surface
    free = replace(court(), groups=[], initial=np.tile([0.0, 0.0, 1.0], (solved.domain.vertex_count, 1)))
    assert closed(free, replace(SETTINGS, default_kind="free"), solved, ClosingOptions()) is None
