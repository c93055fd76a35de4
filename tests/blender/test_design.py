"""Approximate Surface and Fit to Outline: what they form and measure, what they leave alone, and how they end."""

from __future__ import annotations

import json
import threading
from types import SimpleNamespace

import bpy

# isort: split
import numpy as np
import pytest
from numpy.testing import assert_allclose

from .scenes import activate, boundary_edges, mesh_object, positions, quad_disc, quad_ring, snapshot, values

FINISHED, CANCELLED = {"FINISHED"}, {"CANCELLED"}


def rim_of(plan) -> np.ndarray:
    return np.unique([tuple(plan.data.edges[e].vertices) for e in boundary_edges(plan.data)])


def fitted(plan, **settings) -> np.ndarray:
    """World points of the result of Fit to Outline."""
    activate(plan)
    assert bpy.ops.cmc.fit_outline(**settings) == FINISHED
    return positions(plan.cmc.fit)


def approximated(surface, **settings) -> np.ndarray:
    activate(surface)
    assert bpy.ops.cmc.approximate_surface(**settings) == FINISHED
    return positions(surface.cmc.nearest)


def report(plan) -> dict:
    return json.loads(plan.cmc.design_report)


def off_line(points: np.ndarray, line: np.ndarray) -> np.ndarray:
    """Distances of points from a closed polyline."""
    a, d = line, np.roll(line, -1, axis=0) - line
    t = np.einsum("nmi,mi->nm", points[:, None] - a, d) / np.einsum("mi,mi->m", d, d)
    return np.linalg.norm(points[:, None] - a - t.clip(0, 1)[..., None] * d, axis=2).min(axis=1)


def small_disc(name="Disc", **options):
    return quad_disc(name, rings=5, columns=24, **options)


def cap(name="Cap", rings=8, columns=32, radius=4.0, ball=5.0):
    """A piece of a sphere over a disc."""
    ob = quad_disc(name, rings=rings, columns=columns, radius=radius)
    for vertex in ob.data.vertices:
        vertex.co.z = np.sqrt(ball**2 - vertex.co.x**2 - vertex.co.y**2)
    return ob


# --- the knobs -----------------------------------------------------------------------------

@pytest.mark.parametrize("rise", [0.15, 0.5, 1.0])
def test_rise_keeps_the_outline(rise):
    """From flat to hemisphere over a circle: the cap of that height, its rim on the circle."""
    plan = small_disc()
    points = fitted(plan, fit_rise=rise)
    rim = rim_of(plan)
    assert off_line(points[rim], positions(plan)[rim]).max() < 0.01 * 8.0
    assert_allclose(points[:, 2].max(), 4.0 * rise, rtol=0, atol=4e-3)
    height = points[:, 2].max()
    ball = (16.0 + height**2) / (2 * height)
    assert_allclose(np.linalg.norm(points - [0, 0, height - ball], axis=1), ball, rtol=0.01, atol=0)
    assert plan.cmc.fit_rise == pytest.approx(rise)


def test_rise_keeps_an_oblong_outline_wherever_it_lies():
    plan = quad_disc(rings=5, columns=32)
    plan.location, plan.rotation_euler, plan.scale = (120.0, 30.0, 2.0), (0.0, 0.0, 0.7), (1.6, 1.0, 1.0)
    drawn = positions(plan)
    for rise in (0.3, 0.8):
        points = fitted(plan, fit_rise=rise)
        rim = rim_of(plan)
        assert off_line(points[rim], drawn[rim]).max() < 0.01 * 12.8
        extent = np.ptp(drawn[:, :2], axis=0).min()
        assert_allclose(points[:, 2].max() - 2.0, 0.5 * rise * extent, rtol=5e-3, atol=0)
    assert tuple(plan.cmc.fit.location) == pytest.approx((120.0, 30.0, 2.0))


def test_height():
    plan = small_disc()
    plan.location.z = 3.0
    points = fitted(plan, knob="HEIGHT", fit_height=1.5)
    assert points[:, 2].max() - 3.0 == pytest.approx(1.5, rel=2e-3)


