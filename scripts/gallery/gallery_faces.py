"""Pictures for docs/explanation/combinatorics.md: the three meshes of a surface, the sphere's identity, needles.

`render_gallery.py` starts Blender and calls them.
"""

from __future__ import annotations

import sys
from types import SimpleNamespace

import bpy
import cmc_formfinding.solver as solver
import numpy as np
from cmc_formfinding.solver import Domain, conditions, shapes, solve_cmc
from cmc_formfinding.solver.gauss.energies import ENERGIES

from scripts.gallery import plot, scene

# so that the tests' experiments use the copy of the solver that Blender has
sys.modules["solver"] = solver
from tests.solver import figure20, meshes

PLASTER, BLUE, RUST, LINE = (0.72, 0.66, 0.57), (0.20, 0.36, 0.52), (0.55, 0.17, 0.07), (0.02, 0.021, 0.024)

COLOURS = {
    "dual_cotan": (0.55, 0.17, 0.07),
    "mobius": (0.05, 0.22, 0.42),
    "shell": (0.20, 0.36, 0.10),
    "tan": (0.45, 0.30, 0.02),
}


def combinatorics() -> None:
    """Paper, Figures 5 and 6: g and f+ of one map, normals on vertices above, on faces below; all three meshes."""
    disc = shapes.disc(91)
    plan = disc.positions * [1.15, 0.95]
    domain = Domain.from_positions(plan, disc.domain.faces)
    rim = conditions.binormal(domain, plan, domain.boundary_edges, tilt=np.radians(12))
    for row, (sites, energy) in enumerate((("vertices", "cotan"), ("faces", "mobius"))):
        surface = solve_cmc(domain, rim, sites=sites, energy=energy)
        counts = (len(domain.faces), len(domain.edges), domain.vertex_count)
        own = "dual" if sites == "vertices" else "primal"
        columns = [("g", own), ("f+", "primal"), ("f+", "dual"), ("f+", "corner")]
        for column, (sheet, combinatorics) in enumerate(columns):
            mesh = surface.as_mesh(sheet, combinatorics)
            kinds = np.repeat([0, 1, 2], counts) if combinatorics == "corner" else None
            place = np.array([2.35 * column, 0.0, -1.62 * row])
            points = fitted(mesh.vertices, 1.75) + place
            colour = BLUE if sheet == "g" else PLASTER
            faceted(f"{sites} {sheet} {combinatorics}", points, mesh.polygons, colour, kinds)
        scene.add_text(f"normals on {sites}", (-1.25, 0.0, -0.05 - 1.62 * row), 0.17, turned=90.0)
    for column, text in enumerate(("g", "f+, primal", "f+, dual", "f+, corners")):
        scene.add_text(text, (2.35 * column, 0.0, 0.95), 0.2)


def energies() -> None:
    """Edge energies and their Hodge stars over the angle α between two normals."""
    alpha = np.linspace(0.0, np.pi, 601)[1:-1]
    half = {"0": 0.0, "90°": np.pi / 2, "180°": np.pi}
    value = plot.Chart((0.0, 0.0), (3.4, 2.6), (0.0, np.pi), (0.0, 8.0))
    value.frame("energy / dual weight", half, {"0": 0, "2": 2, "4": 4, "6": 6, "8": 8})
    star = plot.Chart((4.4, 0.0), (3.4, 2.6), (0.0, np.pi), (0.0, 4.0))
    star.frame("star / dual weight", half, {"0": 0, "1": 1, "2": 2, "3": 3, "4": 4})
    edge = links(60.0, 60.0)
    ends = {"dual_cotan": (1.45, 0.4), "mobius": (2.4, 1.35), "shell": (2.55, 4.6), "tan": (1.75, 6.6)}
    for name, colour in COLOURS.items():
        energy = ENERGIES[name]
        value.line(alpha, energy.value(np.cos(alpha), edge) / edge.weights, colour)
        star.line(alpha, energy.star(np.cos(alpha), edge) / edge.weights, colour)
        value.word(energy.label, *ends[name], colour)
    poor = plot.Chart((8.8, 0.0), (3.4, 2.6), (0.0, np.pi), (-6.0, 14.0))
    poor.frame("star on poor edges", half, {"-5": -5, "0": 0, "5": 5, "10": 10})
    poor.line([0.0, np.pi], [0.0, 0.0], plot.GREY, 0.015)
    for angle, dashed in ((85.0, False), (100.0, True)):
        edge = links(angle, angle)
        for name in ("dual_cotan", "mobius"):
            poor.line(alpha, ENERGIES[name].star(np.cos(alpha), edge), COLOURS[name], dashed=dashed)
    poor.word("nearly cocircular", 1.0, 12.7, COLOURS["dual_cotan"])
    poor.word("not Delaunay", 1.0, -4.4, COLOURS["dual_cotan"])
    poor.word("Möbius, on both", 0.8, 4.0, COLOURS["mobius"])


