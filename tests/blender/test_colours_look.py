"""The panel Look: its legend, curvature lines, and normals on a sphere."""

from __future__ import annotations

import json
from types import SimpleNamespace

import bpy

# isort: split
import numpy as np
import pytest
from mathutils import Euler, Vector
from numpy.testing import assert_allclose

from .scenes import activate, positions, quad_disc, values
from .sidebar import draw
from .test_colours import colours, hall, module, solve


def legend():
    return module("drawing.legend").legend_of(bpy.context)


# --- the legend ----------------------------------------------------------------------------

def test_no_legend_without_colours():
    plan = hall()
    solve(plan)
    assert legend() is None
    activate(None)
    assert legend() is None


def test_the_legend_says_what_is_shown():
    plan = hall()
    result = solve(plan)
    plan.cmc.colour_by = "MEAN_CURVATURE"
    found = legend()
    assert (found.title, found.subtitle) == ("Mean Curvature", "1/m  Hall f+")
    assert [place for place, _ in found.labels] == pytest.approx([0.0, 0.5, 1.0])
    low, middle, high = (text for _, text in found.labels)
    assert middle.endswith("  target") and middle.startswith(f"{result['cmc_mean_curvature']:.3f}"[:5])
    assert low.startswith("≤ ") or high.startswith("≥ ")  # two of a hundred are beyond
    plan.cmc.colour_by = "GAUSS_CURVATURE"
    assert legend().subtitle == "1/m²  Hall f+"
    plan.cmc.colour_by = "DEVIATION"
    assert legend().labels[-1][1].endswith("m")
    bpy.context.scene.unit_settings.system = "NONE"
    plan.cmc.colour_by = "MEAN_CURVATURE"
    assert legend().subtitle == "per unit  Hall f+"


@pytest.mark.parametrize(
    ("ground", "theme", "text", "shadow"),
    [(0.2, 1.0, 1.0, 0.0), (0.39, 1.0, 1.0, 0.0), (0.9, 1.0, 0.0, 1.0), (0.9, 0.0, 0.0, 1.0), (0.1, 0.0, 1.0, 0.0)],
)
def test_its_text_is_unlike_the_ground(ground, theme, text, shadow):
    """The dark theme, Blender's light one, and colours of one's own."""
    space = SimpleNamespace(text_hi=(theme,) * 3, gradients=SimpleNamespace(high_gradient=(ground,) * 3))
    assert module("drawing.legend").inks(space) == ((text, text, text, 1.0), (shadow, shadow, shadow, 0.7))


def test_it_is_about_the_result_that_is_active_and_seen():
    plan = hall()
    plan.cmc.colour_by = "GAUSS_CURVATURE"
    result = solve(plan, want_twin=True)
    activate(plan.cmc.f_minus)
    assert legend().subtitle.endswith("Hall f-")
    activate(plan)
    assert legend().subtitle.endswith("Hall f+")
    result.hide_set(True)
    assert legend().subtitle.endswith("Hall f-")
    plan.cmc.f_minus.hide_set(True)
    assert legend() is None
    other = quad_disc()
    activate(other)
    assert legend() is None


def test_legend_and_switch_stay_when_another_object_is_active():
    plan = hall()
    solve(plan)
    plan.cmc.colour_by = "MEAN_CURVATURE"
    bpy.ops.object.empty_add()
    for other in (bpy.context.object, quad_disc("Other"), None):
        activate(other)
        assert legend().subtitle.endswith("Hall f+")
        record = draw("CMC_PT_look")
        assert "Hall" in record.texts and "colour_by" in record.props and not record.operators
    plan.cmc.f_plus.hide_set(True)
    assert legend() is None and "colour_by" not in draw("CMC_PT_look").props
    plan.cmc.f_plus.hide_set(False)
    plan.cmc.colour_by = "NONE"
    assert legend() is None and "colour_by" not in draw("CMC_PT_look").props


def test_it_says_that_something_was_not_measured():
    plan = hall()
    result = solve(plan)
    result.data.attributes.remove(result.data.attributes["cmc_distortion"])
    plan.cmc.colour_by = "DISTORTION"
    assert legend().labels == [] and "solve again" in legend().subtitle


def test_the_legend_of_instances_is_that_of_the_shell():
    bpy.ops.cmc.add_module(module="HONEYCOMB", edges=8)
    plan = bpy.context.object
    plan.cmc.colour_by = "GAUSS_CURVATURE"
    solve(plan)
    of_shell = legend()
    assert bpy.ops.cmc.complete(complete_as="INSTANCES") == {"FINISHED"}
    assert legend().labels == of_shell.labels
    activate(list(plan.cmc.copies.objects)[-1])
    assert legend().labels == of_shell.labels


# --- curvature lines -----------------------------------------------------------------------

def lab(srgb) -> np.ndarray:
    """CIELAB of sRGB colours (n, 3): equal distances look equal."""
    c = module("properties.colour_maps").linear(srgb)
    xyz = c @ np.array([(0.4124, 0.2126, 0.0193), (0.3576, 0.7152, 0.1192), (0.1805, 0.0722, 0.9505)])
    x, y, z = np.cbrt(xyz / [0.9505, 1.0, 1.089]).T
    return np.column_stack([116 * y - 16, 500 * (x - y), 200 * (y - z)])