def test_volume():
    plan = small_disc()
    points = fitted(plan, knob="VOLUME", fit_volume=40.0)
    x, y = points[:, 0], points[:, 1]
    found = 0.0
    for polygon in plan.cmc.fit.data.polygons:
        corner = list(polygon.vertices)
        for k in range(1, len(corner) - 1):
            t = [corner[0], corner[k], corner[k + 1]]
            area = 0.5 * ((x[t[1]] - x[t[0]]) * (y[t[2]] - y[t[0]]) - (x[t[2]] - x[t[0]]) * (y[t[1]] - y[t[0]]))
            found += area * points[t, 2].mean()
    assert found == pytest.approx(40.0, rel=0.01)


def test_mean_curvature():
    plan = small_disc()
    points = fitted(plan, knob="MEAN_CURVATURE", fit_mean_curvature=0.2)
    assert report(plan)["mean_curvature"] == pytest.approx(0.2)
    assert points[:, 2].max() == pytest.approx(2.0, rel=0.02)
    curvature = np.array(values(plan.cmc.fit.data.attributes["cmc_mean_curvature"]))
    assert np.median(curvature) == pytest.approx(0.2, rel=0.02)


# --- what is fitted to ---------------------------------------------------------------------

def raised_loop(name="Curve", count=48, radius=4.0, lift=0.5):
    t = 2 * np.pi * np.arange(count) / count
    points = np.column_stack([radius * np.cos(t), radius * np.sin(t), 1.0 + lift * np.cos(2 * t)])
    return mesh_object(name, points, [], edges=[(k, (k + 1) % count) for k in range(count)]), points


def test_a_curve_that_rises_and_falls():
    curve, line = raised_loop()
    plan = small_disc()
    points = fitted(plan, curve="Curve", fit_rise=0.5)
    assert (plan.cmc.fit_to, plan.cmc.fit_curve) == ("CURVE", curve)
    assert off_line(points[rim_of(plan)], line).max() < 0.01 * 8.0
    assert_allclose(fitted(plan), points, rtol=0, atol=1e-5)  # what was said is kept


def test_a_curve_object():
    bpy.ops.curve.primitive_bezier_circle_add(radius=3.0, location=(10.0, 0.0, 1.0))
    circle = bpy.context.object
    plan = small_disc()
    points = fitted(plan, curve=circle.name, fit_rise=0.5)
    rim = points[rim_of(plan)] - [10.0, 0.0, 1.0]
    assert_allclose(np.linalg.norm(rim[:, :2], axis=1), 3.0, rtol=0.01, atol=0)
    assert_allclose(rim[:, 2], 0.0, rtol=0, atol=0.03)


def test_free_heights():
    """Seen from above the rim is on the outline; told to keep its heights it is on it in space, too."""
    plan = quad_disc(rings=5, columns=32)
    plan.scale = (1.6, 1.0, 1.0)
    points = fitted(plan, free_heights=True, fit_rise=0.4)
    rim = rim_of(plan)
    drawn = positions(plan)[rim]
    assert off_line(points[rim] * [1, 1, 0], drawn).max() < 0.01 * 12.8


def empties(places, collection=None):
    found = []
    for k, place in enumerate(places):
        ob = bpy.data.objects.new(f"Anchor {k}", None)
        ob.location = place
        (collection or bpy.context.scene.collection).objects.link(ob)
        found.append(ob)
    return found


FEET = [(4.0, 0.0, 0.0), (0.0, 4.0, 0.4), (-4.0, 0.0, 0.0), (0.0, -4.0, 0.4)]


def nearest(points, place) -> float:
    return np.linalg.norm(points - place, axis=1).min()


def test_selected_empties_are_anchors():
    plan = small_disc()
    for ob in empties(FEET):
        ob.select_set(True)
    points = fitted(plan, fit_to="ANCHORS", fit_rise=0.5)
    assert max(nearest(points, place) for place in FEET) < 0.01 * 8.0