def links(first: float, second: float) -> SimpleNamespace:
    """A link across an edge with two opposite angles, in degrees."""
    angles = np.radians([[first, second]])
    return SimpleNamespace(angles=angles, weights=2.0 / np.sum(1.0 / np.tan(angles), axis=1))


def identity() -> None:
    """Paper, Figure 20: spheres of growing aspect ratio, and minimisers reached from the identity on their faces."""
    for column, aspect in enumerate(figure20.ASPECTS):
        points, faces = figure20.sphere(1200, aspect)
        octant = (np.sign(points).prod(axis=1) > 0).astype(int)
        recoveries = [figure20.recover(points, faces, energy) for energy in ("mobius", "dual_cotan")]
        place = np.array([2.3 * column, 0.0, 0.0])
        line = 0.007 / np.sqrt(max(1.0, aspect / 8))
        scene.add_text(str(aspect), place + [0.0, 0.0, 1.5], 0.36)
        faceted(f"{aspect} sphere", points + place, list(faces), PLASTER, line=line)
        for row, recovery in enumerate(recoveries, start=1):
            image = recovery.harmonic.normals + place + [0.0, 0.0, -2.4 * row]
            faceted(f"{aspect} {row}", image, stars(points, faces), PLASTER, 2 * octant, line=line)
    for row, text in enumerate(("mesh", "Möbius", "dual cotan")):
        scene.add_text(text, (-1.6, 0.0, -2.4 * row), 0.36, turned=90.0)


def needles() -> None:
    """Paper, Figure 19: the surface over a disc of needles, and over a regular one, for m = 1 of Figure 3."""
    disc = shapes.disc(600)
    turn = np.array([[0.5, 0.866], [-0.866, 0.5]])
    for column, (points, faces) in enumerate((meshes.needles(700, 8.0), (disc.positions, disc.domain.faces))):
        plan = points @ turn
        domain = Domain.from_positions(plan, faces)
        surface = solve_cmc(domain, conditions.twisted(domain, plan, domain.boundary_edges, 1))
        place = np.array([4.6 * column, 0.0, 0.0])
        upright = np.column_stack([plan[:, 0], 0 * plan[:, 0], plan[:, 1]])
        faceted(f"plan {column}", 0.95 * upright + place, list(faces), BLUE, line=0.006)
        shell = fitted(surface.f_plus, 2.35) + place + [2.2, 0.0, 0.0]
        faceted(f"f+ {column}", shell, list(surface.faces), PLASTER, line=0.006)


def stars(points, faces) -> list[np.ndarray]:
    """The faces around each vertex of a sphere, counter-clockwise from outside."""
    corner = np.argsort(faces.ravel(), kind="stable")
    around = np.split(corner // 3, np.cumsum(np.bincount(faces.ravel()))[:-1])
    middles = points[faces].mean(axis=1)
    rings = []
    for vertex, ring in zip(points, around, strict=True):
        x = np.cross(vertex, [0.3, 0.5, 0.8])
        y = np.cross(vertex, x)
        angle = np.arctan2((middles[ring] - vertex) @ y, (middles[ring] - vertex) @ x)
        rings.append(ring[np.argsort(angle)])
    return rings


def fitted(points, size: float):
    """Points centred at the origin and scaled so that the diagonal of their bounding box is sqrt(2) `size`."""
    points = points - 0.5 * (points.min(axis=0) + points.max(axis=0))
    return points * (size / np.linalg.norm(np.ptp(points, axis=0)) * np.sqrt(2.0))


def faceted(name: str, points, polygons, colour, kinds=None, line: float = 0.011) -> bpy.types.Object:
    """Polygons with flat faces and drawn edges; `kinds` (n,) colours them `colour`, rust or blue."""
    ob = scene.mesh_object(name, points, polygons, scene.matte(f"{name} 0", colour))
    if kinds is not None:
        for k, other in enumerate((RUST, BLUE), start=1):
            ob.data.materials.append(scene.matte(f"{name} {k}", other))
        ob.data.polygons.foreach_set("material_index", np.asarray(kinds, dtype=np.int32))
    wire(name, points, polygons, line)
    return ob


def wire(name: str, points, polygons, width: float) -> bpy.types.Object:
    """The edges of polygons as tubes."""
    pairs = np.concatenate([np.stack([p, np.roll(p, -1)], axis=1) for p in polygons])
    pairs = np.unique(np.sort(pairs, axis=1), axis=0)
    curve = bpy.data.curves.new(f"{name} edges", "CURVE")
    curve.dimensions, curve.bevel_depth, curve.bevel_resolution = "3D", width / 2, 1
    for pair in pairs:
        spline = curve.splines.new("POLY")
        spline.points.add(1)
        spline.points.foreach_set("co", np.column_stack([points[pair], np.ones(2)]).ravel().astype(np.float32))
    return scene.add_object(f"{name} edges", curve, scene.matte(f"{name} edges", LINE))
