"""Mesh Plan: outlines of every kind in, a well-shaped plan out, groups carried over, nothing lost."""

from __future__ import annotations

import math

import bpy
import numpy as np
import pytest
from mathutils import Euler, Matrix, Vector

SQUARE = [(0.0, 0.0), (8.0, 0.0), (8.0, 6.0), (0.0, 6.0)]
HOLE = [(3.0, 2.0), (5.0, 2.0), (5.0, 4.0), (3.0, 4.0)]


def wire(*loops, z=0.0, name="Hall") -> bpy.types.Object:
    """An object of edges only."""
    points, edges = [], []
    for loop in loops:
        first, count = len(points), len(loop)
        points += [(x, y, z) for x, y in loop]
        edges += [(first + k, first + (k + 1) % count) for k in range(count)]
    return added(name, points, edges, [])


def ngon(loop, z=0.0, name="Hall") -> bpy.types.Object:
    return added(name, [(x, y, z) for x, y in loop], [], [range(len(loop))])


def added(name, points, edges, faces) -> bpy.types.Object:
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(points, edges, [list(face) for face in faces])
    repair_selection(mesh)
    return linked(bpy.data.objects.new(name, mesh))


def repair_selection(mesh) -> None:
    """Blender 5.0 crashes on setting the selection of edges it has calculated."""
    from cmc_formfinding.cmc_addon.bridges import edge_bridge

    edge_bridge.repair_selection(mesh)


def curve(*splines, kind="POLY", cyclic=True, dimensions="2D") -> bpy.types.Object:
    """A curve object with a spline through each list of points; Bezier handles are automatic."""
    data = bpy.data.curves.new("Hall", "CURVE")
    data.dimensions = dimensions
    for loop in splines:
        spline = data.splines.new(kind)
        points = spline.bezier_points if kind == "BEZIER" else spline.points
        points.add(len(loop) - 1)
        for point, (x, y) in zip(points, loop, strict=True):
            if kind == "BEZIER":
                point.co = (x, y, 0)
                point.handle_left_type = point.handle_right_type = "AUTO"
            else:
                point.co = (x, y, 0, 1)
        spline.use_cyclic_u = cyclic
        if kind == "NURBS":
            spline.order_u = 4
    return linked(bpy.data.objects.new("Hall", data))


def linked(ob) -> bpy.types.Object:
    bpy.context.collection.objects.link(ob)
    for other in bpy.context.view_layer.objects:
        other.select_set(False)
    activate(ob)
    bpy.context.view_layer.update()
    return ob


def activate(ob) -> None:
    ob.select_set(True)
    bpy.context.view_layer.objects.active = ob


def mesh_plan(**settings) -> bpy.types.Object:
    assert bpy.ops.cmc.mesh_plan(**settings) == {"FINISHED"}
    return bpy.context.object


def points(ob) -> np.ndarray:
    """Vertices in world coordinates."""
    matrix = np.array(ob.matrix_world)
    return np.array([v.co for v in ob.data.vertices]) @ matrix[:3, :3].T + matrix[:3, 3]


def corners(ob) -> np.ndarray:
    return points(ob)[[list(face.vertices) for face in ob.data.polygons]]


def normals(ob) -> np.ndarray:
    """World normals of the faces, as long as twice the area."""
    a, b, c = corners(ob).transpose(1, 0, 2)
    return np.cross(b - a, c - a)


def area(ob) -> float:
    return 0.5 * float(np.linalg.norm(normals(ob), axis=1).sum())


def smallest_angle(ob) -> float:
    p = corners(ob)
    u, v = np.roll(p, -1, axis=1) - p, np.roll(p, 1, axis=1) - p
    cosines = (u * v).sum(2) / (np.linalg.norm(u, axis=2) * np.linalg.norm(v, axis=2))
    return math.degrees(np.arccos(cosines).min())


