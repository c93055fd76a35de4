"""Pictures of bubbles: Wente's family as strips, his tori whole and cut open, rings of a honeycomb, shells over a rim.

`render_gallery.py` starts Blender and calls them. The surfaces come from the solver's own calls `wente` and `ring`.
"""

from __future__ import annotations

import bmesh
import bpy
import numpy as np
from cmc_formfinding.solver import complete, conditions, ring, shapes, solve_cmc, wente
from cmc_formfinding.solver.catalogue.honeycomb_ring import AROUND
from cmc_formfinding.solver.catalogue.wente import Bubble
from cmc_formfinding.solver.catalogue.wente_heights import wente_height
from cmc_formfinding.solver.symmetry.completion import Completion
from mathutils import Vector

from scripts.gallery import scene, staging

WARM, COOL, BLUE = (0.78, 0.70, 0.60), (0.33, 0.45, 0.54), (0.10, 0.19, 0.33)
TORI = ((60, 72), (90, 56), (120, 48))  # degrees, columns a quarter
# Degrees, columns a quarter, height as a multiple of the closing one.
FAMILY = ((60, 48, 1.45), (85, 40, 1.4), (105, 32, 1.35), (125, 32, 1.35), (150, 28, 1.3))


def family() -> None:
    """Paper, Figure 13: cylinders too high to close, cut and laid out as strips of bubbles, for five angles."""
    plaster, x, strips = scene.checker("Plaster", "Plan", cells=1.0), 0.0, []
    for angle, columns, stretch in FAMILY:
        height = stretch * wente_height(np.radians(angle))
        bubble = wente(np.radians(angle), columns, height=height, closed=False)
        tell(f"{angle}°", bubble)
        strip = placed(f"{angle}°", complete(bubble.surface, bubble.sides[:2], repeat=4), [plaster], bubble=bubble)
        turn(strip, np.radians(-0.5 * angle + 15.0))
        points = staging.world_points(strip)
        cut_off(strip, points[:, 2].min(), points[:, 2].min() + 13.0)
        points = staging.world_points(strip)
        strip.location = (x - points[:, 0].min(), 0.0, -points[:, 2].min())
        x += np.ptp(points[:, 0]) + 1.6
        strips.append(strip)
    points = np.concatenate([staging.world_points(strip) for strip in strips])
    scene.add_ground(30.0)
    scene.light(sun=(-0.6, -0.75, 0.6), strength=3.6, sky=0.7)
    staging.look_at(points, (-80.0, 0.22), 60.0, 1.75)


def tori() -> None:
    """Paper, Figure 15: the tori of 60°, 90° and 120°, with one of their cylinders in dark blue."""
    colours = [scene.matte("Plaster", WARM), scene.matte("Cylinder", BLUE)]
    row(lambda completion: cylinder(completion), colours, gap=1.6, view=(-90.0, 0.62), aspect=2.3)


def tori_cut() -> None:
    """The same tori cut in half along the plane in which N takes the long way; f+ and f- in two colours."""
    colours = [scene.matte("f+", WARM), scene.matte("f-", COOL)]
    row(sheets, colours, gap=1.2, view=(-90.0, 1.5), aspect=2.75, halved=True)


def rings() -> None:
    """Three by three rings of the honeycomb (paper, Figure 16), the middle one in dark blue."""
    made = ring(2.4, max_edge=0.06)
    print(f"ring: {len(made.completion.copies)} copies, longest period {np.abs(made.periods).max():.0e}.")
    nine = complete(made.piece, made.sides, around=AROUND, translations=made.lattice, repeat=3)
    middle = np.repeat(np.arange(9) == 4, len(made.completion.copies)).astype(int)
    colours = [scene.matte("Plaster", WARM), scene.matte("Ring", BLUE)]
    tubes = placed("Rings", nine, colours, of_copies=middle)
    points = staging.world_points(tubes)
    scene.add_ground(40.0, z=float(points[:, 2].min()))
    scene.light(sun=(-0.7, -0.35, 0.6), strength=4.0, sky=0.6)
    staging.look_at(points, (-62.0, 1.0), 60.0, 2.0)


