"""A hall drawn by hand, nine corners and a courtyard: outline, Mesh Plan, Solve; closed, both rims on their lines."""

from __future__ import annotations

import json

import bmesh
import bpy
import numpy as np
from bpy_extras.view3d_utils import location_3d_to_region_2d

OUTLINE = [(-9, -6), (8, -6), (9, 1), (4, 2.5), (4.5, 6), (0, 7), (-4, 4.5), (-8, 6), (-10, 0)]
COURT = [(-4, -2.5), (-0.5, -3), (0, 0.5), (-3.5, 1)]


def tell(hands):
    yield from draw(hands)
    yield from hands.press("TAB")
    assert bpy.context.mode == "OBJECT"
    yield from hands.click_button("cmc.mesh_plan")
    yield from hands.wait_for(lambda: "Plane Plan" in bpy.data.objects, "the plan is there")
    plan = bpy.data.objects["Plane Plan"]
    yield from hands.picture("plan")
    assert plan.cmc.rounded.endswith("of 13 corners rounded"), plan.cmc.rounded
    yield from hands.click_button("cmc.solve")
    yield from hands.wait_for(lambda: plan.cmc.f_plus is not None, "the shell is there")
    yield from hands.press("NUMPAD_1")
    for key in ("NUMPAD_8", "NUMPAD_8", "NUMPAD_6", "NUMPAD_6"):
        yield from hands.press(key)
    yield from hands.press("HOME")
    yield 1.0
    yield from hands.picture("solved")
    check(plan)


def draw(hands):
    """A plane whose corners are deleted; then corner after corner with Ctrl and the right button."""
    middle = (hands.viewport.width // 2, hands.viewport.height // 2)
    yield from hands.press("A", middle, shift=True)
    yield from hands.click_words("Mesh", hands.viewport)
    yield from hands.click_words("Plane", hands.viewport)
    yield from hands.wait_for(lambda: "Plane" in bpy.data.objects, "the plane is there")
    yield from hands.press("S", middle)
    yield from hands.type("10", middle)
    yield from hands.press("NUMPAD_7")
    yield from hands.press("NUMPAD_PERIOD", middle)
    yield 1.0
    yield from hands.press("TAB")
    yield from hands.press("ONE")
    yield from hands.press("A")
    yield from hands.press("X")
    yield from hands.click_words("Vertices", hands.viewport)
    for loop in (OUTLINE, COURT):
        yield from hands.press("A", alt=True)
        for point in loop:
            x, y = place(hands, (*point, 0))
            hands.move(x, y)
            yield 0.1
            for value in ("PRESS", "RELEASE"):
                hands.window.event_simulate(type="RIGHTMOUSE", value=value, x=x, y=y, ctrl=True)
            yield 0.3
        yield from hands.click(*place(hands, (*loop[0], 0)), shift=True)
        yield from hands.press("F")
    drawn = bmesh.from_edit_mesh(bpy.context.object.data)
    assert (len(drawn.verts), len(drawn.edges)) == (13, 13), (len(drawn.verts), len(drawn.edges))
    yield from hands.picture("drawn")


def check(plan):
    """The shell is closed, no faces cross, and each rim is on its line to 0.5 % of the span."""
    report = json.loads(plan.cmc.report)
    shown = report["sheets"][report["sheet"]]
    assert report["converged"] and not report["is_open"] and not shown["intersections"]["count"]
    assert len(plan.cmc.f_plus.data.vertices) == len(plan.data.vertices), "not cut open"
    off = np.concatenate([off_line(rim, line) for rim, line in zip(loops(plan.cmc.f_plus), loops(plan), strict=True)])
    print(f"hall: rims {off.max():.2e} off their lines, span {shown['span']:.2f}", flush=True)
    assert off.max() < 0.005 * shown["span"]


def loops(ob) -> list[np.ndarray]:
    """The outer and the inner rim in order, in the world."""
    bm = bmesh.new()
    bm.from_mesh(ob.data)
    left, found = {edge for edge in bm.edges if edge.is_boundary}, []
    while left:
        edge = left.pop()
        chain = [edge.verts[0], edge.verts[1]]
        while ahead := next((e for e in chain[-1].link_edges if e in left), None):
            left.discard(ahead)
            chain.append(ahead.other_vert(chain[-1]))
        found.append(np.array([ob.matrix_world @ vertex.co for vertex in chain[:-1]]))
    bm.free()
    return sorted(found, key=lambda loop: -np.ptp(loop, axis=0).max())


def off_line(points: np.ndarray, line: np.ndarray) -> np.ndarray:
    """Distances of points from a closed polyline."""
    a, d = line, np.roll(line, -1, axis=0) - line
    t = np.einsum("nmi,mi->nm", points[:, None] - a, d) / np.einsum("mi,mi->m", d, d)
    return np.linalg.norm(points[:, None] - a - t.clip(0, 1)[..., None] * d, axis=2).min(axis=1)


def place(hands, point) -> tuple[int, int]:
    """Where a point of the plan is in the window."""
    region = next(region for region in hands.area.regions if region.type == "WINDOW")
    found = location_3d_to_region_2d(region, hands.area.spaces.active.region_3d, point)
    return region.x + round(found.x), region.y + round(found.y)
