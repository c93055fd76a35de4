"""The first time: from Blender as it starts to a shell whose rim is on its outline, in six clicks; then it is saved.

Add, Mesh, CMC, Rectangle; the tab of the sidebar, where Blender does not let an extension choose it; Solve.
docs/how-to/six-clicks.md is the same path with the mouse.
"""

from __future__ import annotations

import json
import os
import subprocess

import bpy

MOST = 6


def until(condition, what: str, seconds: float = 60.0):
    """Wait for something to become true."""
    waited = 0.0
    while not condition():
        assert waited < seconds, f"waited in vain until {what}"
        waited += 0.05
        yield 0.05


class Counted:
    """Hands whose clicks are counted."""

    def __init__(self, hands) -> None:
        self.hands, self.clicks = hands, []

    def click(self, x, y, what):
        self.clicks.append(what)
        yield from self.hands.click(x, y)

    def button(self, command):
        place = yield from self.hands.find(command)  # looking is no clicking
        yield from self.click(*place, command)


def tell(hands):
    bpy.context.preferences.view.filebrowser_display_type = "SCREEN"
    bpy.ops.mesh.primitive_cube_add()  # Blender starts with it
    bpy.ops.ed.undo_push(message="Cube")
    hands.area.spaces.active.show_region_ui = False
    yield 0.5
    yield from hands.picture("start")
    counted = Counted(hands)

    counted.clicks += ["Add", "Mesh", "CMC", "Rectangle"]  # with the mouse; the keyboard's way is shorter
    place = hands.area.x + 400, hands.area.y + 700
    yield from hands.press("A", place, shift=True)
    yield from hands.picture("add-menu")
    yield from hands.type("rectangle", place)
    yield from until(lambda: "Rectangle" in bpy.data.objects, "the plan is there")

    yield from until(lambda: hands.sidebar.width > 50, "the sidebar is open")
    yield 1.5
    if hands.sidebar.active_panel_category != "CMC":
        yield from open_tab(hands, counted)
    yield from hands.picture("plan")

    yield from counted.button("cmc.solve")
    yield from until(lambda: plan().cmc.f_plus is not None, "the shell is there")
    yield 1.0
    shown = json.loads(plan().cmc.report)["sheets"]["f+"]
    assert shown["outline"]["max"] < 1e-3 * shown["span"], "the rim is on the outline"
    yield from hands.picture("fitted")
    assert len(counted.clicks) <= MOST, f"{len(counted.clicks)} clicks: {', '.join(counted.clicks)}"
    print(f"first time: {len(counted.clicks)} clicks: {', '.join(counted.clicks)}", flush=True)

    yield from hands.press("S", ctrl=True)
    yield 1.5
    snap(hands, "saving")
    yield from hands.press("RET", (640, 450))
    yield from until(lambda: bpy.data.filepath and os.path.exists(bpy.data.filepath), "the file is saved")
    yield from hands.picture("saved")


def snap(hands, name):
    """A picture where there is no viewport to redraw."""
    hands.shots += 1
    file = f"/pictures/{hands.story}-{hands.shots:02d}-{name}.png"
    subprocess.run(["import", "-window", "root", file], check=True)


def plan():
    return bpy.data.objects["Rectangle"]


def open_tab(hands, counted):
    """Click on the tab; where it is, is found by trying, and only the click that hits it counts."""
    side = hands.sidebar
    for y in range(side.y + side.height - 40, side.y + 20, -25):
        yield from hands.click(side.x + side.width - 12, y)
        if hands.sidebar.active_panel_category == "CMC":
            counted.clicks.append("CMC tab")
            return
    raise LookupError("no tab CMC in the sidebar")
