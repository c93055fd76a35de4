"""The scene around plans and shells: ground, sun, sky, materials, a person for scale, a camera.

Needs Blender (`blender_session.start()` first). Lengths are metres, z is up.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path

import bpy
import numpy as np
from mathutils import Vector

PAPER = (0.56, 0.54, 0.51)
PLASTER = (0.80, 0.765, 0.71)
PLASTER_DARK = (0.52, 0.455, 0.39)
INK = (0.05, 0.055, 0.06)


# --- materials -----------------------------------------------------------------------------


def matte(name: str, colour: Sequence[float], roughness: float = 0.85) -> bpy.types.Material:
    """A matte material of one colour (linear RGB)."""
    material = bpy.data.materials.new(name)
    if material.node_tree is None:  # before Blender 5.0
        material.use_nodes = True
    surface = material.node_tree.nodes["Principled BSDF"]
    surface.inputs["Base Color"].default_value = (*colour, 1.0)
    surface.inputs["Roughness"].default_value = roughness
    material.diffuse_color = (*colour, 1.0)
    return material


def glow(name: str, colour: Sequence[float]) -> bpy.types.Material:
    """An emissive material: its colour (linear RGB) does not depend on the light."""
    material = matte(name, (0.0, 0.0, 0.0), 1.0)
    surface = material.node_tree.nodes["Principled BSDF"]
    surface.inputs["Emission Color"].default_value = (*colour, 1.0)
    surface.inputs["Emission Strength"].default_value = 1.0
    surface.inputs["Specular IOR Level"].default_value = 0.0
    return material


def checker(
    name: str,
    uv_layer: str,
    cells: float = 1.0,
    light: Sequence[float] = PLASTER,
    dark: Sequence[float] = PLASTER_DARK,
) -> bpy.types.Material:
    """Plaster with a checker in a UV layer, `cells` squares a UV unit: on a conformal map they stay squares."""
    material = matte(name, light)
    nodes, links = material.node_tree.nodes, material.node_tree.links
    uv = nodes.new("ShaderNodeUVMap")
    uv.uv_map = uv_layer
    shift = nodes.new("ShaderNodeMapping")  # a corner of the checker lies at the plan's origin, not half a square off
    shift.inputs["Location"].default_value = (0.0, 0.0, 0.5 / cells)
    squares = nodes.new("ShaderNodeTexChecker")
    squares.inputs["Color1"].default_value = (*light, 1.0)
    squares.inputs["Color2"].default_value = (*dark, 1.0)
    squares.inputs["Scale"].default_value = cells
    links.new(uv.outputs["UV"], shift.inputs["Vector"])
    links.new(shift.outputs["Vector"], squares.inputs["Vector"])
    links.new(squares.outputs["Color"], nodes["Principled BSDF"].inputs["Base Color"])
    return material


# --- things --------------------------------------------------------------------------------


def add_object(name: str, data: bpy.types.ID, material: bpy.types.Material | None = None) -> bpy.types.Object:
    """Link a new object to the scene's own collection."""
    ob = bpy.data.objects.new(name, data)
    if material is not None:
        data.materials.append(material)
    bpy.context.scene.collection.objects.link(ob)
    return ob


def mesh_object(name: str, points, faces, material: bpy.types.Material | None = None) -> bpy.types.Object:
    """A mesh object from points (V, 3) and faces, lists of vertices."""
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(np.asarray(points, dtype=float).tolist(), [], [[int(v) for v in face] for face in faces])
    return add_object(name, mesh, material)


