"""Colours of results: the measures, their range, and what later changes do to them."""

from __future__ import annotations

import json
import os

import bpy

# isort: split
import numpy as np
import pytest
from numpy.testing import assert_allclose

from .scenes import activate, add_group, boundary_edges, jittered, mesh_object, quad_disc, quad_ring, snapshot, values

MEASURES = ("cmc_mean_curvature", "cmc_gauss_curvature", "cmc_distortion", "cmc_deviation")


def solve(plan, **settings):
    activate(plan)
    assert bpy.ops.cmc.solve(**settings) == {"FINISHED"}
    return plan.cmc.f_plus


def hall(rows: int = 10, columns: int = 16):
    """A rectangular plan of quads, twice as long as wide, its rim leaning by 35°."""
    x, y = np.meshgrid(np.linspace(0, 8, columns + 1), np.linspace(0, 4, rows + 1), indexing="ij")
    index = np.arange(x.size).reshape(x.shape)
    faces = np.stack([index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:]], axis=-1).reshape(-1, 4)
    plan = mesh_object("Hall", np.stack([x.ravel(), y.ravel(), 0 * x.ravel()], axis=1), faces)
    add_group(plan, "Rim", boundary_edges(plan.data), "BINORMAL", tilt=0.6)
    return plan


def colours(result) -> np.ndarray:
    return np.array(values(result.data.attributes["CMC"]))


def numbers(result, name: str) -> np.ndarray:
    return np.array(values(result.data.attributes[name]))


def shown(result) -> tuple:
    mesh = result.data
    return mesh.color_attributes.active_color_name, "CMC" in mesh.attributes


def maps():
    from cmc_formfinding.cmc_addon.properties import colour_maps

    return colour_maps


def module(name: str):
    import importlib

    return importlib.import_module(f"cmc_formfinding.cmc_addon.{name}")


# --- what is measured ----------------------------------------------------------------------

def test_numbers_are_on_the_shell():
    plan = hall()
    result = solve(plan, want_twin=True)
    sheet = json.loads(plan.cmc.report)["sheets"]["f+"]
    for ob in (result, plan.cmc.f_minus):
        for name in MEASURES[:3]:
            assert (ob.data.attributes[name].domain, ob.data.attributes[name].data_type) == ("POINT", "FLOAT")
            assert np.isfinite(numbers(ob, name)).all()
    assert "CMC" not in result.data.attributes
    H = sheet["mean_curvature"]["target"]
    assert np.median(numbers(result, "cmc_mean_curvature")) == pytest.approx(H, rel=0.05)
    assert numbers(result, "cmc_distortion").mean() == pytest.approx(sheet["distortion"]["mean"], rel=0.1)
    off = numbers(result, "cmc_deviation")
    rim = np.unique([plan.data.edges[e].vertices[:] for e in boundary_edges(plan.data)])
    assert off.max() == pytest.approx(sheet["outline"]["max"], rel=1e-5)
    assert (off[rim] >= 0.0).all() and (np.delete(off, rim) == -1.0).all()
    assert "cmc_deviation" not in plan.cmc.f_minus.data.attributes


def test_a_hemisphere_is_a_sphere():
    plan = quad_disc(rings=12, columns=48)
    result = solve(plan)
    H = result["cmc_mean_curvature"]
    assert_allclose(numbers(result, "cmc_gauss_curvature"), H * H, rtol=0.05)
    assert_allclose(numbers(result, "cmc_mean_curvature"), H, rtol=0.05)


def test_curvature_is_measured_from_the_mesh_where_it_is_missing():
    """On results of older versions, and hanging shells: the same numbers as those of the solve."""
    plan = hall()
    for flip in (False, True):
        result = solve(plan, flip=flip)
        for name in MEASURES[:2]:
            measured = numbers(result, name)
            result.data.attributes.remove(result.data.attributes[name])
            found = module("bridges.colour_bridge").measure(result.data, name)
            assert_allclose(found, measured, rtol=1e-2, atol=1e-3 * np.abs(measured).max())
        assert module("bridges.colour_bridge").measure(result.data, "cmc_nothing") is None


def test_a_shell_cut_open_has_numbers_on_both_sides():
    plan = quad_ring(rings=6, columns=36)
    result = solve(plan)
    assert len(result.data.vertices) > len(plan.data.vertices)
    plan.cmc.colour_by = "DISTORTION"
    assert len(colours(result)) == len(result.data.vertices)
    assert numbers(result, "cmc_distortion").min() >= 1.0


@pytest.mark.parametrize("combinatorics", ["DUAL", "CORNER"])
def test_other_meshes_have_numbers_too(combinatorics):
    plan = jittered(hall())
    plan.cmc.colour_by = "MEAN_CURVATURE"
    result = solve(plan, combinatorics=combinatorics)
    H = numbers(result, "cmc_mean_curvature")
    assert np.median(H) == pytest.approx(result["cmc_mean_curvature"], rel=0.05)
    assert len(colours(result)) == len(result.data.vertices) != len(plan.data.vertices)
    assert (numbers(result, "cmc_deviation") >= 0.0).sum() > 20
    solve(plan, combinatorics="PRIMAL")
    assert len(colours(result)) == len(plan.data.vertices)


