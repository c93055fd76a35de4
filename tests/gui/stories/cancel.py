"""A long solve: the window goes on drawing, progress is shown, Esc and the button stop it, nothing is changed."""

from __future__ import annotations

import bpy


def tell(hands):
    bpy.ops.mesh.primitive_circle_add(vertices=32, radius=5, fill_type="NGON")
    bpy.ops.cmc.mesh_plan(edge_length=0.04)
    plan = bpy.context.object
    print(f"{len(plan.data.vertices)} vertices")
    bpy.ops.cmc.select_ungrouped()
    bpy.ops.cmc.group_add(name="rim", kind="TWISTED", m=3.0, assign=True)
    bpy.ops.ed.undo_push(message="Plan")
    before = state(plan)

    x, y = yield from hands.find("cmc.solve", (0.35,))
    yield from hands.click(x, y)
    run = bpy.context.window_manager.cmc
    assert run.running, "a click starts a solve that leaves the window free"
    yield from hands.picture("running")
    assert run.running, "still running after a second of drawing"
    yield from hands.press("ESC")
    assert not run.running
    assert state(plan) == before, "Esc changes nothing"
    yield from hands.picture("escaped")

    yield from hands.click(x, y)
    assert run.running
    yield from hands.click_button("cmc.cancel", (0.94,), near=y)
    for _ in range(600):
        if not run.running:
            break
        yield 0.1
    assert not run.running
    assert state(plan) == before, f"the button changes nothing: {state(plan)}"
    yield from hands.picture("cancelled")

    plan.data.cmc.groups[0].kind = "BINORMAL"
    yield from hands.click(x, y)
    for _ in range(1500):
        if not run.running:
            break
        yield 0.1
    assert plan.cmc.f_plus is not None, "a solve after a cancelled one works"


def state(plan) -> tuple:
    return (
        [ob.name for ob in bpy.data.objects],
        [mesh.name for mesh in bpy.data.meshes],
        [collection.name for collection in bpy.data.collections],
        plan.cmc.report,
        plan.cmc.message,
    )
