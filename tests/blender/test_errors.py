"""Every message a user can meet when solving names the offender, and leaves the file as it was."""

from __future__ import annotations

from importlib import import_module

import bpy
import numpy as np
import pytest

from .scenes import activate, add_group, boundary_edges, link, mesh_object, quad_disc, snapshot


def fails(pattern: str, call=None, **settings) -> None:
    """The call reports an error that matches, and afterwards everything is as before."""
    before = snapshot()
    with pytest.raises(RuntimeError, match=pattern):
        (call or bpy.ops.cmc.solve)(**settings)
    assert snapshot() == before


def grid(n: int, offset=(0.0, 0.0)):
    """Vertices and quads of an n × n grid of unit cells."""
    points = [(x + offset[0], y + offset[1], 0.0) for y in range(n + 1) for x in range(n + 1)]
    faces = [
        (y * (n + 1) + x, y * (n + 1) + x + 1, (y + 1) * (n + 1) + x + 1, (y + 1) * (n + 1) + x)
        for y in range(n)
        for x in range(n)
    ]
    return points, faces


def test_nothing_active():
    activate(None)
    fails("No object is active")


def test_not_a_mesh():
    link(bpy.data.objects.new("Lamp", bpy.data.lights.new("Lamp", "POINT")))
    fails("'Lamp' is not a mesh")


def test_no_faces():
    mesh_object("Wire", [(0, 0, 0), (1, 0, 0), (1, 1, 0)], [], edges=[(0, 1), (1, 2)])
    fails("'Wire' has no faces")


def test_empty_mesh():
    mesh_object("Empty", np.zeros((0, 3)), [])
    fails("'Empty' has no faces")


def test_closed_mesh():
    bpy.ops.mesh.primitive_cube_add()
    fails("The mesh is closed: it has no boundary")


def test_two_components():
    points, faces = grid(3)
    more, more_faces = grid(3, (10.0, 0.0))
    mesh_object("Two", points + more, faces + [tuple(i + len(points) for i in f) for f in more_faces])
    # counted in polygons, 9 in each part; its 18 triangles are the solver's business
    fails("2 components.*faces 0, 1, 2, 3, 4, 5, 6, 7 and 1 more")


def test_moebius_strip():
    n = 12
    t = 2 * np.pi * np.arange(n) / n
    points = []
    for side in (-0.4, 0.0, 0.4):
        radius = 2 + side * np.cos(t / 2)
        points += list(zip(radius * np.cos(t), radius * np.sin(t), side * np.sin(t / 2), strict=True))
    faces = []
    for row in range(2):
        for k in range(n):
            a, b = row * n + k, (row + 1) * n + k
            if k < n - 1:
                faces.append((a, a + 1, b + 1, b))
            else:  # half a turn: the lower side continues as the upper
                faces.append((a, (2 - row) * n, (1 - row) * n, b))
    ob = mesh_object("Moebius", points, faces)
    turned = [next(e.index for e in ob.data.edges if set(e.vertices) == pair) for pair in ({0, 12}, {12, 24})]
    fails(
        f"one-sided, like a Möbius strip.*edges {turned[0]}, {turned[1]} "
        r"\(the first joins vertices 12, 0; faces 0, 11, 12, 23\)"
    )


def test_flipped_face():
    points, faces = grid(3)
    faces[4] = faces[4][::-1]
    mesh_object("Flipped", points, faces)
    fails(r"\b4\b")


def test_spike():
    points, faces = grid(3)
    points.append((5.0, 0.0, 0.0))
    tip = len(points) - 1
    # the polygon 2 (a quad at the lower right corner) runs out to a tip and back along the same line
    a, b, c, d = faces[2]
    faces[2] = (a, b, tip, c, d)
    points[b], points[tip], points[c] = (3.0, 0.0, 0.0), (5.0, 0.5, 0.0), (3.0, 0.0, 0.0)
    mesh_object("Spike", points, faces)
    fails(rf"[Pp]olygon 2 has a spike at vertex {tip}")


