"""Pictures of shells fitted to a target: an approximated disc, a cultural centre, a hall whose rim is its outline.

`render_gallery.py` starts Blender and calls them.
"""

from __future__ import annotations

import bpy
import numpy as np
from cmc_formfinding.solver import Domain, mean_curvature_of, shapes
from cmc_formfinding.solver.fitting.fit import Fit
from cmc_formfinding.solver.fitting.gauss_map import fit_gauss_map
from cmc_formfinding.solver.fitting.outline import fit_outline
from cmc_formfinding.solver.gauss.drawn_normals import drawn_normals
from scipy.sparse import csr_array, hstack, vstack
from scipy.sparse.linalg import splu

from scripts.assets import plans, surfaces
from scripts.gallery import scene

WEIGHTS = (1e-4, 1e-3, 1e-2)
# of the wavy disc, so that its rim is seen to rise
TURNED = np.radians(25.0)
# direction to the camera, for the cultural centre
FROM = -1.25
RUST, WHITE, BLUE = (0.55, 0.13, 0.05), (0.80, 0.78, 0.74), (0.07, 0.20, 0.45)


def approximation() -> None:
    """Paper, Figure 10: a wavy disc and its approximations for three λ, with a conformal checker and coloured by H."""
    disc = shapes.disc(2500)
    given = surfaces.wavy_disc(disc.positions, disc.domain.faces)
    domain = Domain.from_positions(given.points, given.faces)
    uv = 5.0 * conformal_coordinates(given.points, given.faces)
    fits = [fit_gauss_map(domain, given.points, weight) for weight in WEIGHTS]
    columns = [("input", given.points, drawn_normals(domain, given.points))]
    for weight, fit in zip(WEIGHTS, fits, strict=True):
        tell(f"λ = {weight:g}", fit)
        columns.append((f"λ = {weight:g}", fit.points(), outward(fit)))
    plaster, coloured = scene.checker("Plaster", "UVMap"), painted("Curvature")
    for k, (title, points, normals) in enumerate(columns):
        place = np.array([2.45 * k, 0.0, 0.0])
        above = textured(title, points, given.faces, uv, plaster)
        below = textured(f"H, {title}", points, given.faces, uv, coloured)
        colour_by_curvature(below.data, points, given.faces, normals, 1.2)
        above.location, below.location = place, place - [0.0, 0.0, 1.45]
        above.rotation_euler.z = below.rotation_euler.z = TURNED
        above.visible_shadow = False
        scene.add_text(title, place + [0.0, 0.0, 0.95], 0.19)


def centre(count: int = 2500) -> None:
    """Paper, Figure 11: a cultural centre as drawn, and its approximation by a surface of constant H."""
    disc = shapes.disc(count)
    given = surfaces.cultural_centre(disc.positions, disc.domain.faces)
    domain = Domain.from_positions(given.points, given.faces)
    uv = 0.25 * conformal_coordinates(given.points, given.faces)
    tell("centre, tangent planes", fit_gauss_map(domain, given.points, 1e-4))
    fit = fit_gauss_map(domain, given.points, 1e-4, near=300.0)
    tell("centre, places too", fit)
    plaster, glass = scene.checker("Plaster", "UVMap"), scene.matte("Glass", (0.03, 0.045, 0.06), 0.25)
    towards = np.array([np.cos(FROM), np.sin(FROM), 0.0])
    aside = np.array([-towards[1], towards[0], 0.0])
    walls = ring(disc.positions, 4)
    for k, points in enumerate((given.points, fit.points())):
        roof = textured(f"Roof {k}", points, given.faces, uv, plaster)
        roof.modifiers.new("Thickness", "SOLIDIFY").thickness = 0.4
        wall = curtain(points[walls], glass)
        roof.location = wall.location = 98.0 * k * aside
        roof.rotation_euler.z = wall.rotation_euler.z = np.arctan2(49.0, 330.0) * (1 - 2 * k)  # seen from the same side
    scene.add_ground(100.0)
    scene.light(sun=(-0.5, -0.8, 0.7))
    middle = 49.0 * aside
    eye = middle + 330.0 * towards + [0.0, 0.0, 72.0]
    scene.aim(eye, middle + [0.0, 0.0, 10.0], 60.5)
    for place in (-5.0, -3.6):
        scene.add_person(middle + place * aside + 34.0 * towards, eye)


def ring(disc: np.ndarray, inwards: int) -> np.ndarray:
    """The vertices of a ring of `shapes.disc`, counted from the rim, in their order."""
    radius = np.linalg.norm(disc, axis=1)
    around = np.flatnonzero(np.isclose(radius, np.unique(np.round(radius, 9))[-1 - inwards]))
    return around[np.argsort(np.arctan2(disc[around, 1], disc[around, 0]))]


def curtain(top: np.ndarray, material: bpy.types.Material) -> bpy.types.Object:
    """A wall from a closed polyline (n, 3) down into the ground."""
    n = len(top)
    foot = np.column_stack([top[:, :2], np.full(n, -2.0)])
    faces = [(i, (i + 1) % n, n + (i + 1) % n, n + i) for i in range(n)]
    return scene.mesh_object("Curtain", np.concatenate([top, foot]), faces, material)