def test_a_collection_of_anchors_with_weights():
    supports = bpy.data.collections.new("Supports")
    bpy.context.scene.collection.children.link(supports)
    off = empties([*FEET, (0.0, 0.0, 40.0)], supports)[-1]
    off.cmc.anchor_weight = 0.0
    plan = small_disc()
    points = fitted(plan, anchors="Supports")
    assert (plan.cmc.fit_to, plan.cmc.fit_anchors) == ("ANCHORS", supports)
    assert max(nearest(points, place) for place in FEET) < 0.01 * 8.0
    assert report(plan)["distances"]["anchors"] < 0.01 * 8.0, "one without weight does not count"


def test_a_weak_anchor_that_is_missed_is_told_of():
    supports = bpy.data.collections.new("Supports")
    bpy.context.scene.collection.children.link(supports)
    weak = empties([(4.0, 0.0, 6.0), *FEET[1:]], supports)[0]
    weak.cmc.anchor_weight = 1e-4
    plan = small_disc()
    points = fitted(plan, anchors="Supports")
    off = nearest(points, (4.0, 0.0, 6.0))
    assert off > 1.0 and report(plan)["distances"]["anchors"] > off - 1e-3 and not report(plan)["met"]


def test_anchors_that_contradict_say_so():
    supports = bpy.data.collections.new("Supports")
    bpy.context.scene.collection.children.link(supports)
    low, high = empties([(4.0, 0.0, 0.0), (4.0, 0.0, 3.0)], supports)
    plan = small_disc()
    low.cmc.anchor_weight, high.cmc.anchor_weight = 1.0, 4.0
    points = fitted(plan, anchors="Supports")
    assert not report(plan)["met"] and "anchor is missed" in report(plan)["message"]
    assert nearest(points, (4.0, 0.0, 3.0)) < nearest(points, (4.0, 0.0, 0.0))


# --- which way up --------------------------------------------------------------------------

def test_hanging_is_standing_in_a_mirror():
    plan = small_disc()
    plan.location.z = 2.0
    up = fitted(plan)
    down = fitted(plan, hanging=True)
    assert_allclose(down, up * [1, 1, -1] + [0, 0, 4.0], rtol=0, atol=1e-4)
    mesh = plan.cmc.fit.data
    curvature = np.array(values(mesh.attributes["cmc_mean_curvature"]))
    assert np.median(curvature) > 0
    normals, faces = np.array(values(mesh.attributes["cmc_normal"])), [p.normal for p in mesh.polygons]
    around = [normals[list(p.vertices)].mean(axis=0) for p in mesh.polygons]
    assert all(np.dot(a, n) > 0.9 for a, n in zip(around, faces, strict=True))


def test_faces_that_look_down_hang():
    plan = small_disc()
    up = fitted(plan)
    plan.data.flip_normals()
    points = fitted(plan)
    assert points[:, 2].min() == pytest.approx(-up[:, 2].max(), rel=1e-3)
    assert points[:, 2].max() < 0.05


def test_a_plan_on_a_wall():
    plan = small_disc()
    plan.rotation_euler = (np.pi / 2, 0.0, 0.0)  # its faces look along -y
    points = fitted(plan)
    assert -points[:, 1].min() == pytest.approx(2.0, rel=5e-3)
    assert abs(points[rim_of(plan), 1]).max() < 0.08


# --- the nearest surface -------------------------------------------------------------------

def test_a_sphere_is_its_own_nearest_surface():
    surface = cap()
    points = approximated(surface, smoothness=0.0)
    assert_allclose(points, positions(surface), rtol=0, atol=0.05)
    mesh = surface.cmc.nearest.data
    deviation = np.array(values(mesh.attributes["cmc_deviation"]))
    assert deviation.shape == (len(mesh.vertices),)
    assert deviation.max() < 0.05
    curvature = np.array(values(mesh.attributes["cmc_mean_curvature"]))
    assert np.median(curvature) == pytest.approx(0.2, rel=0.02)
    assert report(surface)["deviation"]["max"] == pytest.approx(deviation.max(), rel=1e-4)


