"""Shells with lines along some sides and given normals along others, by the door of all shells."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

from solver import Plan, Settings, form, shapes
from solver.shells.mixed import sides_report
from solver.shells.plan import plan_domain
from solver.shells.update import update
from solver.surface.solve import CmcSolver

STREET = {"side0": ("binormal", {"tilt": np.radians(60)})}
LINES = Settings(default_kind="line")


@pytest.fixture(scope="module")
def hall():
    corners = np.array([(0, 0), (8, 0), (8, 5), (0, 5.0)])
    return shapes.polygon(corners, max_edge=0.35, corner_radius=0.6)


@pytest.fixture(scope="module")
def street(hall):
    return Plan.from_shape(hall, STREET)


@pytest.fixture(scope="module")
def shell(street):
    return form(street, LINES)


def test_the_rim_is_on_its_lines_and_the_street_leans(hall, street, shell):
    assert shell.ok, shell.message
    sides = {side["name"]: side for side in sides_report(street.groups, shell.fit)}
    span = shell.report.shown.span
    assert sides["side0"]["kind"] == "held" and sides["side0"]["angle"] < 1e-5
    assert sides[""]["kind"] == "line" and sides[""]["distance"] < 3e-3 * span
    middle = hall.domain.edges[hall.sides["side0"]][len(hall.sides["side0"]) // 2, 0]
    assert_allclose(np.arcsin(shell.normals["f+"][middle, 2]), np.radians(60), atol=1e-6)


def test_flipped_it_hangs_as_its_mirror_image(street, shell):
    hanging = form(street, Settings(default_kind="line", flip=True))
    assert_allclose(hanging.points(), shell.points() * [1, 1, -1], atol=1e-9)


def test_updates_go_on_from_the_fit(street, shell):
    solver = CmcSolver(plan_domain(street))
    again = update(street, LINES, solver, shell.fit)
    assert again.fit is not None and again.span is None and again.last is again.fit
    lines = Plan(street.positions, street.triangles)
    assert update(lines, LINES, solver, again.last).span is not None