def boundary(ob) -> list[int]:
    used = np.bincount([loop.edge_index for loop in ob.data.loops], minlength=len(ob.data.edges))
    return np.flatnonzero(used == 1).tolist()


def groups(ob) -> dict[str, set[int]]:
    """Edges of each group, by name."""
    values = np.array([item.value for item in ob.data.attributes["cmc_group"].data])
    return {group.name: set(np.flatnonzero(values == group.uid).tolist()) for group in ob.data.cmc.groups}


def set_group(ob, name, edges, **parameters) -> None:
    ob.data.edges.foreach_set("select", np.isin(np.arange(len(ob.data.edges)), list(edges)))
    activate(ob)
    bpy.ops.cmc.group_add(name=name, assign=True, **parameters)


def along(ob, axis, where) -> set[int]:
    """Boundary edges of which both ends have that coordinate."""
    at = np.isclose(points(ob)[:, axis], where, atol=1e-5)
    return {k for k in boundary(ob) if all(at[v] for v in ob.data.edges[k].vertices)}


# --- outlines of every kind ----------------------------------------------------------------

def test_ngon() -> None:
    ob = ngon(SQUARE)
    plan = mesh_plan(round_corners=False)
    assert (plan.name, ob.name) == ("Hall Plan", "Hall")
    assert len(ob.data.polygons) == 1, "the drawn outline stays as it is"
    assert area(plan) == pytest.approx(48.0, rel=1e-6)
    assert (normals(plan)[:, 2] > 0).all()
    assert smallest_angle(plan) > 25
    ends = points(plan)[[list(edge.vertices) for edge in plan.data.edges]]
    lengths = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
    assert 0.1 < np.median(lengths) < 0.2 * 1.05, "a fortieth of 8 is 0.2"


def test_faces_with_a_hole() -> None:
    ring = [(0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)]
    added("Court", [(x, y, 0) for x, y in SQUARE + HOLE], [], ring)
    plan = mesh_plan(edge_length=0.5, round_corners=False)
    assert area(plan) == pytest.approx(48.0 - 4.0, rel=1e-6)
    assert not ((points(plan)[:, :2] > (3.01, 2.01)) & (points(plan)[:, :2] < (4.99, 3.99))).all(axis=1).any()


def test_edges_only_with_a_hole_drawn_first() -> None:
    wire(HOLE, SQUARE)
    plan = mesh_plan(edge_length=0.5, round_corners=False)
    assert area(plan) == pytest.approx(44.0, rel=1e-6)


def test_a_mesh_of_many_faces_and_stray_edges() -> None:
    bpy.ops.mesh.primitive_grid_add(x_subdivisions=5, y_subdivisions=3, size=4)
    plan = mesh_plan(edge_length=0.4, round_corners=False)
    assert area(plan) == pytest.approx(16.0, rel=1e-6)


@pytest.mark.parametrize("kind", ["POLY", "BEZIER", "NURBS"])
@pytest.mark.parametrize("clockwise", [False, True])
def test_curves(kind, clockwise) -> None:
    angles = np.linspace(0, 2 * np.pi, 24, endpoint=False) * (-1 if clockwise else 1)
    circles = [[(r * math.cos(t), r * math.sin(t)) for t in angles] for r in (5.0, 2.0)]
    ob = curve(*circles, kind=kind)
    plan = mesh_plan(edge_length=0.5)
    exact = math.pi * (25 - 4) * (0.975 if kind == "NURBS" else 1)  # a NURBS runs inside its polygon
    assert area(plan) == pytest.approx(exact, rel=0.03)
    assert (normals(plan)[:, 2] > 0).all()
    assert not ob.hide_get(), "a curve has no faces to fight with"