# --- colours -------------------------------------------------------------------------------

@pytest.mark.parametrize("by", ["MEAN_CURVATURE", "GAUSS_CURVATURE", "DISTORTION", "DEVIATION"])
def test_colours_are_those_of_the_numbers(by):
    plan = hall()
    result = solve(plan)
    plan.cmc.colour_by = by
    name = module("properties.colour_settings").QUANTITIES[by].attribute
    found = module("results.colours").stored_range(result)
    measured = numbers(result, name)
    known = measured >= 0.0 if by == "DEVIATION" else np.isfinite(measured)
    expected = maps().linear(found.colours(measured))
    assert_allclose(colours(result)[known, :3], expected[known], atol=2e-3)
    assert_allclose(colours(result)[:, 3], 1.0)
    assert shown(result) == ("CMC", True)


def test_the_target_is_in_the_middle():
    plan = hall()
    result = solve(plan)
    plan.cmc.colour_by = "MEAN_CURVATURE"
    found = module("results.colours").stored_range(result)
    assert found.centre == pytest.approx(result["cmc_mean_curvature"], rel=1e-5)
    assert found.high - found.centre == pytest.approx(found.centre - found.low, rel=1e-4)
    middle = np.abs(numbers(result, "cmc_mean_curvature") - found.centre).argmin()
    assert_allclose(colours(result)[middle, :3], maps().linear(maps().RAMPS["diverging"][3]), atol=0.1)


def test_a_target_that_is_newer_than_the_report():
    """While a shell is dragged it has no report; the nearest surface of the same plan has its own."""
    plan = hall()
    plan.cmc.colour_by = "MEAN_CURVATURE"
    result = solve(plan)
    for vertex in plan.data.vertices:
        vertex.co.z -= 0.02 * (vertex.co.x**2 + vertex.co.y**2)
    assert bpy.ops.cmc.approximate_surface() == {"FINISHED"}
    of_nearest = tuple(plan.cmc.nearest.cmc.colour_range)
    module("results.colours").repaint(plan, target=0.3)
    assert module("results.colours").stored_range(result).centre == pytest.approx(0.3)
    assert tuple(plan.cmc.nearest.cmc.colour_range) == of_nearest


def test_none_leaves_nothing_behind():
    """The plan's own colours come back as the active ones."""
    plan = hall()
    plan.data.color_attributes.new("Tint", "FLOAT_COLOR", "POINT")
    plan.data.color_attributes.active_color_name = "Tint"
    result = solve(plan)
    before = snapshot()
    plan.cmc.colour_by = "GAUSS_CURVATURE"
    assert shown(result) == ("CMC", True)
    solve(plan)
    plan.cmc.colour_by = "NONE"
    assert shown(result) == ("Tint", False)
    result.cmc.colour_range = (0.0,) * 6
    assert snapshot()["meshes"] == before["meshes"]


def test_changing_what_is_shown_solves_nothing(monkeypatch):
    plan = hall()
    result = solve(plan)
    form = module("tasks.solve").form
    monkeypatch.setattr(form, "form", lambda *_, **__: pytest.fail("it was solved again"))
    seen = set()
    for by in ("MEAN_CURVATURE", "GAUSS_CURVATURE", "DISTORTION", "DEVIATION"):
        plan.cmc.colour_by = by
        seen.add(colours(result).tobytes())
    assert len(seen) == 4


def test_the_next_solve_colours_again():
    plan = hall()
    plan.cmc.colour_by = "GAUSS_CURVATURE"
    result = solve(plan)
    before, wide = colours(result), module("results.colours").stored_range(result)
    plan.data.cmc.groups[0].tilt = 0.2
    solve(plan, size="HEIGHT", height=2.0)
    assert shown(result) == ("CMC", True)
    assert not np.allclose(colours(result), before, atol=0.02)
    assert module("results.colours").stored_range(result) != wide
    assert_allclose(
        colours(result)[:, :3],
        maps().linear(module("results.colours").stored_range(result).colours(numbers(result, "cmc_gauss_curvature"))),
        atol=2e-3,
    )


def test_all_sheets_have_the_range_of_the_shell():
    """f- too; the Gauss image and g have the shell's colours."""
    plan = hall()
    plan.cmc.colour_by = "GAUSS_CURVATURE"
    result = solve(plan, want_twin=True, want_g=True, want_gauss=True)
    ranges = [tuple(ob.cmc.colour_range) for ob in (result, plan.cmc.f_minus, plan.cmc.g, plan.cmc.gauss)]
    assert len(set(ranges)) == 1
    assert_allclose(colours(plan.cmc.gauss), colours(result))
    assert_allclose(colours(plan.cmc.g), colours(result))
    assert not np.allclose(colours(plan.cmc.f_minus), colours(result), atol=0.05)
    solve(plan, sheet="F_MINUS")
    assert_allclose(colours(plan.cmc.gauss), colours(plan.cmc.f_minus))