def test_three_faces_at_an_edge():
    points, faces = grid(3)
    points.append((1.5, 1.5, 1.0))
    faces.append((5, 6, len(points) - 1))
    ob = mesh_object("Fin", points, faces)
    edge = next(e.index for e in ob.data.edges if set(e.vertices) == {5, 6})
    fails(rf"[Ee]dge {edge} .*more than two faces")


def test_zero_area():
    points, faces = grid(3)
    points[5] = points[6]
    ob = mesh_object("Collapsed", points, faces)
    assert tuple(ob.data.polygons[4].vertices) == (5, 6, 10, 9)
    fails(r"\b(no area|spike|crosses)")


def test_nan():
    ob = quad_disc()
    ob.data.vertices[7].co.x = float("nan")
    fails("vertex 7 of 'Disc' are not finite")


def test_flat_transform():
    quad_disc().scale = (0.0, 1.0, 1.0)
    fails("no area|spike")


def test_loose_vertex():
    ob = quad_disc()
    ob.data.vertices.add(1)
    last = len(ob.data.vertices) - 1
    fails(rf"[Vv]ertex {last} belongs to no face")


def test_one_face():
    mesh_object("Single", [(0, 0, 0), (1, 0, 0), (0, 1, 0)], [(0, 1, 2)])
    fails("no vertex inside its boundary")


def test_all_free():
    ob = quad_disc()
    add_group(ob, "Rim", boundary_edges(ob.data), "FREE")
    fails("All boundary edges are free")


def test_antipodal_normals():
    ob = quad_disc()
    rim = boundary_edges(ob.data)
    at = {v: [e for e in rim if v in ob.data.edges[e].vertices] for v in [100]}[100]
    add_group(ob, "Up", at[:1], "PLANE", normal=(0.0, 0.0, 1.0))
    add_group(ob, "Down", at[1:], "PLANE", normal=(0.0, 0.0, -1.0))
    fails(r"(opposite|cancel).*\b100\b|\b100\b.*(opposite|cancel)")


def test_nothing_selected():
    ob = quad_disc()
    for edge in ob.data.edges:
        edge.select = False
    fails("No boundary edge of 'Disc' is selected", bpy.ops.cmc.solve_selection)


def test_degenerate_sheet_shown():
    quad_disc(rings=12, columns=48)
    fails("f- degenerates to a point", sheet="F_MINUS")


def test_result_of_a_deleted_plan():
    plan = quad_disc()
    bpy.ops.cmc.solve()
    result = plan.cmc.f_plus
    bpy.context.scene.collection.objects.unlink(plan)
    activate(result)
    fails("'Disc f\\+' is a result whose plan has been deleted")


def test_result_in_edit_mode():
    plan = quad_disc()
    bpy.ops.cmc.solve()
    activate(plan.cmc.f_plus)
    bpy.ops.object.mode_set(mode="EDIT")
    fails("'Disc f\\+' is in edit mode")


def test_a_plan_of_another_file(tmp_path):
    path = str(tmp_path / "plans.blend")
    bpy.data.libraries.write(path, {quad_disc()})
    bpy.ops.wm.read_factory_settings(use_empty=True)
    import addon_utils

    addon_utils.enable("cmc_formfinding", default_set=True)
    with bpy.data.libraries.load(path, link=True) as (there, here):
        here.objects = there.objects
    link(bpy.data.objects["Disc"])
    fails("'Disc' is linked from another file")


@pytest.mark.parametrize("failing", ["background.worker", "operators"])
def test_a_registration_that_fails_is_taken_back(addon, monkeypatch, failing):
    """The error reaches Blender, and nothing of the add-on is left, so that it can be enabled again."""
    cmc_addon = addon.cmc_addon
    module = import_module(f"{cmc_addon.__name__}.{failing}")
    real = module.register
    cmc_addon.unregister()

    def register():
        real()
        raise ValueError("no")

    monkeypatch.setattr(module, "register", register)
    with pytest.raises(ValueError, match="no"):
        cmc_addon.register()
    assert not hasattr(bpy.types.Object, "cmc")
    assert not hasattr(bpy.types, "CMC_OT_solve")
    monkeypatch.undo()
    cmc_addon.register()
    assert hasattr(bpy.types, "CMC_OT_solve")