def wavy(name="Wavy"):
    ob = quad_disc(name, rings=8, columns=32, rise=1.5)
    for vertex in ob.data.vertices:
        vertex.co.z += 0.15 * np.sin(3 * vertex.co.x) * np.cos(2 * vertex.co.y)
    ob.location = (30.0, -20.0, 5.0)
    return ob


def test_deviation_is_the_distance_to_the_original():
    """Not to its vertices, and in the world; the largest is red."""
    surface = wavy()
    points = approximated(surface)
    deviation = np.array(values(surface.cmc.nearest.data.attributes["cmc_deviation"]))
    dense = surface.data.copy()
    other = bpy.data.objects.new("Dense", dense)
    bpy.context.scene.collection.objects.link(other)
    other.location = surface.location
    other.modifiers.new("Fine", "SUBSURF").subdivision_type = "SIMPLE"
    other.modifiers["Fine"].levels = 4
    bpy.context.view_layer.update()
    fine = other.evaluated_get(bpy.context.evaluated_depsgraph_get()).to_mesh()
    samples = np.array([other.matrix_world @ v.co for v in fine.vertices])
    by_samples = np.array([np.linalg.norm(samples - p, axis=1).min() for p in points])
    # quads are bent: Blender's surface and ours, of triangles, differ by a little
    assert_allclose(deviation, by_samples, rtol=0, atol=0.04)
    assert 0.05 < deviation.max() < 0.6
    colours = np.array(values(surface.cmc.nearest.data.attributes["cmc_deviation_colour"]))
    red, blue = colours[deviation.argmax()], colours[deviation.argmin()]
    assert red[0] > 2 * red[2] and blue[2] > 2 * blue[0]
    assert surface.cmc.nearest.data.color_attributes.active_color_name == "cmc_deviation_colour"


def test_smoothness_calms_the_rim():
    surface = wavy()
    variation = []
    for smoothness in (0.0, 1e-2, 1.0):
        approximated(surface, smoothness=smoothness)
        mesh = surface.cmc.nearest.data
        normals = np.array(values(mesh.attributes["cmc_normal"]))
        ends = np.array([tuple(mesh.edges[e].vertices) for e in boundary_edges(mesh)])
        jumps = normals[ends[:, 0]] - normals[ends[:, 1]]
        variation.append((jumps**2).sum())
    assert variation[0] > variation[1] > variation[2]
    assert surface.cmc.smoothness == 1.0


# --- results are results -------------------------------------------------------------------

OPERATORS = {"nearest": (cap, approximated, "Cap nearest CMC"), "fit": (small_disc, fitted, "Disc fit")}


@pytest.fixture(params=OPERATORS)
def design(request):
    """The link to the result, the plan, the call, the name of the result."""
    build, call, name = OPERATORS[request.param]
    operator = bpy.ops.cmc.approximate_surface if request.param == "nearest" else bpy.ops.cmc.fit_outline
    return SimpleNamespace(link=request.param, plan=build(), call=call, name=name, operator=operator)


def test_layers_and_materials_are_the_plans(design):
    plan = design.plan
    steel = bpy.data.materials.new("Steel")
    plan.data.materials.append(steel)
    layer = plan.data.uv_layers.new(name="Drawing")
    layer.uv.foreach_set("vector", np.random.default_rng(1).random(2 * len(plan.data.loops)).astype(np.float32))
    plan.vertex_groups.new(name="Held").add([1, 2], 0.5, "REPLACE")
    design.call(plan)
    result = getattr(plan.cmc, design.link)
    assert result.name == design.name
    assert result.cmc.source == plan and result.users_collection[0].name == f"CMC {plan.name}"
    assert values(result.data.attributes["Drawing"]) == values(plan.data.attributes["Drawing"])
    assert result.data.materials[0] == steel
    assert [group.name for group in result.vertex_groups] == ["Held"]
    assert [tuple(p.vertices) for p in result.data.polygons] == [tuple(p.vertices) for p in plan.data.polygons]
    normals = np.array(values(result.data.attributes["cmc_normal"]))
    assert_allclose(np.linalg.norm(normals, axis=1), 1.0, rtol=0, atol=1e-6)
    assert json.loads(result["cmc_report"])["met"] and result["cmc_mean_curvature"] > 0