def test_a_filled_bevelled_curve_is_taken_by_its_line() -> None:
    ob = curve(SQUARE)
    ob.data.fill_mode = "BOTH"
    ob.data.extrude, ob.data.bevel_depth = 0.3, 0.1
    before = set(bpy.data.curves), set(bpy.data.meshes)
    plan = mesh_plan(edge_length=0.5, round_corners=False)
    assert area(plan) == pytest.approx(48.0, rel=1e-6)
    assert (set(bpy.data.curves), set(bpy.data.meshes) - {plan.data}) == before, "nothing is left behind"
    assert (ob.data.extrude, ob.data.bevel_depth, ob.data.fill_mode) == pytest.approx((0.3, 0.1, "BOTH"))


@pytest.mark.parametrize("build", [lambda: ngon(SQUARE), lambda: curve(SQUARE)], ids=["mesh", "curve"])
def test_from_edit_mode_and_undo(build) -> None:
    ob = build()
    name = ob.name
    bpy.ops.ed.undo_push(message="start")
    bpy.ops.object.mode_set("EXEC_DEFAULT", True, mode="EDIT")
    bpy.ops.cmc.mesh_plan("EXEC_DEFAULT", True, edge_length=1.0)
    assert bpy.context.mode == "OBJECT" and bpy.context.object.name == "Hall Plan"
    bpy.ops.ed.undo()
    assert "Hall Plan" not in bpy.data.objects
    assert bpy.context.object.name == name and not bpy.context.object.hide_get()
    bpy.ops.ed.redo()
    assert bpy.data.objects["Hall Plan"].cmc.outline == bpy.data.objects[name]
    assert bpy.data.objects[name].cmc.plan == bpy.data.objects["Hall Plan"]


# --- where it lies -------------------------------------------------------------------------

def test_heights_of_a_level_plan_are_kept() -> None:
    ngon(SQUARE, z=3.25)
    plan = mesh_plan(edge_length=0.5)
    assert (points(plan)[:, 2] == 3.25).all()


def test_transforms_are_respected() -> None:
    ob = ngon(SQUARE)
    ob.location, ob.scale = (10, -5, 2), (2, 0.5, 7)
    ob.rotation_euler = (0, 0, math.radians(30))
    bpy.context.view_layer.update()
    plan = mesh_plan(edge_length=0.4, round_corners=False)
    assert tuple(plan.scale) == pytest.approx((1, 1, 1), abs=1e-6)
    middle = (points(plan).min(axis=0) + points(plan).max(axis=0)) / 2
    assert tuple(plan.location) == pytest.approx(tuple(middle), abs=1e-5), "the origin is in the middle"
    assert area(plan) == pytest.approx(16 * 3, rel=1e-5)
    drawn = [ob.matrix_world @ v.co for v in ob.data.vertices]
    nearest = [min((Vector(p) - q).length for p in points(plan)) for q in drawn]
    assert max(nearest) < 1e-5


def test_a_mirrored_outline_gives_faces_that_look_up() -> None:
    ob = ngon(SQUARE)
    ob.scale = (-1, 1, 1)
    bpy.context.view_layer.update()
    assert (normals(mesh_plan(edge_length=0.5))[:, 2] > 0).all()


@pytest.mark.parametrize("degrees", [20, 60, 90, 160])
def test_a_plan_in_any_plane(degrees) -> None:
    ob = ngon(SQUARE)
    ob.matrix_world = Matrix.LocRotScale((1, 2, 3), Euler((math.radians(degrees), 0, 0)), None)
    bpy.context.view_layer.update()
    plan = mesh_plan(edge_length=0.5, round_corners=False)
    assert area(plan) == pytest.approx(48.0, rel=1e-5)
    normal = np.array(ob.matrix_world.to_3x3() @ Vector((0, 0, 1)))
    assert np.abs((points(plan) - (1, 2, 3)) @ normal).max() < 1e-5
    assert (normals(plan)[:, 2] > -1e-6).all()