def add_ground(size: float, z: float = 0.0) -> bpy.types.Object:
    """A ground plane for objects of this size; it fades into the sky with the distance from the camera."""
    s = 60.0 * size
    corners = [(-s, -s, z), (s, -s, z), (s, s, z), (-s, s, z)]
    material = matte("Ground", PAPER, 0.95)
    nodes, links = material.node_tree.nodes, material.node_tree.links
    camera, part = nodes.new("ShaderNodeCameraData"), nodes.new("ShaderNodeMapRange")
    part.interpolation_type = "SMOOTHERSTEP"
    part.inputs["From Min"].default_value, part.inputs["From Max"].default_value = 2.0 * size, 9.0 * size
    clear, mixed = nodes.new("ShaderNodeBsdfTransparent"), nodes.new("ShaderNodeMixShader")
    links.new(camera.outputs["View Distance"], part.inputs["Value"])
    links.new(part.outputs["Result"], mixed.inputs[0])
    links.new(nodes["Principled BSDF"].outputs["BSDF"], mixed.inputs[1])
    links.new(clear.outputs["BSDF"], mixed.inputs[2])
    links.new(mixed.outputs["Shader"], nodes["Material Output"].inputs["Surface"])
    return mesh_object("Ground", corners, [(0, 1, 2, 3)], material)


def add_line(name: str, points, width: float, closed: bool = True, colour=INK) -> bpy.types.Object:
    """A round line along points (n, 3)."""
    curve = bpy.data.curves.new(name, "CURVE")
    curve.dimensions = "3D"
    curve.bevel_depth = width / 2
    spline = curve.splines.new("POLY")
    points = np.asarray(points, dtype=float)
    spline.points.add(len(points) - 1)
    spline.points.foreach_set("co", np.column_stack([points, np.ones(len(points))]).ravel().astype(np.float32))
    spline.use_cyclic_u = closed
    return add_object(name, curve, matte(name, colour))


def add_text(
    text: str, place: Sequence[float], size: float, turned: float = 0.0, colour=INK, align: str = "CENTER"
) -> bpy.types.Object:
    """Text in a plane y = const, centred at `place`, read from -y, turned by `turned` degrees counter-clockwise."""
    curve = bpy.data.curves.new(text, "FONT")
    curve.body, curve.size, curve.align_x, curve.align_y = text, size, align, "CENTER"
    ob = add_object(text, curve, glow(text, colour))
    ob.location = place
    ob.rotation_euler = (math.pi / 2, -math.radians(turned), 0.0)
    ob.visible_shadow = False
    return ob


# Half of a standing person as seen from the front, from the crown to the sole: distance from the middle line and
# height, as parts of 1.74 m.
_PERSON = [
    (0.000, 1.000), (0.030, 0.992), (0.045, 0.965), (0.047, 0.935), (0.041, 0.900), (0.030, 0.872), (0.031, 0.853),
    (0.075, 0.836), (0.108, 0.818), (0.124, 0.780), (0.131, 0.690), (0.137, 0.600), (0.139, 0.500), (0.141, 0.455),
    (0.122, 0.450), (0.114, 0.500), (0.108, 0.600), (0.101, 0.690), (0.096, 0.740), (0.093, 0.650), (0.090, 0.580),
    (0.098, 0.500), (0.095, 0.400), (0.083, 0.270), (0.079, 0.150), (0.066, 0.045), (0.072, 0.012), (0.070, 0.000),
    (0.030, 0.000), (0.032, 0.060), (0.028, 0.200), (0.016, 0.340), (0.000, 0.450),
]  # fmt: skip


def add_person(place: Sequence[float], facing: Sequence[float], height: float = 1.74) -> bpy.types.Object:
    """A flat figure of a person at `place`, facing the point `facing`."""
    half = np.array(_PERSON) * height
    profile = np.concatenate([half, (half * [-1, 1])[-2:0:-1]])
    n, thick = len(profile), 0.02
    points = [(x, y, z) for y in (-thick, thick) for x, z in profile]
    faces = [list(range(n)), list(range(2 * n - 1, n - 1, -1))]
    faces += [[k, n + k, n + (k + 1) % n, (k + 1) % n] for k in range(n)]
    person = mesh_object("Person", points, faces, matte("Person", INK))
    person.location = place
    towards = Vector(facing) - Vector(place)
    person.rotation_euler.z = math.atan2(towards.y, towards.x) + math.pi / 2
    return person


