"""The sidebar in every state: what it shows, and that every setting can be reached."""

from __future__ import annotations

import json
from types import SimpleNamespace

import bpy
import pytest

from .sidebar import ICONS, Drawn, Layout, draw, panel_class, text_of


@pytest.fixture
def plan() -> bpy.types.Object:
    bpy.ops.mesh.primitive_circle_add(vertices=24, radius=3, fill_type="NGON")
    bpy.ops.cmc.mesh_plan(edge_length=0.6)
    bpy.context.object.cmc.default_kind = "BINORMAL"
    return bpy.context.object


# --- every state ---------------------------------------------------------------------------

def nothing():
    bpy.context.view_layer.objects.active = None


def mesh_without_faces():
    mesh = bpy.data.meshes.new("wire")
    mesh.from_pydata([(0, 0, 0), (1, 0, 0), (0, 1, 0)], [(0, 1), (1, 2), (2, 0)], [])
    ob = bpy.data.objects.new("wire", mesh)
    bpy.context.collection.objects.link(ob)
    bpy.context.view_layer.objects.active = ob


def empty_mesh():
    ob = bpy.data.objects.new("nothing", bpy.data.meshes.new("nothing"))
    bpy.context.collection.objects.link(ob)
    bpy.context.view_layer.objects.active = ob


def result_without_plan():
    bpy.ops.mesh.primitive_plane_add()
    bpy.context.object.cmc.role = "F_PLUS"


def foreign_report():
    bpy.ops.mesh.primitive_plane_add()
    bpy.context.object.cmc.report = "not a report {"


STATES = {
    "nothing": (nothing, "Select a mesh or a closed curve"),
    "text": (lambda: bpy.ops.object.text_add(), "Select a mesh or a closed curve"),
    "empty": (lambda: bpy.ops.object.empty_add(), "Select a mesh or a closed curve"),
    "camera": (lambda: bpy.ops.object.camera_add(), "Select a mesh or a closed curve"),
    "curve": (lambda: bpy.ops.curve.primitive_bezier_circle_add(), "Select a plan"),
    "mesh": (lambda: bpy.ops.mesh.primitive_plane_add(), "4 of 4 edges in no group"),
    "closed mesh": (lambda: bpy.ops.mesh.primitive_cube_add(), "no boundary"),
    "no faces": (mesh_without_faces, "no faces"),
    "empty mesh": (empty_mesh, "no boundary"),
    "result without plan": (result_without_plan, "has been deleted"),
    "foreign report": (foreign_report, "4 of 4 edges"),
}


@pytest.mark.parametrize(("build", "text"), STATES.values(), ids=STATES.keys())
def test_states(build, text) -> None:
    build()
    assert text in text_of(draw())


@pytest.mark.parametrize("mode", ["OBJECT", "EDIT", "SCULPT"])
def test_modes(plan, mode) -> None:
    bpy.ops.cmc.group_add(name="rim")
    bpy.ops.object.mode_set(mode=mode)
    record = draw()
    assert ("cmc.group_assign" in record.operators) == (mode == "EDIT")
    assert ("cmc.solve_selection" in record.operators) == (mode == "EDIT")


@pytest.mark.parametrize("mode", ["EDIT"])
def test_curve_in_edit_mode(mode) -> None:
    bpy.ops.curve.primitive_bezier_circle_add()
    bpy.ops.object.mode_set(mode=mode)
    assert "cmc.mesh_plan" in draw().operators


def test_linked_from_a_library(plan, tmp_path) -> None:
    name = plan.name
    bpy.ops.cmc.group_add(name="rim")
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "library.blend"))
    bpy.ops.wm.read_homefile(use_empty=True)
    with bpy.data.libraries.load(str(tmp_path / "library.blend"), link=True) as (_, taken):
        taken.objects = [name]
    bpy.context.collection.objects.link(taken.objects[0])
    bpy.context.view_layer.objects.active = taken.objects[0]
    draw()
    with pytest.raises(RuntimeError, match="make it local"):
        bpy.ops.cmc.group_add()
    with pytest.raises(RuntimeError, match="make it local"):
        bpy.ops.cmc.mesh_plan()


