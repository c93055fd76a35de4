"""Stage a plan and its shell for a picture: checker, ground, drawn outline, people, sun, camera.

Used for the previews of the assets, for the demo and for the pictures of docs/. Needs Blender and the add-on
(`blender_session.start()` first).
"""

from __future__ import annotations

import math

import bpy
import numpy as np
from cmc_formfinding.cmc_addon.bridges import mesh_bridge
from cmc_formfinding.cmc_addon.properties.links import result_of
from numpy.typing import NDArray

from scripts.gallery import scene


def form(plan: bpy.types.Object, **settings: object) -> bpy.types.Object:
    """Solve over a plan with the add-on's operator, and return the shell."""
    bpy.context.view_layer.objects.active = plan
    bpy.ops.cmc.solve(**settings)
    shell = result_of(plan, plan.cmc.sheet)
    assert shell is not None
    return shell


def stage(
    plan: bpy.types.Object,
    shell: bpy.types.Object,
    view: tuple[float, float],
    *,
    cells: float = 1.0,
    thickness: float = 0.15,
    lens: float = 42.0,
    aspect: float = 1.6,
    people: bool = True,
) -> None:
    """Light the shell, draw its plan on the ground, and aim the camera at it.

    view: the direction in plan to the camera, in degrees, and the slope of the line of sight.
    """
    paint(shell, scene.checker("Plaster", plan.data.uv_layers[0].name, cells))
    scene.thicken(shell, thickness)
    plan.hide_render = True
    size = max(plan.dimensions)
    scene.add_ground(size)
    for k, loop in enumerate(rims(plan)):
        scene.add_line(f"Outline {k}", loop + [0.0, 0.0, 0.01], width=size / 250)
    scene.light()
    angle = math.radians(view[0])
    places = standing_places(plan, np.array([math.cos(angle), math.sin(angle), 0.0])) if people else np.empty((0, 3))
    eye = look_at(np.concatenate([world_points(shell), *rims(plan), places]), view, lens, aspect)
    for place in places:
        scene.add_person(place, eye)


def paint(ob: bpy.types.Object, material: bpy.types.Material) -> None:
    """Give all faces of an object one material, whatever the mesh has."""
    slots = ob.material_slots
    if not len(slots):
        ob.data.materials.append(None)
    for slot in ob.material_slots:
        slot.link = "OBJECT"
        slot.material = material


def rims(plan: bpy.types.Object) -> list[NDArray[np.float64]]:
    """The boundary loops of a plan as points (n, 3)."""
    read = mesh_bridge.read_plan(plan)
    after: dict[int, list[int]] = {}
    for a, b in read.edges[read.boundary].tolist():
        after.setdefault(a, []).append(b)
        after.setdefault(b, []).append(a)
    loops = []
    while after:
        start, (at, _) = next(iter(after.items()))
        loop, before = [start], start
        while at != start:
            loop.append(at)
            here = after.pop(at)
            at, before = here[0] if here[1] == before else here[1], at
        after.pop(start)
        loops.append(read.positions[loop])
    return loops


def world_points(ob: bpy.types.Object) -> NDArray[np.float64]:
    bpy.context.view_layer.update()
    return mesh_bridge.read_plan(ob).positions


def look_at(points: NDArray[np.float64], view: tuple[float, float], lens: float, aspect: float) -> NDArray[np.float64]:
    """Aim the camera so that all points are in the picture, with a margin; returns its place."""
    angle, slope = math.radians(view[0]), view[1]
    back = np.array([math.cos(angle), math.sin(angle), slope])
    back /= np.linalg.norm(back)
    right = np.array([-math.sin(angle), math.cos(angle), 0.0])
    up = np.cross(back, right)
    middle = 0.5 * (points.min(axis=0) + points.max(axis=0))
    reach = points - middle
    half = 18.0 / lens  # half the picture's width at distance 1
    half_height = half / aspect
    margin = 1.12
    distance = max(
        (margin * np.abs(reach @ right) / half + reach @ back).max(),
        (margin * np.abs(reach @ up) / half_height + reach @ back).max(),
    )
    eye = middle + distance * back
    scene.aim(eye, middle, lens)
    return eye


def standing_places(plan: bpy.types.Object, towards: NDArray[np.float64]) -> NDArray[np.float64]:
    """Places (3, 3) for people who give the scale of a shell seen from the direction `towards`."""
    rim = rims(plan)[0]
    centre = rim.mean(axis=0)
    side = np.array([-towards[1], towards[0], 0.0])
    near, width = float(((rim - centre) @ towards).max()), float(np.abs((rim - centre) @ side).max())
    spots = [(1.02 * near + 0.6, 0.30 * width), (1.02 * near + 1.1, 0.30 * width + 0.8), (0.3 * near, -0.15 * width)]
    return np.array([centre + along * towards + across * side for along, across in spots])
