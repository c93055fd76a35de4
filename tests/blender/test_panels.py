"""The sidebar in every state: what it shows, and that every setting can be reached."""

from __future__ import annotations

import json
from types import SimpleNamespace

import bpy
import pytest

from .sidebar import Drawn, Layout, draw, panel_class, text_of


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
    "nothing": (nothing, "Draw an outline and press Mesh Plan, or begin with"),
    "text": (lambda: bpy.ops.object.text_add(), "or begin with Rectangle"),
    "empty": (lambda: bpy.ops.object.empty_add(), "or begin with Rectangle"),
    "camera": (lambda: bpy.ops.object.camera_add(), "or begin with Rectangle"),
    "curve": (lambda: bpy.ops.curve.primitive_bezier_circle_add(), "Mesh Plan from BézierCircle"),
    "mesh": (lambda: bpy.ops.mesh.primitive_plane_add(), "Mesh Plan from Plane"),
    "closed mesh": (lambda: bpy.ops.mesh.primitive_cube_add(), "no boundary"),
    "no faces": (mesh_without_faces, "Mesh Plan from wire"),
    "empty mesh": (empty_mesh, "no boundary"),
    "result without plan": (result_without_plan, "has been deleted"),
    "foreign report": (foreign_report, "Size by"),
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
    from cmc_formfinding.cmc_addon.bridges.mesh_cache import usual_size
    from cmc_formfinding.cmc_addon.properties.units import length_text
    from cmc_formfinding.solver.surface.placement import FREE_SIZES, SIZES, SPANNED_SIZES

    def offered() -> list:
        layout = Layout()
        cls = panel_class("CMC_MT_size")
        cls.draw(Drawn(cls, layout), bpy.context)
        return layout.record.texts

    assert offered() == ["Nearest to Plan", *(SIZES[name] for name in FREE_SIZES[1:])]
    plan.cmc.default_kind = "LINE"
    usual, *others = offered()
    assert others == [SIZES[name] for name in SPANNED_SIZES[1:]]
    height = usual_size(plan)
    assert height is not None and 0.95 < height < 1.05, "0.35 × 3 m"
    assert usual == f"Usual: {length_text(height)} high"
    meshes = len(bpy.data.meshes)
    bpy.ops.object.mode_set(mode="EDIT")
    assert usual_size(plan) == pytest.approx(height, rel=1e-6) and len(bpy.data.meshes) == meshes
    bpy.ops.object.mode_set(mode="OBJECT")
    for vertex in plan.data.vertices:
        vertex.co.z = 0.3 * vertex.co.x
    plan.data.update()
    bpy.context.view_layer.update()
    assert offered()[0] == "Usual: a soap film"


def court(plan) -> bpy.types.Object:
    """A plan with a hole, its rim free."""
    bpy.ops.cmc.add_plan(shape="ANNULUS", columns=24)
    return bpy.context.object


def test_the_empty_tab_has_the_four_plans_and_nothing_else() -> None:
    nothing()
    record = draw()
    assert record.operators == 4 * ["cmc.add_plan"]
    assert record.texts[2:] == ["Rectangle", "Round", "L-Shaped", "Court"]


def test_a_new_tab_is_short(plan) -> None:
    """What is open at first: Plan, Sides, Shell; and after Solve, Result."""
    from .sidebar import panels

    opened = [name for name in panels() if "DEFAULT_CLOSED" not in getattr(panel_class(name), "bl_options", ())]
    parents = {name: getattr(panel_class(name), "bl_parent_id", "") for name in opened}
    assert sorted(name for name, parent in parents.items() if not parent) == [
        "CMC_PT_boundary", "CMC_PT_plan", "CMC_PT_results", "CMC_PT_shell"]
    labels = [panel_class(f"CMC_PT_{name}").bl_label for name in ("plan", "boundary", "shell", "results")]
    assert labels == ["Plan", "Sides", "Shell", "Result"]


