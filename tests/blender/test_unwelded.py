"""Parts that only touch: Solve and Mesh Plan say that their vertices coincide, or where a T-junction is."""

from __future__ import annotations

import bpy
import pytest

from .scenes import mesh_object


def halves(other_step=1.0):
    """Two plans of 6 × 8 joined with Ctrl J; 9 pairs of coinciding vertices where the steps are equal."""
    points, faces = [], []
    for at, step in ((0.0, 1.0), (6.0, other_step)):
        first, columns, rows = len(points), int(6 / step), int(8 / step)
        points += [(at + x * step, y * step, 0.0) for y in range(rows + 1) for x in range(columns + 1)]
        n = columns + 1
        corners = [first + y * n + x for y in range(rows) for x in range(columns)]
        faces += [(a, a + 1, a + n + 1, a + n) for a in corners]
    return mesh_object("Halves", points, faces)


def merge(distance=1e-4):
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.select_all(action="SELECT")
    bpy.ops.mesh.remove_doubles(threshold=distance)
    bpy.ops.object.mode_set(mode="OBJECT")


def test_two_halves():
    halves()
    with pytest.raises(RuntimeError, match=r"2 components that touch: .*merge them by distance"):
        bpy.ops.cmc.solve()
    merge()
    assert bpy.ops.cmc.solve() == {"FINISHED"}


def test_a_t_junction():
    halves(other_step=2.0)
    with pytest.raises(RuntimeError, match=r"Vertices .* lie inside an edge of the rim"):
        bpy.ops.cmc.solve()
    merge()
    with pytest.raises(RuntimeError, match=r"Vertices .* lie inside an edge of the rim.*a T-junction"):
        bpy.ops.cmc.solve()


def test_two_rooms_that_share_a_wall():
    corners = [(0, 0), (6, 0), (6, 8), (0, 8), (6, 0), (12, 0), (12, 8), (6, 8)]
    mesh_object("Rooms", [(x, y, 0.0) for x, y in corners], [(0, 1, 2, 3), (4, 5, 6, 7)])
    with pytest.raises(RuntimeError, match=r"2 outlines beside each other, of which 2 vertices coincide"):
        bpy.ops.cmc.mesh_plan()
    merge()
    assert bpy.ops.cmc.mesh_plan(edge_length=1.0) == {"FINISHED"}