def test_an_outline_that_is_not_flat_is_flattened_and_said_so(capfd) -> None:
    added("Hall", [(0, 0, 0.2), (8, 0, -0.2), (8, 8, 0.2), (0, 8, -0.2)], [(0, 1), (1, 2), (2, 3), (3, 0)], [])
    plan = mesh_plan(edge_length=0.5)
    assert np.ptp(points(plan)[:, 2]) < 1e-5
    assert "leaves its plane by 0.2" in capfd.readouterr().out


def test_uv_layer_holds_plan_coordinates() -> None:
    ob = ngon(SQUARE)
    ob.location = (100, 50, 4)
    bpy.context.view_layer.update()
    plan = mesh_plan(edge_length=0.5)
    assert plan.data.uv_layers.active.name == "Plan"
    uv = np.array([item.vector for item in plan.data.uv_layers["Plan"].uv])
    vertex = [loop.vertex_index for loop in plan.data.loops]
    assert uv == pytest.approx(points(plan)[vertex][:, :2] - (104, 53), abs=1e-4), "from the plan's middle"


# --- settings ------------------------------------------------------------------------------

def test_corners_are_rounded_by_default() -> None:
    ngon(SQUARE)
    plan = mesh_plan(edge_length=0.25)
    assert area(plan) == pytest.approx(48 - (4 - math.pi) * 0.8**2, rel=1e-3), "radius: a tenth of 8"
    bpy.context.view_layer.objects.active = plan
    mesh_plan(corner_radius=2.0)
    assert area(plan) == pytest.approx(48 - (4 - math.pi) * 2.0**2, rel=1e-3)


def test_settings_are_remembered_by_the_scene() -> None:
    ngon(SQUARE)
    mesh_plan(edge_length=1.0, round_corners=False)
    first = len(bpy.context.object.data.polygons)
    mesh_plan()
    assert len(bpy.context.object.data.polygons) == first
    assert bpy.context.scene.cmc.edge_length == 1.0 and not bpy.context.scene.cmc.round_corners


# --- the same plan again -------------------------------------------------------------------

def test_the_plan_is_updated_in_place() -> None:
    ob = ngon(SQUARE)
    paint = bpy.data.materials.new("Concrete")
    ob.data.materials.append(paint)
    plan = mesh_plan(edge_length=1.0)
    assert list(plan.data.materials) == [paint]
    plan.name, plan.cmc.size, mesh = "Renamed", "RISE", plan.data
    coarse = len(mesh.polygons)
    again = mesh_plan(edge_length=0.5)  # with the plan active: meshes its outline anew
    assert again == plan and plan.data == mesh and len(mesh.polygons) > 1.4 * coarse
    assert (plan.name, plan.cmc.size, list(mesh.materials)) == ("Renamed", "RISE", [paint])
    ob.hide_set(False)
    ob.data.vertices[2].co.x = 12
    for other in bpy.context.selected_objects:
        other.select_set(False)
    activate(ob)
    assert mesh_plan(round_corners=False) == plan, "with the outline active: the same plan"
    assert area(plan) == pytest.approx(48 + 0.5 * 4 * 6, rel=1e-5)
    assert len([o for o in bpy.data.objects if o.type == "MESH"]) == 2


def test_duplicates_and_deletions() -> None:
    ob = ngon(SQUARE)
    plan = mesh_plan(edge_length=1.0)
    twin = ob.copy()
    twin.data = ob.data.copy()
    linked(twin)
    other = mesh_plan(edge_length=1.0)
    assert other != plan and other.cmc.outline == twin, "a duplicated outline gets a plan of its own"

    copy = plan.copy()
    copy.data = plan.data.copy()
    linked(copy)
    assert mesh_plan(edge_length=0.5) == copy, "a duplicated plan is updated when it is active"
    assert len(copy.data.polygons) > len(plan.data.polygons)

    bpy.data.objects.remove(plan)
    activate(ob)
    fresh = mesh_plan(edge_length=1.0, round_corners=False)
    assert fresh not in (other, copy) and fresh.cmc.outline == ob, "a deleted plan is made anew"

    bpy.data.objects.remove(ob)
    activate(fresh)
    assert mesh_plan(edge_length=0.5) == fresh, "without its outline a plan is meshed from its own rim"
    assert area(fresh) == pytest.approx(48, rel=1e-5)


