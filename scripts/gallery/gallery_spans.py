"""Pictures of surfaces through given lines: six roofs, one line and a slider of H, necks, sides that lean.

`render_gallery.py` starts Blender and calls them. All come from `span_outline`.
"""

from __future__ import annotations

from collections.abc import Sequence

import bpy
import numpy as np
from cmc_formfinding.solver import Shape, Span, shapes, span_outline

from scripts.gallery import scene, staging

ANGLE = np.linspace(0.0, 2.0 * np.pi, 120, endpoint=False)
SQUARE = np.array([(-3.0, -3.0), (3.0, -3.0), (3.0, 3.0), (-3.0, 3.0)])
# Parts of 1 / R, R the radius of the line seen from above; its largest H is about 0.99 / R.
SLIDER = (-0.98, -0.65, 0.0, 0.65, 0.98)
NECKS = (0.3, 0.6, 0.9, 1.0, 1.05)
LEANS = (60.0, 90.0, 120.0)
RUST = (0.42, 0.10, 0.04)


# --- the pictures --------------------------------------------------------------------------


def spans(edge: float = 0.12) -> None:
    """Six roofs, each on its lines; squares are those of the plan to which the surface is conformal."""
    plaster = scene.checker("Plaster", "Plan", cells=2.0)
    roofs = {
        "soap film": raised_loop(),
        "hypar": hypar(edge),
        "catenoid": between_circles(3.0, 1.8, 2.1),
        "court": court(edge),
        "ring": between_circles(3.0, 1.2, 1.3, mean_curvature=0.22, aside=0.8, slope=0.3),
        "square": span_outline(square := polygon(SQUARE, edge), square.positions, rise=0.6),
    }
    for k, (name, span) in enumerate(roofs.items()):
        place = (8.2 * (k % 3), -7.6 * (k // 3), 0.0)
        draw(name, told(name, span), place, plaster, thickness=0.06, line=0.1)
    scene.add_ground(26.0)
    scene.light(sun=(-0.75, -0.4, 0.6), strength=4.0, sky=0.6)
    eye = staging.look_at(drawn_points(), (-84.0, 0.5), 60.0, 2.35)
    for place in ((4.1, -3.2, 0.0), (4.6, -3.6, 0.0), (12.4, -11.0, 0.0)):
        scene.add_person(place, eye)


def slider() -> None:
    """One line, and the surfaces through it whose H goes from -1/R to 1/R."""
    disc, line = shapes.disc(3000), np.column_stack([np.cos(ANGLE), np.sin(ANGLE), 0.2 * np.cos(2.0 * ANGLE + 0.9)])
    plaster = scene.checker("Plaster", "Plan", cells=6.0)
    for k, H in enumerate(SLIDER):
        span = told(f"H = {H:.2f} / R", span_outline(disc, disc.positions, line, mean_curvature=H))
        draw(f"{H}", span, (2.3 * k, 0.0, 0.0), plaster, line=0.035)
        scene.add_text(f"H = {H:g} / R".replace("-", "−") if H else "H = 0", (2.3 * k, 0.0, -1.35), 0.19)


def necks() -> None:
    """Catenoids between circles of radius 1 and 0.6, higher and higher, and the height at which there is none."""
    ring = shapes.annulus(0.6, 1.0, 4000)
    plaster = scene.checker("Plaster", "Plan", cells=8.0)
    for k, height in enumerate(NECKS):
        place = (2.5 * k, 0.0, 0.0)
        lines = [circle(1.0), circle(0.6, height)]
        span = told(f"height {height}", span_outline(ring, ring.positions, lines))
        if span.ok:
            draw(f"{height}", span, place, plaster, line=0.035)
        else:
            for line in lines:
                scene.add_line("Circle", line + place, 0.035, colour=RUST)
        scene.add_text(f"{height}" if span.ok else f"{height}: none", np.array(place) + [0.0, -1.0, -0.45], 0.26)


def leans() -> None:
    """Halls of 12 × 14 m on three sides of their plan, while the fourth rises over its line and leans."""
    hall = polygon(np.array([(-6.0, 0.0), (6.0, 0.0), (6.0, 14.0), (-6.0, 14.0)]), 0.35)
    plaster, people = scene.checker("Plaster", "Plan", cells=1.0), []
    for k, angle in enumerate(LEANS):
        street = [(hall.sides["side0"], np.radians(angle))]
        span = told(f"{angle:g}°", span_outline(hall, hall.positions, rise=0.75, leans=street))
        place = np.array([15.5 * k, 0.0, 0.0])
        draw(f"{angle:g}°", span, place, plaster, thickness=0.12, line=0.16)
        scene.add_line("Street", np.array([(-6.0, 0.0, 0.02), (6.0, 0.0, 0.02)]) + place, 0.1, closed=False)
        scene.add_text(f"{angle:g}°", place + [0.6, -4.0, 0.5], 1.1)
        people += [place + [-3.4, -2.8, 0.0], place + [-2.5, -3.3, 0.0]]
    scene.add_ground(50.0)
    scene.light(sun=(-0.75, -0.6, 0.62), strength=4.0, sky=0.6)
    eye = staging.look_at(drawn_points(), (-84.0, 0.3), 60.0, 3.5)
    for place in people[: 2 * len(LEANS) - 1]:
        scene.add_person(place, eye)


# --- the surfaces --------------------------------------------------------------------------


def raised_loop() -> Span:
    """A soap film on a loop that touches the ground twice."""
    disc = shapes.disc(2500)
    loop = np.column_stack([3.4 * np.cos(ANGLE), 2.7 * np.sin(ANGLE), 1.5 + 1.4 * np.cos(2.0 * ANGLE + 0.5)])
    return span_outline(disc, 3.0 * disc.positions, loop)


def hypar(edge: float) -> Span:
    """The soap film on four straight edges, two corners of which are raised."""
    plan = polygon(SQUARE, edge)
    x, y = plan.positions.T
    return span_outline(plan, np.column_stack([x, y, 1.6 + 1.5 * x * y / 9.0]))


def court(edge: float) -> Span:
    """A hall around a court, both on the ground; the corners of the hall stay sharp."""
    hole = 0.36 * SQUARE + [0.5, 0.3]
    plan = shapes.polygon(SQUARE, [hole], max_edge=edge, corner_radius=0.4, corners="re-entrant")
    return span_outline(plan, plan.positions, height=0.9)


def between_circles(
    outer: float, inner: float, height: float, mean_curvature: float = 0.0, aside: float = 0.0, slope: float = 0.0
) -> Span:
    """The surface between a circle on the ground and one above, which may lie aside and slope."""
    plan = shapes.annulus(inner, outer, 2500)
    above = circle(inner, height)
    above[:, 2] += slope * above[:, 0]
    return span_outline(plan, plan.positions, [circle(outer), above + [aside, 0.0, 0.0]], mean_curvature=mean_curvature)


def circle(radius: float, height: float = 0.0) -> np.ndarray:
    return np.column_stack([radius * np.cos(ANGLE), radius * np.sin(ANGLE), np.full(len(ANGLE), height)])


def polygon(outline: np.ndarray, edge: float) -> Shape:
    """A plan whose corners stay sharp."""
    return shapes.polygon(outline, max_edge=edge)


# --- how they are drawn --------------------------------------------------------------------


def told(name: str, span: Span) -> Span:
    print(f"{name}: H {span.mean_curvature:.4g}, {len(span.history)} steps. {span.message}")
    return span


def draw(
    name: str,
    span: Span,
    place: Sequence[float] | np.ndarray,
    material: bpy.types.Material,
    *,
    thickness: float = 0.0,
    line: float,
) -> None:
    """A span at a place, with its lines; the UVs are the places of its plan, in which it is conformal."""
    ob = scene.mesh_object(name, span.points, span.faces, material)
    uv = span.positions[span.faces, :2]
    ob.data.uv_layers.new(name="Plan").uv.foreach_set("vector", uv.astype(np.float32).ravel())
    ob.data.shade_smooth()
    if thickness:
        scene.thicken(ob, thickness)
    ob.location = place
    for loop in span.domain.boundary_loops:
        scene.add_line(f"Line of {name}", span.points[loop] + place, line, colour=RUST)


def drawn_points() -> np.ndarray:
    """The points of all surfaces in the scene."""
    surfaces = [ob for ob in bpy.context.scene.objects if ob.type == "MESH" and ob.name != "Ground"]
    return np.concatenate([staging.world_points(ob) for ob in surfaces])
