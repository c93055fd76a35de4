"""The README followed word by word: what *The first shell* says to press is pressed, in its order.

Menus are written *Add > Mesh > …*, buttons **Solve**, the small ones "+" and *Assign*; a word that is none of these is
an error, so that the README cannot name what is not there.
"""

from __future__ import annotations

import json
import re
from pathlib import Path

import bpy

README = Path("/checkout/README.md")
SMALL = {"+": "cmc.group_add", "Assign": "cmc.group_assign"}
# Words in italics that say where something is, or what it is called.
NAMES = {"Size by", "Sides"}


def tell(hands):
    section = README.read_text(encoding="utf-8").partition("## The first shell\n")[2].partition("\n| next |")[0]
    steps, _, own = section.partition("Your own hall:")
    assert steps.strip() and own.strip(), "the section has moved"
    hands.area.spaces.active.show_region_ui = False
    yield 0.5
    for step in re.findall(r"^\d+\. (.*(?:\n {3}.*)*)", steps, re.M):
        yield from follow(hands, step)
    check(bpy.data.objects["Rectangle"])
    yield from hands.picture("rectangle")

    outline(hands)
    yield 0.5
    yield from follow(hands, own)
    plan = bpy.data.objects["Hall Plan"]
    check(plan)
    (side,) = plan.data.cmc.groups
    assert side.kind == "LEAN", "the side leans over its line"
    bpy.ops.object.mode_set(mode="OBJECT")
    yield from hands.click_button("cmc.solve")
    yield from hands.wait_for(lambda: "leans" in plan.cmc.report and not running(), "it is solved again")
    (lean,) = json.loads(plan.cmc.report)["span"]["leans"]
    assert abs(lean["off"]) < 3.0
    yield from hands.picture("hall")


def follow(hands, text: str):
    """Do what a passage says, word by word."""
    before = ""
    for word in re.finditer(r"\*\*([^*]+)\*\*|\*([^*]+)\*|(?<= )(\+)(?= )", text):
        button, italic, plus = word.groups()
        if "in edit mode select edges" in text[: word.start()] and "in edit mode select edges" not in before:
            select_side()
        before = text[: word.start()]
        if button:
            yield from press(hands, button)
        elif plus or italic in SMALL:
            yield from hands.click_button(SMALL[plus or italic], (0.97, 0.15))
        elif " > " in italic:
            yield from menu(hands, [part.strip() for part in re.split(r"\s*>\s*", " ".join(italic.split()))])
        else:
            assert italic in NAMES, f"the README names {italic!r}, which is no button"


def press(hands, label: str):
    """A button by the name on it; "CMC" is the tab, which has come by itself."""
    if label == "CMC":
        assert hands.sidebar.width > 50 and hands.sidebar.active_panel_category == "CMC"
        return
    names = [f"cmc.{name}" for name in dir(bpy.ops.cmc)]
    (command,) = [name for name in names if title(name) == label]
    yield from hands.click_button(command)
    yield from hands.wait_for(lambda: not running(), f"{label} has ended")
    yield 1.0


def title(name: str) -> str:
    return getattr(bpy.ops.cmc, name.removeprefix("cmc.")).get_rna_type().name


def menu(hands, path: list[str]):
    """Open a menu of the viewport and walk down, by its words."""
    first, *rest = path
    assert first == "Add", first
    yield from hands.press("A", (hands.area.x + 400, hands.area.y + 700), shift=True)
    for word in rest:
        yield from hands.click_words(word, hands.viewport)
    yield 1.5


def running() -> bool:
    return bpy.context.window_manager.cmc.running


def check(plan):
    """A shell with its rim on the outline."""
    report = json.loads(plan.cmc.report)
    shown = report["sheets"][report["sheet"]]
    assert report["converged"] and not report["is_open"]
    assert shown["outline"]["max"] < 0.005 * shown["span"], shown["outline"]


def outline(hands):
    """Two loops of edges: a hall and its courtyard."""
    hall = [(-9, -6), (9, -6), (9, 4), (2, 6), (-9, 5)]
    court = [(-3, -2), (1, -2), (1, 1), (-3, 1)]
    edges = [(k, (k + 1) % 5) for k in range(5)] + [(5 + k, 5 + (k + 1) % 4) for k in range(4)]
    mesh = bpy.data.meshes.new("Hall")
    mesh.from_pydata([(x, y + 20, 0) for x, y in hall + court], edges, [])
    ob = bpy.data.objects.new("Hall", mesh)
    bpy.context.scene.collection.objects.link(ob)
    for other in bpy.context.selected_objects:
        other.select_set(False)
    ob.select_set(True)
    bpy.context.view_layer.objects.active = ob
    bpy.ops.ed.undo_push(message="Hall")


def select_side() -> None:
    """Edges along the lower side."""
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.context.tool_settings.mesh_select_mode = (False, True, False)
    bpy.ops.mesh.select_all(action="DESELECT")
    bpy.ops.object.mode_set(mode="OBJECT")
    mesh = bpy.context.object.data
    low = min(vertex.co.y for vertex in mesh.vertices)
    for edge in mesh.edges:
        edge.select = all(mesh.vertices[k].co.y < low + 1e-3 for k in edge.vertices)
    bpy.ops.object.mode_set(mode="EDIT")
