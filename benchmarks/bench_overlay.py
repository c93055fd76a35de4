"""The viewport overlay: processor time of a redraw, and of the first redraw after a change.

`make bench` prints milliseconds. Run as a script, this file is the measured Blender, in a process of its own.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import time
from pathlib import Path

import pytest

pytest.importorskip("bpy", reason="needs the bpy module")

ROOT = Path(__file__).parents[1]
ROUNDS = 7


@pytest.mark.timeout(300)
@pytest.mark.parametrize("vertices", [5_000, 50_000])
def test_a_redraw(vertices, capsys):
    arguments = [sys.executable, __file__, str(vertices)]
    environment = {**os.environ, "OPENBLAS_NUM_THREADS": "1"}
    done = subprocess.run(arguments, capture_output=True, text=True, env=environment, check=False)
    assert done.returncode == 0, done.stderr[-2000:]
    measured = json.loads(next(line for line in reversed(done.stdout.splitlines()) if line.startswith("{")))
    with capsys.disabled():
        print(f"\n{measured.pop('vertices')} vertices")
        for name, seconds in measured.items():
            print(f"  {name:<32s} {1e3 * seconds:7.2f} ms")
    assert measured["nothing has changed"] < 0.002


def measure(vertices: int) -> dict[str, float]:
    """Seconds of each kind of redraw: the minimum over the rounds."""
    import bmesh
    import bpy
    from blender.scenes import add_group, boundary_edges

    side = round(vertices**0.5)
    bpy.ops.mesh.primitive_grid_add(x_subdivisions=side - 1, y_subdivisions=side - 1, size=10)
    plan = bpy.context.object
    edges = boundary_edges(plan.data)
    group = add_group(plan, "Half", edges[: len(edges) // 2], "BINORMAL")
    overlay = sys.modules["cmc_formfinding.cmc_addon.drawing.overlay"]

    def least(change) -> float:
        taken = []
        for k in range(ROUNDS):
            change(0.1 * (k + 1))
            bpy.context.view_layer.update()
            before = time.thread_time()
            assert overlay.frame(bpy.context)
            taken.append(time.thread_time() - before)
        return min(taken)

    def drag(x: float) -> None:
        bm = bmesh.from_edit_mesh(plan.data)
        bm.verts.ensure_lookup_table()
        bm.verts[0].co.z = x
        bmesh.update_edit_mesh(plan.data, loop_triangles=False, destructive=False)

    overlay.frame(bpy.context)
    measured = {"vertices": len(plan.data.vertices)}
    measured["nothing has changed"] = least(lambda _: None)
    measured["the plan was moved"] = least(lambda x: setattr(plan.location, "x", x))
    measured["an angle was turned"] = least(lambda x: setattr(group, "tilt", x))
    measured["the plan was scaled"] = least(lambda x: setattr(plan.scale, "x", 1.0 + x))
    bpy.ops.object.mode_set(mode="EDIT")
    measured["a vertex was dragged (edit mode)"] = least(drag)
    bpy.ops.object.mode_set(mode="OBJECT")
    return measured


if __name__ == "__main__":
    sys.path.insert(0, str(ROOT / "tests"))
    from blender.conftest import PACKAGE  # makes the checkout a package of its own

    import bpy  # isort: skip
    import addon_utils  # isort: skip

    bpy.ops.wm.read_factory_settings(use_empty=True)
    addon_utils.enable(PACKAGE, default_set=True)
    print(json.dumps(measure(int(sys.argv[1]))), flush=True)