# --- what is shown -------------------------------------------------------------------------

def test_only_the_parameters_of_the_kind_are_drawn(plan) -> None:
    from cmc_formfinding.solver.gauss.conditions import KINDS

    bpy.ops.cmc.group_add(name="rim")
    every = {parameter.name for kind in KINDS.values() for parameter in kind.parameters}
    for name, kind in KINDS.items():
        plan.data.cmc.groups[0].kind = name.upper()
        drawn = set(draw("CMC_PT_boundary").props)
        assert drawn & every == {parameter.name for parameter in kind.parameters}


def test_only_the_size_that_counts_is_drawn(plan) -> None:
    from cmc_formfinding.cmc_addon.properties.settings import SIZE_PROPERTY

    for size, value in SIZE_PROPERTY.items():
        plan.cmc.size = size
        drawn = set(draw("CMC_PT_shell").props) & set(SIZE_PROPERTY.values())
        assert drawn == ({value} if value else set())


def test_only_the_sizes_that_the_sides_leave_are_offered(plan) -> None:
    from cmc_formfinding.solver.surface.placement import FREE_SIZES, SIZES, SPANNED_SIZES

    def offered() -> list:
        layout = Layout()
        cls = panel_class("CMC_MT_size")
        cls.draw(Drawn(cls, layout), bpy.context)
        return layout.record.texts

    assert offered() == [SIZES[name] for name in FREE_SIZES]
    plan.cmc.default_kind = "LINE"
    assert offered() == ["Usual", *(SIZES[name] for name in SPANNED_SIZES[1:])]


def test_every_setting_of_a_solve_can_be_reached(plan) -> None:
    from cmc_formfinding.cmc_addon.properties.settings import SETTINGS, SIZE_PROPERTY

    bpy.ops.cmc.group_add(name="rim")
    plan.cmc.shell, plan.cmc.close_by = "DEGREE", "BOTH"
    drawn = set()
    for kind in ("BINORMAL", "LINE"):
        plan.cmc.default_kind = kind
        for size in SIZE_PROPERTY:
            plan.cmc.size = size
            drawn |= set(draw("CMC_PT_boundary", "CMC_PT_shell", "CMC_PT_options", "CMC_PT_advanced").props)
    assert set(SETTINGS) - drawn == {"flip", "size"}, "which have a button and a menu of their own"


def test_every_setting_of_the_view_can_be_reached(plan) -> None:
    from cmc_formfinding.cmc_addon.properties.overlay_settings import OVERLAY_SETTINGS

    layout = Layout()
    cls = panel_class("CMC_PT_overlay")
    for part in (cls.draw_header, cls.draw):
        part(Drawn(cls, layout), bpy.context)
    assert sorted(layout.record.props) == sorted(OVERLAY_SETTINGS)
    popover = panel_class("CMC_PT_overlay_popover")
    assert popover.bl_parent_id == "VIEW3D_PT_overlay" and popover.is_registered
    view = SimpleNamespace(overlay=SimpleNamespace(show_overlays=True))
    popover.draw(SimpleNamespace(layout=layout), SimpleNamespace(scene=bpy.context.scene, space_data=view))
    assert sorted(layout.record.props) == sorted(2 * OVERLAY_SETTINGS)


def test_every_setting_of_a_design_can_be_reached(plan) -> None:
    from cmc_formfinding.cmc_addon.properties.design_settings import (
        APPROXIMATE_SETTINGS,
        FIT_SETTINGS,
        HEIGHT_PROPERTY,
        POINTERS,
    )

    drawn = set()
    plan.cmc.limit_tilt, plan.cmc.match = True, "POSITION"
    for target in ("OUTLINE", "CURVE", "ANCHORS"):
        for height_parameter in HEIGHT_PROPERTY:
            plan.cmc.fit_to, plan.cmc.height_parameter = target, height_parameter
            record = draw("CMC_PT_design")
            drawn |= set(record.props)
            assert record.props.count(HEIGHT_PROPERTY[height_parameter]) == 1
    assert {*APPROXIMATE_SETTINGS, *FIT_SETTINGS, *POINTERS.values()} == drawn
    assert record.operators == ["cmc.fit_outline", "cmc.approximate_surface"]


