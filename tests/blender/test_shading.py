"""Viewports switch to colours while results are coloured, and back."""

from __future__ import annotations

import bpy
import pytest

from .scenes import quad_disc
from .test_colours import hall, module, solve


def views() -> list:
    return module("drawing.shading").views(bpy.context.window_manager)


@pytest.fixture
def windows():
    """Factory settings with their screens, and the add-on in them."""
    bpy.ops.wm.read_homefile(use_factory_startup=True)
    import addon_utils

    addon_utils.enable("cmc_formfinding", default_set=True)
    if not views():
        pytest.skip("no viewport here")


def test_viewports_show_colours_and_go_back(windows):
    plan = hall()
    solve(plan)
    views()[0].shading.color_type = "OBJECT"
    plan.cmc.colour_by = "DISTORTION"
    assert views()[0].shading.color_type == "VERTEX"
    plan.cmc.colour_by = "GAUSS_CURVATURE"
    other = quad_disc()
    other.cmc.colour_by = "DISTORTION"
    plan.cmc.colour_by = "NONE"
    assert views()[0].shading.color_type == "VERTEX"
    other.cmc.colour_by = "NONE"
    assert views()[0].shading.color_type == "OBJECT"


def test_another_shading_chosen_meanwhile_stays(windows):
    plan = hall()
    solve(plan)
    plan.cmc.colour_by = "DISTORTION"
    views()[0].shading.color_type = "RANDOM"
    solve(plan)
    assert views()[0].shading.color_type == "RANDOM"
    plan.cmc.colour_by = "NONE"
    assert views()[0].shading.color_type == "RANDOM"


def test_undoing_the_click_brings_the_shading_back(windows):
    plan = hall()
    solve(plan)
    views()[0].shading.color_type = "OBJECT"
    bpy.ops.ed.undo_push(message="Solved")
    plan.cmc.colour_by = "DISTORTION"
    bpy.ops.ed.undo_push(message="Coloured")
    bpy.ops.ed.undo()
    assert views()[0].shading.color_type == "OBJECT"
    bpy.ops.ed.redo()
    assert views()[0].shading.color_type == "VERTEX"
