"""The pictures of docs/: the demo, the paper's figures, a nodoid, the plans of assets/ with their shells.

    make gallery
    .venv/bin/python -m scripts.gallery.render_gallery figure3 --samples 8     # one of them, quickly
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable
from pathlib import Path

from scripts.assets import plans
from scripts.gallery import blender_session

package = blender_session.start()

import bpy
import numpy as np
from cmc_formfinding.solver import CmcSurface, conditions, shapes, solve_cmc

from scripts.assets import make_assets
from scripts.gallery import (
    demo,
    gallery_bubbles,
    gallery_design,
    gallery_faces,
    gallery_modules,
    gallery_spans,
    scene,
    staging,
)

IMAGES = blender_session.ROOT / "docs" / "images"
WIDTH = 1000
BLUE, BLUE_DARK = (0.62, 0.72, 0.80), (0.36, 0.46, 0.56)


# --- the pictures --------------------------------------------------------------------------

def pavilion(samples: int) -> None:
    """The picture of `make demo`."""
    demo.staged()
    scene.render(IMAGES / "pavilion.png", WIDTH, round(0.62 * WIDTH), samples)


def figure3(samples: int) -> None:
    """Paper, Figure 3: boundary normals that turn m times, the surface g of constant K, the CMC disc f+."""
    disc = shapes.disc(5000)
    uv = 6.0 * disc.positions
    f_look, g_look = looks()
    turned = disc.positions @ [[0.5, 0.866], [-0.866, 0.5]]  # so that the openings face the camera
    for m in range(4):
        rim = conditions.twisted(disc.domain, turned, disc.sides["outer"], m)
        surface = solve_cmc(disc.domain, rim)
        tell(f"m = {m}", surface)
        x = 2.7 * m
        drawn_normals(turned, rim, (x, 0.0, 4.6))
        show(f"g, m = {m}", surface.g, surface.faces, uv, g_look, (x, 0.0, 2.35), 1.9)
        show(f"f+, m = {m}", surface.f_plus, surface.faces, uv, f_look, (x, 0.0, 0.0), 2.15)
    picture("figure3", (4.05, -26.0, 8.6), (4.05, 0.0, 2.25), 92.0, 0.62, samples)


def nodoid(samples: int) -> None:
    """A cylinder with opposite normals on its ends, from a start that winds around: f+, g and f- of a nodoid."""
    band = shapes.cylinder(2 * np.pi, 3.3132763405, 96)
    ends = conditions.fixed(band.domain, band.sides["bottom"], [0, 0, 1])
    ends += conditions.fixed(band.domain, band.sides["top"], [0, 0, -1])
    surface = solve_cmc(band.domain, ends, degree=1)
    tell("nodoid", surface)
    uv = band.positions[surface.faces] * (6 / np.pi)
    seam = np.ptp(uv[:, :, 0], axis=1) > 6
    uv[seam, :, 0] += np.where(uv[seam, :, 0] < 6, 12.0, 0.0)
    f_look, g_look = looks()
    names = (("f+", surface.f_plus, f_look), ("g", surface.g, g_look), ("f-", surface.f_minus, f_look))
    for x, (name, points, look) in zip((0.0, 3.9, 6.4), names, strict=True):
        show(name, points, surface.faces, uv, look, (x, 0.0, 0.0), None)
    picture("nodoid", (2.75, -24.0, 9.0), (2.75, 0.0, 0.0), 86.0, 0.42, samples)


def plans_and_shells(samples: int) -> None:
    """The plans of assets/, each drawn on the ground below its shell, all to the same scale."""
    places = {  # x, y, and degrees turned
        "pavilion": (-30, -14, 0),
        "market": (5, -18, 31),
        "courtyard": (41, -12, 0),
        "hall": (-36, 24, 0),
        "canopy": (32, 28, 0),
    }
    scene.add_ground(100.0)
    scene.light()
    plaster = scene.checker("Plaster", "Plan")
    for name, place in places.items():
        plan = make_assets.draw(plans.SKETCHES[name]())
        plan.location[:2] = place[:2]
        plan.rotation_euler.z = np.radians(place[2])
        shell = staging.form(plan)
        staging.paint(shell, plaster)
        scene.thicken(shell, 0.25)
        plan.hide_render = True
        for loop in staging.rims(plan):
            scene.add_line("Outline", loop + [0.0, 0.0, 0.02], width=0.22)
    scene.add_person((-17.0, -26.0, 0.0), (0.0, -100.0, 0.0))
    picture("plans", (8.0, -122.0, 74.0), (8.0, 5.0, 0.0), 45.0, 0.52, samples, sky=False)


def combinatorics(samples: int) -> None:
    """The dual and the corner mesh of a coarse disc (paper, Figures 5 and 6)."""
    gallery_faces.combinatorics()
    picture("combinatorics", (3.38, -30.0, 14.0), (3.38, 0.0, -0.72), 119.0, 0.42, samples, suffix=".jpg")


def energies(samples: int) -> None:
    """Edge energies and their Hodge stars, as curves."""
    gallery_faces.energies()
    picture("energies", (5.9, -60.0, 1.3), (5.9, 0.0, 1.3), 164.0, 0.28, samples)


def identity(samples: int) -> None:
    """The identity of the sphere, recovered or lost (paper, Figure 20)."""
    gallery_faces.identity()
    picture("identity", (5.4, -60.0, 12.0), (5.4, 0.0, -2.1), 148.0, 0.52, samples, suffix=".jpg")


def needles(samples: int) -> None:
    """The same surface over a disc of needles and over a regular one (paper, Figure 19)."""
    gallery_faces.needles()
    picture("needles", (3.42, -40.0, 10.0), (3.42, 0.0, 0.0), 159.0, 0.27, samples, suffix=".jpg")


def approximation(samples: int) -> None:
    """A wavy disc and its CMC approximations (paper, Figure 10)."""
    gallery_design.approximation()
    picture("approximation", (3.68, -28.0, 12.5), (3.68, 0.0, -0.5), 115.0, 0.38, samples, sun=(-0.9, -0.45, 0.55))


def centre(samples: int) -> None:
    """A cultural centre and its CMC approximation (paper, Figure 11)."""
    gallery_design.centre()
    scene.render(IMAGES / "centre.png", WIDTH, round(0.31 * WIDTH), samples)


def outline(samples: int) -> None:
    """The L-shaped hall, its rim on its outline."""
    gallery_design.hall()
    scene.render(IMAGES / "outline.png", WIDTH, round(WIDTH / 1.75), samples)


def columns(samples: int) -> None:
    """A roof on columns: the column capital of Add > Mesh > CMC, completed."""
    gallery_modules.hall()
    scene.render(IMAGES / "columns.jpg", WIDTH, round(0.44 * WIDTH), samples)


def honeycomb(samples: int) -> None:
    """Three by three units of the honeycomb module (paper, Figure 16)."""
    gallery_modules.honeycomb()
    scene.render(IMAGES / "honeycomb.jpg", WIDTH, round(0.44 * WIDTH), samples)


def nodoid_cut(samples: int) -> None:
    """Three periods of a nodoid from instances of a quarter of one half."""
    gallery_modules.nodoid()
    scene.render(IMAGES / "nodoid_cut.jpg", WIDTH, round(0.44 * WIDTH), samples)


def unduloids(samples: int) -> None:
    """The family of unduloids (paper, Section 5.3.2)."""
    gallery_modules.family()
    scene.render(IMAGES / "unduloids.jpg", WIDTH, round(0.56 * WIDTH), samples)


def wente_family(samples: int) -> None:
    """Wente's family (paper, Figure 13): strips of bubbles for five angles."""
    gallery_bubbles.family()
    scene.render(IMAGES / "wente_family.jpg", WIDTH, round(WIDTH / 1.75), samples)