def test_curvature_lines_stand_out_from_every_colour():
    """Orange lines on the orange of a large H were lost; 50 is a plain difference, 2 can just be seen."""
    maps, lines = module("properties.colour_maps"), module("drawing.curvature_lines_overlay")
    ranges = [maps.Range(0.0, 1.0), maps.Range(0.0, 1.0, 0.5)]
    ground = np.concatenate([span.colours(np.linspace(0.0, 1.0, 50)) for span in ranges])
    ground = lab(np.concatenate([ground, [maps.NOT_KNOWN, (0.8, 0.8, 0.8)]]))
    kinds = lab([colour[:3] for colour in lines._COLOURS])
    assert np.linalg.norm(kinds[:, None] - ground, axis=2).min() > 50
    assert np.linalg.norm(kinds[0] - kinds[1]) > 50 and abs(kinds[0, 0] - kinds[1, 0]) > 20


def lines(result, which="BOTH", spacing=0.0):
    return module("drawing.curvature_lines_overlay").lines_of(result.data, which, spacing)


def test_curvature_lines_run_across_and_along_a_hall():
    """In the middle of a long hall the shell bends across it, and least along it."""
    plan = hall(12, 24)
    result = solve(plan)
    first, second = lines(result)
    assert len(first) == len(second) > 100
    middle = np.abs(first.mean(axis=1)[:, :2] - [4.0, 2.0]).max(axis=1) < 1.0
    assert middle.any()
    for ends, axis in ((first, 1), (second, 0)):
        along = (ends[middle, 1] - ends[middle, 0])[:, :2]  # as seen from above
        assert (np.abs(along[:, axis]) > 0.9 * np.linalg.norm(along, axis=1)).all()


def test_curvature_lines_are_evenly_spread_and_as_long_as_their_spacing():
    plan = hall(16, 32)
    result = solve(plan)
    first, second = lines(result, "MAX", 0.6)
    assert len(second) == 0
    places = first.mean(axis=1)
    apart = np.linalg.norm(places[:, None] - places[None], axis=2) + 99.0 * np.eye(len(places))
    assert apart.min() > 0.6
    assert np.quantile(apart.min(axis=1), 0.95) < 1.2
    lengths = np.linalg.norm(first[:, 1] - first[:, 0], axis=1)
    assert_allclose(lengths, 0.62 * 0.6, rtol=1e-4)
    assert len(lines(result, "MAX", 0.3)[0]) > 2.5 * len(first)


def test_a_sphere_has_none():
    plan = quad_disc(rings=12, columns=48)
    first, second = lines(solve(plan))
    assert len(first) == len(second) == 0


def test_directions_are_an_attribute_once_curvature_lines_are_shown():
    """Unit vectors in the surface, zero where there are none; kept up to date by the next solve, gone without them."""
    plan = hall()
    result = solve(plan)
    assert "cmc_direction" not in result.data.attributes
    plan.cmc.curvature_lines = "BOTH"
    found = np.array(values(result.data.attributes["cmc_direction"]))
    normals = np.array(values(result.data.attributes["cmc_normal"]))
    length = np.linalg.norm(found, axis=1)
    assert ((np.abs(length - 1.0) < 1e-5) | (length == 0.0)).all() and (length > 0.5).mean() > 0.9
    assert np.abs(np.einsum("ni,ni->n", found, normals)).max() < 1e-5
    before = lines(result)[0]
    for flip in (True, False):
        solve(plan, flip=flip, size="HEIGHT", height=2.5)
        stored = np.array(values(result.data.attributes["cmc_direction"]))
        result.data.attributes.remove(result.data.attributes["cmc_direction"])
        again = module("bridges.colour_bridge").measure(result.data, "cmc_direction")
        both = stored.any(axis=1) & again.any(axis=1)
        assert both.mean() > 0.9
        assert np.abs(np.einsum("ni,ni->n", stored, again))[both].min() > 0.99
    assert not np.allclose(lines(result)[0], before)
    plan.cmc.curvature_lines = "NONE"
    solve(plan)
    assert "cmc_direction" not in result.data.attributes


@pytest.mark.parametrize("combinatorics", ["DUAL", "CORNER"])
def test_other_meshes_have_curvature_lines_too(combinatorics):
    plan = hall()
    plan.cmc.curvature_lines = "MAX"
    first, _ = lines(solve(plan, combinatorics=combinatorics), "MAX")
    assert len(first) > 50


def test_curvature_lines_stay_where_they_are_while_a_shell_changes_its_shape():
    plan = hall()
    result = solve(plan)
    before = module("drawing.curvature_lines_overlay")._places
    lines(result)
    kept = before[result.data.session_uid][1]
    solve(plan, size="HEIGHT", height=2.0)
    lines(result)
    assert module("drawing.curvature_lines_overlay")._places[result.data.session_uid][1] is kept


