"""Eight plans with lines, leans, planes and mirrors side by side, in Python."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

from solver import Group, Plan, Settings, form, shapes
from solver.shells.mixed import sides_report
from solver.shells.span import span_report
from tests.mixed_plans import LINE_OFF, MIXED_PLANS, MixedPlan, misses


def plan_of(mixed: MixedPlan) -> tuple[Plan, dict[str, np.ndarray]]:
    positions, triangles, pairs = mixed.mesh(shapes)
    groups = []
    for name, (kind, parameters) in mixed.sides.items():
        turned = {key: value if key == "normal" else np.radians(value) for key, value in parameters.items()}
        groups.append(Group(name, pairs[name], kind, turned))
    return Plan(positions, triangles, groups=groups), pairs


@pytest.mark.parametrize("mixed", MIXED_PLANS, ids=lambda mixed: mixed.name)
def test_every_side_is_as_asked_or_told(mixed):
    plan, pairs = plan_of(mixed)
    shell = form(plan, Settings(default_kind="line", size="rise", value=mixed.rise))
    assert shell.ok, shell.message
    assert (shell.span is None) == mixed.is_fitted
    points, codes = shell.points(), {note.code for note in shell.warnings}
    assert mixed.off_line(points, plan.positions, plan.triangles, pairs) < (LINE_OFF if mixed.is_fitted else 1e-3)
    report = {"sides": sides_report(plan.groups, shell.fit)} if mixed.is_fitted else {"span": span_report(shell.span)}
    assert not misses(report, codes)
    for name, (kind, parameters) in mixed.sides.items():
        _check_side(shell.normals["f+"], points, pairs[name], kind, parameters)


def _check_side(normals: np.ndarray, points: np.ndarray, pairs: np.ndarray, kind: str, parameters: dict) -> None:
    """The side's middle third has the given normals to rounding; a mirror's rim lies in one plane."""
    vertices = np.unique(pairs)
    along = points[vertices] @ np.ptp(points[vertices], axis=0)
    middle = vertices[np.abs(along - np.median(along)) < np.ptp(along) / 6.0]
    if kind == "plane":
        assert_allclose(normals[middle] - parameters["normal"], 0.0, atol=1e-12)
    elif kind == "binormal":
        assert_allclose(normals[middle, 2], np.sin(np.radians(parameters["tilt"])), rtol=0, atol=1e-9)
    elif kind == "mirror":
        assert np.ptp(points[vertices] @ parameters["normal"]) < 1e-9 * np.ptp(points)


def test_a_lean_that_is_off_must_be_told():
    span = {"leans": [{"asked": 35.0, "measured": 35.2, "off": 1.7}]}
    assert misses({"span": span}, set()) and not misses({"span": span}, {"lean-missed"})
    assert misses({"sides": [{"name": "a", "kind": "held", "angle": 1e-3}]}, set())
