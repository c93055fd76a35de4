"""What is drawn over the viewport: how long a redraw takes, and the first one after a change, in processor time.

`make bench` prints milliseconds. Started as a script it is the Blender that is measured, in a process of its own.
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
    found = json.loads(next(line for line in reversed(done.stdout.splitlines()) if line.startswith("{")))
    with capsys.disabled():
        print(f"\n{found.pop('vertices')} vertices")
        for name, seconds in found.items():
            print(f"  {name:<32s} {1e3 * seconds:7.2f} ms")
    assert found["nothing has changed"] < 0.002


def measure(vertices: int) -> dict[str, float]:
    """Seconds of each kind of redraw, the least of some rounds."""
    import bmesh
    import bpy
    from blender.scenes import add_group, boundary_edges

    side = round(vertices**0.5)
    bpy.ops.mesh.primitive_grid_add(x_subdivisions=side - 1, y_subdivisions=side - 1, size=10)
    plan = bpy.context.object
    edges = boundary_edges(plan.data)
    group = add_group(plan, "Half", edges[: len(edges) // 2], "BINORMAL")
    seeing = sys.modules["cmc_formfinding.cmc_addon.drawing.overlay"]

    def least(change) -> float:
        taken = []
        for k in range(ROUNDS):
            change(0.1 * (k + 1))
            bpy.context.view_layer.update()
            before = time.thread_time()
            assert seeing.frame(bpy.context)
            taken.append(time.thread_time() - before)
        return min(taken)

    def drag(x: float) -> None:
        bm = bmesh.from_edit_mesh(plan.data)
        bm.verts.ensure_lookup_table()
        bm.verts[0].co.z = x
        bmesh.update_edit_mesh(plan.data, loop_triangles=False, destructive=False)

    seeing.frame(bpy.context)
    found = {"vertices": len(plan.data.vertices)}
    found["nothing has changed"] = least(lambda _: None)
    found["the plan was moved"] = least(lambda x: setattr(plan.location, "x", x))
    found["an angle was turned"] = least(lambda x: setattr(group, "tilt", x))
    found["the plan was scaled"] = least(lambda x: setattr(plan.scale, "x", 1.0 + x))
    bpy.ops.object.mode_set(mode="EDIT")
    found["a vertex was dragged (edit mode)"] = least(drag)
    bpy.ops.object.mode_set(mode="OBJECT")
    return found


if __name__ == "__main__":
    sys.path.insert(0, str(ROOT / "tests"))
    from blender.conftest import PACKAGE  # makes the checkout a package of its own

    import bpy  # isort: skip
    import addon_utils  # isort: skip

    bpy.ops.wm.read_factory_settings(use_empty=True)
    addon_utils.enable(PACKAGE, default_set=True)
    print(json.dumps(measure(int(sys.argv[1]))), flush=True)