def test_curvature_lines_are_drawn_a_little_nearer_and_at_the_same_place():
    from mathutils import Matrix, Vector

    projection = Matrix(((1.2, 0, 0, 0), (0, 1.6, 0, 0), (0, 0, -1.002, -0.2), (0, 0, -1, 0)))
    moved = module("drawing.curvature_lines_overlay").nearer(projection, 20.0)
    parallel = Matrix(((0.2, 0, 0, 0), (0, 0.3, 0, 0), (0, 0, -0.01, 0), (0, 0, 0, 1)))
    for old, new in ((projection, moved), (parallel, module("drawing.curvature_lines_overlay").nearer(parallel, 20.0))):
        for z in (-1.0, -30.0):
            here, there = (matrix @ Vector((0.7, -0.4, z, 1.0)) for matrix in (old, new))
            assert tuple(there.xy / there.w) == pytest.approx(tuple(here.xy / here.w), abs=1e-6)
            assert there.z / there.w < here.z / here.w - 1e-5


# --- the Gauss image -----------------------------------------------------------------------

def test_the_gauss_image_is_made_without_a_solve(monkeypatch):
    """Where Solve would have made it, but for its place beside the shell; in the shell's colours."""
    plan = hall()
    plan.cmc.colour_by = "GAUSS_CURVATURE"
    shell = solve(plan)
    with monkeypatch.context() as patched:
        patched.setattr(module("tasks.solve").form, "form", lambda *_, **__: pytest.fail("it was solved again"))
        assert bpy.ops.cmc.gauss_image() == {"FINISHED"}
    image = plan.cmc.gauss
    assert plan.cmc.want_gauss and image.name == "Hall Gauss image"
    assert positions(image)[:, 0].max() < positions(shell)[:, 0].min()
    assert_allclose(colours(image), colours(shell))
    assert bpy.context.view_layer.objects.active == plan
    made, place = positions(image), tuple(image.location)
    solve(plan)
    assert plan.cmc.gauss == image and tuple(image.location) == place
    assert_allclose(positions(image), made, atol=1e-4)


@pytest.mark.parametrize("settings", [{"flip": True}, {"sheet": "F_MINUS"}, {"sheet": "F_MINUS", "flip": True}])
def test_of_other_sheets_too(settings):
    plan = hall()
    solve(plan, **settings)
    assert bpy.ops.cmc.gauss_image() == {"FINISHED"}
    made = positions(plan.cmc.gauss)
    solve(plan)
    assert_allclose(positions(plan.cmc.gauss), made, atol=1e-4)


def test_it_is_hidden_and_comes_back_where_it_was():
    plan = hall()
    solve(plan)
    bpy.ops.cmc.gauss_image()
    image = plan.cmc.gauss
    image.location.y += 3.0
    place = tuple(image.location)
    bpy.ops.cmc.gauss_image()
    assert image.hide_viewport and not plan.cmc.want_gauss
    solve(plan)
    assert image.hide_viewport
    bpy.ops.cmc.gauss_image()
    assert plan.cmc.gauss == image and not image.hide_viewport
    assert tuple(image.location) == place


def test_one_that_solve_has_made_is_moved_aside():
    plan = hall()
    shell = solve(plan, want_gauss=True)
    image = plan.cmc.gauss
    assert positions(image)[:, 0].max() > positions(shell)[:, 0].min()
    bpy.ops.cmc.gauss_image()
    bpy.ops.cmc.gauss_image()
    assert positions(image)[:, 0].max() < positions(shell)[:, 0].min()


@pytest.mark.parametrize("turn", [0.0, 46.7, 135.0, 200.0])
@pytest.mark.parametrize("tip", [0.0, 63.6])
def test_it_is_beside_the_shell_as_it_is_seen(turn, tip):
    """Not in front of it nor behind: no point of it is in line with one of the shell."""
    plan = hall()
    shell = solve(plan)
    view = Euler((np.radians(tip), 0.0, np.radians(turn))).to_quaternion()
    space = SimpleNamespace(type="VIEW_3D", region_3d=SimpleNamespace(view_rotation=view))
    image = module("results.gauss_image").show(
        SimpleNamespace(space_data=space, view_layer=bpy.context.view_layer, scene=bpy.context.scene), plan)
    right = np.array(view @ Vector((1.0, 0.0, 0.0)))
    assert (positions(image) @ right).max() < (positions(shell) @ right).min()
    ahead = np.array(view @ Vector((0.0, 0.0, -1.0)))
    assert abs(np.array(image.location - image.cmc.placed_at) @ ahead) < 1e-4


def test_it_needs_a_shell():
    plan = hall()
    activate(plan)
    assert not bpy.ops.cmc.gauss_image.poll()
    with pytest.raises(RuntimeError, match="no shell yet"):
        bpy.ops.cmc.gauss_image()
    solve(plan)
    activate(plan.cmc.f_plus)
    assert bpy.ops.cmc.gauss_image() == {"FINISHED"}
    assert json.loads(plan.cmc.gauss["cmc_report"])["plan"] == "Hall"