def test_a_design_in_numbers(plan) -> None:
    assert "Span" not in draw("CMC_PT_design").texts
    assert "follow" not in draw("CMC_PT_design").props, "there is nothing yet that could"
    bpy.ops.cmc.fit_outline(limit_tilt=True)
    record = draw("CMC_PT_design")
    assert "follow" in record.props and "tilt_max" in record.props
    for name in ("Off Line", "Off Height", "Off Lean"):
        assert name in record.texts
    results = draw("CMC_PT_results")
    assert {"Span", "Rise", "Area", "Radius 1/H", "H"} <= set(results.texts)
    assert json.loads(plan.cmc.design_report)["message"] in text_of(results)
    bpy.context.view_layer.objects.active = plan.cmc.fit
    assert "cmc.fit_outline" in draw("CMC_PT_design").operators
    plan.cmc.design_report = "not a report {"
    assert "Off Line" not in draw("CMC_PT_design").texts


def test_the_weight_of_an_anchor() -> None:
    bpy.ops.object.empty_add()
    assert draw("CMC_PT_design").props == ["anchor_weight"]


def test_angles_in_the_list_are_degrees(plan) -> None:
    bpy.ops.cmc.group_add(name="rim", tilt=0.5235987755982988)
    assert "30°" in draw("CMC_PT_boundary").texts


def test_the_count_follows_every_change(plan) -> None:
    edges = text_of(draw("CMC_PT_boundary")).split()[0]
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.context.tool_settings.mesh_select_mode = (False, True, False)
    bpy.ops.mesh.select_all(action="SELECT")
    assert f"{edges} of {edges} edges" in text_of(draw("CMC_PT_boundary"))
    bpy.ops.cmc.group_add(name="rim", assign=True)
    assert "in no group" not in text_of(draw("CMC_PT_boundary"))
    bpy.ops.mesh.select_all(action="DESELECT")
    bpy.ops.cmc.group_select()
    bpy.ops.cmc.group_remove_from()
    bpy.context.view_layer.update()
    assert f"{edges} of {edges} edges" in text_of(draw("CMC_PT_boundary"))
    bpy.ops.object.mode_set(mode="OBJECT")
    assert f"{edges} of {edges} edges" in text_of(draw("CMC_PT_boundary"))


def test_the_count_is_kept_between_redraws(plan, monkeypatch) -> None:
    from cmc_formfinding.cmc_addon.bridges import edge_bridge

    draw("CMC_PT_boundary")
    monkeypatch.setattr(edge_bridge, "count_boundary", lambda *_: pytest.fail("counted again"))
    for _ in range(3):
        draw("CMC_PT_boundary")


def test_results_in_numbers(plan) -> None:
    assert not text_of(draw("CMC_PT_results"))
    bpy.ops.cmc.solve()
    record = draw("CMC_PT_results", "CMC_PT_checks", "CMC_PT_solver")
    report = json.loads(plan.cmc.report)
    assert "Done. Curvature is even to 1.5 %." in text_of(record)
    for name in (
        "Span", "Rise", "Area", "Rim", "Radius 1/H", "H", "Energy E", "Overhang", "Distortion", "Crossing",
    ):
        assert name in record.texts
    assert f"{report['energy']:.6g}" in record.texts


def test_warnings_stay_in_the_panel(plan) -> None:
    bpy.ops.cmc.select_ungrouped()
    bpy.ops.cmc.group_add(tilt=-0.6, assign=True)
    bpy.ops.cmc.solve()
    warnings = json.loads(plan.cmc.report)["warnings"]
    assert any("overhangs" in warning["text"] for warning in warnings)
    assert "overhangs" in text_of(draw("CMC_PT_results"))


