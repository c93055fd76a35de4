"""A shell on lines, by hand: Other Edges on the line, a side that leans, H dragged through 0 with Live."""

from __future__ import annotations

import bpy
import numpy as np
from stories.live import at_rest, points


def plan():
    return bpy.data.objects["Rectangle"]


def look(hands, rotation=(0.82, 0.42, 0.17, 0.34)):
    """The plan and its shell in the middle of the view, from the south-east."""
    region = next(region for region in hands.area.regions if region.type == "WINDOW")
    with bpy.context.temp_override(window=hands.window, area=hands.area, region=region):
        hands.area.spaces.active.region_3d.view_rotation = rotation
        bpy.ops.view3d.view_all()
    yield 0.6


def side(inside):
    """Select the boundary edges whose middles are inside, in edit mode."""
    bpy.ops.object.mode_set(mode="OBJECT")
    mesh = plan().data
    faces = np.bincount([loop.edge_index for loop in mesh.loops], minlength=len(mesh.edges))
    for edge in mesh.edges:
        middle = sum((mesh.vertices[v].co for v in edge.vertices), start=mesh.vertices[0].co * 0) / 2
        edge.select = bool(faces[edge.index] == 1 and inside(middle))
    for vertex in mesh.vertices:
        vertex.select = False
    for polygon in mesh.polygons:
        polygon.select = False
    bpy.context.tool_settings.mesh_select_mode = (False, True, False)
    bpy.ops.object.mode_set(mode="EDIT")


def rectangle():
    """Add > Mesh > CMC > Rectangle, its edges in no group and on their line."""
    bpy.ops.cmc.add_plan(shape="RECTANGLE")
    bpy.ops.cmc.mesh_plan(edge_length=0.6)
    bpy.context.object.name = "Rectangle"
    plan().cmc.default_kind = "LINE"
    bpy.ops.ed.undo_push(message="Plan")


def middle(shell) -> float:
    """The height of the shell over the middle of the plan."""
    places = points(shell)
    return float(places[np.linalg.norm(places[:, :2], axis=1).argmin(), 2])


class Heights:
    """The heights of the shell over the middle of the plan, one for each shape that it takes, until `stop`."""

    def __init__(self) -> None:
        self.seen: list[float] = []
        bpy.app.timers.register(self)

    def __call__(self) -> float:
        height = middle(plan().cmc.f_plus)
        if not self.seen or height != self.seen[-1]:
            self.seen.append(height)
        return 0.0

    def stop(self) -> np.ndarray:
        bpy.app.timers.unregister(self)
        return np.array(self.seen)


def off_line() -> float:
    """How far the shell's rim is off the drawn edges, as a length; its vertices slide along the smooth line through
    them, which is a few millimetres off the edges at rounded corners."""
    mesh, shell = plan().data, plan().cmc.f_plus
    faces = np.bincount([loop.edge_index for loop in mesh.loops], minlength=len(mesh.edges))
    edges = np.array([edge.vertices for edge in mesh.edges if faces[edge.index] == 1])
    moved = points(shell) + np.array(shell.location) - np.array(plan().location)
    start, step = points(plan())[edges[:, 0]], np.diff(points(plan())[edges], axis=1)[:, 0]
    away = moved[np.unique(edges)][:, None] - start
    part = np.clip(np.einsum("rei,ei->re", away, step) / np.einsum("ei,ei->e", step, step), 0.0, 1.0)
    return float(np.linalg.norm(away - part[..., None] * step, axis=2).min(axis=1).max())


def tell(hands):
    rectangle()
    yield from look(hands)
    yield from hands.picture("on-the-line")
    yield from hands.click_button("cmc.solve")
    yield from hands.wait_for(lambda: plan().cmc.f_plus is not None, "the shell is there")
    yield from look(hands)
    yield from hands.picture("solved")
    assert off_line() < 0.01, off_line()

    bpy.ops.object.mode_set(mode="EDIT")
    bpy.context.tool_settings.mesh_select_mode = (False, True, False)
    yield from hands.picture("edited")
    side(lambda p: p.y < -2.9 and abs(p.x) < 4.0)
    bpy.ops.cmc.group_add(name="Street", kind="LEAN", angle=np.radians(60), assign=True)
    bpy.ops.object.mode_set(mode="OBJECT")
    yield from hands.click_button("cmc.solve")
    yield from hands.wait_for(lambda: off_line() > 0.02, "the side has left its line")
    yield from look(hands)
    yield from hands.picture("leans")

    yield from dragged_through_zero(hands)
    yield from raised(hands)
    yield from on_a_curve(hands)


def dragged_through_zero(hands):
    plan().cmc.size, plan().cmc.mean_curvature = "MEAN_CURVATURE", 0.06
    yield from hands.click_button("cmc.live")
    yield from hands.wait_for(at_rest, "the shell has the curvature")
    yield from look(hands)
    yield from hands.picture("dome")
    x, y = yield from hands.find_field("cmc.mean_curvature")
    watch = Heights()
    yield from hands.drag((x, y), (x - 14, y), steps=14, pause=0.15)
    yield from hands.wait_for(at_rest, "it has come to rest")
    heights, H = watch.stop(), plan().cmc.mean_curvature
    steps = np.abs(np.diff(heights))
    print(f"H to {H:.3f}: {len(heights)} shapes from {heights[0]:.3f} to {heights[-1]:.3f}, "
          f"{steps.max():.3f} at most from one to the next", flush=True)
    assert H < -0.01 and heights[0] > 0 > heights[-1] and len(heights) > 5
    assert steps.max() < 0.5 * np.ptp(heights), "it has not jumped"
    yield from hands.picture("hanging")
    bpy.ops.ed.undo_push(message="Hanging")


def raised(hands):
    """A corner of the line raised in edit mode; the rim and its line go along."""
    plan().cmc.mean_curvature = 0.0
    mesh = plan().data
    for vertex in mesh.vertices:
        vertex.co.z = 0.012 * vertex.co.x * vertex.co.y
    mesh.update()
    yield from hands.wait_for(at_rest, "the soap film is there")
    yield from look(hands)
    yield from hands.picture("soap-film")


def on_a_curve(hands):
    """The whole loop in one group on a chosen curve, above the plan."""
    side(lambda p: True)
    bpy.ops.cmc.group_remove(all=True)
    bpy.ops.cmc.group_add(name="Ring", kind="LINE", assign=True)
    bpy.ops.object.mode_set(mode="OBJECT")
    data = bpy.data.curves.new("Curve", "CURVE")
    data.dimensions = "3D"
    spline = data.splines.new("POLY")
    turn = np.linspace(0.0, 2.0 * np.pi, 120, endpoint=False)
    spline.points.add(len(turn) - 1)
    for point, t in zip(spline.points, turn.tolist(), strict=True):
        point.co = (7.0 * np.cos(t), 4.5 * np.sin(t), 2.0 + 0.8 * np.cos(2.0 * t), 1.0)
    spline.use_cyclic_u = True
    curve = bpy.data.objects.new("Curve", data)
    bpy.context.collection.objects.link(curve)
    plan().data.cmc.groups["Ring"].curve = curve
    plan().cmc.mean_curvature = 0.08
    yield from hands.wait_for(at_rest, "the shell is on the curve")
    yield from look(hands)
    yield from hands.picture("curve")
    assert points(plan().cmc.f_plus)[:, 2].min() > 1.0