def test_the_next_one_writes_into_the_same_object(design):
    plan = design.plan
    design.call(plan)
    result, mesh = getattr(plan.cmc, design.link), getattr(plan.cmc, design.link).data
    gold = bpy.data.materials.new("Gold")
    mesh.materials.append(gold)
    result.name, result.location.x = "Mine", 20.0
    for vertex in plan.data.vertices:
        vertex.co.x *= 1.2
    before = positions(result)
    activate(result)  # the plan is what counts
    assert design.operator() == FINISHED
    assert getattr(plan.cmc, design.link) == result and result.data == mesh
    assert result.name == "Mine" and result.location.x == 20.0 and mesh.materials[0] == gold
    assert np.abs(positions(result) - before).max() > 0.1
    assert len([ob for ob in bpy.data.objects if ob.cmc.role != "NONE"]) == 1


def test_solve_and_design_leave_each_other_alone():
    plan = small_disc()
    fit = fitted(plan)
    assert bpy.ops.cmc.solve() == FINISHED
    shell = positions(plan.cmc.f_plus)
    assert_allclose(positions(plan.cmc.fit), fit, rtol=0, atol=0)
    assert not plan.cmc.fit.hide_viewport
    fitted(plan, fit_rise=0.2)
    assert_allclose(positions(plan.cmc.f_plus), shell, rtol=0, atol=0)
    assert bpy.data.objects["Disc f+"].users_collection == plan.cmc.fit.users_collection


def test_in_edit_mode(design):
    bpy.ops.object.mode_set(mode="EDIT")
    design.call(design.plan)
    assert design.plan.mode == "EDIT"


def test_settings_are_the_objects_unless_given():
    plan, other = small_disc("One"), small_disc("Other")
    fitted(plan, knob="HEIGHT", fit_height=1.0)
    assert (plan.cmc.knob, plan.cmc.fit_height, other.cmc.knob) == ("HEIGHT", 1.0, "RISE")
    assert fitted(plan)[:, 2].max() == pytest.approx(1.0, rel=5e-3)


def test_every_setting_is_an_operator_property(addon):
    settings = addon.cmc_addon.design_settings
    for operator, names in (
        (bpy.ops.cmc.approximate_surface, settings.APPROXIMATE_SETTINGS),
        (bpy.ops.cmc.fit_outline, (*settings.FIT_SETTINGS, *settings.POINTERS)),
    ):
        assert set(names) <= {p.identifier for p in operator.get_rna_type().properties}
        stored = bpy.types.Object.bl_rna.properties["cmc"].fixed_type.properties.keys()
        assert {settings.POINTERS.get(name, name) for name in names} <= set(stored)


def test_undo_and_redo(design):
    name = design.plan.name
    bpy.ops.ed.undo_push(message="before")
    assert design.operator("EXEC_DEFAULT", True) == FINISHED
    assert design.name in bpy.data.objects
    bpy.ops.ed.undo()
    assert [ob.name for ob in bpy.data.objects] == [name]
    assert getattr(bpy.data.objects[name].cmc, design.link) is None
    bpy.ops.ed.redo()
    assert getattr(bpy.data.objects[name].cmc, design.link) == bpy.data.objects[design.name]


# --- ending early --------------------------------------------------------------------------

def test_cancelled_changes_nothing(addon, monkeypatch, design):
    session = addon.cmc_addon.session
    design.call(design.plan)
    for vertex in design.plan.data.vertices:
        vertex.co.x *= 1.2
    activate(design.plan)
    real = session.prepare

    def prepare(*args):
        session.cancel()
        return real(*args)

    monkeypatch.setattr(session, "prepare", prepare)
    before = snapshot()
    assert design.operator() == CANCELLED
    assert snapshot() == before
    assert session.Running.stop is None


