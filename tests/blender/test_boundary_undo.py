"""Undo of the list of boundary groups in edit mode, where undo knows the edit mesh only."""

from __future__ import annotations

import bpy  # before bmesh, which it brings along

# isort: split
import bmesh
import pytest

from .test_boundary import SIDE, members, names, select, square_grid


@pytest.fixture
def grid() -> bpy.types.Object:
    return square_grid()


def in_edit_mode(ob) -> None:
    """Edit mode with the west side selected, as a step of its own."""
    bpy.ops.ed.undo_push(message="start")
    bpy.ops.object.mode_set("EXEC_DEFAULT", True, mode="EDIT")
    bpy.context.tool_settings.mesh_select_mode = (False, True, False)
    select(ob, on_side_in_edit_mode(ob))
    bpy.ops.ed.undo_push(message="select")


def on_side_in_edit_mode(ob) -> list[int]:
    edges = bmesh.from_edit_mesh(ob.data).edges
    return [edge.index for edge in edges if all(abs(v.co.x + 1) < 1e-6 for v in edge.verts)]


def test_undo_of_the_list_in_edit_mode(grid) -> None:
    in_edit_mode(grid)
    bpy.ops.cmc.group_add("EXEC_DEFAULT", True, name="west", assign=True)
    bpy.ops.cmc.group_add("EXEC_DEFAULT", True, name="other")
    bpy.ops.cmc.group_move("EXEC_DEFAULT", True, direction="UP")
    grid.data.cmc.groups["west"].angle = 0.5
    bpy.ops.cmc.group_remove("EXEC_DEFAULT", True, group="west")
    assert (names(grid), members(grid, 1)) == (["other"], set())
    states = [(["other", "west"], SIDE), (["west", "other"], SIDE), (["west"], SIDE), ([], 0)]
    for expected in states:
        bpy.ops.ed.undo()
        assert (names(grid), len(members(grid, 1))) == expected
    for expected in reversed(states[:-1]):
        bpy.ops.ed.redo()
        assert (names(grid), len(members(grid, 1))) == expected
    assert grid.data.cmc.groups["west"].angle == pytest.approx(0.5), "angles are as last set"
    bpy.ops.ed.redo()
    assert (names(grid), members(grid, 1)) == (["other"], set())
    bpy.ops.object.mode_set("EXEC_DEFAULT", True, mode="OBJECT")
    assert names(grid) == ["other"]


def test_undo_in_edit_mode_leaves_groups_made_in_object_mode(grid) -> None:
    in_edit_mode(grid)
    bpy.ops.cmc.group_add("EXEC_DEFAULT", True, name="first")
    bpy.ops.object.mode_set("EXEC_DEFAULT", True, mode="OBJECT")
    bpy.ops.cmc.group_add("EXEC_DEFAULT", True, name="second")
    bpy.ops.object.mode_set("EXEC_DEFAULT", True, mode="EDIT")
    bpy.ops.cmc.group_add("EXEC_DEFAULT", True, name="third")
    bpy.ops.ed.undo()
    assert names(bpy.context.object) == ["first", "second"]
    bpy.ops.ed.redo()
    assert names(bpy.context.object) == ["first", "second", "third"]