def thicken(ob: bpy.types.Object, thickness: float) -> None:
    """Thicken a shell inwards by a modifier and shade it smooth; its mesh stays as it is."""
    ob.data.shade_smooth()
    solid = ob.modifiers.new("Thickness", "SOLIDIFY")
    solid.thickness = thickness
    solid.offset = -1.0
    solid.use_even_offset = True


# --- light and camera ----------------------------------------------------------------------


def light(sun: Sequence[float] = (-0.85, -0.45, 0.62), strength: float = 3.6, sky: float = 0.55) -> None:
    """A low, soft sun from the direction `sun`, and a sky that is bright at the horizon."""
    lamp = bpy.data.lights.new("Sun", "SUN")
    lamp.energy, lamp.angle, lamp.color = strength, math.radians(3.0), (1.0, 0.95, 0.88)
    ob = add_object("Sun", lamp)
    ob.rotation_euler = Vector(sun).to_track_quat("Z", "Y").to_euler()
    world = bpy.data.worlds.new("Sky")
    bpy.context.scene.world = world
    if world.node_tree is None:  # before Blender 5.0
        world.use_nodes = True
    _paint_sky(world.node_tree, sky)


def _paint_sky(tree: bpy.types.NodeTree, strength: float) -> None:
    """A gradient from the horizon up, brighter to the camera than as a light."""
    nodes, links = tree.nodes, tree.links
    background = nodes["Background"]
    direction, height = nodes.new("ShaderNodeTexCoord"), nodes.new("ShaderNodeSeparateXYZ")
    ramp, path = nodes.new("ShaderNodeValToRGB"), nodes.new("ShaderNodeLightPath")
    seen = nodes.new("ShaderNodeMapRange")
    low, high = ramp.color_ramp.elements
    low.position, low.color = 0.0, (0.94, 0.93, 0.90, 1.0)
    high.position, high.color = 0.4, (0.25, 0.46, 0.80, 1.0)
    seen.inputs["To Min"].default_value, seen.inputs["To Max"].default_value = strength, 0.95
    links.new(direction.outputs["Generated"], height.inputs["Vector"])
    links.new(height.outputs["Z"], ramp.inputs["Fac"])
    links.new(ramp.outputs["Color"], background.inputs["Color"])
    links.new(path.outputs["Is Camera Ray"], seen.inputs["Value"])
    links.new(seen.outputs["Result"], background.inputs["Strength"])


def aim(eye: Sequence[float], target: Sequence[float], lens: float = 40.0) -> bpy.types.Object:
    """Put the camera at `eye`, looking at `target`; focal length in millimetres on 36 mm film."""
    camera = bpy.data.cameras.new("Camera")
    camera.lens, camera.clip_end = lens, 5000.0
    ob = add_object("Camera", camera)
    ob.location = eye
    ob.rotation_euler = (Vector(eye) - Vector(target)).to_track_quat("Z", "Y").to_euler()
    bpy.context.scene.camera = ob
    return ob


def render(path: Path, width: int, height: int, samples: int = 64, dither: float = 0.0) -> Path:
    """Render the scene with Cycles on the CPU into a temporary file, then move that to its place.

    dither: 1 hides banding in a plain sky and triples the size of the file.
    """
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.cycles.device, scene.cycles.samples, scene.cycles.seed = "CPU", samples, 0
    scene.cycles.use_denoising, scene.cycles.max_bounces = True, 4
    scene.cycles.adaptive_threshold = 0.03
    scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = width, height, 100
    image = scene.render.image_settings
    image.file_format, image.color_mode = "JPEG" if path.suffix == ".jpg" else "PNG", "RGB"
    image.compression, image.quality = 100, 85
    scene.render.dither_intensity = dither
    scene.view_settings.view_transform = "AgX"
    scene.view_settings.look = "AgX - Medium High Contrast"
    scene.view_settings.exposure = 0.1
    path.parent.mkdir(parents=True, exist_ok=True)
    temporary = path.with_name(f".{path.stem}.part{path.suffix}")
    scene.render.filepath = str(temporary)
    bpy.ops.render.render(write_still=True)
    scene.render.filepath = f"//{path.name}"
    temporary.replace(path)
    return path