def test_units_are_the_scenes(plan) -> None:
    bpy.ops.cmc.solve()
    bpy.context.scene.unit_settings.system = "METRIC"
    bpy.context.scene.unit_settings.scale_length = 0.01
    assert any(text.endswith("cm") for text in draw("CMC_PT_results").texts)
    bpy.context.scene.unit_settings.system = "NONE"
    assert not any(text.endswith("m") and text[0].isdigit() for text in draw("CMC_PT_results").texts)


def test_with_a_result_active(plan) -> None:
    bpy.ops.cmc.group_add(name="rim")
    bpy.ops.cmc.solve()
    bpy.context.view_layer.objects.active = plan.cmc.f_plus
    record = draw()
    assert "tilt" in record.props, "the angles of the plan can be changed from here"
    assert "cmc.solve" in record.operators and "cmc.group_add" not in record.operators
    assert bpy.ops.cmc.go_to(target="PLAN") == {"FINISHED"} and bpy.context.object == plan
    assert bpy.ops.cmc.go_to(target="SHELL") == {"FINISHED"} and bpy.context.object == plan.cmc.f_plus
    bpy.ops.cmc.go_to(target="OUTLINE")
    assert bpy.context.object == plan.cmc.outline and not bpy.context.object.hide_get()
    assert "cmc.solve" not in draw("CMC_PT_shell").operators, "the outline is not what is solved"


def test_while_running() -> None:
    run = bpy.context.window_manager.cmc
    run.running, run.progress, run.message = True, 0.25, "Step 2"
    record = draw("CMC_PT_shell")
    assert record.operators == ["cmc.cancel"] and "Step 2" in record.texts


def test_groups_have_colours_of_their_own() -> None:
    from cmc_formfinding.cmc_addon.drawing.palette import colour_of, icon_of

    assert {icon_of(uid) for uid in range(1, 16)} <= ICONS and len({icon_of(uid) for uid in range(1, 16)}) == 15
    assert len({colour_of(uid) for uid in range(1, 16)}) > 10


def test_the_specials_menu() -> None:
    layout = Layout()
    cls = panel_class("CMC_MT_groups")
    cls.draw(Drawn(cls, layout), bpy.context)
    assert set(layout.record.operators) == {
        "cmc.group_add", "cmc.select_ungrouped", "cmc.group_remove_from", "cmc.group_remove"}


def test_every_operator_has_a_tooltip_and_every_property_a_description() -> None:
    from cmc_formfinding.cmc_addon import operators

    for cls in operators.CLASSES:
        kind = getattr(bpy.ops.cmc, cls.bl_idname.removeprefix("cmc.")).get_rna_type()
        assert kind.description, f"{cls.bl_idname} has no tooltip"
        for name, prop in kind.properties.items():
            if name != "rna_type" and not prop.is_hidden:
                assert prop.name, f"{cls.bl_idname}.{name}"


@pytest.mark.parametrize(
    ("part", "text"),
    [(0.0, "0 %"), (1.1e-10, "0 %"), (3e-7, "under 0.01 %"), (1e-4, "0.01 %"), (0.0062, "0.62 %"), (1.5, "150 %")],
)
def test_percentages_without_rounding_errors(part, text) -> None:
    from cmc_formfinding.solver.measure.summary import percent

    assert percent(part) == text


@pytest.mark.parametrize(
    "text",
    ["[]", '"text"', "3", "null", '{"message": "", "converged": true, "sheets": [], "sheet": 3}', "[" * 100_000],
)
def test_a_stored_report_that_is_no_report_counts_as_none(addon, text):
    bpy.ops.mesh.primitive_plane_add()
    bpy.context.object.cmc.report = text
    assert addon.cmc_addon.properties.reports.solve_report(bpy.context.object) is None