def hand_for(design, operator):
    """Stands for the operator that Blender makes, to turn its crank by hand."""

    class Hand(design.Designing):
        take = operator.take
        properties = SimpleNamespace(is_property_set=lambda name: False)

        def __init__(self):
            self.reports = []
            self._work = self.steps(bpy.context, 0.01)

        def report(self, kind, text):
            self.reports.append((kind, text))

        def tick(self, kind="TIMER", value="NOTHING"):
            return self.modal(bpy.context, SimpleNamespace(type=kind, value=value))

    return Hand()


@pytest.fixture
def hand(addon):
    design = addon.cmc_addon.operators.design
    return hand_for(design, design.CMC_OT_fit_outline)


def test_an_approximation_is_shown_too(addon, monkeypatch):
    surface = wavy()
    design, shown = addon.cmc_addon.operators.design, []
    monkeypatch.setattr(addon.cmc_addon.preview, "show", lambda *shape: shown.append(shape))
    hand, result = hand_for(design, design.CMC_OT_approximate_surface), {"RUNNING_MODAL"}
    while result == {"RUNNING_MODAL"}:
        result = hand.tick()
    assert result == FINISHED and len(shown) == 1
    assert_allclose(shown[0][0], positions(surface.cmc.nearest), rtol=0, atol=1.0)
    assert "on average" in hand.reports[-1][1]


def test_shapes_are_shown_while_it_runs(addon, hand, monkeypatch):
    plan = small_disc()
    plan.scale = (1.6, 1.0, 1.0)
    preview = addon.cmc_addon.preview
    shown, progress = [], []
    real = preview.show
    monkeypatch.setattr(preview, "show", lambda *shape: (shown.append(shape), real(*shape)))
    result = {"RUNNING_MODAL"}
    while result == {"RUNNING_MODAL"}:
        result = hand.tick()
        progress.append(bpy.context.window_manager.cmc.progress)
    assert result == FINISHED
    assert len(shown) >= 2
    points, triangles = shown[-1]
    assert_allclose(points, positions(plan.cmc.fit), rtol=0, atol=0.5)
    assert preview.sides(triangles).shape == (len(points) + len(triangles) - 1, 2)  # Euler, for a disc
    assert progress == sorted(progress) and progress[-1] > 0
    assert preview.Preview.shape is None, "cleared at the end"


def test_escape_leaves_the_scene_as_it_was(addon, hand):
    plan = small_disc()
    plan.scale = (1.6, 1.0, 1.0)
    bpy.context.view_layer.update()
    before = snapshot()
    while addon.cmc_addon.preview.Preview.shape is None:
        assert hand.tick() == {"RUNNING_MODAL"}
    assert hand.tick("MOUSEMOVE") == {"PASS_THROUGH"}
    assert hand.tick("ESC", "PRESS") == CANCELLED
    assert snapshot() == before
    assert addon.cmc_addon.preview.Preview.shape is None
    assert addon.cmc_addon.session.Running.stop is None
    thread: threading.Thread = addon.cmc_addon.session.Running.thread
    thread.join(10.0)
    assert not thread.is_alive(), "a fit ends at its next step"


def test_a_plan_changed_meanwhile(hand):
    plan = small_disc()
    hand.tick()
    plan.data.vertices[0].co.z += 0.5
    result = {"RUNNING_MODAL"}
    while result == {"RUNNING_MODAL"}:
        result = hand.tick()
    assert result == CANCELLED and plan.cmc.fit is None
    assert "was changed while it was being solved" in hand.reports[-1][1]


def test_a_curve_deleted_meanwhile(hand):
    curve, _ = raised_loop()
    plan = small_disc()
    plan.cmc.fit_to, plan.cmc.fit_curve = "CURVE", curve
    hand.tick()
    bpy.data.objects.remove(curve)
    result = {"RUNNING_MODAL"}
    while result == {"RUNNING_MODAL"}:
        result = hand.tick()
    assert result == FINISHED and plan.cmc.fit_curve is None


