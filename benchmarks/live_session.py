"""Live in a real Blender (the bpy module), in a process of its own; `bench_live.py` starts it.

    python benchmarks/live_session.py speed 5000     from a change of a property or a vertex to the written mesh
    python benchmarks/live_session.py edits 1000     random edits: distance from a fresh solve at the end, and memory

The timer's ticks are called directly, as fast as they return. Prints one line of JSON.
"""

from __future__ import annotations

import ctypes
import gc
import json
import math
import statistics
import sys
import time
from contextlib import suppress
from pathlib import Path

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT / "tests"))

from blender.conftest import PACKAGE  # noqa: E402  makes the checkout a package of its own

import bpy  # noqa: E402  isort: skip
import addon_utils  # noqa: E402  isort: skip
import numpy as np  # noqa: E402  isort: skip

from blender.live_driver import off_by, settle  # noqa: E402  isort: skip
from blender.scenes import add_group, boundary_edges  # noqa: E402  isort: skip
from blender.test_live_survives import many_edits  # noqa: E402  isort: skip

ROUNDS = 7


def live_plan(vertices: int) -> bpy.types.Object:
    """A round plan with about this many vertices; half of its rim is tilted."""
    bpy.ops.mesh.primitive_circle_add(vertices=int(4 * math.sqrt(vertices)), radius=4.0, fill_type="NGON")
    bpy.ops.cmc.mesh_plan(edge_length=math.sqrt(16.0 * math.pi / vertices / (0.5 * math.sqrt(3.0))))
    plan = bpy.context.object
    plan.name = "Plan"
    edges = boundary_edges(plan.data)
    add_group(plan, "Half", edges[: len(edges) // 2], "BINORMAL", tilt=0.3)
    plan.cmc.intersections = False  # only measured at rest
    plan.cmc.live = True
    return plan


# --- speed ---------------------------------------------------------------------------------

def updated(live, change) -> tuple[float, float]:
    """Seconds from a change until the results show it, and the longest tick, which holds up the window."""
    state = next(iter(live.Live.states.values()))
    began = time.perf_counter()
    change()
    longest = 0.0
    while True:
        before = time.perf_counter()
        live.tick()
        longest = max(longest, time.perf_counter() - before)
        if not (state.is_dirty or state.is_behind):
            return time.perf_counter() - began, longest
        time.sleep(0.001)


def bare_solves(addon, live, plan, changes):
    """A function of k: the bare solve after change k, with the plan's cached factor, from the last map."""
    tasks, update = addon.cmc_addon.tasks.solve, addon.cmc_addon.live.update
    plan_cache = addon.cmc_addon.background.plan_cache
    conditions = __import__(f"{PACKAGE}.solver.shells.plan_conditions", fromlist=["plan_conditions"]).plan_conditions
    made = []
    for change in changes:
        change()
        reading = update.read(bpy.context, plan)
        settings = tasks.solver_settings(reading.solve.settings)
        prepared = plan_cache.prepare(reading.solve.mesh, settings.solver_choice)
        made.append((prepared.solver, conditions(reading.solve.plan(prepared), settings, prepared.solver.domain)))
    last = [made[-1][0].solve(made[-1][1]).harmonic.normals]

    def solve(k: int) -> None:
        last[0] = made[k][0].solve(made[k][1], initial=last[0]).harmonic.normals

    for k in range(len(made)):
        solve(k)
    return solve


def speed(addon, vertices: int) -> dict:
    """Medians over interleaved rounds, with a tilt that alternates by two degrees."""
    live = addon.cmc_addon.live.live
    plan = live_plan(vertices)
    group = plan.data.cmc.groups[0]
    tilts = [lambda: setattr(group, "tilt", 0.3), lambda: setattr(group, "tilt", 0.335)]
    solve = bare_solves(addon, live, plan, tilts)
    middle = min(plan.data.vertices, key=lambda vertex: vertex.co.length).index
    settle(live, 600.0)

    def moved(k: int) -> None:
        plan.data.vertices[middle].co.x += (0.3 if k % 2 else -0.3) * 4.0 / math.sqrt(vertices)
        plan.data.update()
        bpy.context.view_layer.update()

    taken: dict[str, list[float]] = {"bare": [], "tilt": [], "held up": [], "vertex": [], "coarse": []}
    for k in range(ROUNDS):
        began = time.perf_counter()
        solve(k % 2)
        taken["bare"].append(time.perf_counter() - began)
        for name, limit in (("coarse", 0), ("tilt", 10**9)):
            live.limit = lambda limit=limit: limit
            tilts[1 - k % 2]()
            updated(live, lambda: None)
            seconds, longest = updated(live, tilts[k % 2])
            taken[name].append(seconds)
            taken["held up"].append(longest)
        taken["vertex"].append(updated(live, lambda k=k: moved(k))[0])
    settle(live, 600.0)
    return {"vertices": len(plan.data.vertices), **{name: statistics.median(times) for name, times in taken.items()}}


# --- many edits ----------------------------------------------------------------------------

def memory() -> float:
    """Megabytes in use by this process after all free memory is returned."""
    gc.collect()
    with suppress(OSError, AttributeError):
        ctypes.CDLL("libc.so.6").malloc_trim(0)
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * 4096 / 2**20


def edits(addon, count: int) -> dict:
    """Memory after each fifth of the edits; after the first, the undo stack is full."""
    live = addon.cmc_addon.live.live
    live_plan(1_000)
    settle(live)
    bpy.ops.ed.undo_push(message="Live")
    used, began = [], time.perf_counter()
    for part in range(5):
        many_edits(live, "Plan", count // 5, seed=part)
        settle(live)
        used.append(memory())
    plan = bpy.data.objects["Plan"]
    return {"edits": count, "off by": off_by(addon, plan), "MB": used, "seconds": time.perf_counter() - began}


def main(what: str, number: str) -> None:
    bpy.ops.wm.read_factory_settings(use_empty=True)
    addon = addon_utils.enable(PACKAGE, default_set=True)
    assert addon is not None
    bpy.context.preferences.edit.undo_steps = 32
    print(json.dumps({"speed": speed, "edits": edits}[what](addon, int(number))), flush=True)


if __name__ == "__main__":
    np.seterr(all="ignore")
    main(*sys.argv[1:])