def hall() -> None:
    """The L-shaped hall, its rim fitted to the drawn outline."""
    sketch = plans.hall()
    hall = shapes.polygon(sketch.outline, max_edge=sketch.edge_length, corner_radius=sketch.corner_radius)
    fit = fit_outline(hall.domain, hall.positions, rise=0.35)
    tell("hall", fit)
    points = fit.points()
    shell = textured("Shell", points, fit.surface.faces, hall.positions, scene.checker("Plaster", "UVMap"))
    scene.thicken(shell, 0.15)
    rim = hall.domain.boundary_loops[0]
    line = np.column_stack([hall.positions[rim], np.full(len(rim), 0.02)])
    scene.add_line("Outline", line, width=0.16)
    scene.add_ground(34.0)
    scene.light()
    eye = (34.0, -44.0, 24.0)
    scene.aim(eye, (4.0, 0.0, 0.0), 47.0)
    for place in ((13.0, -11.2, 0.0), (14.3, -11.7, 0.0)):
        scene.add_person(place, eye)


def tell(name: str, fit: Fit) -> None:
    distances = ", ".join(f"{label} {value:.3g}" for label, value in fit.distances.items())
    print(f"{name}: H {fit.surface.mean_curvature:.4g}, {distances}; {len(fit.history)} evaluations. {fit.message}")


def outward(fit: Fit) -> np.ndarray:
    """Unit normals of the fitted sheet, on the side that is drawn."""
    return fit.surface.normals if fit.sheet == "f+" else -fit.surface.normals


def textured(name: str, points, faces, uv, material) -> bpy.types.Object:
    """A smooth object with UVs at its vertices."""
    ob = scene.mesh_object(name, points, faces, material)
    layer = ob.data.uv_layers.new(name="UVMap")
    layer.uv.foreach_set("vector", np.asarray(uv[np.asarray(faces)], dtype=np.float32).ravel())
    ob.data.shade_smooth()
    return ob


def painted(attribute: str) -> bpy.types.Material:
    """A matte material coloured by an attribute of the mesh."""
    material = scene.matte(attribute, WHITE)
    nodes = material.node_tree.nodes
    colour = nodes.new("ShaderNodeAttribute")
    colour.attribute_name = attribute
    material.node_tree.links.new(colour.outputs["Color"], nodes["Principled BSDF"].inputs["Base Color"])
    return material


def colour_by_curvature(mesh: bpy.types.Mesh, points, faces, normals, most: float) -> None:
    """Blue where H is -most, white at 0, rust at +most, from the measured H of faces."""
    H = mean_curvature_of(points, faces, normals)
    count = np.bincount(faces.ravel(), np.repeat(np.isfinite(H), 3), len(points))
    sums = np.bincount(faces.ravel(), np.repeat(np.nan_to_num(H), 3), len(points))
    part = np.clip(sums / np.maximum(count, 1) / most, -1.0, 1.0)[:, None]
    ends = np.where(part > 0, RUST, BLUE)
    colours = (1 - np.abs(part)) * np.array(WHITE) + np.abs(part) * ends
    layer = mesh.attributes.new("Curvature", "FLOAT_COLOR", "POINT")
    layer.data.foreach_set("color", np.column_stack([colours, np.ones(len(points))]).astype(np.float32).ravel())


def conformal_coordinates(points, faces) -> np.ndarray:
    """A conformal parametrisation (V, 2) of a surface, in its own size, about (0, 0).

    Least squares of the Cauchy-Riemann equations; the two vertices farthest apart along x are held.
    """
    a, b, c = (points[faces[:, k]] for k in range(3))
    x = (b - a) / np.linalg.norm(b - a, axis=1, keepdims=True)
    normal = np.cross(b - a, c - a)
    y = np.cross(normal / np.linalg.norm(normal, axis=1, keepdims=True), x)
    corners = [np.einsum("fi,fi->f", p - a, x) + 1j * np.einsum("fi,fi->f", p - a, y) for p in (a, b, c)]
    roots = np.sqrt(np.linalg.norm(normal, axis=1))
    values = np.stack([(corners[2] - corners[1]), (corners[0] - corners[2]), (corners[1] - corners[0])], axis=1)
    values = (values / roots[:, None]).ravel()
    rows = np.repeat(np.arange(len(faces)), 3)
    L = csr_array((values, (rows, faces.ravel())), shape=(len(faces), len(points)))
    held = [int(points[:, 0].argmin()), int(points[:, 0].argmax())]
    free = np.setdiff1d(np.arange(len(points)), held)
    known = np.array([0.0, np.linalg.norm(points[held[1]] - points[held[0]])])
    L, K = L[:, free].tocsc(), L[:, held].tocsc()
    real = vstack([hstack([L.real, -L.imag]), hstack([L.imag, L.real])]).tocsc()
    right = np.concatenate([-(K.real @ known), -(K.imag @ known)])
    solution = splu((real.T @ real).tocsc()).solve(real.T @ right)
    uv = np.zeros((len(points), 2))
    uv[free] = solution.reshape(2, -1).T
    uv[held, 0] = known
    return uv - uv.mean(axis=0)