def test_a_class_that_fails_leaves_the_others_to_be_taken_back(addon):
    registration = import_module(f"{addon.cmc_addon.__name__}.properties.registration").registration

    class CMC_OT_good(bpy.types.Operator):
        bl_idname, bl_label = "cmc.good", "Good"

    class CMC_OT_bad(bpy.types.Operator):
        """No label: Blender refuses it."""

    register, unregister = registration((CMC_OT_good, CMC_OT_bad), {"load_post": print})
    with pytest.raises((ValueError, RuntimeError, AttributeError)):
        register()
    assert CMC_OT_good.is_registered
    assert print not in bpy.app.handlers.load_post
    unregister()
    assert not hasattr(bpy.types, "CMC_OT_good")


def test_registering_twice_calls_nothing_twice(addon):
    registration = import_module(f"{addon.cmc_addon.__name__}.properties.registration").registration

    class CMC_OT_good(bpy.types.Operator):
        bl_idname, bl_label = "cmc.good", "Good"

    register, unregister = registration((CMC_OT_good,), {"load_post": print})
    register()
    register()
    assert bpy.app.handlers.load_post.count(print) == 1
    unregister()
    assert print not in bpy.app.handlers.load_post and not CMC_OT_good.is_registered


def test_the_add_on_registered_twice_is_there_once(addon):
    cmc_addon = addon.cmc_addon
    lists = {name: len(getattr(bpy.app.handlers, name)) for name in ("load_post", "undo_post", "depsgraph_update_post")}
    cmc_addon.register()
    assert {name: len(getattr(bpy.app.handlers, name)) for name in lists} == lists


@pytest.mark.parametrize("name", ["Closed", "Loose"])
def test_errors_in_edit_mode(name):
    """The same in edit mode, with a change that is not yet in the mesh."""
    import bmesh

    bpy.ops.mesh.primitive_cube_add() if name == "Closed" else quad_disc()
    bpy.ops.object.mode_set(mode="EDIT")
    bm = bmesh.from_edit_mesh(bpy.context.object.data)
    if name == "Loose":
        bm.verts.new((9.0, 9.0, 9.0))
    fails("closed" if name == "Closed" else r"[Vv]ertex 121 belongs to no face")


def test_errors_are_in_the_plans_numbers(addon):
    """Triangles become their polygons, edges those of the mesh; an edge inside a polygon is named by its vertices."""
    numbering, bridge = addon.cmc_addon.bridges.numbering, addon.cmc_addon.bridges.mesh_bridge
    errors = import_module(f"{addon.__name__}.solver.errors")
    plan = bridge.read_plan(mesh_object("Grid", *grid(3)))
    triangles = np.array([t for a, b, c, d in grid(3)[1] for t in ((a, b, c), (a, c, d))], dtype=np.int32)
    owners = np.repeat(np.arange(9, dtype=np.int32), 2)
    pairs = np.unique(np.sort(triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1), axis=0).tolist()
    side, diagonal = pairs.index([5, 6]), pairs.index([5, 10])
    ours = next(k for k, pair in enumerate(plan.edges.tolist()) if set(pair) == {5, 6})
    assert ours != side, "else the number could not tell"

    def renumbered(text, **offenders):
        return numbering.in_plan_numbers(errors.MeshError(text, **offenders), plan, triangles, owners)

    error = renumbered("Faces 8, 9, 17 have no area; face 3 is fine.", faces=[8, 9, 17])
    assert str(error) == "Faces 4, 8 have no area; face 1 is fine."
    assert list(error.faces) == [4, 8] and isinstance(error, errors.MeshError)
    error = renumbered(f"Edges {side}, {diagonal} are bad at vertex 5.", edges=[side, diagonal], vertices=[5])
    assert str(error) == f"Edges {ours}, from vertex 5 to 10 are bad at vertex 5."
    assert list(error.edges) == [ours] and list(error.vertices) == [5]
    error = renumbered("Faces 8, 9 have no area.", faces=[8, 9])
    assert str(error) == "Face 4 has no area."