# --- errors --------------------------------------------------------------------------------

def fails(pattern: str, call, **settings) -> None:
    before = snapshot()
    with pytest.raises(RuntimeError, match=pattern):
        call(**settings)
    assert snapshot() == before


@pytest.fixture(params=["approximate_surface", "fit_outline"])
def operator(request):
    return getattr(bpy.ops.cmc, request.param)


def test_nothing_active(operator):
    activate(None)
    fails("No object is active", operator)


def test_not_a_mesh(operator):
    bpy.ops.object.camera_add()
    fails("'Camera' is not a mesh", operator)


def test_no_faces(operator):
    mesh_object("Wire", [(0, 0, 0), (1, 0, 0), (1, 1, 0)], [], edges=[(0, 1), (1, 2)])
    fails("'Wire' has no faces", operator)


def test_closed_mesh(operator):
    bpy.ops.mesh.primitive_cube_add()
    fails("The mesh is closed: it has no boundary", operator)


def test_two_components(operator):
    first, second = small_disc("One"), small_disc("Two")
    faces = [tuple(p.vertices) for p in first.data.polygons]
    points = np.concatenate([positions(first), positions(second) + [20.0, 0.0, 0.0]])
    count = len(first.data.vertices)
    mesh_object("Both", points, faces + [tuple(i + count for i in face) for face in faces])
    fails("2 components", operator)


def test_a_result_whose_plan_is_gone(operator):
    plan = small_disc()
    fitted(plan)
    result = plan.cmc.fit
    bpy.data.objects.remove(plan)
    activate(result)
    fails("plan has been deleted", operator)


def test_a_result_in_edit_mode(operator):
    plan = small_disc(rise=1.0)
    fitted(plan)
    approximated(plan)
    activate(plan.cmc.nearest)
    bpy.ops.object.mode_set(mode="EDIT")
    fails("is in edit mode", operator)


def test_a_flat_surface_has_no_nearest_one():
    small_disc()
    fails("flat or a point", bpy.ops.cmc.approximate_surface)


def test_a_hole():
    quad_ring()
    fails("no holes.*2 loops", bpy.ops.cmc.fit_outline)


def test_no_curve():
    plan = small_disc()
    fails("'Disc' has no curve", bpy.ops.cmc.fit_outline, fit_to="CURVE")
    fails("no object 'Nobody'", bpy.ops.cmc.fit_outline, curve="Nobody")
    curve, _ = raised_loop()
    plan.cmc.fit_to, plan.cmc.fit_curve = "CURVE", curve
    bpy.context.scene.collection.objects.unlink(curve)
    activate(plan)
    fails("'Curve' has been deleted", bpy.ops.cmc.fit_outline)


def test_curves_that_will_not_do():
    mesh_object("Open", [(0, 0, 0), (1, 0, 0), (1, 1, 0)], [], edges=[(0, 1), (1, 2)])
    quad_ring("Two")
    mesh_object("Points", [(0, 0, 0), (1, 0, 0)], [])
    bpy.ops.object.camera_add()
    small_disc()
    fails("'Open' is open at", bpy.ops.cmc.fit_outline, curve="Open")
    fails("'Two' has 2 loops", bpy.ops.cmc.fit_outline, curve="Two")
    fails("'Points' has no edges", bpy.ops.cmc.fit_outline, curve="Points")
    fails("'Camera' is neither a mesh nor a curve", bpy.ops.cmc.fit_outline, curve="Camera")


def test_no_anchors():
    bpy.data.collections.new("Nothing")
    small_disc()
    fails("There are no anchors", bpy.ops.cmc.fit_outline, fit_to="ANCHORS")
    fails("'Nothing' has no empties", bpy.ops.cmc.fit_outline, anchors="Nothing")
    fails("no collection 'Nobody'", bpy.ops.cmc.fit_outline, anchors="Nobody")