def shells() -> None:
    """Two shells with the same normals along a circle, both on that circle: the cap and the large bubble."""
    tilt, colour = np.radians(30.0), scene.matte("Plaster", WARM)
    disc = shapes.disc(12000)
    held = conditions.binormal(disc.domain, disc.positions, disc.sides["outer"], tilt=tilt)
    cap = solve_cmc(disc.domain, held)
    bubble = solve_cmc(disc.domain, held, degree=cap.harmonic.degree - 1.0)
    rim, drawn = disc.domain.boundary_vertices, []
    for name, surface, points in (("cap", cap, cap.f_plus), ("bubble", bubble, -bubble.f_minus)):
        print(f"{name}: energy {surface.harmonic.energy:.4f}, degree {surface.harmonic.degree:.4f}. {surface.message}")
        centred = points - points[rim].mean(axis=0)
        centred[:, 2] *= np.sign(centred[:, 2].sum())
        shell = scene.mesh_object(name, centred, surface.faces, colour)
        shell.data.shade_smooth()
        shell.location.x = 4.6 * len(drawn)
        scene.add_line(f"Rim of the {name}", staging.world_points(shell)[rim], 0.05)
        drawn.append(shell)
    points = np.concatenate([staging.world_points(shell) for shell in drawn])
    scene.add_ground(12.0, z=float(points[:, 2].min()))
    scene.light(sun=(-0.6, -0.75, 0.6), strength=3.6, sky=0.7)
    staging.look_at(points, (-80.0, 0.25), 60.0, 2.1)


# --- how they are made ---------------------------------------------------------------------


def row(part_of, colours, gap: float, view: tuple[float, float], aspect: float, halved: bool = False) -> None:
    """The tori side by side on the ground, to one scale; `part_of` gives the colour of each copy."""
    x, drawn = 0.0, []
    for angle, columns in TORI:
        bubble = wente(np.radians(angle), columns, halved=True)
        tell(f"{angle}°", bubble)
        completion = complete(bubble.surface, bubble.sides)
        torus = placed(f"{angle}°", completion, colours, of_copies=part_of(completion))
        if halved:
            cut_off(torus, -np.inf, 0.0)
        torus.location.x = x + 0.5 * torus.dimensions.x
        x += torus.dimensions.x + gap
        drawn.append(torus)
    points = np.concatenate([staging.world_points(torus) for torus in drawn])
    scene.add_ground(14.0, z=float(points[:, 2].min()))
    scene.light(sun=(-0.6, -0.75, 0.75), strength=3.6, sky=0.7)
    staging.look_at(points, view, 70.0, aspect)


def cylinder(completion: Completion) -> np.ndarray:
    """1 for the copies of one cylinder: those reached from the first without crossing its ends."""
    across = [seam.name != "bottom" for seam in completion.seams]
    reached, new = {0}, [0]
    while new:
        here = completion.neighbours[new][:, across]
        new = sorted(set(here.ravel().tolist()) - reached)
        reached.update(new)
    return np.isin(np.arange(len(completion.copies)), list(reached)).astype(int)


def sheets(completion: Completion) -> np.ndarray:
    """0 for copies that show f+, 1 for those that show f-."""
    return np.array([sheet == "f-" for sheet in completion.sheets]).astype(int)


def placed(name: str, completion: Completion, colours, of_copies=None, bubble: Bubble | None = None):
    """A completed surface as an object about its middle, each copy in its colour; with UVs if a bubble is given."""
    mesh = completion.mesh
    points = mesh.vertices - 0.5 * (mesh.vertices.min(axis=0) + mesh.vertices.max(axis=0))
    ob = scene.mesh_object(name, points, mesh.faces)
    for colour in colours:
        ob.data.materials.append(colour)
    if of_copies is not None:
        ob.data.polygons.foreach_set("material_index", of_copies[mesh.copies].astype(np.int32))
    if bubble is not None:
        squares = np.array([6.0, max(1.0, round(12.0 * bubble.height / np.pi))])  # whole ones on each quarter
        plan = bubble.positions / bubble.positions.max(axis=0) * squares
        corners = plan[bubble.domain.faces].reshape(-1, 2)[mesh.corners]
        ob.data.uv_layers.new(name="Plan").uv.foreach_set("vector", corners.astype(np.float32).ravel())
    ob.data.shade_smooth()
    return ob


def turn(ob: bpy.types.Object, angle: float) -> None:
    ob.rotation_euler.z = angle
    bpy.context.view_layer.update()


def cut_off(ob: bpy.types.Object, low: float, high: float) -> None:
    """Cut the object off below and above two heights, in its own coordinates."""
    mesh = bmesh.new()
    mesh.from_mesh(ob.data)
    for height, outwards in ((low, -1.0), (high, 1.0)):
        if np.isfinite(height):
            every = mesh.verts[:] + mesh.edges[:] + mesh.faces[:]
            bmesh.ops.bisect_plane(
                mesh, geom=every, plane_co=Vector((0, 0, height)), plane_no=Vector((0, 0, outwards)), clear_outer=True
            )
    mesh.to_mesh(ob.data)
    mesh.free()
    bpy.context.view_layer.update()


def tell(name: str, bubble: Bubble) -> None:
    print(f"{name}: {bubble.message}")
