"""Drive Live as a user and the window's timer do: make a change, tick until the results follow."""

from __future__ import annotations

import time

import bpy
import numpy as np

from .scenes import add_group, boundary_edges, positions, quad_disc

EXACT = 2e-6
"""Relative to the size of a shell: two solves of one plan, stored in single precision."""


def live_disc(name: str = "Disc", **shape) -> bpy.types.Object:
    """A round plan, half of its rim in a group, live."""
    plan = quad_disc(name, **shape)
    edges = boundary_edges(plan.data)
    add_group(plan, "Half", edges[: len(edges) // 2], "BINORMAL", tilt=0.3)
    plan.cmc.live = True
    return plan


def start_update(live, change) -> None:
    """Make changes until a tick leaves an update running: on a busy machine one may end before the tick looks."""
    for attempt in range(100):
        change(attempt)
        live.tick()
        if live.Live.running is not None:
            return
    raise AssertionError("every update ended at once")


def settle(live, seconds: float = 30.0) -> int:
    """Tick until there is nothing more to do; returns the number of ticks."""
    bpy.context.view_layer.update()
    ticks = 1
    while live.tick() is not None:
        ticks += 1
        assert ticks < seconds / 0.003, "never ends"
        time.sleep(0.003)
    return ticks


def catch_up(live, seconds: float = 30.0) -> None:
    """Tick until the results show the last change, and no further."""
    bpy.context.view_layer.update()
    until = time.monotonic() + seconds
    live.tick()
    while any(state.is_dirty or state.is_behind for state in live.Live.states.values()):
        assert time.monotonic() < until, "never catches up"
        time.sleep(0.003)
        live.tick()


def state_of(live, plan):
    return live.Live.states[plan.session_uid]


def solved_anew(addon, plan) -> np.ndarray:
    """Points of a fresh solve of the plan, with empty caches."""
    solve, plan_cache = addon.cmc_addon.tasks.solve, addon.cmc_addon.background.plan_cache
    bpy.context.view_layer.update()
    task = solve.SolveTask.read(bpy.context, plan, solve.settings_of(plan.cmc))
    plan_cache.forget()
    return task.work(lambda *_: True).shell.placed[solve.ROLES[plan.cmc.sheet]]


def off_by(addon, plan) -> float:
    """Distance of the shown sheet from a solve of its plan, as a part of its size."""
    expected = solved_anew(addon, plan)
    found = positions(getattr(plan.cmc, plan.cmc.sheet.lower()))
    return float(np.abs(found - expected).max() / np.linalg.norm(np.ptp(expected, axis=0)))


def move(plan, index: int, by) -> None:
    """Move a vertex as a tool does in object or in edit mode."""
    if plan.mode == "EDIT":
        import bmesh

        mesh = bmesh.from_edit_mesh(plan.data)
        mesh.verts.ensure_lookup_table()
        mesh.verts[index].co += type(mesh.verts[index].co)(by)
        bmesh.update_edit_mesh(plan.data)
    else:
        for axis, amount in enumerate(by):
            plan.data.vertices[index].co[axis] += amount
        plan.data.update()
    bpy.context.view_layer.update()
