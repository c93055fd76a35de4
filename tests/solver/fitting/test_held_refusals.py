"""Given normals and mirrors beside lines that no surface can have are refused before the search."""

from __future__ import annotations

import numpy as np
import pytest

from solver import ConditionError, Plan, Settings, conditions, fit_outline, form, shapes

HALL = np.array([(0, 0), (9, 0), (9, 6), (0, 6.0)])


@pytest.fixture(scope="module")
def hall():
    return shapes.polygon(HALL, max_edge=0.75, corner_radius=0.8)


def touched(along: float, tilt: float) -> tuple[float, float, float]:
    """A normal at this tilt over the horizon, out of the street, turned along it by an angle; degrees."""
    part, t = np.sin(np.radians(along)), np.radians(tilt)
    across = np.sqrt(1.0 - part**2)
    return part, -across * np.cos(t), across * np.sin(t)


@pytest.mark.parametrize(
    "along, tilt, message",
    [
        (0, -20, "point down by 20°.*Turn them up"),
        (60, 50, "turn by 60° along their side.*Turn them across"),
        (-60, 50, "turn by 60° along their side"),
        (0, 100, "lean by 10° into the plan.*lean the side over its line"),
    ],
)
def test_normals_that_no_surface_has_beside_lines(hall, along, tilt, message):
    held = conditions.fixed(hall, "side0", touched(along, tilt))
    with pytest.raises(ConditionError, match=message) as error:
        fit_outline(hall, hall.positions, rise=0.35, held=held)
    assert len(error.value.vertices)


def test_normals_given_for_f_minus_are_those_of_f_minus(hall):
    up, down = (conditions.fixed(hall, "side0", touched(0, tilt)) for tilt in (50, -50))
    fit_outline(hall, hall.positions, rise=0.35, held=up, sheet="f-", max_evaluations=2)
    with pytest.raises(ConditionError, match="point down"):
        fit_outline(hall, hall.positions, rise=0.35, held=down, sheet="f-")


def test_around_a_courtyard_there_are_no_ends_to_miss():
    court = shapes.polygon(HALL, [HALL * 0.3 + [3.0, 2.0]], max_edge=0.8, corner_radius=0.4)
    held = conditions.binormal(court, "hole0", tilt=np.radians(-20))
    fit_outline(court, court.positions, rise=0.35, held=held, max_evaluations=2)


def test_a_mirror_whose_plane_leaves_the_ends_of_its_side():
    sharp = shapes.polygon(HALL, max_edge=0.75)
    settings = Settings(default_kind="line")
    for more in ({}, {"side0": ("plane", {"normal": touched(0, 50)})}):
        plan = Plan.from_shape(sharp, {"side3": ("mirror", {"normal": (-0.8, 0.6, 0.0)}), **more})
        with pytest.raises(ConditionError, match=r"passes up to 1\.8 beside the ends of its side"):
            form(plan, settings)
    nearly = Plan.from_shape(sharp, {"side3": ("mirror", {"normal": (-1.0, 0.005, 0.0)})})
    assert form(nearly, settings).ok


def test_one_mirror_for_two_parallel_walls_is_refused():
    sharp = shapes.polygon(HALL, max_edge=0.75)
    walls = {name: ("mirror", {"normal": (1.0, 0.0, 0.0)}) for name in ("side1", "side3")}
    with pytest.raises(ConditionError, match="give sides in several planes a mirror each"):
        form(Plan.from_shape(sharp, walls), Settings(default_kind="line"))