def wente_tori(samples: int) -> None:
    """Wente's tori (paper, Figure 15), whole."""
    gallery_bubbles.tori()
    scene.render(IMAGES / "wente_tori.jpg", WIDTH, round(WIDTH / 2.3), samples)


def wente_cut(samples: int) -> None:
    """Wente's tori, cut open."""
    gallery_bubbles.tori_cut()
    scene.render(IMAGES / "wente_cut.jpg", WIDTH, round(WIDTH / 2.75), samples)


def rings(samples: int) -> None:
    """Three by three rings (paper, Figure 16)."""
    gallery_bubbles.rings()
    scene.render(IMAGES / "rings.jpg", WIDTH, round(WIDTH / 2.0), samples)


def two_shells(samples: int) -> None:
    """Two shells with the same normals along their rim (paper, Theorem D.1)."""
    gallery_bubbles.shells()
    scene.render(IMAGES / "two_shells.jpg", WIDTH, round(WIDTH / 2.1), samples)


def spans(samples: int) -> None:
    """Six roofs on their lines: soap films, a ring, a court, a square with sharp corners."""
    gallery_spans.spans()
    scene.render(IMAGES / "spans.jpg", WIDTH, round(WIDTH / 2.35), samples)


def span_slider(samples: int) -> None:
    """One line, and H from -1/R to 1/R."""
    gallery_spans.slider()
    picture("span_slider", (4.6, -40.0, 12.0), (4.6, 0.0, -0.15), 128.0, 0.27, samples, suffix=".jpg")


