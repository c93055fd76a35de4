"""Live: the time from a change to the written mesh, as a multiple of the bare solve from the last map with a cached
factor, in the same run; and a thousand edits.

`make bench` prints the ratios. Each test runs its own Blender, see live_session.py.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

pytest.importorskip("bpy", reason="needs the bpy module")

SESSION = Path(__file__).with_name("live_session.py")


def session(*arguments: str) -> dict:
    """The output of live_session.py, with one thread of BLAS."""
    done = subprocess.run(
        [sys.executable, str(SESSION), *arguments],
        capture_output=True,
        text=True,
        env={**os.environ, "OPENBLAS_NUM_THREADS": "1"},
        check=False,
    )
    assert done.returncode == 0, done.stderr[-2000:]
    return json.loads(next(line for line in reversed(done.stdout.splitlines()) if line.startswith("{")))


@pytest.mark.timeout(900)
@pytest.mark.parametrize("vertices", [5_000, 50_000])
def test_a_change_until_the_mesh_is_written(vertices, capsys):
    times = session("speed", str(vertices))
    bare = times["bare"]
    with capsys.disabled():
        print(f"\n{times['vertices']} vertices; the bare solve, factor cached, {1e3 * bare:.0f} ms")
        for name in ("tilt", "vertex", "coarse"):
            print(f"  {name:<8s} {times[name] / bare:5.2f} x, {1.0 / times[name]:5.1f} a second")
        print(f"  the window is held up for {1e3 * times['held up']:.1f} ms at a time, {times['held up'] / bare:.3f} x")


@pytest.mark.timeout(3600)
def test_a_thousand_edits(capsys):
    times = session("edits", "1000")
    with capsys.disabled():
        used = ", ".join(f"{number:.0f}" for number in times["MB"])
        print(f"\n{times['edits']} edits in {times['seconds']:.0f} s; {times['off by']:.1e} of the size off; {used} MB")
    assert times["off by"] < 1e-6
    assert times["MB"][-1] < 1.05 * times["MB"][0]
