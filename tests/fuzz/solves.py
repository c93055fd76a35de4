"""Many solves in one Blender: does its memory stay flat? `python -m tests.fuzz.solves -n 500`

Every solve is of a plan that has changed; every tenth plan is a new one, and the old one is deleted with its shell.
"""

from __future__ import annotations

import argparse
import itertools
import resource
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
WARM = 50
"""Solves after which the caches are full; memory counts from there."""
SHARE = 0.05
"""By how much it may grow."""
_SHAPES = ("RECTANGLE", "L_SHAPE", "COURT", "ROUND", "ANNULUS")


def megabytes() -> float:
    """What the process has in memory now."""
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * resource.getpagesize() / 1e6


def solve_many(count: int, new_every: int = 10) -> list[float]:
    """Megabytes after each solve, in the Blender of this process with the add-on enabled."""
    import bpy

    sizes, shapes = [], itertools.cycle(_SHAPES)
    for k in range(count):
        if k % new_every == 0:
            for ob in list(bpy.data.objects):
                bpy.data.objects.remove(ob)
            bpy.ops.outliner.orphans_purge(do_recursive=True)
            bpy.ops.cmc.add_plan(shape=next(shapes), columns=16)
            plan = bpy.context.object
        plan.cmc.size, plan.cmc.rise = "RISE", 0.1 + 0.2 * (k % 97) / 97
        bpy.context.view_layer.objects.active = plan
        assert bpy.ops.cmc.solve("EXEC_DEFAULT", True, want_twin=True) == {"FINISHED"}
        sizes.append(megabytes())
    return sizes


def growth(sizes: list[float], warm: int = WARM) -> float:
    """By which part the memory has grown since the caches were filled."""
    return max(sizes[warm:]) / sizes[warm - 1] - 1.0


def main() -> int:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("-n", type=int, default=500, help="solves (500)")
    parser.add_argument("--here", action="store_true", help=argparse.SUPPRESS)
    options = parser.parse_args()
    if not options.here:  # Blender prints a line for every solve
        command = [sys.executable, "-m", "tests.fuzz.solves", "-n", str(options.n), "--here"]
        ran = subprocess.run(command, stdout=subprocess.PIPE, text=True, cwd=ROOT)
        print("\n".join(line for line in ran.stdout.splitlines() if line.startswith("memory")))
        return ran.returncode

    import bpy

    from tests.blender.conftest import PACKAGE

    # isort: split
    import addon_utils  # is on the path once bpy is imported

    bpy.ops.wm.read_factory_settings(use_empty=True)
    assert addon_utils.enable(PACKAGE, default_set=True)
    sizes = solve_many(options.n)
    for k in sorted({WARM, *range(WARM, options.n, 50), options.n}):
        print(f"memory after {k:4} solves: {sizes[k - 1]:.1f} MB")
    print(f"memory has grown by {growth(sizes):.1%}")
    return 0 if growth(sizes) <= SHARE else 1


if __name__ == "__main__":
    sys.exit(main())