def test_an_outline_with_faces_is_hidden_and_nothing_else() -> None:
    ob = ngon(SQUARE)
    plan = mesh_plan(edge_length=1.0)
    assert ob.hide_get() and ob.hide_render and not plan.hide_get()
    assert bpy.context.selected_objects == [plan]
    edges = wire(SQUARE, name="Wire")
    mesh_plan(edge_length=1.0)
    assert not edges.hide_get()


# --- groups --------------------------------------------------------------------------------

def test_groups_carry_over_to_the_pieces() -> None:
    ob = ngon(SQUARE)  # edges 0 south, 1 east, 2 north, 3 west
    order = {tuple(sorted(e.vertices)): e.index for e in ob.data.edges}
    set_group(ob, "long", [order[0, 1], order[2, 3]], tilt=0.5)
    set_group(ob, "east", [order[1, 2]], kind="PLANE", normal=(1, 0, 0))
    plan = mesh_plan(edge_length=0.5, round_corners=False)
    assert groups(plan) == {"long": along(plan, 1, 0) | along(plan, 1, 6), "east": along(plan, 0, 8)}
    long, east = plan.data.cmc.groups
    assert (long.kind, long.tilt, east.kind) == ("BINORMAL", pytest.approx(0.5), "PLANE")
    assert len(groups(plan)["east"]) == 12 and len(along(plan, 0, 0)) == 12, "the west side is in no group"


def test_group_borders_on_a_smooth_outline_stay_vertices() -> None:
    count = 60
    circle = [(5 * math.cos(t), 5 * math.sin(t)) for t in 2 * np.pi * np.arange(count) / count]
    ob = wire(circle)
    set_group(ob, "quarter", range(7, 22))
    plan = mesh_plan(edge_length=0.9)
    ends = np.array([circle[7], circle[22]])
    gap = np.linalg.norm(points(plan)[:, None, :2] - ends, axis=2).min(axis=0)
    assert gap.max() < 1e-5


def test_own_groups_and_settings_of_the_plan_survive_an_update() -> None:
    ob = ngon(SQUARE)
    order = {tuple(sorted(e.vertices)): e.index for e in ob.data.edges}
    set_group(ob, "east", [order[1, 2]])
    plan = mesh_plan(edge_length=0.5, round_corners=False)
    plan.data.cmc.groups["east"].tilt = 0.7
    for other in bpy.context.selected_objects:
        other.select_set(False)
    set_group(plan, "west", along(plan, 0, 0), kind="FREE")
    mesh_plan(edge_length=0.3, round_corners=False)
    assert groups(plan) == {"east": along(plan, 0, 8), "west": along(plan, 0, 0)}
    assert plan.data.cmc.groups["east"].tilt == pytest.approx(0.7)
    assert plan.data.cmc.groups["west"].kind == "FREE"
    assert len({group.uid for group in plan.data.cmc.groups}) == 2


# --- messages ------------------------------------------------------------------------------

def two_plans():
    return wire(SQUARE, [(20, 0), (22, 0), (21, 2)])


def closed_mesh():
    bpy.ops.mesh.primitive_cube_add()


def three_faces():
    added("Hall", [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1)], [], [(0, 1, 2), (0, 1, 3), (0, 1, 4)])


def text():
    return linked(bpy.data.objects.new("Hall", bpy.data.curves.new("Hall", "FONT")))


