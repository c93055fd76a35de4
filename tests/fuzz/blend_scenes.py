"""Random scenes, and what a hand does to them between two of our buttons."""

from __future__ import annotations

import math
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from random import Random

import bpy

from .operator_calls import random_value

Things = list[bpy.types.Object]


# --- what is drawn -------------------------------------------------------------------------

def _mesh(name: str, vertices, faces, edges=()) -> bpy.types.Object:
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata([tuple(map(float, point)) for point in vertices], list(edges), [tuple(face) for face in faces])
    wrong = mesh.attributes.get(".select_edge")  # Blender 5.0 gives it a type that crashes on writing
    if wrong is not None:
        mesh.attributes.remove(wrong)
    return _link(bpy.data.objects.new(name, mesh))


def _link(ob: bpy.types.Object) -> bpy.types.Object:
    bpy.context.scene.collection.objects.link(ob)
    bpy.context.view_layer.objects.active = ob
    return ob


def _circle(count: int, radius: float = 4.0, middle=(0.0, 0.0)) -> list[tuple[float, float, float]]:
    turns = [2 * math.pi * k / count for k in range(count)]
    return [(middle[0] + radius * math.cos(t), middle[1] + radius * math.sin(t), 0.0) for t in turns]


def disc(random: Random) -> bpy.types.Object:
    rim = _circle(random.choice((6, 9, 16)), random.choice((1.0, 4.0)))
    faces = [(0, 1 + k, 1 + (k + 1) % len(rim)) for k in range(len(rim))]
    return _mesh("Disc", [(0.0, 0.0, 0.0), *rim], faces)


