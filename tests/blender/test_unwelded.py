"""Parts that only touch: Solve and Mesh Plan say that their vertices coincide, or where a T-junction is."""

from __future__ import annotations

import bpy
import numpy as np
import pytest

from .scenes import activate, add_group, boundary_edges, mesh_object, quad_disc, values
from .sidebar import draw, text_of

FINISHED = {"FINISHED"}


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


# --- Weld ----------------------------------------------------------------------------------

def row() -> tuple[str, bool]:
    """What the panel says of vertices that touch, and whether it has the button."""
    record = draw("CMC_PT_plan")
    return text_of(record), "cmc.weld" in record.operators


@pytest.mark.parametrize("mode", ["OBJECT", "EDIT"])
def test_weld_joins_two_halves(mode):
    plan = halves()
    bpy.ops.object.mode_set(mode=mode)
    with pytest.raises(RuntimeError, match=r"merge them by distance.* Weld, in the panel Plan, joins them\."):
        bpy.ops.cmc.solve()
    assert "9 vertices touch, unjoined" in row()[0] and row()[1]
    assert bpy.ops.cmc.weld() == FINISHED
    bpy.context.view_layer.update()
    assert not row()[1] and not bpy.ops.cmc.weld.poll()
    assert bpy.ops.cmc.solve() == FINISHED
    bpy.ops.object.mode_set(mode="OBJECT")
    assert (len(plan.data.vertices), len(plan.data.polygons)) == (13 * 9, 96)


@pytest.mark.parametrize("swap", [False, True])
def test_weld_splits_edges_at_t_junctions(swap):
    """A row of large quads beside a row of small ones: the large ones become polygons of five corners."""
    plan = halves(other_step=2.0)
    if swap:
        plan.data.flip_normals()
    assert "vertices touch" in row()[0]
    assert bpy.ops.cmc.weld() == FINISHED
    assert len(plan.data.vertices) == 7 * 9 + 4 * 5 - 5
    assert sorted(len(face.vertices) for face in plan.data.polygons) == [4] * (48 + 8) + [5] * 4
    assert bpy.ops.cmc.solve() == FINISHED


def test_several_vertices_inside_one_edge():
    points = [(0, 0), (8, 0), (8, 4), (0, 4)] + [(k, 4) for k in (0, 1, 3, 6, 8)] + [(8, 8), (0, 8)]
    plan = mesh_object("Wall", [(x, y, 0.0) for x, y in points], [(0, 1, 2, 3), (4, 5, 6, 7, 8, 9, 10)])
    assert bpy.ops.cmc.weld() == FINISHED
    assert len(plan.data.vertices) == 9 and sorted(len(face.vertices) for face in plan.data.polygons) == [7, 7]
    assert len(boundary_edges(plan.data)) == 6


def test_after_a_merge_only_the_junctions_are_left():
    plan = halves(other_step=2.0)
    merge()
    assert "4 vertices touch" in row()[0]
    assert bpy.ops.cmc.weld() == FINISHED and bpy.ops.cmc.solve() == FINISHED
    assert len(plan.data.vertices) == 7 * 9 + 4 * 5 - 5


def test_weld_keeps_groups_and_layers_and_is_one_step_of_undo():
    plan = halves()
    x = [vertex.co.x for vertex in plan.data.vertices]
    rim = [e for e in boundary_edges(plan.data) if all(x[v] == 0 for v in plan.data.edges[e].vertices)]
    uid = add_group(plan, "Left", rim, "BINORMAL", tilt=0.3).uid
    layer = plan.data.attributes.new("mine", "FLOAT", "FACE")
    layer.data.foreach_set("value", np.arange(96, dtype=np.float32))
    bpy.ops.ed.undo_push(message="Drawn")
    assert bpy.ops.cmc.weld("EXEC_DEFAULT", True) == FINISHED
    mesh = bpy.data.objects["Halves"].data
    assert values(mesh.attributes["cmc_group"]).count(uid) == len(rim) == 8
    assert sorted(values(mesh.attributes["mine"])) == list(range(96))
    bpy.ops.ed.undo()
    assert len(bpy.data.objects["Halves"].data.vertices) == 2 * 7 * 9


def test_rooms_are_welded_into_one_outline():
    corners = [(0, 0), (6, 0), (6, 8), (0, 8), (6, 0), (12, 0), (12, 8), (6, 8)]
    mesh_object("Rooms", [(x, y, 0.0) for x, y in corners], [(0, 1, 2, 3), (4, 5, 6, 7)])
    with pytest.raises(RuntimeError, match="Weld, in the panel Plan, joins them"):
        bpy.ops.cmc.mesh_plan()
    assert bpy.ops.cmc.weld() == FINISHED
    assert bpy.ops.cmc.mesh_plan(edge_length=1.0) == FINISHED


def test_there_is_nothing_to_weld():
    """Not on one whole plan, nor on a slit, which is meant to be open, nor on results."""
    plan = quad_disc()
    assert not row()[1] and not bpy.ops.cmc.weld.poll()
    assert bpy.ops.cmc.solve() == FINISHED
    activate(plan.cmc.f_plus)
    assert not row()[1] and not bpy.ops.cmc.weld.poll()
    slit = [(x, y, 0.0) for y in range(3) for x in range(3)] + [(1.0, 0.0, 0.0)]
    mesh_object("Slit", slit, [(0, 1, 4, 3), (9, 2, 5, 4), (3, 4, 7, 6), (4, 5, 8, 7)])
    assert not row()[1]
    activate(None)
    assert not bpy.ops.cmc.weld.poll()