def test_how_many_corners_are_rounded_stays_in_the_panel() -> None:
    bpy.ops.mesh.primitive_plane_add(size=6.0)
    bpy.ops.cmc.mesh_plan(edge_length=0.8, corners="NONE")
    assert "None of 4 corners rounded" in draw("CMC_PT_plan").texts
    bpy.ops.cmc.mesh_plan(corners="ALL")
    assert "4 of 4 corners rounded" in draw("CMC_PT_plan").texts and "Update" in draw("CMC_PT_plan").texts


def test_a_rim_that_is_free_all_around(plan) -> None:
    plan.cmc.default_kind, plan.cmc.size = "LINE", "VOLUME"
    for name, kind in (("Street", "LEAN"), ("Garden", "LINE"), ("Wall", "MIRROR")):
        bpy.ops.cmc.group_add(name=name, kind=kind, angle=0.5)
    assert bpy.ops.cmc.rim_free() == {"FINISHED"}
    assert (plan.cmc.default_kind, plan.cmc.size) == ("BINORMAL", "MATCH_PLAN")
    groups = plan.data.cmc.groups
    assert [group.kind for group in groups] == ["BINORMAL", "BINORMAL", "MIRROR"]
    assert [round(group.tilt, 6) for group in groups][:2] == [0.5, 0.0]
    assert bpy.ops.cmc.solve() == {"FINISHED"}
    assert "span" not in json.loads(plan.cmc.report)


def test_a_new_group_leans_over_its_line(plan) -> None:
    bpy.ops.cmc.group_add()
    group = plan.data.cmc.groups[0]
    assert group.kind == "LEAN" and abs(group.angle - 0.7853982) < 1e-6


def test_keep_closed_is_there_where_it_counts(plan) -> None:
    assert "keep_closed" not in draw("CMC_PT_shell").props
    made = court(plan)
    assert "keep_closed" in draw("CMC_PT_shell").props
    bpy.ops.cmc.solve(keep_closed=False)
    record = draw("CMC_PT_results")
    assert record.operators == ["cmc.solve"] and "Keep Closed Around Courts" in record.texts
    bpy.ops.cmc.solve(keep_closed=True)
    assert draw("CMC_PT_results").operators == []
    for group in made.data.cmc.groups:
        group.kind = "LINE"
    assert "keep_closed" not in draw("CMC_PT_shell").props, "lines close by themselves"


def test_every_setting_of_a_solve_can_be_reached(plan) -> None:
    from cmc_formfinding.cmc_addon.properties.settings import SETTINGS, SIZE_PROPERTY

    bpy.ops.cmc.group_add(name="rim", kind="BINORMAL")
    plan.cmc.shell, plan.cmc.close_by = "DEGREE", "BOTH"
    hole = court(plan)
    hole.cmc.close_by = "BOTH"
    drawn = set(draw("CMC_PT_shell", "CMC_PT_options").props)
    bpy.context.view_layer.objects.active = plan
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


def test_every_setting_of_an_approximation_can_be_reached(plan) -> None:
    from cmc_formfinding.cmc_addon.properties.approximate_settings import APPROXIMATE_SETTINGS

    plan.cmc.match = "POSITION"
    record = draw("CMC_PT_approximate")
    assert set(APPROXIMATE_SETTINGS) == set(record.props) and record.operators == ["cmc.approximate_surface"]


def test_an_approximation_in_numbers(plan) -> None:
    for vertex in plan.data.vertices:
        vertex.co.z = -0.03 * (vertex.co.x**2 + vertex.co.y**2)
    assert "Deviation" not in draw("CMC_PT_approximate").texts
    bpy.ops.cmc.approximate_surface()
    assert {"Deviation", "Off Normals", "Rim Roughness"} <= set(draw("CMC_PT_approximate").texts)
    results = draw("CMC_PT_results")
    assert {"Span", "Rise", "Area", "Radius 1/H", "H"} <= set(results.texts)
    assert json.loads(plan.cmc.design_report)["message"] in text_of(results)
    plan.cmc.design_report = "not a report {"
    assert "Deviation" not in draw("CMC_PT_approximate").texts