def test_a_range_set_by_hand():
    """It begins with the fitted one, stays through the next solve, and is dropped for another quantity."""
    plan = hall()
    result = solve(plan)
    plan.cmc.colour_by = "GAUSS_CURVATURE"
    fitted = module("results.colours").stored_range(result)
    before = colours(result)
    plan.cmc.colour_fit = False
    assert (plan.cmc.colour_min, plan.cmc.colour_max) == pytest.approx((fitted.low, fitted.high))
    assert_allclose(colours(result), before, atol=1e-4)
    plan.cmc.colour_max = 10.0 * fitted.high
    assert not np.allclose(colours(result), before, atol=0.05)
    solve(plan, size="HEIGHT", height=2.0)
    assert module("results.colours").stored_range(result).high == pytest.approx(10.0 * fitted.high)
    plan.cmc.colour_by = "DISTORTION"
    assert plan.cmc.colour_fit
    assert module("results.colours").stored_range(result).low == 1.0


def test_missing_values_are_grey():
    """An older result has no distortion until it is solved again."""
    plan = hall()
    result = solve(plan)
    result.data.attributes.remove(result.data.attributes["cmc_distortion"])
    plan.cmc.colour_by = "DISTORTION"
    assert module("results.colours").stored_range(result) is None
    assert_allclose(colours(result)[:, :3], maps().linear(maps().NOT_KNOWN[0]))
    solve(plan)
    assert module("results.colours").stored_range(result).low == 1.0


def test_nearest_surfaces():
    dome = quad_disc("Dome", rise=1.0, rings=8, columns=32)
    dome.cmc.colour_by = "DEVIATION"
    assert bpy.ops.cmc.approximate_surface() == {"FINISHED"}
    nearest = dome.cmc.nearest
    assert (numbers(nearest, "cmc_deviation") >= 0.0).all()
    assert shown(nearest) == ("CMC", True)
    assert "cmc_deviation_colour" in nearest.data.attributes
    dome.cmc.colour_by = "NONE"
    assert shown(nearest) == ("cmc_deviation_colour", False)


def test_copies_by_symmetry():
    bpy.ops.cmc.add_module(module="HONEYCOMB", edges=8)
    plan = bpy.context.object
    plan.cmc.colour_by = "GAUSS_CURVATURE"
    solve(plan)
    assert bpy.ops.cmc.complete() == {"FINISHED"}
    copies = plan.cmc.completed
    assert len(colours(copies)) == len(copies.data.vertices)
    assert tuple(copies.cmc.colour_range) == tuple(plan.cmc.f_plus.cmc.colour_range)
    assert numbers(copies, "cmc_gauss_curvature").min() == pytest.approx(
        numbers(plan.cmc.f_plus, "cmc_gauss_curvature").min(), rel=1e-4)
    assert bpy.ops.cmc.complete(complete_as="INSTANCES") == {"FINISHED"}
    meshes = {ob.data for ob in plan.cmc.copies.objects}
    assert all("CMC" in mesh.attributes for mesh in meshes)
    plan.cmc.colour_by = "NONE"
    assert not any("CMC" in mesh.attributes for mesh in bpy.data.meshes)


def test_two_plans_have_colours_of_their_own():
    one, other = hall(), quad_disc()
    solve(one)
    solve(other)
    one.cmc.colour_by = "DISTORTION"
    assert "CMC" in one.cmc.f_plus.data.attributes
    assert "CMC" not in other.cmc.f_plus.data.attributes


def test_a_result_in_edit_mode_waits():
    plan = hall()
    result = solve(plan)
    activate(result)
    bpy.ops.object.mode_set(mode="EDIT")
    plan.cmc.colour_by = "DISTORTION"
    bpy.ops.object.mode_set(mode="OBJECT")
    assert "CMC" not in result.data.attributes
    plan.cmc.colour_by = "GAUSS_CURVATURE"
    assert shown(result) == ("CMC", True)


def test_undo_save_and_load(tmp_path):
    plan = hall()
    solve(plan)
    bpy.ops.ed.undo_push(message="Solved")
    plan.cmc.colour_by = "GAUSS_CURVATURE"
    bpy.ops.ed.undo_push(message="Coloured")
    bpy.ops.ed.undo()
    plan = bpy.data.objects["Hall"]
    assert plan.cmc.colour_by == "NONE" and "CMC" not in plan.cmc.f_plus.data.attributes
    bpy.ops.ed.redo()
    result = bpy.data.objects["Hall"].cmc.f_plus
    found = colours(result)
    assert shown(result) == ("CMC", True)
    path = os.fspath(tmp_path / "hall.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path)
    bpy.ops.wm.open_mainfile(filepath=path)
    plan = bpy.data.objects["Hall"]
    assert_allclose(colours(plan.cmc.f_plus), found)
    plan.cmc.colour_by = "DISTORTION"
    assert not np.allclose(colours(plan.cmc.f_plus), found)
