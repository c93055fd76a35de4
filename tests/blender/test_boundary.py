"""Boundary groups: the list, membership in edit and object mode, undo, and what survives."""

from __future__ import annotations

from contextlib import contextmanager

import bpy  # before bmesh, which it brings along

# isort: split
import bmesh
import numpy as np
import pytest

ATTRIBUTE = "cmc_group"
SIDE = 4  # cells along a side of the grid


def square_grid() -> bpy.types.Object:
    """A square plan of 4 × 4 quads: 16 boundary edges, 24 inner ones; nothing selected, object mode."""
    bpy.ops.mesh.primitive_grid_add(x_subdivisions=SIDE, y_subdivisions=SIDE, size=2.0)
    ob = bpy.context.object
    select(ob, [])
    return ob


@pytest.fixture
def grid() -> bpy.types.Object:
    return square_grid()


@contextmanager
def edit_mode():
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.context.tool_settings.mesh_select_mode = (False, True, False)
    yield bmesh.from_edit_mesh(bpy.context.object.data)
    bpy.ops.object.mode_set(mode="OBJECT")


def select(ob: bpy.types.Object, edges) -> None:
    """Select exactly these edges, in either mode."""
    mesh = ob.data
    if mesh.is_editmode:
        bm = bmesh.from_edit_mesh(mesh)
        bm.edges.ensure_lookup_table()
        for edge in bm.edges:
            edge.select_set(False)
        for k in edges:
            bm.edges[k].select_set(True)
        bm.select_flush_mode()
        return
    mesh.edges.foreach_set("select", np.isin(np.arange(len(mesh.edges)), list(edges)))
    ends = np.array([tuple(mesh.edges[k].vertices) for k in edges], dtype=int).ravel()
    mesh.vertices.foreach_set("select", np.isin(np.arange(len(mesh.vertices)), ends))
    mesh.polygons.foreach_set("select", np.zeros(len(mesh.polygons), dtype=bool))


def selected(ob: bpy.types.Object) -> set[int]:
    if ob.data.is_editmode:
        return {edge.index for edge in bmesh.from_edit_mesh(ob.data).edges if edge.select}
    return {edge.index for edge in ob.data.edges if edge.select}


def values(ob: bpy.types.Object) -> np.ndarray:
    """Group uid of each edge, in either mode."""
    if ob.data.is_editmode:
        bm = bmesh.from_edit_mesh(ob.data)
        layer = bm.edges.layers.int.get(ATTRIBUTE)
        return np.array([edge[layer] if layer else 0 for edge in bm.edges])
    if ATTRIBUTE not in ob.data.attributes:
        return np.zeros(len(ob.data.edges), dtype=int)
    return np.array([item.value for item in ob.data.attributes[ATTRIBUTE].data])


def members(ob: bpy.types.Object, uid: int) -> set[int]:
    return set(np.nonzero(values(ob) == uid)[0].tolist())


def on_side(ob: bpy.types.Object, axis: int, where: float) -> list[int]:
    """Edges with both ends at that coordinate."""
    points = [vertex.co[axis] for vertex in ob.data.vertices]
    return [e.index for e in ob.data.edges if all(abs(points[v] - where) < 1e-6 for v in e.vertices)]


def ungrouped(ob: bpy.types.Object) -> tuple[int, int]:
    from cmc_formfinding.cmc_addon.bridges import edge_bridge
    from cmc_formfinding.cmc_addon.properties import group_list

    return edge_bridge.count_boundary(ob.data, group_list.uids(ob.data))


# --- the list ------------------------------------------------------------------------------

def names(ob) -> list[str]:
    return [group.name for group in ob.data.cmc.groups]


def test_names_are_numbered_and_uids_grow(grid) -> None:
    for _ in range(3):
        bpy.ops.cmc.group_add()
    bpy.ops.cmc.group_add(name="North", kind="PLANE", normal=(0, 1, 0))
    groups = grid.data.cmc.groups
    assert [g.name for g in groups] == ["Group", "Group.001", "Group.002", "North"]
    assert [g.uid for g in groups] == [1, 2, 3, 4]
    assert grid.data.cmc.active_index == 3
    assert (groups[3].kind, tuple(groups[3].normal)) == ("PLANE", (0, 1, 0))
    bpy.ops.cmc.group_remove(group="North")
    bpy.ops.cmc.group_add(name="East")
    assert groups[-1].uid == 5, "a uid is never used twice"


@pytest.mark.parametrize(("name", "taken", "free"), [
    ("Rim", [], "Rim"),
    ("Rim", ["Rim"], "Rim.001"),
    ("Rim.001", ["Rim", "Rim.001"], "Rim.002"),
    ("Rim", ["Rim", "Rim.001", "Rim.003"], "Rim.002"),
])
def test_free_name(name, taken, free) -> None:
    from cmc_formfinding.cmc_addon.properties.group_list import free_name

    assert free_name(name, set(taken)) == free


