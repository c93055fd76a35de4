"""Form a shell over a plan of assets/ in Blender, render it, and write the results to build/demo/.

    make demo

The plan is opened as a user opens it; Mesh Plan and Solve are the add-on's operators. Each file is written under
another name and then moved, so that there is never half a file.
"""

from __future__ import annotations

import json
import os
import sys
import tempfile
import time
from pathlib import Path

from scripts.gallery import blender_session

package = blender_session.start()

import addon_utils
import bpy

from scripts.gallery import scene, staging

PLAN = blender_session.ROOT / "assets" / "pavilion.blend"
OUTPUT = blender_session.ROOT / "build" / "demo"
NAME = "pavilion"
VIEW = (-62.0, 0.14)
EDGE_LENGTH = 0.25  # metres; finer than the asset, for the picture
SIZE = (1280, 800)


def main() -> int:
    began = time.perf_counter()
    plan, shell = staged()
    report = json.loads(plan.cmc.report)
    print(f"Formed '{shell.name}' over '{plan.name}' in {time.perf_counter() - began:.1f} s.")
    OUTPUT.mkdir(parents=True, exist_ok=True)
    files = [write_report(report), write_glb(shell), write_picture(), write_blend()]
    print("\n".join(key_numbers(report)))
    print("\n".join(f"{file.relative_to(blender_session.ROOT)}  {file.stat().st_size / 1024:.0f} kB" for file in files))
    print(f"Done in {time.perf_counter() - began:.0f} s.")
    return 0 if report["converged"] else 1


def staged() -> tuple[bpy.types.Object, bpy.types.Object]:
    """The plan and its shell in a scene ready to render."""
    plan = open_plan(PLAN)
    bpy.ops.cmc.mesh_plan(edge_length=EDGE_LENGTH, corners="NONE")
    shell = staging.form(plan, want_twin=True, want_g=True)
    staging.stage(plan, shell, VIEW, cells=2.0, thickness=0.15)
    hide_beside(plan, shell)
    return plan, shell


def open_plan(file: Path) -> bpy.types.Object:
    """Open a plan's file and return the plan."""
    bpy.ops.wm.open_mainfile(filepath=str(file), load_ui=False)
    (plan,) = [ob for ob in bpy.data.objects if ob.asset_data is not None]
    plan.asset_clear()  # so that the demo's file is not an asset library
    return plan


def hide_beside(plan: bpy.types.Object, shell: bpy.types.Object) -> None:
    """Hide the twin and g in the picture; they stay in the file."""
    for result in plan.cmc.collection.objects:
        if result != shell:
            result.hide_render = True
            result.hide_set(True)


def write_report(report: dict) -> Path:
    temporary = OUTPUT / ".report.part.json"
    temporary.write_text(json.dumps(report, indent=2, ensure_ascii=False) + "\n", encoding="utf-8")
    return temporary.replace(OUTPUT / "report.json")


def write_glb(shell: bpy.types.Object) -> Path:
    """The shell alone, with its UVs and a plain colour in place of its material."""
    addon_utils.enable("io_scene_gltf2")
    for ob in bpy.context.view_layer.objects:
        ob.select_set(ob == shell)
    return moved(
        f"{NAME}.glb",
        lambda path: bpy.ops.export_scene.gltf(
            filepath=path, export_format="GLB", use_selection=True, export_apply=True, export_attributes=True
        ),
    )


def write_blend() -> Path:
    """The whole scene as rendered: F12 renders it again."""
    return moved(
        f"{NAME}.blend",
        lambda path: bpy.ops.wm.save_as_mainfile(filepath=path, copy=True, compress=True, check_existing=False),
    )


def write_picture() -> Path:
    return scene.render(OUTPUT / f"{NAME}.png", *SIZE, samples=10, dither=1.0)


def moved(name: str, write) -> Path:
    """Let `write` make a file beside its place, then move it there."""
    with tempfile.TemporaryDirectory(prefix=".demo-", dir=OUTPUT) as scratch:
        temporary = Path(scratch) / name
        write(str(temporary))
        os.replace(temporary, OUTPUT / name)
    return OUTPUT / name


def key_numbers(report: dict) -> list[str]:
    shown = report["sheets"][report["sheet"]]
    H, curvature, distortion = report["mean_curvature"], shown["mean_curvature"], shown["distortion"]
    return [
        f"Plan: {report['plan']}, {report['faces']} triangles. {report['sentence']}",
        f"Span {shown['span']:.1f} m, rise {shown['rise']:.1f} m, area {shown['area']:.0f} m².",
        f"Radius of mean curvature 1/H = {1 / H:.2f} m; H is off by {100 * curvature['relative_l2']:.1f} % (L²).",
        f"Conformal: the mean distortion of the checker's squares is {distortion['mean']:.3f}, where 1 is a square.",
        f"Residual {report['residual']:.1e} after {report['iterations']} Newton steps.",
        f"{shown['intersections']['count']} pairs of faces cross; "
        f"{100 * shown['overhang']['area_share']:.1f} % of the area overhangs.",
    ]


if __name__ == "__main__":
    sys.exit(main())
