"""Presets of boundary groups, and the menus in which they and all operators are found."""

from __future__ import annotations

from types import SimpleNamespace

import bpy
import numpy as np
import pytest

from .scenes import activate
from .sidebar import Layout, Properties

FINISHED = {"FINISHED"}


@pytest.fixture
def plan():
    bpy.ops.mesh.primitive_grid_add(x_subdivisions=6, y_subdivisions=6, size=4)
    return bpy.context.object


def select_side(plan, axis: int, sign: float) -> None:
    """In edit mode, the edges of one side of the grid."""
    bpy.ops.object.mode_set(mode="OBJECT")
    mesh = plan.data
    mesh.vertices.foreach_set("select", np.zeros(len(mesh.vertices), dtype=bool))
    mesh.polygons.foreach_set("select", np.zeros(len(mesh.polygons), dtype=bool))
    for edge in mesh.edges:
        edge.select = all(sign * mesh.vertices[k].co[axis] > 1.99 for k in edge.vertices)
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.context.tool_settings.mesh_select_mode = (False, True, False)


@pytest.mark.parametrize(("preset", "degrees"), [("WALL", 0.0), ("HALF", 45.0), ("FLAT", 90.0)])
def test_angles(plan, preset, degrees):
    select_side(plan, 0, 1)
    assert bpy.ops.cmc.group_new(preset=preset) == FINISHED
    group = plan.data.cmc.groups[0]
    assert group.kind == "BINORMAL" and abs(np.degrees(group.tilt) - degrees) < 1e-4
    bpy.ops.object.mode_set(mode="OBJECT")
    assert sum(item.value == group.uid for item in plan.data.attributes["cmc_group"].data) == 6


@pytest.mark.parametrize(("preset", "axis"), [("MIRROR_X", 0), ("MIRROR_Y", 1)])
@pytest.mark.parametrize("sign", [1, -1])
def test_mirrors_point_out_of_the_plan(plan, preset, axis, sign):
    plan.location = (50.0, 50.0, 0.0)
    bpy.context.view_layer.update()
    select_side(plan, axis, sign)
    bpy.ops.cmc.group_new(preset=preset)
    group = plan.data.cmc.groups[0]
    wanted = np.zeros(3)
    wanted[axis] = sign
    assert group.kind == "MIRROR" and np.array_equal(group.normal, wanted)


def test_a_mirror_of_an_outline_that_has_no_faces(plan):
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.delete(type="ONLY_FACE")
    select_side(plan, 0, -1)
    assert bpy.ops.cmc.group_new(preset="MIRROR_X") == FINISHED
    assert plan.data.cmc.groups[0].kind == "MIRROR" and tuple(plan.data.cmc.groups[0].normal) == (-1.0, 0.0, 0.0)


def test_a_preset_changes_the_active_group_and_is_undone(plan):
    bpy.ops.cmc.group_add(name="rim", kind="BINORMAL", tilt=0.3)
    bpy.ops.cmc.group_add(name="other", kind="BINORMAL", tilt=0.3)
    bpy.ops.ed.undo_push(message="before")
    bpy.ops.cmc.group_preset("EXEC_DEFAULT", True, preset="FLOOR")
    groups = bpy.context.object.data.cmc.groups
    assert groups[1].kind == "MIRROR" and tuple(groups[1].normal) == (0, 0, -1) and groups[0].kind == "BINORMAL"
    bpy.ops.ed.undo()
    assert bpy.context.object.data.cmc.groups[1].kind == "BINORMAL"
    assert bpy.ops.cmc.group_preset(preset="FLAT", group="rim") == FINISHED
    assert abs(bpy.context.object.data.cmc.groups[0].tilt - np.pi / 2) < 1e-6


def test_what_goes_wrong_is_said(plan):
    with pytest.raises(RuntimeError, match="Add a boundary group first"):
        bpy.ops.cmc.group_preset(preset="WALL")
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.select_all(action="DESELECT")
    with pytest.raises(RuntimeError, match="No edge is selected"):
        bpy.ops.cmc.group_new(preset="WALL")
    assert not plan.data.cmc.groups


def test_every_preset_can_be_solved_from(plan):
    sides = {"WALL": (1, 1), "HALF": (1, -1), "FLAT": (0, -1), "MIRROR_X": (0, 1)}
    for preset, (axis, sign) in sides.items():
        select_side(plan, axis, sign)
        bpy.ops.cmc.group_new(preset=preset)
    bpy.ops.object.mode_set(mode="OBJECT")
    assert bpy.ops.cmc.solve() == FINISHED and plan.cmc.f_plus is not None


# --- menus ---------------------------------------------------------------------------------

class MenuLayout(Layout):
    """A menu: operators of any module, sub-menus, a pie."""

    def _part(self, **_):
        return MenuLayout(self.record)

    menu_pie = _part

    def operator(self, name, *, text="", icon="NONE", **_):
        self.record.operators.append(name)
        self.record.texts.append(text)
        module, _, rest = name.partition(".")
        kind = getattr(getattr(bpy.ops, module), rest).get_rna_type()
        return Properties(kind)

    def menu(self, name, **_):
        assert hasattr(bpy.types, name)
        self.record.texts.append(name)


def menu(name):
    from cmc_formfinding.cmc_addon.panels import menus

    layout = MenuLayout()
    getattr(menus, name).draw(SimpleNamespace(layout=layout), bpy.context)
    return layout.record


def test_the_assign_menu_has_the_groups_and_the_presets(plan):
    bpy.ops.cmc.group_add(name="South")
    bpy.ops.cmc.group_add(name="North")
    bpy.ops.object.mode_set(mode="EDIT")
    record = menu("CMC_MT_assign")
    assert record.texts[:3] == ["South", "North", "New Group"]
    assert [text for text in record.texts if text.startswith("New: ")][-1] == "New: Mirror Floor"
    assert record.operators.count("cmc.group_new") == 8


@pytest.mark.parametrize("mode", ["OBJECT", "EDIT"])
def test_every_menu_is_drawn(plan, mode):
    bpy.ops.object.mode_set(mode=mode)
    for name in ("CMC_MT_object", "CMC_MT_mesh", "CMC_MT_pie", "CMC_MT_group_presets", "CMC_MT_assign"):
        assert menu(name).operators


def test_f3_finds_every_operator():
    """F3 looks through the menus: an operator that is in none cannot be found."""
    from cmc_formfinding.cmc_addon import operators

    activate(None)
    bpy.ops.mesh.primitive_grid_add()
    found = set().union(*(menu(name).operators for name in ("CMC_MT_object", "CMC_MT_mesh", "CMC_MT_assign")))
    found |= {"cmc.group_preset"}  # in a menu of that menu
    elsewhere = {
        "cmc.add_module", "cmc.add_plan", "cmc.add_bubble",  # Add > Mesh > CMC
        "cmc.group_remove", "cmc.group_move", "cmc.group_plane", "cmc.flip_corner", "cmc.cancel",  # beside their thing
    }
    ours = {cls.bl_idname for cls in operators.CLASSES if issubclass(cls, bpy.types.Operator)}
    assert ours - elsewhere <= found


def test_they_are_in_blenders_menus_once():
    from cmc_formfinding.cmc_addon.panels import menus

    for name, draw in menus.PLACES.items():
        assert getattr(bpy.types, name).draw._draw_funcs.count(draw) == 1