def necks(samples: int) -> None:
    """Catenoids between two circles, up to the height at which there is none."""
    gallery_spans.necks()
    picture("necks", (5.0, -40.0, 13.0), (5.0, 0.0, 0.28), 120.0, 0.23, samples, suffix=".jpg")


def span_leans(samples: int) -> None:
    """Halls on three sides of their plan, whose fourth side leans."""
    gallery_spans.leans()
    scene.render(IMAGES / "span_leans.jpg", WIDTH, round(WIDTH / 3.5), samples)


PICTURES: dict[str, Callable[[int], None]] = {
    "pavilion": pavilion,
    "plans": plans_and_shells,
    "figure3": figure3,
    "nodoid": nodoid,
    "combinatorics": combinatorics,
    "energies": energies,
    "identity": identity,
    "needles": needles,
    "approximation": approximation,
    "centre": centre,
    "outline": outline,
    "columns": columns,
    "honeycomb": honeycomb,
    "nodoid_cut": nodoid_cut,
    "unduloids": unduloids,
    "wente_family": wente_family,
    "wente_tori": wente_tori,
    "wente_cut": wente_cut,
    "rings": rings,
    "two_shells": two_shells,
    "spans": spans,
    "span_slider": span_slider,
    "necks": necks,
    "span_leans": span_leans,
}


# --- how they are made ---------------------------------------------------------------------

def looks() -> tuple[bpy.types.Material, bpy.types.Material]:
    """Plaster for surfaces of constant H, blue for those of constant K."""
    return scene.checker("H", "UVMap"), scene.checker("K", "UVMap", light=BLUE, dark=BLUE_DARK)


def show(name: str, points, faces, uv, material, place, size: float | None) -> bpy.types.Object:
    """A surface as a smooth object centred at `place` and scaled to `size`; uv of vertices or of corners (F, 3, 2)."""
    points = points - 0.5 * (points.min(axis=0) + points.max(axis=0))
    if size is not None:
        points = points * (size / np.linalg.norm(np.ptp(points, axis=0)) * np.sqrt(2.0))
    ob = scene.mesh_object(name, points, faces, material)
    layer = ob.data.uv_layers.new(name="UVMap")
    corners = uv[faces] if np.ndim(uv) == 2 else uv
    layer.uv.foreach_set("vector", np.asarray(corners, dtype=np.float32).ravel())
    ob.data.shade_smooth()
    ob.location = place
    return ob


def drawn_normals(positions, rim, place) -> None:
    """The plan disc and the prescribed normals of its rim, as lines."""
    flat = np.column_stack([positions, np.zeros(len(positions))])
    sites, normals = rim.resolve()
    order = np.argsort(np.arctan2(flat[sites, 1], flat[sites, 0]))
    sites, normals = sites[order], normals[order]
    offset = np.array(place)
    scene.add_line("Rim", 0.62 * flat[sites] + offset, 0.025)
    for k in range(0, len(sites), 3):
        foot = 0.62 * flat[sites[k]] + offset
        scene.add_line("Normal", [foot, foot + 0.34 * normals[k]], 0.016, closed=False, colour=(0.55, 0.12, 0.06))


def picture(
    name: str,
    eye,
    target,
    lens: float,
    height: float,
    samples: int,
    sky: bool = True,
    suffix: str = ".png",
    sun=(-0.5, -0.8, 0.9),
) -> Path:
    """Render the scene to docs/images/NAME.png (or .jpg). height: as a part of the width."""
    if sky:
        scene.light(sun=sun, strength=2.6, sky=0.8)
        paper = scene.matte("Paper", (0.83, 0.83, 0.82))
        far = 60.0
        corners = [(-far, far, -far), (2 * far, far, -far), (2 * far, far, far), (-far, far, far)]
        scene.mesh_object("Backdrop", corners, [(0, 1, 2, 3)], paper).visible_shadow = False
    scene.aim(eye, target, lens)
    return scene.render(IMAGES / f"{name}{suffix}", WIDTH, round(height * WIDTH), samples)


def tell(name: str, surface: CmcSurface) -> None:
    harmonic = surface.harmonic
    print(f"{name}: energy {harmonic.energy:.4f}, degree {harmonic.degree:.3f}. {surface.message}")


def main() -> None:
    parser = argparse.ArgumentParser(description="Render the pictures of docs/.")
    parser.add_argument("names", nargs="*", choices=[*PICTURES, []], help="which of them (all)")
    parser.add_argument("--samples", type=int, default=16, help="samples a pixel (16)")
    arguments = parser.parse_args()
    for name in arguments.names or PICTURES:
        blender_session.empty_scene()
        PICTURES[name](arguments.samples)


if __name__ == "__main__":
    sys.exit(main())