def test_move(grid) -> None:
    for name in "abc":
        bpy.ops.cmc.group_add(name=name)
    bpy.ops.cmc.group_move(direction="UP")
    assert [g.name for g in grid.data.cmc.groups] == ["a", "c", "b"]
    assert grid.data.cmc.active_index == 1
    bpy.ops.cmc.group_move(direction="DOWN")
    bpy.ops.cmc.group_move(direction="DOWN")  # at the end already: stays
    assert [g.name for g in grid.data.cmc.groups] == ["a", "b", "c"]
    assert grid.data.cmc.active_index == 2


@pytest.mark.parametrize("mode", ["OBJECT", "EDIT"])
def test_remove_clears_membership_and_keeps_the_others(grid, mode) -> None:
    west, east = on_side(grid, 0, -1.0), on_side(grid, 0, 1.0)
    bpy.ops.object.mode_set(mode=mode)
    for name, edges in (("west", west), ("east", east)):
        select(grid, edges)
        bpy.ops.cmc.group_add(name=name, assign=True)
    assert (members(grid, 1), members(grid, 2)) == (set(west), set(east))
    bpy.ops.cmc.group_remove(group="west")
    bpy.ops.object.mode_set(mode="OBJECT")
    assert (members(grid, 1), members(grid, 2)) == (set(), set(east))
    assert [g.name for g in grid.data.cmc.groups] == ["east"]
    assert grid.data.cmc.active_index == 0
    bpy.ops.cmc.group_remove(all=True)
    assert not values(grid).any() and not grid.data.cmc.groups


# --- membership ----------------------------------------------------------------------------

@pytest.mark.parametrize("mode", ["OBJECT", "EDIT"])
def test_assign_select_deselect_remove_from(grid, mode) -> None:
    west, south = on_side(grid, 0, -1.0), on_side(grid, 1, -1.0)
    bpy.ops.cmc.group_add(name="west")
    bpy.ops.cmc.group_add(name="south")
    bpy.ops.object.mode_set(mode=mode)
    bpy.context.tool_settings.mesh_select_mode = (False, True, False)
    select(grid, west)
    assert bpy.ops.cmc.group_assign(group="west") == {"FINISHED"}
    select(grid, south)
    bpy.ops.cmc.group_assign()  # the active one, south
    assert (members(grid, 1), members(grid, 2)) == (set(west), set(south))
    assert ungrouped(grid) == (4 * SIDE, 2 * SIDE)

    bpy.ops.cmc.group_select(group="west")
    assert selected(grid) == set(west) | set(south)
    bpy.ops.cmc.group_deselect(group="south")
    assert selected(grid) == set(west)
    bpy.ops.cmc.group_assign(group="south")  # moves them: an edge is in one group at most
    assert (members(grid, 1), members(grid, 2)) == (set(), set(west) | set(south))
    bpy.ops.cmc.group_remove_from(group="south")
    assert members(grid, 2) == set(south)
    bpy.ops.cmc.select_ungrouped()
    assert selected(grid) == set(np.nonzero(~np.isin(np.arange(40), south))[0]) & boundary(grid)


def boundary(ob: bpy.types.Object) -> set[int]:
    from cmc_formfinding.cmc_addon.bridges import edge_bridge

    return set(np.nonzero(edge_bridge.read_edges(ob.data).boundary)[0].tolist())


@pytest.mark.parametrize("mode", ["OBJECT", "EDIT"])
def test_inner_edges_are_never_assigned(grid, mode) -> None:
    inside = on_side(grid, 0, 0.0)
    bpy.ops.cmc.group_add()
    bpy.ops.object.mode_set(mode=mode)
    select(grid, [*inside, *on_side(grid, 0, -1.0)])
    bpy.ops.cmc.group_assign()
    assert members(grid, 1) == set(on_side(grid, 0, -1.0))
    select(grid, inside)
    with pytest.raises(RuntimeError, match="The 4 edges selected are not on the boundary"):
        bpy.ops.cmc.group_assign()
    select(grid, [])
    with pytest.raises(RuntimeError, match="No edge is selected"):
        bpy.ops.cmc.group_assign()
    assert members(grid, 1) == set(on_side(grid, 0, -1.0))


def test_an_outline_without_faces_can_be_grouped() -> None:
    mesh = bpy.data.meshes.new("outline")
    mesh.from_pydata([(0, 0, 0), (1, 0, 0), (0, 1, 0)], [(0, 1), (1, 2), (2, 0)], [])
    ob = bpy.data.objects.new("outline", mesh)
    bpy.context.collection.objects.link(ob)
    bpy.context.view_layer.objects.active = ob
    select(ob, [1])
    bpy.ops.cmc.group_add(assign=True)
    assert members(ob, 1) == {1}
    assert ungrouped(ob) == (3, 2)


def test_selection_on_a_mesh_made_by_a_script() -> None:
    """Blender 5.0 stores the selection of calculated edges with a wrong type: a crash if it is not mended."""
    mesh = bpy.data.meshes.new("plan")
    mesh.from_pydata([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)], [], [(0, 1, 2, 3)])
    ob = bpy.data.objects.new("plan", mesh)
    bpy.context.collection.objects.link(ob)
    bpy.context.view_layer.objects.active = ob
    bpy.ops.cmc.select_ungrouped()
    bpy.ops.cmc.group_add(assign=True)
    assert members(ob, 1) == {0, 1, 2, 3}
    bpy.ops.cmc.group_deselect()
    assert selected(ob) == set()


