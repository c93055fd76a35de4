"""Write the modules of Add > Mesh > CMC into assets/modules/: .blend marked as Blender assets, .obj, and job files.

`make_assets.py` calls it; by itself it writes the modules only:

    .venvs/full-4.5/bin/python -m scripts.assets.make_modules

A job is for `python -m solver`: it solves the module of the OBJ beside it and completes it as the asset does.
"""

from __future__ import annotations

import sys

from scripts.gallery import blender_session

package = blender_session.start()

import bpy
import numpy as np
from cmc_formfinding.solver.catalogue.module_presets import PRESETS, Preset
from cmc_formfinding.solver.io.mesh_files import write_mesh

from scripts.assets import asset_files
from scripts.gallery import scene, staging

FOLDER = asset_files.ASSETS / "modules"


def main() -> None:
    FOLDER.mkdir(exist_ok=True)
    asset_files.write_catalogue()
    for name, preset in PRESETS.items():
        picture = preview(name)
        blender_session.empty_scene()
        plan = draw(name)
        write_mesh(FOLDER / f"{name}.obj", asset_files.obj_data(plan))
        (FOLDER / f"{name}.toml").write_text(job(name, preset, plan), encoding="utf-8")
        details = f"{preset.description}. Solve, then Complete by Symmetry."
        asset_files.mark(plan, details, ("module", "symmetry"), picture, "modules")
        asset_files.save(FOLDER / f"{name}.blend", plan)
        print(f"{plan.name}: {len(plan.data.polygons)} faces, {len(plan.data.cmc.groups)} boundary groups")


def draw(name: str) -> bpy.types.Object:
    """The plan of a module, alone in the scene and active."""
    bpy.context.scene.unit_settings.system = "METRIC"
    bpy.ops.cmc.add_module(module=name.upper())
    bpy.context.object.select_set(False)
    return bpy.context.object


def job(name: str, preset: Preset, plan: bpy.types.Object) -> str:
    """The job file of a module: its conditions are the plan's groups."""
    lines = [f"# {preset.name}: {preset.description[:1].lower()}{preset.description[1:]}.", "", f'mesh = "{name}.obj"']
    for group in plan.data.cmc.groups:
        normal = ", ".join(f"{0.0 if abs(part) < 1e-7 else part:.9g}" for part in group.normal)
        lines += ["", "[[conditions]]", f'group = "{group.name}"', f'kind = "{group.kind.lower()}"']
        lines += [f"normal = [{normal}]"]
    sides = [f'"{group.name}"' for group in plan.data.cmc.groups if group.name not in preset.ends]
    lines += ["", "[complete]", f"sides = [{', '.join(sides)}]", f"repeat = {list(preset.repeat)}"]
    lines += [f'mesh = "../../build/jobs/{name}.obj"', "", "[output]", f'report = "../../build/jobs/{name}.json"']
    return "\n".join(lines) + "\n"


def preview(name: str) -> np.ndarray:
    """A picture of the completed module."""
    blender_session.empty_scene()
    plan = draw(name)
    bpy.ops.cmc.solve()
    bpy.ops.cmc.complete()
    whole = plan.cmc.completed
    plan.hide_render = True
    staging.paint(whole, scene.checker("Plaster", "Plan", cells=1.0))
    whole.data.shade_smooth()
    points = staging.world_points(whole)
    scene.add_ground(float(np.ptp(points, axis=0).max()), z=float(points[:, 2].min()))
    scene.light()
    staging.look_at(points, (-62.0, 0.5), 42.0, 1.0)
    return asset_files.picture_of_scene()


if __name__ == "__main__":
    sys.exit(main())
