"""Pictures of modules that complete themselves: columns in a hall, a honeycomb, a nodoid cut open, a family of tubes.

`render_gallery.py` starts Blender and calls them. All come from Add > Mesh > CMC, Solve, Complete by Symmetry.
"""

from __future__ import annotations

import json

import bpy
import numpy as np
from mathutils import Matrix

from scripts.gallery import scene, staging

WARM, COOL = (0.78, 0.70, 0.60), (0.62, 0.68, 0.72)


def completed(name: str, **options: object) -> bpy.types.Object:
    """A module solved and completed to one mesh; see `made`."""
    return made(name, complete_as="MESH", **options).cmc.completed


def made(
    name: str, *, complete_as: str, ends: tuple[str, ...] = (), repeat=(1, 1, 1), **options: object
) -> bpy.types.Object:
    """The plan of a module, solved and completed. ends: groups at which the completed shell stops."""
    bpy.ops.cmc.add_module(module=name, **options)
    plan = bpy.context.object
    for group in ends:
        plan.data.cmc.groups[group].across = "OFF"
    bpy.ops.cmc.solve()
    bpy.ops.cmc.complete(complete_as=complete_as, complete_repeat=repeat)
    plan.hide_render = True
    reported = json.loads(plan.cmc.complete_report)
    print(f"{plan.name}: {reported['copies']} copies, seams {reported['relative_gap']:.1e} of the size.")
    return plan


def hall(bays: tuple[int, int] = (4, 3)) -> None:
    """A roof on a grid of columns, cut in the middle of the bays, seen from eye level."""
    bpy.ops.cmc.add_module(module="CAPITAL", slenderness=0.55, edges=40, size=6.5)
    plan = bpy.context.object
    bpy.ops.cmc.solve()
    planes = {plane["name"]: plane["offset"] for plane in json.loads(plan.cmc.report)["planes"]}
    column, bay = -np.array([planes["Left"], planes["Front"]]), 2.0 * (planes["Right"] + planes["Left"])
    low, high = column - 0.5 * bay, column + (np.array(bays) - 0.5) * bay
    box = scene.mesh_object("Box", [(*low, -50.0), (*high, 50.0)], [])
    box.hide_render = True
    bpy.context.view_layer.objects.active = plan
    bpy.ops.cmc.complete(box=box.name)
    plan.hide_render = True
    roof = plan.cmc.completed
    staging.paint(roof, scene.matte("Plaster", scene.PLASTER))
    scene.thicken(roof, -0.2)
    bottom = extent(roof)[0][2]
    scene.add_ground(20.0, z=bottom)
    scene.light(sun=(-0.75, -0.6, 0.42), strength=4.6, sky=0.9)
    middle = 0.5 * (low + high)
    eye = np.array([middle[0] - 15.0, low[1] - 17.0, bottom + 2.4])
    for x, y in ((-16.0, 5.0), (-8.6, -1.0), (-7.7, -0.7), (1.0, 12.0), (9.5, 1.5), (14.0, 7.0)):
        scene.add_person((middle[0] + x, low[1] + y, bottom), eye)
    scene.aim(eye, (middle[0] - 4.0, low[1], bottom + 3.1), 26.0)


def honeycomb() -> None:
    """Three by three units of a honeycomb of tubes."""
    tubes = completed("HONEYCOMB", slenderness=0.35, edges=26, size=3.0, repeat=(3, 3, 1))
    staging.paint(tubes, scene.checker("Plaster", "Plan", cells=2.0))
    scene.thicken(tubes, 0.08)
    points = staging.world_points(tubes)
    ground = float(points[:, 2].min())
    scene.add_ground(20.0, z=ground)
    scene.light(sun=(-0.7, -0.35, 0.6), strength=4.0, sky=0.6)
    eye = staging.look_at(points, (-90.0, 0.8), 50.0, 2.1)
    middle = points.mean(axis=0)
    for x, y in ((-6.5, -0.4), (0.9, -4.2), (1.7, -4.0)):
        scene.add_person((middle[0] + x, middle[1] + y, ground), eye)


def nodoid() -> None:
    """Three periods of a nodoid cut open along its axis: f+ outside, f- in the loops inside."""
    options = {"slenderness": 0.45, "edges": 40, "repeat": (3, 1, 1)}
    plan = made("NODOID", ends=("Axis",), complete_as="INSTANCES", **options)
    colours = {"f+": scene.matte("f+", WARM), "f-": scene.matte("f-", COOL)}
    for ob in plan.cmc.copies.objects:
        if not ob.data.materials:
            ob.data.materials.append(colours[ob.data["cmc_piece"]])
    points = np.concatenate([staging.world_points(ob) for ob in plan.cmc.copies.objects])
    scene.add_ground(12.0, z=float(points[:, 2].min()))
    scene.light(sun=(-0.35, -0.95, 0.75), strength=3.4, sky=0.75)
    staging.look_at(points, (-62.0, 0.24), 60.0, 2.3)


def family() -> None:
    """Unduloids of one diameter, standing: from nearly a cylinder to nearly a chain of spheres."""
    plaster = scene.checker("Plaster", "Plan", cells=1.0)
    places = []
    for k, slenderness in enumerate((0.2, 0.4, 0.6, 0.8, 1.0)):
        tube = completed("UNDULOID", slenderness=slenderness, edges=30, repeat=(3, 1, 1))
        staging.paint(tube, plaster)
        stand(tube, np.array([6.4 * k, 0.0, 0.0]))
        places.append(staging.world_points(tube))
    points = np.concatenate(places)
    scene.add_ground(30.0)
    scene.light(sun=(-0.6, -0.75, 0.6), strength=3.6, sky=0.7)
    staging.look_at(points, (-75.0, 0.3), 60.0, 1.75)


def stand(tube: bpy.types.Object, place: np.ndarray) -> None:
    """Turn a tube upright, on the ground at `place`, four metres thick at its bellies and cut off at 16 m."""
    points = staging.world_points(tube)
    low, high = points.min(axis=0), points.max(axis=0)
    scale = 4.0 / (high - low)[1]
    turn = np.array([[0.0, 0.0, -1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]])
    middle = 0.5 * (low + high)
    matrix = np.eye(4)
    matrix[:3, :3] = scale * turn
    matrix[:3, 3] = place - scale * turn @ (middle - [middle[0] - low[0], 0.0, 0.0])
    tube.matrix_world = Matrix((matrix @ np.array(tube.matrix_world)).tolist())
    bpy.context.view_layer.update()


def extent(ob: bpy.types.Object) -> tuple[np.ndarray, np.ndarray]:
    points = staging.world_points(ob)
    return points.min(axis=0), points.max(axis=0)