BAD = {
    "open": (lambda: added("Hall", [(0, 0, 0), (1, 0, 0), (1, 1, 0)], [(0, 1), (1, 2)], []), "open at vertices 0, 2"),
    "open curve": (lambda: curve(SQUARE, HOLE, cyclic=False), r"Splines 0, 1 of 'Hall' are open"),
    "empty curve": (lambda: curve(), "is empty"),
    "empty": (lambda: added("Hall", [(0, 0, 0)], [], []), "no outline"),
    "closed": (closed_mesh, "'Cube' is closed and has no boundary"),
    "three faces": (three_faces, r"Edge \d of 'Hall' has more than two faces"),
    "bow tie": (
        lambda: wire([(0, 0), (4, 4), (4, 0), (0, 4)]), r"crosses or touches itself.*In 'Hall': vertices 0, 1, 2, 3"),
    "bow tie, curve": (lambda: curve([(0, 0), (4, 4), (4, 0), (0, 4)]), r"crosses.*In 'Hall': \(0, 0, 0\)"),
    "touching faces": (
        lambda: added("Hall", [(x, y, 0) for x, y in [*SQUARE, (9, 9), (8, 9)]], [], [(0, 1, 2, 3), (2, 4, 5)]),
        "More than two edges .* meet at vertex 2"),
    "two plans": (two_plans, "2 outlines beside each other"),
    "spike": (lambda: ngon([*SQUARE[:3], (4, 6), (4, 9), (4.0001, 6), (0, 6)]), "spike.*In 'Hall': vertex 4"),
    "no area": (lambda: wire([(0, 0), (1, 0), (2, 0)]), "spike|encloses no area"),
    "NaN": (lambda: wire([(0, 0), (math.nan, 0), (2, 2)]), "vertex 1 of 'Hall' are not finite"),
    "text": (text, "Select an outline"),
}


@pytest.mark.parametrize(("build", "message"), BAD.values(), ids=BAD.keys())
@pytest.mark.parametrize("mode", ["OBJECT", "EDIT"])
def test_bad_outlines(build, message, mode) -> None:
    build()
    ob = bpy.context.object
    if ob.type != "FONT":
        bpy.ops.object.mode_set(mode=mode)
    before = everything()
    with pytest.raises(RuntimeError, match=message):
        bpy.ops.cmc.mesh_plan()
    assert everything() == before


def everything() -> tuple:
    """What a failed call must leave alone."""
    return (
        bpy.context.mode,
        bpy.context.object,
        [(o.name, o.hide_get(), o.select_get(), o.data, o.cmc.plan) for o in bpy.data.objects],
        [len(bpy.data.meshes), len(bpy.data.curves), len(bpy.data.collections)],
        bpy.context.scene.cmc.edge_length,
    )


def test_absurd_edge_length() -> None:
    ngon(SQUARE)
    with pytest.raises(RuntimeError, match=r"into 1e[+]12 triangles; a length near 0.2 is usual"):
        bpy.ops.cmc.mesh_plan(edge_length=1e-5)
    assert list(bpy.data.objects) == [bpy.context.object]


def test_nothing_of_a_new_plan_is_selected() -> None:
    ngon(SQUARE)
    plan = mesh_plan(edge_length=1.0)
    bpy.ops.object.mode_set(mode="EDIT")
    assert plan.data.total_edge_sel == 0
    bpy.ops.object.mode_set(mode="OBJECT")
    bpy.ops.cmc.select_ungrouped()
    assert sum(edge.select for edge in plan.data.edges) == len(boundary(plan))


def test_a_linked_outline_gets_a_local_plan(tmp_path) -> None:
    ngon(SQUARE)
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "library.blend"))
    bpy.ops.wm.read_homefile(use_empty=True)
    with bpy.data.libraries.load(str(tmp_path / "library.blend"), link=True) as (_, taken):
        taken.objects = ["Hall"]
    ob = linked(taken.objects[0])
    plan = mesh_plan(edge_length=1.0)
    assert plan.library is None and plan.data.library is None and plan.cmc.outline == ob
    activate(ob)
    for other in bpy.context.selected_objects:
        other.select_set(False)
    bpy.context.view_layer.objects.active = plan
    assert mesh_plan(edge_length=0.5) == plan