def grid(random: Random) -> bpy.types.Object:
    """A field of quads, flat or as a bowl, sometimes with a hole in it."""
    n, rise = random.randint(2, 5), random.choice((0.0, 0.0, 0.3, -1.0))
    points = [(x, y, rise * (x * x + y * y) / n) for y in range(n + 1) for x in range(n + 1)]
    faces = [(k, k + 1, k + n + 2, k + n + 1) for y in range(n) for k in range(y * (n + 1), y * (n + 1) + n)]
    if n > 2 and random.random() < 0.5:
        del faces[len(faces) // 2]
    return _mesh("Grid", points, faces)


def polygon(random: Random) -> bpy.types.Object:
    """One face, or only its edges; also one that crosses itself."""
    count = random.randint(3, 9)
    points = [(random.uniform(-5, 5), random.uniform(-5, 5), 0.0) for _ in range(count)]
    if random.random() < 0.7:
        points.sort(key=lambda point: math.atan2(point[1], point[0]))
    if random.random() < 0.5:
        return _mesh("Polygon", points, [range(count)])
    return _mesh("Polyline", points, [], [(k, (k + 1) % count) for k in range(count)])


def ready(random: Random) -> bpy.types.Object | None:
    """What Add > Mesh > CMC makes; sometimes solved already."""
    name, choice = random.choice((("add_plan", "shape"), ("add_plan", "shape"), ("add_module", "module")))
    operator = getattr(bpy.ops.cmc, name)
    kinds = [item.identifier for item in operator.get_rna_type().properties[choice].enum_items]
    operator(**{choice: random.choice(kinds), "columns" if name == "add_plan" else "edges": 14})
    plan = bpy.context.object
    if random.random() < 0.4:
        with suppress(RuntimeError):
            bpy.ops.cmc.solve(want_twin=random.random() < 0.3, want_g=random.random() < 0.3)
    return plan


def faulty(random: Random) -> bpy.types.Object:
    """Meshes that are no plans."""
    square = [(0, 0, 0), (2, 0, 0), (2, 2, 0), (0, 2, 0)]
    kinds: list[Callable[[], bpy.types.Object]] = [
        lambda: _mesh("Empty Mesh", [], []),
        lambda: _mesh("Cube", [(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)],
                      [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]),
        lambda: _mesh("Fins", [*square, (1, 1, 2)], [(0, 1, 2), (0, 2, 3), (0, 2, 4)]),
        lambda: _mesh("Bow Tie", [*square, (3, 3, 0), (3, 2.5, 0)], [(0, 1, 2, 3), (2, 5, 4)]),
        lambda: _mesh("Two Parts", [*square, *[(x + 5, y, z) for x, y, z in square]], [(0, 1, 2, 3), (4, 5, 6, 7)]),
        lambda: _mesh("Not a Number", [*square, (math.nan, 1, 0)], [(0, 1, 4), (1, 2, 4), (2, 3, 4), (3, 0, 4)]),
        lambda: _mesh("Point", [(1, 1, 0)] * 4, [(0, 1, 2, 3)]),
        lambda: _mesh("Loose", [*square, (9, 9, 9)], [(0, 1, 2, 3)]),
        lambda: _mesh("Needle", [(0, 0, 0), (1, 0, 0), (2, 0, 0), (1, 1e-7, 0)], [(0, 1, 3), (1, 2, 3)]),
        lambda: _mesh("Torn", square, [(0, 1, 2), (0, 3, 2)]),
    ]
    return random.choice(kinds)()


def curve(random: Random) -> bpy.types.Object:
    data = bpy.data.curves.new("Curve", "CURVE")
    data.dimensions = random.choice(("2D", "3D"))
    for part in range(random.choice((1, 1, 2))):
        points = _circle(random.randint(3, 8), 4.0 / (1 + 2 * part))
        spline = data.splines.new(random.choice(("POLY", "BEZIER")))
        spline.use_cyclic_u = random.random() < 0.8
        if spline.type == "POLY":
            spline.points.add(len(points) - 1)
            for point, place in zip(spline.points, points, strict=True):
                point.co = (*place, 1.0)
        else:
            spline.bezier_points.add(len(points) - 1)
            for knot, place in zip(spline.bezier_points, points, strict=True):
                knot.co, knot.handle_left_type, knot.handle_right_type = place, "AUTO", "AUTO"
    return _link(bpy.data.objects.new("Curve", data))


def other(random: Random) -> bpy.types.Object:
    """No mesh at all."""
    makers = {"Empty": lambda: None, "Lamp": lambda: bpy.data.lights.new("Lamp", "POINT"),
              "Text": lambda: bpy.data.curves.new("Text", "FONT"), "Camera": lambda: bpy.data.cameras.new("Camera")}
    name = random.choice(sorted(makers))
    return _link(bpy.data.objects.new(name, makers[name]()))


def from_library(random: Random, folder: Path) -> bpy.types.Object | None:
    """A plan linked from another file, sometimes with overrides of its object, or of its mesh too."""
    plan = disc(random)
    name, path = plan.name, str(folder / "library.blend")
    bpy.data.libraries.write(path, {plan})
    bpy.data.objects.remove(plan)
    with bpy.data.libraries.load(path, link=True) as (_, wanted):
        wanted.objects = [name]
    linked = _link(wanted.objects[0])
    bpy.context.view_layer.update()
    if random.random() < 0.6:
        linked = linked.override_create(remap_local_usages=True)
        if random.random() < 0.6:
            linked.data.override_create(remap_local_usages=True)
    bpy.context.view_layer.objects.active = linked
    return linked


def new_scene(random: Random, folder: Path) -> None:
    """An empty file with a few things drawn, the last one active."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    Evaluated.layers = False
    units = bpy.context.scene.unit_settings
    units.system = random.choice(("METRIC", "METRIC", "IMPERIAL", "NONE"))
    units.scale_length = random.choice((1.0, 1.0, 0.001, 0.0254))
    for _ in range(random.choice((0, 1, 1, 2, 3))):
        random.choice((ready, ready, disc, grid, grid, polygon, faulty, curve, other))(random)
    if random.random() < 0.08:
        from_library(random, folder)
    for ob in bpy.context.view_layer.objects:
        ob.select_set(random.random() < 0.3)
    bpy.ops.ed.undo_push(message="drawn")


# --- what a hand does ----------------------------------------------------------------------

def act(random: Random) -> str:
    """Do something to the scene, a step for undo; returns what, for the log. What Blender refuses is left out."""
    things = sorted(bpy.data.objects, key=lambda ob: ob.name_full)
    name = random.choice(sorted(_ACTIONS))
    if not things and name not in ("draw", "undo", "redo", "scene"):
        return "nothing"
    with suppress(Exception):
        done = _ACTIONS[name](random, things)
        if name not in ("undo", "redo"):
            bpy.ops.ed.undo_push(message=name)  # as a click does; undo without it ends Blender
        return f"{name} {done}"
    return f"{name} refused"


def _mode(random: Random, things: Things) -> str:
    mode = random.choice(("OBJECT", "OBJECT", "EDIT", "EDIT", "EDIT", "WEIGHT_PAINT", "VERTEX_PAINT"))
    bpy.ops.object.mode_set("EXEC_DEFAULT", True, mode=mode)
    return mode


def _active(random: Random, things: Things) -> str:
    if bpy.context.mode != "OBJECT" and random.random() < 0.8:
        bpy.ops.object.mode_set("EXEC_DEFAULT", True, mode="OBJECT")
    ob = random.choice([*things, *[ob for ob in things if ob.type == "MESH"] * 3, None])
    bpy.context.view_layer.objects.active = ob
    if ob is not None:
        ob.select_set(random.random() < 0.8)
    return ob.name if ob else "none"


def _select(random: Random, things: Things) -> str:
    ob = bpy.context.object
    if ob is None or ob.type != "MESH":
        return "no mesh"
    was = ob.mode
    bpy.ops.object.mode_set(mode="OBJECT")
    part = random.choice((0.0, 0.3, 1.0))
    for edge in ob.data.edges:
        edge.select = random.random() < part
    for vertex in ob.data.vertices:
        vertex.select = random.random() < part
    bpy.ops.object.mode_set(mode=was)
    bpy.context.tool_settings.mesh_select_mode = random.choice(((True, False, False), (False, True, False),
                                                                (False, False, True)))
    return f"{part:.0%} of {ob.name}"


def _property(random: Random, things: Things) -> str:
    """A setting of an object, of its groups or of the scene."""
    ob = random.choice(things)
    owners = [ob.cmc, ob.cmc, bpy.context.scene.cmc]
    if ob.type == "MESH":
        owners += list(ob.data.cmc.groups) * 3
    owner = random.choice(owners)
    known = [rna for rna in owner.bl_rna.properties if not rna.is_readonly and rna.type not in ("POINTER", "COLLECTION")
             and rna.identifier not in ("uid", "role", "parked", "meshed", "placed_at", "repeated", "behind")]
    rna = random.choice(known)
    value = random_value(random, rna)
    setattr(owner, rna.identifier, value)
    return f"{owner!r}.{rna.identifier} = {value!r}"


def _hide(random: Random, things: Things) -> str:
    ob, how = random.choice(things), random.choice(("eye", "viewport", "render", "collection", "excluded"))
    if how == "eye":
        ob.hide_set(not ob.hide_get())
    elif how == "viewport":
        ob.hide_viewport = not ob.hide_viewport
    elif how == "render":
        ob.hide_render = not ob.hide_render
    else:
        layers = list(bpy.context.view_layer.layer_collection.children)
        layer = random.choice(layers)
        if how == "excluded":
            layer.exclude = not layer.exclude
        else:
            layer.collection.hide_viewport = not layer.collection.hide_viewport
        return f"{how} {layer.name}"
    return f"{how} {ob.name}"


def _transform(random: Random, things: Things) -> str:
    ob, what = random.choice(things), random.choice(("location", "rotation_euler", "scale", "parent", "far"))
    if what == "parent":
        ob.parent = random.choice([other for other in things if other.parent is None])
    elif what == "far":
        ob.location = (5.4e5, 4.1e6, 300.0)
    elif what == "scale":
        ob.scale = random.choice(((1, 1, 1), (-1, 1, 1), (2, 0.5, 1), (0, 0, 0), (1e-6, 1e-6, 1e-6), (1e6, 1e6, 1e6)))
    else:
        setattr(ob, what, [random.uniform(-2, 2) for _ in range(3)])
    return f"{what} of {ob.name}"


def _geometry(random: Random, things: Things) -> str:
    """Move a vertex, add a layer, weights, a shape key, a modifier, a material; not of what edit mode has in hand,
    which Blender's own data does not follow."""
    ob = random.choice([ob for ob in things if ob.type == "MESH" and not ob.data.is_editmode])
    mesh, what = ob.data, random.choice(("move", "layer", "weights", "key", "modifier", "material", "nan", "clear"))
    if what == "move":
        mesh.vertices[random.randrange(len(mesh.vertices))].co.z += random.uniform(-1, 1)
    elif what == "layer":
        name = random.choice(("cmc_group", "cmc_start", "cmc_length", "cmc_H", "own", "cmc_normal", "cmc_source"))
        kind = random.choice(("FLOAT", "INT", "FLOAT_VECTOR", "BOOLEAN", "STRING", "QUATERNION"))
        mesh.attributes.new(name, kind, random.choice(("POINT", "EDGE", "FACE", "CORNER")))
    elif what == "weights":
        ob.vertex_groups.new(name="Weights").add([0, 1, 2], 0.5, "REPLACE")
    elif what == "key":
        ob.shape_key_add()
    elif what == "modifier":
        ob.modifiers.new("Modifier", random.choice(("SUBSURF", "MIRROR", "ARRAY", "SOLIDIFY", "DECIMATE", "MASK")))
    elif what == "material":
        mesh.materials.append(bpy.data.materials.new("Material"))
    elif what == "nan":
        mesh.vertices[0].co.x = math.inf
    elif random.random() < 0.3:
        mesh.clear_geometry()
    return f"{what} of {ob.name}"


def _arrange(random: Random, things: Things) -> str:
    """Rename, duplicate, share a mesh, unlink, delete: in object mode, as a hand does."""
    if bpy.context.mode != "OBJECT":
        return "nothing"
    ob, what = random.choice(things), random.choice(("rename", "copy", "deep copy", "share", "unlink", "delete"))
    name = ob.name
    if what == "rename":
        ob.name = random.choice(("a", "Hall/1", "Café", "x" * 63, "Disc", "f+", "..", "Länge 'ß' \"q\""))
    elif what in ("copy", "deep copy"):
        twin = ob.copy()
        if what == "deep copy" and twin.data is not None:
            twin.data = twin.data.copy()
        _link(twin)
    elif what == "share":
        ob.data = random.choice([other for other in things if other.type == ob.type]).data
    elif what == "unlink":
        for collection in ob.users_collection:
            collection.objects.unlink(ob)
    else:
        bpy.data.objects.remove(ob)
    return f"{what} {name}"


class Evaluated:
    """layers: whether several view layers have been seen; then Blender itself ends in an undo (5.0.1,
    `restore_to_object`)."""

    layers = False


def may_undo() -> bool:
    return not Evaluated.layers


def _undo(random: Random, things: Things) -> str:
    return str(bpy.ops.ed.undo()) if may_undo() else "of one view layer only"


def _redo(random: Random, things: Things) -> str:
    return str(bpy.ops.ed.redo()) if may_undo() else "of one view layer only"


def _scene(random: Random, things: Things) -> str:
    """Another scene, or another view layer of this one."""
    window, Evaluated.layers = bpy.context.window, True
    if len(bpy.data.scenes) < 2:
        bpy.data.scenes.new("Other")
    if len(bpy.context.scene.view_layers) < 2:
        bpy.context.scene.view_layers.new("Second")
    if random.random() < 0.5:
        window.scene = random.choice(list(bpy.data.scenes))
    else:
        window.view_layer = random.choice(list(bpy.context.scene.view_layers))
    return f"{window.scene.name}, {window.view_layer.name}"


def _draw(random: Random, things: Things) -> str:
    if bpy.context.mode != "OBJECT":
        return "not in this mode"
    return random.choice((ready, ready, disc, grid, polygon, faulty, curve, other))(random).name


_ACTIONS: dict[str, Callable[[Random, Things], str]] = {
    "mode": _mode, "mode again": _mode, "active": _active, "active again": _active, "select": _select,
    "property": _property, "property again": _property, "hide": _hide, "transform": _transform, "geometry": _geometry,
    "arrange": _arrange, "undo": _undo, "redo": _redo, "scene": _scene, "draw": _draw,
}