@pytest.mark.parametrize("mode", ["OBJECT", "EDIT"])
def test_hidden_edges_are_not_selected(grid, mode) -> None:
    west = on_side(grid, 0, -1.0)
    select(grid, west)
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.context.tool_settings.mesh_select_mode = (False, True, False)
    bpy.ops.mesh.hide(unselected=False)
    bpy.ops.object.mode_set(mode=mode)
    bpy.ops.cmc.select_ungrouped()
    assert selected(grid) and not selected(grid) & set(west)


def test_face_select_mode_changes_to_edges(grid) -> None:
    select(grid, on_side(grid, 0, -1.0))
    bpy.ops.cmc.group_add(assign=True)
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.context.tool_settings.mesh_select_mode = (False, False, True)
    bpy.ops.mesh.select_all(action="DESELECT")
    bpy.ops.cmc.group_select()
    assert selected(grid) == members(grid, 1) and len(members(grid, 1)) == SIDE


# --- what survives -------------------------------------------------------------------------

def test_membership_survives_subdivision_and_copy(grid) -> None:
    select(grid, on_side(grid, 0, -1.0))
    bpy.ops.cmc.group_add(name="west", kind="BINORMAL", tilt=0.5, assign=True)
    with edit_mode():
        bpy.ops.mesh.select_all(action="SELECT")
        bpy.ops.mesh.subdivide(number_cuts=1)
    assert members(grid, 1) == set(on_side(grid, 0, -1.0)) and len(members(grid, 1)) == 2 * SIDE

    copy = grid.copy()
    copy.data = grid.data.copy()
    assert members(copy, 1) == members(grid, 1)
    assert [(g.name, g.uid, g.kind) for g in copy.data.cmc.groups] == [("west", 1, "BINORMAL")]
    assert copy.data.cmc.groups[0].tilt == pytest.approx(0.5)
    assert copy.data.cmc.next_uid == 2


def test_membership_survives_saving(grid, tmp_path) -> None:
    select(grid, on_side(grid, 0, -1.0))
    bpy.ops.cmc.group_add(name="west", kind="FREE", assign=True)
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "plan.blend"))
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "plan.blend"))
    ob = bpy.data.objects["Grid"]
    assert len(members(ob, 1)) == SIDE
    assert [(g.name, g.kind) for g in ob.data.cmc.groups] == [("west", "FREE")]


def test_undo_in_object_mode(grid) -> None:
    name = grid.name
    select(grid, on_side(grid, 0, -1.0))
    bpy.ops.ed.undo_push(message="start")
    bpy.ops.cmc.group_add("EXEC_DEFAULT", True, name="west", assign=True)
    bpy.ops.cmc.group_remove("EXEC_DEFAULT", True)
    bpy.ops.ed.undo()
    ob = bpy.data.objects[name]
    assert [g.name for g in ob.data.cmc.groups] == ["west"] and len(members(ob, 1)) == SIDE
    bpy.ops.ed.undo()
    ob = bpy.data.objects[name]
    assert not ob.data.cmc.groups and not values(ob).any()
    bpy.ops.ed.redo()
    ob = bpy.data.objects[name]
    assert [g.name for g in ob.data.cmc.groups] == ["west"] and len(members(ob, 1)) == SIDE


# --- where it does not apply ---------------------------------------------------------------

def test_messages(grid) -> None:
    with pytest.raises(RuntimeError, match="Add a boundary group first"):
        bpy.ops.cmc.group_assign()
    bpy.ops.cmc.group_add(name="rim")
    with pytest.raises(RuntimeError, match=r"No boundary group is called 'rum'; the groups of this mesh are: 'rim'"):
        bpy.ops.cmc.group_select(group="rum")
    with pytest.raises(RuntimeError, match="None of the selected edges is in this group"):
        bpy.ops.cmc.group_remove_from()
    bpy.context.view_layer.objects.active = None
    with pytest.raises(RuntimeError, match="Select a mesh first"):
        bpy.ops.cmc.group_add()


def test_a_foreign_attribute_of_the_same_name_is_left_alone(grid) -> None:
    grid.data.attributes.new(ATTRIBUTE, "FLOAT", "POINT")
    select(grid, on_side(grid, 0, -1.0))
    with pytest.raises(RuntimeError, match="rename or remove it"):
        bpy.ops.cmc.group_add(assign=True)
    assert not grid.data.cmc.groups
    assert grid.data.attributes[ATTRIBUTE].data_type == "FLOAT"
    assert ungrouped(grid) == (4 * SIDE, 4 * SIDE)


def test_renaming_keeps_names_different(grid) -> None:
    for name in ("west", "east"):
        bpy.ops.cmc.group_add(name=name)
    groups = grid.data.cmc.groups
    groups[1].name = "west"
    assert names(grid) == ["west", "west.001"]
    groups[1].name = "north"
    assert names(grid) == ["west", "north"] and groups.get("north") == groups[1]
