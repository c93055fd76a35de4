"""Answers while a plan is changed: near what a whole solve gives, from any map; and measures that can be stopped."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from solver import shapes
from solver.errors import Interrupted, Status
from solver.measure import self_intersections
from solver.shells.form import form
from solver.shells.plan import Group, Plan, Settings
from solver.shells.update import update


@pytest.fixture(scope="module")
def plan() -> Plan:
    shape = shapes.disc(300)
    points = np.column_stack([4.0 * shape.positions, np.zeros(len(shape.positions))])
    rim = shape.domain.edges[shape.domain.boundary_edges]
    return Plan(points, shape.domain.faces, groups=[Group("Half", rim[: len(rim) // 2], "binormal", {"tilt": 0.3})])


def tilted(plan: Plan, tilt: float) -> Plan:
    return replace(plan, groups=[Group("Half", plan.groups[0].edges, "binormal", {"tilt": tilt})])


def test_it_goes_on_from_the_last_map(plan):
    shell = form(plan, intersections=False)
    assert shell.solver is not None
    last = shell.surface.harmonic.normals
    for tilt in (0.35, 0.4, 0.5):
        expected = form(tilted(plan, tilt), intersections=False)
        found = update(tilted(plan, tilt), Settings(), shell.solver, last)
        for sheet in ("f+", "f-", "g", "gauss"):
            assert_allclose(found.placed[sheet], expected.placed[sheet], rtol=0, atol=1e-3)
        for sheet, normals in expected.normals.items():
            assert_allclose(found.normals[sheet], normals, rtol=0, atol=1e-3)
        last = found.surface.harmonic.normals


def test_one_step_is_nearly_there(plan):
    shell = form(plan, intersections=False)
    assert shell.solver is not None
    changed = tilted(plan, 0.45)
    expected = form(changed, intersections=False)
    found = update(changed, Settings(), shell.solver, shell.surface.harmonic.normals, steps=1)
    assert found.surface.harmonic.iterations == 1 and found.surface.status is Status.ITERATION_LIMIT
    far = np.abs(shell.placed["f+"] - expected.placed["f+"]).max()
    assert np.abs(found.placed["f+"] - expected.placed["f+"]).max() < 0.1 * far


def test_where_a_branch_ends_it_begins_anew(plan):
    """From normals all over the place there is no way back."""
    nowhere = np.random.default_rng(0).normal(size=(len(plan.positions), 3))
    shell = form(plan, intersections=False)
    assert shell.solver is not None
    found = update(plan, Settings(), shell.solver, nowhere)
    assert found.surface.status is Status.CONVERGED
    assert_allclose(found.placed["f+"], shell.placed["f+"], rtol=0, atol=1e-3)


def test_measuring_asks_whether_it_is_wanted():
    """A sheet folded through itself, so that there is something to look for."""
    shape = shapes.disc(300)
    x, y = shape.positions.T
    folded = np.column_stack([np.sin(3.0 * x), y, np.cos(5.0 * x) * x])
    assert len(self_intersections(folded, shape.domain.faces))
    with pytest.raises(Interrupted):
        self_intersections(folded, shape.domain.faces, lambda: False)
    asked: list[int] = []
    found = self_intersections(folded, shape.domain.faces, lambda: not asked.append(1))
    assert asked and np.array_equal(found, self_intersections(folded, shape.domain.faces))
